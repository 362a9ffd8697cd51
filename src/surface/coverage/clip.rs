//! The area a triangle has in common with an aperture: exact but for rounding.
//!
//! *Circle.* The border of the triangle is followed; each side contributes the signed area between
//! it and the centre, cut at the circle: ½ r²·angle where it runs outside, the triangle of its ends
//! and the centre where it runs inside.
//!
//! *Rectangle.* The triangle is cut by four half planes (I. E. Sutherland, G. W. Hodgman,
//! Communications of the ACM 17 (1974) 32-42, doi:10.1145/360767.360802).
//!
//! *Polygon.* The area under each of its sides, down to infinity, is cut out of the triangle by
//! three half planes; those under sides that run towards -x count positive, as their line has the
//! polygon below it, the others negative. Nothing is decided, so nothing jumps where lines coincide.

use asphera_geometry::predicates::Place;

use super::aperture::{Aperture, Shape};
use super::border::Border;

/// The area of the counter-clockwise triangle inside the aperture in mm².
///
/// `border` is that of the aperture, whose area is `aperture_mm2`, and tells which sides of a polygon
/// may matter.
pub(super) fn common_area_mm2(
    aperture: &Aperture,
    aperture_mm2: f64,
    border: &Border,
    triangle: [Place; 3],
) -> f64 {
    // Seen from a corner of the triangle, so that nothing is lost far from the origin.
    let from = triangle[0];
    let local = triangle.map(|corner| minus(corner, from));
    let area_mm2 = match &aperture.shape {
        Shape::Circle { centre_mm, radius_mm } => disc(triangle, *centre_mm, *radius_mm),
        Shape::Annulus { centre_mm, inner_mm, outer_mm } => {
            disc(triangle, *centre_mm, *outer_mm) - disc(triangle, *centre_mm, *inner_mm)
        }
        Shape::Rectangle { min_mm, max_mm } => {
            let (low, high) = (minus(*min_mm, from), minus(*max_mm, from));
            let mut piece = Convex::new(local);
            piece.cut(|[x, _]| x - low[0]);
            piece.cut(|[x, _]| high[0] - x);
            piece.cut(|[_, y]| y - low[1]);
            piece.cut(|[_, y]| high[1] - y);
            piece.area_mm2()
        }
        Shape::Outline(outline) => {
            let mut area_mm2 = 0.0;
            border.for_sides_about(triangle, |side| {
                let (p, q) = border.true_side(outline.rings(), side);
                area_mm2 += under(local, minus(p, from), minus(q, from));
            });
            area_mm2
        }
    };
    // Rounding may leave a trace of a triangle that lies outside.
    if area_mm2 > TRACE * aperture_mm2 { area_mm2 } else { 0.0 }
}

/// The area of the triangle in the disc.
fn disc(triangle: [Place; 3], centre: Place, radius_mm: f64) -> f64 {
    let corners = triangle.map(|corner| minus(corner, centre));
    (0..3).map(|i| beside_centre(corners[i], corners[(i + 1) % 3], radius_mm)).sum()
}

/// The signed area in a disc about the origin of the triangle of the origin, `p` and `q`.
fn beside_centre(p: Place, q: Place, radius_mm: f64) -> f64 {
    let sector = |u: Place, v: Place| 0.5 * radius_mm * radius_mm * cross(u, v).atan2(dot(u, v));
    let way = minus(q, p);
    let (squared, half) = (dot(way, way), dot(p, way));
    if squared == 0.0 {
        return 0.0;
    }
    // Where |p + t·way| is the radius: t = (-half ± root) / squared. The distance of the line from
    // the centre gives the root with less cancellation than the squares of p and the radius.
    let distance = cross(p, way) / squared.sqrt();
    let within = (radius_mm - distance) * (radius_mm + distance);
    if within <= 0.0 {
        return sector(p, q);
    }
    let root = (within * squared).sqrt();
    let (enters, leaves) = ((-half - root) / squared, (-half + root) / squared);
    if enters >= 1.0 || leaves <= 0.0 {
        return sector(p, q);
    }
    let at = |share: f64| [p[0] + share * way[0], p[1] + share * way[1]];
    let (mut first, mut last, mut area) = (p, q, 0.0);
    if enters > 0.0 {
        first = at(enters);
        area += sector(p, first);
    }
    if leaves < 1.0 {
        last = at(leaves);
        area += sector(last, q);
    }
    area + 0.5 * cross(first, last)
}

/// The signed area of the part of the triangle below the side of a polygon.
fn under(triangle: [Place; 3], p: Place, q: Place) -> f64 {
    let (low, high) = if p[0] < q[0] { (p, q) } else { (q, p) };
    if low[0] == high[0] {
        return 0.0;
    }
    let mut piece = Convex::new(triangle);
    piece.cut(|[x, _]| x - low[0]);
    piece.cut(|[x, _]| high[0] - x);
    let way = minus(high, low);
    piece.cut(|place| -cross(way, minus(place, low)));
    let area_mm2 = piece.area_mm2();
    if q[0] < p[0] { area_mm2 } else { -area_mm2 }
}

/// A convex polygon of few corners.
struct Convex {
    corners: [Place; 8],
    count: usize,
}

impl Convex {
    fn new([a, b, c]: [Place; 3]) -> Convex {
        Convex { corners: [a, b, c, [0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]], count: 3 }
    }

    /// Leaves what has a value of zero and above; `value` is linear in the place.
    fn cut(&mut self, value: impl Fn(Place) -> f64) {
        let before = self.corners;
        let count = std::mem::take(&mut self.count);
        for i in 0..count {
            let (p, q) = (before[i], before[(i + 1) % count]);
            let (at_p, at_q) = (value(p), value(q));
            if at_p >= 0.0 {
                self.push(p);
            }
            if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
                let share = at_p / (at_p - at_q);
                self.push([p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]);
            }
        }
    }

    /// Each cut adds at most one corner to a convex polygon. Rounding may make it think that a
    /// sliver is crossed more often; what does not fit has no area to speak of.
    fn push(&mut self, corner: Place) {
        if let Some(free) = self.corners.get_mut(self.count) {
            *free = corner;
            self.count += 1;
        }
    }

    fn area_mm2(&self) -> f64 {
        let from = self.corners[0];
        let corners = &self.corners[..self.count];
        let fans = corners.windows(2).skip(1);
        0.5 * fans.map(|pair| cross(minus(pair[0], from), minus(pair[1], from))).sum::<f64>()
    }
}

/// A smaller share of the aperture is none.
const TRACE: f64 = 1e-15;

pub(super) fn minus(p: Place, q: Place) -> Place {
    [p[0] - q[0], p[1] - q[1]]
}

fn dot(u: Place, v: Place) -> f64 {
    u[0] * v[0] + u[1] * v[1]
}

pub(super) fn cross(u: Place, v: Place) -> f64 {
    u[0] * v[1] - u[1] * v[0]
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    fn common(aperture: &Aperture, triangle: [Place; 3]) -> f64 {
        let border = Border::new(aperture, 0, 0);
        common_area_mm2(aperture, aperture.area_mm2(), &border, triangle)
    }

    #[test]
    fn known_areas() {
        let circle = Aperture::circle([0.0; 2], 1.0).unwrap();
        let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found}");
        // The quarter of a disc in a corner at its centre, and all of it in a large triangle.
        is(common(&circle, [[0.0, 0.0], [5.0, 0.0], [0.0, 5.0]]), 0.25 * PI);
        is(common(&circle, [[-9.0, -9.0], [9.0, -9.0], [0.0, 20.0]]), PI);
        // A segment beyond the line y = ½: of the angle 2π/3.
        let segment = PI / 3.0 - 0.5 * (2.0 * PI / 3.0).sin();
        is(common(&circle, [[-9.0, 0.5], [9.0, 0.5], [0.0, 20.0]]), segment);
        is(common(&circle, [[-0.5, 0.0], [0.5, 0.0], [0.0, 0.5]]), 0.25);
        is(common(&circle, [[2.0, 0.0], [3.0, 0.0], [2.0, 1.0]]), 0.0);
        // A side touches the circle from outside.
        is(common(&circle, [[1.0, -1.0], [3.0, 0.0], [1.0, 1.0]]), 0.0);
        let ring = Aperture::annulus([0.0; 2], 0.5, 1.0).unwrap();
        is(common(&ring, [[0.0, 0.0], [5.0, 0.0], [0.0, 5.0]]), 0.25 * PI * 0.75);
        let square = Aperture::rectangle([0.0; 2], 2.0, 2.0).unwrap();
        is(common(&square, [[-3.0, -1.0], [3.0, -1.0], [0.0, 2.0]]), 4.0);
        is(common(&square, [[-2.0, -1.0], [2.0, -1.0], [0.0, 1.0]]), 3.0);
        let ell = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
        let ell = Aperture::polygon(&ell, &[]).unwrap();
        // A side through two corners, and along three sides.
        is(common(&ell, [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]]), 2.0);
        is(common(&ell, [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0]]), 3.0);
        is(common(&ell, [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]), 0.0);
    }

    fn places() -> impl Strategy<Value = [Place; 3]> {
        prop::array::uniform3(prop::array::uniform2(-2.0..2.0_f64)).prop_map(|[p, q, r]| {
            if cross(minus(q, p), minus(r, p)) < 0.0 { [p, r, q] } else { [p, q, r] }
        })
    }

    proptest! {
        #![proptest_config(beside_source())]

        /// The parts of a triangle have the area of the whole, and polygons with many sides that of
        /// the circle they are drawn in.
        #[test]
        fn parts_add_up(triangle in places(), shares in prop::array::uniform2(0.0..1.0_f64)) {
            let around = |r: f64, count: i32| (0..count).map(|i| {
                let (sin, cos) = (f64::from(i) * 2.0 * PI / f64::from(count)).sin_cos();
                [r * cos, r * sin]
            }).collect::<Vec<_>>();
            let circle = Aperture::circle([0.0; 2], 1.2).unwrap();
            let ring = Aperture::annulus([0.0; 2], 0.6, 1.2).unwrap();
            let square = Aperture::rectangle([0.0; 2], 1.8, 1.4).unwrap();
            let same = Aperture::polygon(&[[-0.9, -0.7], [0.9, -0.7], [0.9, 0.7], [-0.9, 0.7]], &[]).unwrap();
            let fine = Aperture::polygon(&around(1.2, 500), &[around(0.6, 500)]).unwrap();
            let [p, q, r] = triangle;
            let at: Place = {
                let (u, v) = (shares[0], shares[1] * (1.0 - shares[0]));
                [0, 1].map(|axis| p[axis] + u * (q[axis] - p[axis]) + v * (r[axis] - p[axis]))
            };
            for aperture in [&circle, &ring, &square, &fine] {
                let border = Border::new(aperture, 0, 0);
                let common = |aperture: &Aperture, triangle: [Place; 3]| {
                    common_area_mm2(aperture, aperture.area_mm2(), &border, triangle)
                };
                let whole = common(aperture, triangle);
                let parts = [[p, q, at], [q, r, at], [r, p, at]].map(|part| common(aperture, part));
                prop_assert!((parts.into_iter().sum::<f64>() - whole).abs() < 1e-13, "{whole}: {parts:?}");
                let area = 0.5 * cross(minus(q, p), minus(r, p));
                prop_assert!(whole <= area * (1.0 + 1e-13) + 1e-15);
            }
            prop_assert!((common(&square, triangle) - common(&same, triangle)).abs() < 1e-14);
            prop_assert!((common(&ring, triangle) - common(&fine, triangle)).abs() < 3e-4);
        }
    }
}

//! The farthest place of a triangle from its nearest corner, of those inside an aperture. Where another sample may be
//! nearer, `nearer.rs` goes on from there.
//!
//! Over what the bisectors of the sides and the border leave of a triangle for one corner the distance to that is
//! convex, so it is largest at a corner of such a piece: at the circumcentre, where a bisector or the border meets a
//! side, where a bisector meets the border, or where the border has a corner. The border is the drawn one.

use asphera_geometry::predicates::Place;
use asphera_geometry::{Gap, PointMm, Triangle, place};

use super::border::Border;
use super::clip::{cross, minus};

/// The gap of a triangle across the border, whose gap as a whole is `whole`.
pub(super) fn clipped_gap(triangle: &Triangle, whole: Gap, border: &Border) -> Gap {
    if border.contains(place(whole.at_mm)) {
        return whole;
    }
    let pieces = Pieces::of(triangle);
    let corners = pieces.corners;
    let mut farthest: Option<Gap> = None;
    let mut note = |at_mm: PointMm| {
        let mm = pieces.nearest_mm(at_mm);
        if farthest.is_none_or(|farthest| mm > farthest.mm) {
            farthest = Some(Gap { mm, at_mm });
        }
    };
    for side in 0..3 {
        let ends = [corners[side], corners[(side + 1) % 3]];
        pieces.for_ends_on(ends, |at_mm| {
            if border.contains(place(at_mm)) {
                note(at_mm);
            }
        });
    }
    let mut near = Vec::new();
    border.sides_near(pieces.flat, &mut near);
    for side in near {
        if let Some(ends) = pieces.clipped_to(&pieces.flat, border.side(side)) {
            pieces.for_ends_on(ends, &mut note);
        }
    }
    farthest.filter(|farthest| farthest.mm < whole.mm).unwrap_or(whole)
}

/// A triangle, in which each corner has a piece.
pub(super) struct Pieces {
    corners: [PointMm; 3],
    /// The same in the plane.
    flat: [Place; 3],
}

impl Pieces {
    pub(super) fn of(triangle: &Triangle) -> Pieces {
        let corners = triangle.corners_mm();
        Pieces { corners, flat: corners.map(place) }
    }

    pub(super) fn corners(&self) -> [PointMm; 3] {
        self.corners
    }

    /// Takes both ends of a straight line in the triangle and all places on it where bisectors cross it.
    fn for_ends_on(&self, [from, to]: [PointMm; 2], mut take: impl FnMut(PointMm)) {
        let distances_mm2 = [from, to].map(|end| self.distances_mm2(end));
        take(from);
        take(to);
        for corner in 0..3 {
            let other = (corner + 1) % 3;
            // The difference of two squares is linear along the line.
            let [start, end] = distances_mm2.map(|to| to[corner] - to[other]);
            if start * end < 0.0 {
                let share = start / (start - end);
                take(std::array::from_fn(|axis| from[axis] + share * (to[axis] - from[axis])));
            }
        }
    }

    /// The part of a line in the plane that lies in a convex polygon of the triangle, on the triangle.
    pub(super) fn clipped_to(
        &self,
        polygon: &[Place],
        (p, q): (Place, Place),
    ) -> Option<[PointMm; 2]> {
        let way = minus(q, p);
        let [mut first, mut last] = [0.0_f64, 1.0_f64];
        for (&a, &b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
            // Not negative on the left of the side, where the polygon lies.
            let start = cross(minus(b, a), minus(p, a));
            let change = cross(minus(b, a), way);
            if change > 0.0 {
                first = first.max(-start / change);
            } else if change < 0.0 {
                last = last.min(-start / change);
            } else if start < 0.0 {
                return None;
            }
        }
        let at = |share: f64| self.lifted([p[0] + share * way[0], p[1] + share * way[1]]);
        (first < last && !polygon.is_empty()).then(|| [at(first), at(last)])
    }

    /// The place of the triangle over one in the plane.
    fn lifted(&self, at: Place) -> PointMm {
        let [a, b, c] = self.flat;
        let whole = cross(minus(b, a), minus(c, a));
        let of_b = cross(minus(at, a), minus(c, a)) / whole;
        let of_c = cross(minus(b, a), minus(at, a)) / whole;
        let [a, b, c] = self.corners.map(|corner| corner[2]);
        [at[0], at[1], a + of_b * (b - a) + of_c * (c - a)]
    }

    fn distances_mm2(&self, at: PointMm) -> [f64; 3] {
        self.corners.map(|corner| (0..3).map(|axis| (at[axis] - corner[axis]).powi(2)).sum())
    }

    fn nearest_mm(&self, at: PointMm) -> f64 {
        self.distances_mm2(at).into_iter().fold(f64::INFINITY, f64::min).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::coverage::Aperture;

    #[test]
    fn no_place_inside_is_farther_and_one_is_as_far() {
        let points = [[0.0, 0.0, 0.0], [3.0, 0.2, 0.5], [1.0, 2.5, -0.4]];
        let triangle = Triangle::new(&points, [0, 1, 2]);
        let whole = triangle.gap();
        for aperture in [
            Aperture::circle([-1.0, -1.0], 2.0),
            Aperture::circle([3.5, 0.0], 2.2),
            Aperture::rectangle([0.0, 0.0], 1.0, 4.0),
            Aperture::rectangle([1.0, 3.0], 4.0, 3.0),
            Aperture::annulus([1.3, 1.0], 0.6, 9.0),
            Aperture::circle([1.3, 1.0], 0.2),
        ] {
            let aperture = aperture.unwrap();
            let border = Border::new(&aperture, 1, 0);
            let found = clipped_gap(&triangle, whole, &border);
            let mut seen = 0.0_f64;
            let cells = 400;
            for (u, v) in (0..=cells).flat_map(|u| (0..=cells - u).map(move |v| (u, v))) {
                let (u, v) = (f64::from(u) / f64::from(cells), f64::from(v) / f64::from(cells));
                let at: PointMm = std::array::from_fn(|axis| {
                    let [a, b, c] = points.map(|point| point[axis]);
                    a + u * (b - a) + v * (c - a)
                });
                if border.contains(place(at)) {
                    let squares = points.map(|point| {
                        (0..3).map(|axis| (at[axis] - point[axis]).powi(2)).sum::<f64>()
                    });
                    seen = seen.max(squares.into_iter().fold(f64::INFINITY, f64::min).sqrt());
                }
            }
            assert!(seen <= found.mm * (1.0 + 1e-9), "{seen} above {found:?} in {aperture:?}");
            assert!(seen >= found.mm - 0.012, "{seen} below {found:?} in {aperture:?}");
            assert!(found.mm <= whole.mm);
        }
    }
}

//! One triangle in space: its areas and its gap.

use crate::nearness::Nearness;
use crate::vector::{cross, dot, length as norm, minus};
use crate::{PointMm, VertexId};

/// A triangle in space whose longest side is the first one, from `a` to `b`.
///
/// The angle at `c` is then the largest, from 60° up, and the edges from `c` are those that give a
/// cross product with the least cancellation.
#[derive(Clone, Copy)]
pub struct Triangle {
    a: PointMm,
    b: PointMm,
    c: PointMm,
    /// The numbers of a, b and c.
    corners: [VertexId; 3],
}

/// The point of a triangle farthest from its nearest corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The distance to the nearest corner in mm.
    pub mm: f64,
    /// Where that is.
    pub at_mm: PointMm,
}

impl Triangle {
    /// The triangle of three different points of a mesh.
    #[inline]
    pub fn new(points: &[PointMm], corners: [VertexId; 3]) -> Triangle {
        let [i, j, k] = corners;
        Triangle::at_places([points[i as usize], points[j as usize], points[k as usize]], corners)
    }

    /// The triangle of three places with these numbers.
    #[inline]
    pub fn at_places([p, q, r]: [PointMm; 3], corners: [VertexId; 3]) -> Triangle {
        let [i, j, k] = corners;
        let [pq, qr, rp] = [squared(minus(q, p)), squared(minus(r, q)), squared(minus(p, r))];
        if pq >= qr && pq >= rp {
            Triangle { a: p, b: q, c: r, corners: [i, j, k] }
        } else if qr >= rp {
            Triangle { a: q, b: r, c: p, corners: [j, k, i] }
        } else {
            Triangle { a: r, b: p, c: q, corners: [k, i, j] }
        }
    }

    /// The ends of the longest side; the triangle lies on its left.
    #[inline]
    pub fn longest_side(&self) -> [VertexId; 2] {
        [self.corners[0], self.corners[1]]
    }

    /// The ends of the two other sides; the triangle lies on their left.
    #[inline]
    pub fn short_sides(&self) -> [[VertexId; 2]; 2] {
        let [a, b, c] = self.corners;
        [[b, c], [c, a]]
    }

    /// Its corners, counter-clockwise as it was given.
    #[inline]
    pub fn corners_mm(&self) -> [PointMm; 3] {
        [self.a, self.b, self.c]
    }

    /// Whether the angle over the longest side is above 90°.
    #[inline]
    pub fn is_obtuse(&self) -> bool {
        dot(minus(self.a, self.c), minus(self.b, self.c)) < 0.0
    }

    /// Height over the longest side in mm.
    #[inline]
    pub fn height_mm(&self) -> f64 {
        2.0 * self.area_mm2() / norm(minus(self.b, self.a))
    }

    /// How far its places lie from their nearest sample, `gap_mm` at most.
    #[inline]
    pub fn nearness(&self, gap_mm: f64) -> Nearness {
        Nearness::new(&sizes(self.a, self.b, self.c), gap_mm)
    }

    /// Sum of the squares of its three sides in mm².
    #[inline]
    pub fn squares_mm2(&self) -> f64 {
        squared(minus(self.b, self.a))
            + squared(minus(self.c, self.b))
            + squared(minus(self.a, self.c))
    }

    /// Area in space in mm².
    #[inline]
    pub fn area_mm2(&self) -> f64 {
        0.5 * norm(cross(minus(self.a, self.c), minus(self.b, self.c)))
    }

    /// Area of the projection on the x-y plane in mm²; negative if it turns clockwise.
    #[inline]
    pub fn projected_area_mm2(&self) -> f64 {
        0.5 * cross(minus(self.a, self.c), minus(self.b, self.c))[2]
    }

    /// The largest distance from a point of the triangle to the nearest of its corners.
    ///
    /// The bisectors of the sides cut the triangle into the regions nearest to each corner. Over
    /// such a region the distance to its corner is convex, so it is largest at a corner of the
    /// region: at the circumcentre if that lies in the triangle, or where a bisector meets a side.
    ///
    /// *No angle above 90°.* The circumcentre lies in the triangle, at the circumradius R from all
    /// corners. Where the bisector of a side meets that side or another one the distance is at most
    /// R, as every point of the triangle lies within R of a corner. The gap is R.
    ///
    /// *An angle above 90° at c.* The circumcentre lies beyond the side ab, which the bisectors of
    /// ca and cb reach before they meet:
    ///
    /// ```text
    ///              c
    ///          _ -/ \ - _           s on ab with |sa| = |sc|:  |sa| = |ca| / (2 cos A)
    ///      _ -   /   \    - _       t on ab with |tb| = |tc|:  |tb| = |cb| / (2 cos B)
    ///   a ------s-----t------- b
    /// ```
    ///
    /// The region of c ends at s and t, those of a and b at s and t and at the midpoints of the
    /// short sides, at |ca| / 2 and |cb| / 2. Since a cosine is at most 1 the gap is the larger of
    /// |sa| and |tb|. Neither passes the middle of ab: |ca| ≤ |ab| cos A is just what an obtuse
    /// angle at c means, hence |sa| ≤ |ab| / 2. With a right angle at c both meet there and both
    /// cases give |ab| / 2.
    ///
    /// Clipping keeps a thin triangle along the hull from reporting a huge circumradius where the
    /// samples are dense.
    #[inline]
    pub fn gap(&self) -> Gap {
        let (ab, ac, bc) = (minus(self.b, self.a), minus(self.c, self.a), minus(self.c, self.b));
        let at_c = dot(ac, bc);
        if at_c <= 0.0 {
            let longest = norm(ab);
            let from_a = clipped_share(squared(ac), dot(ac, ab));
            let from_b = clipped_share(squared(bc), -dot(bc, ab));
            return if from_a >= from_b {
                Gap { mm: from_a * longest, at_mm: along(self.a, from_a, ab) }
            } else {
                Gap { mm: from_b * longest, at_mm: along(self.b, -from_b, ab) }
            };
        }
        // Barycentric weights of the circumcentre: the squared side times the scalar product at the
        // opposite corner. All are positive here.
        let weight_a = squared(bc) * dot(ac, ab);
        let weight_b = squared(ac) * -dot(bc, ab);
        let weight_c = squared(ab) * at_c;
        let total = weight_a + weight_b + weight_c;
        let sides = norm(ab) * norm(ac) * norm(bc);
        Gap {
            mm: sides / (2.0 * norm(cross(ac, bc))),
            at_mm: along(along(self.a, weight_b / total, ab), weight_c / total, ac),
        }
    }
}

/// How large a triangle is: what [`Triangle`] tells, but for rounding, at a third of the cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// See [`Triangle::gap`].
    pub gap_mm: f64,
    /// See [`Triangle::area_mm2`].
    pub area_mm2: f64,
    /// See [`Triangle::projected_area_mm2`].
    pub projected_area_mm2: f64,
    /// The squares of the sides in mm², ascending.
    pub squares_mm2: [f64; 3],
    /// Which corner has the largest angle. The place of the gap is as far from it as the gap is long, and
    /// the other corners are at most twice as far.
    pub blunt: usize,
}

/// The sizes of a triangle, without a branch that half of the triangles take.
///
/// With l ≥ m ≥ s the squares of the sides, the gap over an obtuse angle is m·√l / (l + m - s): by the law
/// of cosines that is the one of [`Triangle::gap`]'s two distances which belongs to m, and the larger one,
/// as l ≥ m + s.
#[inline(always)]
pub fn sizes(p: PointMm, q: PointMm, r: PointMm) -> Sizes {
    let (to_q, to_r) = (minus(q, p), minus(r, p));
    let [pq, qr, rp] = [squared(to_q), squared(minus(r, q)), squared(to_r)];
    let normal = cross(to_q, to_r);
    let twice_area = norm(normal);
    let (less, more) = (lesser(pq, qr), greater(pq, qr));
    let (short, middle, long) =
        (lesser(less, rp), greater(less, lesser(more, rp)), greater(more, rp));
    let (factor, root, below) = if short + middle <= long {
        (middle, long, behind(short, middle, long))
    } else {
        (1.0, short * middle * long, 2.0 * twice_area)
    };
    Sizes {
        gap_mm: factor * root.sqrt() / below,
        area_mm2: 0.5 * twice_area,
        projected_area_mm2: 0.5 * normal[2],
        squares_mm2: [short, middle, long],
        blunt: if long == pq { 2 } else { usize::from(long == rp) },
    }
}

impl Sizes {
    /// Half of each side in mm, ascending.
    #[inline(always)]
    pub fn halves_mm(&self) -> [f64; 3] {
        self.squares_mm2.map(|square_mm2| 0.5 * square_mm2.sqrt())
    }

    /// -1 where an angle is above 90°, else 1.
    #[inline(always)]
    pub fn bluntness(&self) -> f64 {
        let [short, middle, long] = self.squares_mm2;
        if short + middle < long { -1.0 } else { 1.0 }
    }

    /// Whether rounding spoils the gap by no more than 1e-12 of it: the shortest side is more than 1/4096 of the
    /// longest. Not where a side is not a number.
    #[inline(always)]
    pub fn is_stout(&self) -> bool {
        let [short, _, long] = self.squares_mm2;
        short * THIN > long
    }
}

/// l + m - s; in a sliver the difference may be lost, but l - s is at least m.
#[inline(always)]
fn behind(short: f64, middle: f64, long: f64) -> f64 {
    greater(long - short, middle) + middle
}

/// The smaller of two numbers, of which neither may be NaN: in one instruction, where [`f64::min`] takes five.
#[inline(always)]
pub fn lesser(left: f64, right: f64) -> f64 {
    if left < right { left } else { right }
}

/// The larger one in the same way.
#[inline(always)]
pub fn greater(left: f64, right: f64) -> f64 {
    if left > right { left } else { right }
}

/// The square of 4096.
const THIN: f64 = (1_u64 << 24) as f64;

/// A triangle with its smallest corner first, in the order it turns.
#[inline]
pub fn from_smallest([a, b, c]: [VertexId; 3]) -> [VertexId; 3] {
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// Where on the longest side the bisector of a short one meets it, as a share of the longest side
/// from their common corner: the squared short side over twice the scalar product of both.
fn clipped_share(short_squared: f64, product: f64) -> f64 {
    // The product is at least the squared short side but for rounding, see `Triangle::gap`.
    if product > short_squared { 0.5 * short_squared / product } else { 0.5 }
}

fn along(from: PointMm, share: f64, way: [f64; 3]) -> PointMm {
    [from[0] + share * way[0], from[1] + share * way[1], from[2] + share * way[2]]
}

#[inline(always)]
fn squared(u: [f64; 3]) -> f64 {
    dot(u, u)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    fn triangle(points: [PointMm; 3]) -> Triangle {
        Triangle::new(&points, [0, 1, 2])
    }

    /// The largest distance to the nearest corner over a fine barycentric lattice of the triangle:
    /// never above the gap, and below it by no more than the lattice's own pitch.
    fn lattice_gap(points: [PointMm; 3], cells: usize) -> f64 {
        let [p, q, r] = points;
        let mut largest = 0.0_f64;
        for i in 0..=cells {
            for j in 0..=cells - i {
                let (u, v) = (i as f64 / cells as f64, j as f64 / cells as f64);
                let place = along(along(p, u, minus(q, p)), v, minus(r, p));
                let nearest = points.map(|corner| norm(minus(place, corner)));
                largest = largest.max(nearest.into_iter().fold(f64::INFINITY, f64::min));
            }
        }
        largest
    }

    #[test]
    fn known_triangles() {
        // Equilateral of side 2: circumradius 2/√3.
        let gap = triangle([[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 3.0_f64.sqrt(), 0.0]]).gap();
        assert!((gap.mm - 2.0 / 3.0_f64.sqrt()).abs() < 1e-15);
        // Right, 3-4-5: half the hypotenuse, at its middle.
        let gap = triangle([[0.0, 0.0, 7.0], [3.0, 0.0, 7.0], [0.0, 4.0, 7.0]]).gap();
        assert_eq!(gap, Gap { mm: 2.5, at_mm: [1.5, 2.0, 7.0] });
        // Obtuse: base 8, apex 1 above a place 3 along it. From the left |ca|² = 10, cos A = 3/√10:
        // 10/6; from the right |cb|² = 26: 26/10. The circumradius would be 8.06.
        let gap = triangle([[0.0, 0.0, 0.0], [8.0, 0.0, 0.0], [3.0, 1.0, 0.0]]).gap();
        assert!((gap.mm - 2.6).abs() < 1e-15 && (gap.at_mm[0] - 5.4).abs() < 1e-15, "{gap:?}");
    }

    #[test]
    fn the_gap_lies_in_space_not_in_the_plane() {
        // Upright legs 3 and 4 in space: over the plane this is a triangle with legs 3 and 0.1.
        let rise = (16.0_f64 - 0.01).sqrt();
        let gap = triangle([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.1, rise]]).gap();
        assert!((gap.mm - 2.5).abs() < 1e-14, "{gap:?}");
    }

    #[test]
    fn slivers_stay_finite() {
        for height in [1e-3, 1e-9, 1e-15, 1e-30] {
            let low = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.5, height, 0.0]];
            let upright = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, height, 0.0]];
            for (corners, expected_mm) in [(low, 0.25), (upright, 0.5)] {
                let [p, q, r] = corners;
                let (gap, sizes) = (triangle(corners).gap(), sizes(p, q, r));
                assert!((gap.mm - expected_mm).abs() < 1e-6, "{height}: {gap:?}");
                assert!((sizes.gap_mm - expected_mm).abs() < 1e-6, "{height}: {sizes:?}");
            }
        }
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn no_point_of_the_triangle_is_farther(
            corners in prop::array::uniform3(prop::array::uniform3(-10.0..10.0)),
        ) {
            let gap = triangle(corners).gap();
            let cells = 60;
            let seen = lattice_gap(corners, cells);
            let longest = [0, 1, 2]
                .map(|i| norm(minus(corners[i], corners[(i + 1) % 3])))
                .into_iter()
                .fold(0.0, f64::max);
            prop_assert!(seen <= gap.mm * (1.0 + 1e-9), "{seen} above {gap:?}");
            prop_assert!(seen >= gap.mm - longest / cells as f64, "{seen} below {gap:?}");
            let nearest = corners.map(|corner| norm(minus(gap.at_mm, corner)));
            let nearest = nearest.into_iter().fold(f64::INFINITY, f64::min);
            prop_assert!((nearest - gap.mm).abs() <= 1e-6 * gap.mm, "{nearest} at {gap:?}");
        }

        #[test]
        fn sizes_at_once_and_one_by_one(
            corners in prop::array::uniform3(prop::array::uniform3(-10.0..10.0)),
        ) {
            let [p, q, r] = corners;
            let (triangle, sizes) = (triangle(corners), sizes(p, q, r));
            let gap = triangle.gap();
            let equal = |left: f64, right: f64| (left - right).abs() <= 1e-10 * right.abs();
            prop_assert!(equal(sizes.gap_mm, gap.mm), "{:?} {:?}", sizes, gap);
            prop_assert!(equal(sizes.area_mm2, triangle.area_mm2()));
            prop_assert!((sizes.projected_area_mm2 - triangle.projected_area_mm2()).abs() <= 1e-12);
            let blunt = corners[sizes.blunt];
            prop_assert!((norm(minus(gap.at_mm, blunt)) - gap.mm).abs() <= 1e-6 * gap.mm);
            for corner in corners {
                prop_assert!(norm(minus(corner, blunt)) <= 2.0 * gap.mm * (1.0 + 1e-9));
            }
        }

        #[test]
        fn the_gap_scales_and_does_not_depend_on_the_corner_named_first(
            corners in prop::array::uniform3(prop::array::uniform3(-10.0..10.0)),
        ) {
            let [p, q, r] = corners;
            let gap = triangle(corners).gap();
            let turned = triangle([q, r, p]).gap();
            let doubled = triangle(corners.map(|corner| corner.map(|x| 2.0 * x))).gap();
            prop_assert!((turned.mm - gap.mm).abs() <= 1e-12 * gap.mm);
            prop_assert_eq!(doubled.mm, 2.0 * gap.mm);
        }
    }
}

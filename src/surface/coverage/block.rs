//! Some triangles at a time, figure by figure.
//!
//! The coordinates of the corners are first gathered from wherever they are; all else is then the same few
//! operations for one triangle after the other, without a branch, so that the compiler does several at once.

use asphera_geometry::nearness::Nearness;
use asphera_geometry::{PointMm, VertexId, lesser, sizes};

use super::target::Target;

/// Triangles of a block: its figures stay in the nearest cache.
pub(super) const BLOCK: usize = 64;

/// One figure of each triangle.
pub(super) type Row = [f64; BLOCK];

/// The figures of some triangles; they differ by rounding from those of [`asphera_geometry::Triangle`]. Beyond
/// the last triangle, and where one was taken out, stands what counts for nothing.
pub(super) struct Block {
    /// x, y and z of the first corners, then of the second and the third.
    corners: [Row; 9],
    pub(super) gap_mm: Row,
    /// Area in space.
    pub(super) area_mm2: Row,
    pub(super) projected_mm2: Row,
    /// Sum of the squares of the sides.
    pub(super) squares_mm2: Row,
    /// The square of the longest side; infinite where rounding may spoil the gap.
    pub(super) long_mm2: Row,
    /// The smallest local feature size at the corners; NaN where it is not known.
    pub(super) lfs_mm: Row,
    /// NaN where the local feature size is not known.
    pub(super) epsilon: Row,
    /// Half of each side, ascending.
    halves_mm: [Row; 3],
    /// See [`Nearness`].
    bluntness: Row,
}

impl Block {
    pub(super) fn new() -> Block {
        const NONE: Row = [0.0; BLOCK];
        Block {
            corners: [NONE; 9],
            gap_mm: NONE,
            area_mm2: NONE,
            projected_mm2: NONE,
            squares_mm2: NONE,
            long_mm2: NONE,
            lfs_mm: NONE,
            epsilon: NONE,
            halves_mm: [NONE; 3],
            bluntness: NONE,
        }
    }

    /// Measures up to [`BLOCK`] triangles; returns how many there are.
    pub(super) fn measure(
        &mut self,
        points: &[PointMm],
        lfs_at_points_mm: &[f64],
        triangles: impl Iterator<Item = [VertexId; 3]>,
    ) -> usize {
        let mut count = 0;
        for [a, b, c] in triangles.take(BLOCK) {
            let (a, b, c) = (a as usize, b as usize, c as usize);
            let (p, q, r) = (points[a], points[b], points[c]);
            let [px, py, pz, qx, qy, qz, rx, ry, rz] = &mut self.corners;
            (px[count], py[count], pz[count]) = (p[0], p[1], p[2]);
            (qx[count], qy[count], qz[count]) = (q[0], q[1], q[2]);
            (rx[count], ry[count], rz[count]) = (r[0], r[1], r[2]);
            let (a, b, c) = (lfs_at_points_mm[a], lfs_at_points_mm[b], lfs_at_points_mm[c]);
            // The sum is NaN where one of them is.
            let least = lesser(lesser(a, b), c);
            self.lfs_mm[count] = if a + b + c > 0.0 { least } else { f64::NAN };
            count += 1;
        }
        self.size();
        (count..BLOCK).for_each(|row| self.take_out(row));
        count
    }

    /// The place of the first corner.
    pub(super) fn place(&self, row: usize) -> [f64; 2] {
        [self.corners[0][row], self.corners[1][row]]
    }

    /// How far the places of a triangle lie from their nearest sample.
    #[inline(always)]
    pub(super) fn nearness(&self, row: usize) -> Nearness {
        let [short, middle, long] = &self.halves_mm;
        Nearness {
            halves_mm: [short[row], middle[row], long[row]],
            bluntness: self.bluntness[row],
            gap_mm: self.gap_mm[row],
            area_mm2: self.area_mm2[row],
        }
    }

    /// Leaves nothing of a triangle that would count: no area, and a gap and an ε below all others.
    pub(super) fn take_out(&mut self, row: usize) {
        (self.area_mm2[row], self.projected_mm2[row]) = (0.0, 0.0);
        (self.gap_mm[row], self.epsilon[row]) = (-1.0, -1.0);
        self.lfs_mm[row] = f64::INFINITY;
    }

    /// Whether each triangle is clearly covered, if it lies inside.
    pub(super) fn within(&self, limits: &Limits, covered: &mut [bool; BLOCK]) {
        for (row, covered) in covered.iter_mut().enumerate() {
            let limit_mm = lesser(limits.gap_mm, limits.epsilon * self.lfs_mm[row]);
            // Written so that NaN is none.
            *covered = self.lfs_mm[row] > 0.0
                && self.projected_mm2[row] > 0.0
                && self.gap_mm[row] <= limit_mm * limits.slack;
        }
    }

    fn size(&mut self) {
        let [px, py, pz, qx, qy, qz, rx, ry, rz] = &self.corners;
        for row in 0..BLOCK {
            let p = [px[row], py[row], pz[row]];
            let q = [qx[row], qy[row], qz[row]];
            let r = [rx[row], ry[row], rz[row]];
            let sizes = sizes(p, q, r);
            let [short_mm2, middle_mm2, long_mm2] = sizes.squares_mm2;
            self.gap_mm[row] = sizes.gap_mm;
            self.area_mm2[row] = sizes.area_mm2;
            self.projected_mm2[row] = sizes.projected_area_mm2;
            self.squares_mm2[row] = short_mm2 + middle_mm2 + long_mm2;
            self.long_mm2[row] = if sizes.is_stout() { long_mm2 } else { f64::INFINITY };
            self.epsilon[row] = sizes.gap_mm / self.lfs_mm[row];
            let [short, middle, long] = &mut self.halves_mm;
            [short[row], middle[row], long[row]] = sizes.halves_mm();
            self.bluntness[row] = sizes.bluntness();
        }
    }
}

/// Up to where a triangle is clearly covered.
#[derive(Clone, Copy)]
pub(super) struct Limits {
    /// The largest gap in mm wherever it is.
    gap_mm: f64,
    /// The largest ε.
    epsilon: f64,
    /// How much above both is within.
    slack: f64,
}

impl Limits {
    pub(super) fn of(target: &Target, slack: f64) -> Limits {
        let epsilon = target.epsilon.unwrap_or(f64::INFINITY);
        Limits { gap_mm: target.gap_anywhere_mm(), epsilon, slack }
    }
}

/// The sum over the rows of a block, in an order of its own: that in which several are added at once.
#[inline(always)]
pub(super) fn total(of: impl Fn(usize) -> f64) -> f64 {
    let mut lanes = [0.0; LANES];
    for first in (0..BLOCK).step_by(LANES) {
        for (lane, sum) in lanes.iter_mut().enumerate() {
            *sum += of(first + lane);
        }
    }
    let [a, b, c, d] = lanes;
    (a + c) + (b + d)
}

/// The largest number of a block; NaN is none.
#[inline(always)]
pub(super) fn largest(row: &Row) -> f64 {
    let mut lanes = [f64::NEG_INFINITY; LANES];
    for values in row.chunks_exact(LANES) {
        for (most, &value) in lanes.iter_mut().zip(values) {
            *most = if value > *most { value } else { *most };
        }
    }
    lanes.into_iter().fold(f64::NEG_INFINITY, f64::max)
}

/// The smallest number of a block; NaN is none.
#[inline(always)]
pub(super) fn smallest(row: &Row) -> f64 {
    let mut lanes = [f64::INFINITY; LANES];
    for values in row.chunks_exact(LANES) {
        for (least, &value) in lanes.iter_mut().zip(values) {
            *least = if value < *least { value } else { *least };
        }
    }
    lanes.into_iter().fold(f64::INFINITY, f64::min)
}

/// Sums at a time.
const LANES: usize = 4;

#[cfg(test)]
mod tests {
    use asphera_geometry::Triangle;
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn as_one_by_one(
            points in prop::collection::vec(prop::array::uniform3(-10.0..10.0_f64), 3..30),
            corners in prop::collection::vec(prop::array::uniform3(0_u32..1000), 1..=BLOCK),
        ) {
            let lfs_mm: Vec<f64> = (0..points.len()).map(|point| 1.0 + point as f64).collect();
            let distinct = |[a, b, c]: [VertexId; 3]| a != b && b != c && c != a;
            let corners: Vec<[VertexId; 3]> = corners
                .into_iter()
                .map(|corners| corners.map(|corner| corner % points.len() as VertexId))
                .filter(|&corners| distinct(corners))
                .collect();
            let mut block = Block::new();
            let count = block.measure(&points, &lfs_mm, corners.iter().copied());
            prop_assert_eq!(count, corners.len());
            let near = |left: f64, right: f64| (left - right).abs() <= 1e-9 * right.abs().max(1e-3);
            let (mut area_mm2, mut gap_mm) = (0.0, -1.0_f64);
            for (row, &corners) in corners.iter().enumerate() {
                let triangle = Triangle::new(&points, corners);
                let least_mm = corners.map(|corner| lfs_mm[corner as usize]).into_iter().fold(f64::INFINITY, f64::min);
                prop_assert_eq!(block.lfs_mm[row], least_mm);
                prop_assert_eq!(block.epsilon[row], block.gap_mm[row] / least_mm);
                prop_assert!(near(block.area_mm2[row], triangle.area_mm2()));
                prop_assert!(near(block.projected_mm2[row], triangle.projected_area_mm2()));
                prop_assert!(near(block.squares_mm2[row], triangle.squares_mm2()));
                if block.long_mm2[row] < f64::INFINITY {
                    prop_assert!(near(block.gap_mm[row], triangle.gap().mm));
                }
                area_mm2 += triangle.area_mm2();
                gap_mm = gap_mm.max(block.gap_mm[row]);
            }
            prop_assert!(near(total(|row| block.area_mm2[row]), area_mm2));
            prop_assert_eq!(largest(&block.gap_mm), gap_mm);
            for row in 0..count {
                block.take_out(row);
            }
            prop_assert_eq!(total(|row| block.area_mm2[row]), 0.0);
            prop_assert_eq!((largest(&block.epsilon), smallest(&block.lfs_mm)), (-1.0, f64::INFINITY));
        }
    }

    #[test]
    fn a_limit_is_inclusive_and_what_is_not_known_is_not_within() {
        let points = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let within = |target: &Target, lfs_mm: f64| {
            let mut block = Block::new();
            block.measure(&points, &[9.0, lfs_mm, 50.0], [[0, 1, 2]].into_iter());
            let mut within = [false; BLOCK];
            block.within(&Limits::of(target, 1.0), &mut within);
            within[0]
        };
        // The gap is 2.5 mm.
        assert!(within(&Target::epsilon(0.5), 5.0) && !within(&Target::epsilon(0.5), 4.9));
        assert!(within(&Target::reach(2.5, 1.0), 0.1) && !within(&Target::reach(2.4, 1.0), 0.1));
        assert!(!within(&Target::reach(2.5, 1.0), f64::NAN));
    }
}

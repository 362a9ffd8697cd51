//! Points hashed by the cells of one grid in space.

use asphera_geometry::PointMm;

use super::target::squared_mm2;

/// A grid of cubes in which points are found from their cells.
///
/// Cells are chained in buckets by a hash of their numbers; the numbers themselves are not kept.
/// Two cells in one bucket cost a few comparisons more and change nothing, because the distance
/// decides.
pub(super) struct Grid {
    /// Side of a cell is 2 to this power, in mm.
    exponent: i32,
    per_cell_mm: f64,
    /// The last point of each bucket; a power of two of them.
    heads: Vec<u32>,
    /// The point before in the same bucket.
    before: Vec<u32>,
}

impl Grid {
    /// The exponent of the grid in which a ball of radius `reach_mm` touches no more than two cells
    /// along each axis: the power of two that is at least twice as large, below four times.
    pub(super) fn exponent(reach_mm: f64) -> i32 {
        // The exponent of a normal number is that of the power of two below it.
        let biased = (reach_mm.to_bits() >> 52) as i32;
        biased - 1023 + 2
    }

    /// A grid that holds `points`.
    pub(super) fn new(exponent: i32, points: &[PointMm]) -> Grid {
        let buckets = (points.len() + 1).next_power_of_two().max(64);
        let mut grid = Grid {
            exponent,
            per_cell_mm: 2.0_f64.powi(-exponent),
            heads: vec![NONE; buckets],
            before: Vec::with_capacity(points.len()),
        };
        points.iter().for_each(|&point| grid.link(point));
        grid
    }

    /// The exponent of its cells' side.
    pub(super) fn side_exponent(&self) -> i32 {
        self.exponent
    }

    /// Adds the last of `points`; the grid holds all others.
    pub(super) fn push(&mut self, points: &[PointMm]) {
        if points.len() > self.heads.len() {
            *self = Grid::new(self.exponent, points);
        } else if let Some(&last) = points.last() {
            self.link(last);
        }
    }

    /// A point nearer to `centre` than the root of `below_mm2`, which is at most `reach_mm`; the
    /// grid is that of this reach. Which one of several depends on the order of insertion alone.
    pub(super) fn any_within(
        &self,
        centre: PointMm,
        reach_mm: f64,
        below_mm2: f64,
        points: &[PointMm],
    ) -> Option<u32> {
        let low = centre.map(|coordinate| self.cell(coordinate - reach_mm));
        let high = centre.map(|coordinate| self.cell(coordinate + reach_mm));
        let home = centre.map(|coordinate| self.cell(coordinate));
        // The cell of the centre is visited first: most points are found there.
        let other = [0, 1, 2].map(|axis| if home[axis] == low[axis] { high } else { low }[axis]);
        for corner in 0..8_usize {
            let beyond = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            if (0..3).any(|axis| beyond[axis] && other[axis] == home[axis]) {
                continue;
            }
            let cell = [0, 1, 2].map(|axis| if beyond[axis] { other } else { home }[axis]);
            let mut point = self.heads[self.bucket(cell)];
            while point != NONE {
                if squared_mm2(points[point as usize], centre) < below_mm2 {
                    return Some(point);
                }
                point = self.before[point as usize];
            }
        }
        None
    }

    fn link(&mut self, point: PointMm) {
        let bucket = self.bucket(point.map(|coordinate| self.cell(coordinate)));
        let number = self.before.len() as u32;
        self.before.push(self.heads[bucket]);
        self.heads[bucket] = number;
    }

    /// The number of a cell along one axis. A power of two divides without rounding. Numbers too
    /// large for the type are taken as its largest: those cells share a bucket.
    fn cell(&self, coordinate_mm: f64) -> i64 {
        (coordinate_mm * self.per_cell_mm).floor() as i64
    }

    fn bucket(&self, [x, y, z]: [i64; 3]) -> usize {
        // Odd multipliers keep neighbours apart; the last steps bring the high bits down.
        let mut mixed = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (y as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F)
            ^ (z as u64).wrapping_mul(0x1656_67B1_9E37_79F9);
        mixed ^= mixed >> 32;
        mixed = mixed.wrapping_mul(0xD6E8_FEB8_6659_FD93);
        mixed ^= mixed >> 32;
        mixed as usize & (self.heads.len() - 1)
    }
}

/// No point.
const NONE: u32 = u32::MAX;

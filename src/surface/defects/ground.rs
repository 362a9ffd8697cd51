//! The noise of a whole surface, from one visit to its samples and a few of them once more.

use asphera_geometry::{PointMm, VertexId};

use super::detect::SCALES;
use super::noise_field::{CellNoise, NoiseField};
use super::screen::{Raster, Tally};
use super::tail::{self, Tail};

/// How the noise differs by place, and how far it goes.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    pub(super) field: NoiseField,
    pub(super) tail: Tail,
    /// By ring numbers, the least that counts as the deviation of a mean over that of white noise.
    pub(super) colour: [f64; SCALES],
}

/// Finds it from the tallies of cells of a few samples, and from `used` of these samples themselves.
pub(super) fn ground<I: Iterator<Item = (VertexId, PointMm, f64)>>(
    raster: &Raster,
    tallies: &[Tally],
    samples: impl Fn() -> I,
    used: u64,
) -> Ground {
    let side_mm = raster.per_mm.recip();
    let planes: Vec<Option<Plane>> =
        (0..tallies.len()).map(|slot| Plane::of(raster, tallies, slot)).collect();
    let cells = planes.iter().zip(tallies).enumerate().filter_map(|(slot, (plane, tally))| {
        let plane = plane.as_ref()?;
        let count = f64::from(tally.count);
        let sum_of_squares = tally.squares - count * plane.mean * plane.mean;
        let by_slope = plane.slope.iter().map(|slope| slope * slope).sum::<f64>() / 12.0;
        let variance = (sum_of_squares / (count - 1.0) - by_slope).max(0.0);
        Some(CellNoise { place_mm: raster.middle_mm(slot), variance })
    });
    let extent_mm = raster.size.map(|count| (count as f64 - 0.5) * side_mm);
    let field = NoiseField::of(cells, raster.low_mm, extent_mm, side_mm);
    let mut pieces = tail::pieces();
    let step = (used as usize).div_ceil(TAIL_OF);
    for (_, point, deviation) in samples().step_by(step) {
        let slot = raster.slot(point);
        let Some(plane) = &planes[slot] else { continue };
        let middle_mm = raster.middle_mm(slot);
        let [x, y] = [0, 1].map(|axis| (point[axis] - middle_mm[axis]) * raster.per_mm);
        let level = plane.mean + x * plane.slope[0] + y * plane.slope[1];
        let unit = (1.0 - f64::from(tallies[slot].count).recip()).sqrt();
        let size = (deviation - level).abs() / (unit * field.at(middle_mm));
        let cell = [slot % raster.size[0], slot / raster.size[0]];
        pieces[tail::piece_of(cell, raster.size)].push(size);
    }
    Ground { field, tail: Tail::of_cells(pieces), colour: [1.0; SCALES] }
}

impl Ground {
    /// Looks at how means of cells differ from those of the cells to either side: by more than white noise of
    /// `single_mm` lets them if lines of a scan have levels of their own.
    pub(super) fn with_colour(
        mut self,
        (raster, shapes): (&Raster, &[f64]),
        tallies: &[Tally],
        single_mm: f64,
    ) -> Ground {
        for (ring, colour) in self.colour.iter_mut().enumerate().skip(1) {
            // A cell has about as many samples as the first ring, 2×2 cells as many as the second.
            for axis in 0..2 {
                let mut sizes: Vec<f64> = (0..tallies.len())
                    .step_by(tallies.len() / COLOUR_OF + 1)
                    .filter_map(|slot| {
                        Some(apart(raster, tallies, slot, (ring, axis))?.abs() / shapes[slot])
                    })
                    .collect();
                let scale = tail::scale(&mut sizes).unwrap_or(0.0) / (OF_MEDIAN * single_mm);
                if scale > PLAIN {
                    *colour = colour.max(scale);
                }
            }
        }
        self
    }

    /// The noise in each cell over its median.
    pub(super) fn shapes(&self, raster: &Raster) -> Vec<f64> {
        let slots = 0..raster.size[0] * raster.size[1];
        slots.map(|slot| self.field.at(raster.middle_mm(slot))).collect()
    }
}

impl Raster {
    fn middle_mm(&self, slot: usize) -> [f64; 2] {
        let [column, row] = [slot % self.size[0], slot / self.size[0]];
        [(column, 0), (row, 1)]
            .map(|(at, axis)| self.low_mm[axis] + (at as f64 + 0.5) / self.per_mm)
    }
}

/// The plane through a cell, as the cells beside it tell its slopes.
struct Plane {
    mean: f64,
    /// Over a side of a cell.
    slope: [f64; 2],
}

impl Plane {
    /// `None` of a cell with too few samples.
    fn of(raster: &Raster, tallies: &[Tally], slot: usize) -> Option<Plane> {
        let mean = |slot: usize| {
            let tally = &tallies[slot];
            (tally.count > 0).then(|| tally.sum / f64::from(tally.count))
        };
        if tallies[slot].count < LEAST {
            return None;
        }
        let place = [slot % raster.size[0], slot / raster.size[0]];
        let slope = [(0, 1), (1, raster.size[0])].map(|(axis, step)| {
            let inside = place[axis] > 0 && place[axis] + 1 < raster.size[axis];
            let beside = inside.then(|| mean(slot - step).zip(mean(slot + step))).flatten();
            beside.map_or(0.0, |(before, after)| 0.5 * (after - before))
        });
        Some(Plane { mean: mean(slot)?, slope })
    }
}

/// By how much a block of cells lies off the cubic through the next two to either side along an axis, over what that is for
/// samples that differ by 1: form and wide defects are nearly cubics there.
fn apart(
    raster: &Raster,
    tallies: &[Tally],
    slot: usize,
    (side, axis): (usize, usize),
) -> Option<f64> {
    let [column, row] = [slot % raster.size[0], slot / raster.size[0]];
    let mean = |column: usize, row: usize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for row in row..row + side {
            for column in column..column + side {
                let inside = column < raster.size[0] && row < raster.size[1];
                let tally = inside.then(|| &tallies[row * raster.size[0] + column]);
                let tally = tally.filter(|tally| tally.count >= LEAST)?;
                sum += tally.sum;
                count += f64::from(tally.count);
            }
        }
        Some([sum / count, count.recip()])
    };
    let beside = |blocks: usize| -> Option<[[f64; 2]; 2]> {
        let step = if axis == 0 { [blocks * side, 0] } else { [0, blocks * side] };
        let before = mean(column.checked_sub(step[0])?, row.checked_sub(step[1])?)?;
        Some([before, mean(column + step[0], row + step[1])?])
    };
    let own = mean(column, row)?;
    let (mut off, mut variance) = (own[0], own[1]);
    for (weight, [before, after]) in [(2.0 / 3.0, beside(1)?), (-1.0 / 6.0, beside(2)?)] {
        off -= weight * (before[0] + after[0]);
        variance += weight * weight * (before[1] + after[1]);
    }
    Some(off / variance.sqrt())
}

/// Cells that are enough for that of means.
const COLOUR_OF: usize = 20_000;
/// Deviation of samples over the root of the median of the mean squares of cells of six.
const OF_MEDIAN: f64 = 1.06;
/// A deviation of means up to which noise is taken for white.
const PLAIN: f64 = 1.15;
/// Fewest samples of a cell that tell how they differ.
const LEAST: u32 = 3;
/// Samples that are enough for that.
const TAIL_OF: usize = 100_000;

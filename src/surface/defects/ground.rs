//! The noise of a whole surface, from one visit to its samples and a few of them once more.

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;

use super::detect::SCALES;
use super::noise_field::{CellNoise, NoiseField};
use super::screen::Raster;
use super::tail::{self, Tail};
use super::tally::{self, Tally};

/// How the noise differs by place, and how far it goes.
#[derive(Clone, Debug)]
pub(super) struct Ground {
    pub(super) field: NoiseField,
    pub(super) tail: Tail,
    /// By widths of sums, the least that counts as the deviation of a mean over that of white noise.
    pub(super) colour: [f64; SCALES],
}

/// Finds it from the planes of cells of a few samples, and from `used` of these samples themselves.
pub(super) fn ground<I: Iterator<Item = (VertexId, PointMm, f64)>>(
    (raster, planes): (&Raster, &[Option<Plane>]),
    samples: impl Fn() -> I,
    used: u64,
) -> Ground {
    let side_mm = raster.per_mm.recip();
    let cells = planes.iter().enumerate().filter_map(|(slot, plane)| {
        let variance = plane.as_ref()?.variance;
        Some(CellNoise { place_mm: raster.middle_mm(slot), variance })
    });
    let extent_mm = raster.size.map(|count| (count as f64 - 0.5) * side_mm);
    let field = NoiseField::of(cells, raster.low_mm, extent_mm, side_mm);
    let mut pieces = tail::pieces();
    let step = (used as usize).div_ceil(TAIL_OF);
    for (_, point, deviation) in samples().step_by(step) {
        let slot = raster.slot(point);
        let Some(plane) = &planes[slot] else { continue };
        let level = plane.at(raster.place_in(slot, point));
        let unit = (1.0 - plane.count.recip()).sqrt();
        let size = (deviation - level).abs() / (unit * field.at(raster.middle_mm(slot)));
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
        planes: &[Option<Plane>],
        single_mm: f64,
    ) -> Ground {
        for (ring, colour) in self.colour.iter_mut().enumerate().skip(1) {
            // A cell has about as many samples as the narrowest sum of several, 2×2 cells as the next, 3×3 as the widest.
            for axis in 0..2 {
                let mut sizes: Vec<f64> = (0..planes.len())
                    .step_by(planes.len() / COLOUR_OF + 1)
                    .filter_map(|slot| {
                        Some(apart(raster, planes, slot, (ring, axis))?.abs() / shapes[slot])
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

/// The plane through the samples of a cell.
pub(super) struct Plane {
    count: f64,
    mean: f64,
    /// Where it has that height, from the middle of the cell in its sides.
    middle: [f64; 2],
    /// Over a side of a cell.
    slope: [f64; 2],
    /// Variance of the samples about it.
    variance: f64,
}

/// The plane of each cell; `None` of those with too few samples.
pub(super) fn planes(raster: &Raster, tallies: &[Tally]) -> Vec<Option<Plane>> {
    let plane = |(slot, tally): (usize, &Tally)| {
        if tally.count < LEAST {
            return None;
        }
        let count = f64::from(tally.count);
        let (mean, middle) = (tally.sum / count, tally.middle());
        let slope = tally::slope(raster.size, tallies, slot);
        let variance = tally.squares_about(mean, slope) / (count - 1.0);
        Some(Plane { count, mean, middle, slope, variance })
    };
    tallies.par_iter().enumerate().with_min_len(4096).map(plane).collect()
}

impl Plane {
    /// Height at a place from the middle of the cell in its sides.
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.mean + (x - self.middle[0]) * self.slope[0] + (y - self.middle[1]) * self.slope[1]
    }
}

/// By how much a block of cells lies off the cubic through the next two to either side along an axis, over what that is for
/// samples that differ by 1: form and wide defects are nearly cubics there.
fn apart(
    raster: &Raster,
    planes: &[Option<Plane>],
    slot: usize,
    (side, axis): (usize, usize),
) -> Option<f64> {
    let [column, row] = [slot % raster.size[0], slot / raster.size[0]];
    let mean = |column: usize, row: usize| {
        let (mut sum, mut count) = (0.0, 0.0);
        for row in row..row + side {
            for column in column..column + side {
                let inside = column < raster.size[0] && row < raster.size[1];
                let plane = inside.then(|| planes[row * raster.size[0] + column].as_ref())??;
                sum += plane.count * plane.at([0.0; 2]);
                count += plane.count;
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

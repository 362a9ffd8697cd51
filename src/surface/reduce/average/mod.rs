//! Kept points with the mean of what was measured about them.
//!
//! The height of a kept point is read from a plane or quadric fitted to measured points about it. The wider the
//! window, the less noise is left, and the more the surface bends away from the fit: its *bias*. Each kept point has
//! its own window, chosen from its cell, the nearer half of the cell's points, half of those, and so on (`ladder.rs`):
//!
//! - The bias is estimated from a quartic over the window and its surroundings (`choice.rs`): the fit is applied to the
//!   quartic itself, and what it gets wrong there is the bias. A window counts if that is below a
//!   quarter of its statistical uncertainty, and is then part of the uncertainty stated.
//! - Readings over narrower windows must agree with it, of the point itself and of the kept points about it. So what
//!   the quartic does not follow, such as a step or a short wave, is not averaged away as far as the noise lets it be seen.
//!
//! Where no window does, the point stays as it was measured. A cell's points belong to no other, so the noise of averaged
//! heights is independent.

mod cells;
mod choice;
mod ladder;

use asphera_geometry::PointMm;
use rayon::prelude::*;

use self::cells::Cells;
use self::choice::Choosing;
use self::ladder::Ladder;

/// The averages of kept points.
#[derive(Clone, Debug, PartialEq)]
pub struct Averaged {
    /// One for each kept point, in the same order.
    pub points: Vec<AveragedPoint>,
    /// How many were averaged; the others stay as measured.
    pub averaged: u64,
}

/// A kept point with the mean of its surroundings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AveragedPoint {
    /// The place of the kept point, and its averaged height, in mm.
    pub point_mm: PointMm,
    /// Standard uncertainty of the height in mm, from independent noise and from the bias: σ where nothing was
    /// averaged.
    pub u_mm: f64,
    /// The share of the bias in that, in mm: how far the fit is taken to be off where the surface bends. Zero where
    /// nothing was averaged.
    pub bias_mm: f64,
    /// How many measurements went into it.
    pub measurements: u64,
}

/// Gives each of the `kept` points the height of a surface fitted by least squares to `points` about it, read at its
/// own place. `sigma_mm` is the standard deviation of a height.
///
/// `known_mm` is the height of a surface that is known, such as the nominal where it lies, at the x and y of a point,
/// if there is one. It is taken off first and added again, so that only what deviates from it is averaged.
///
/// Points that are not finite must have been left out. Noise that is not independent from point to
/// point, such as vibration, is reduced less than `u_mm` says. Waves
/// that are shorter than the window and lower than about σ may stay unseen and be averaged away: on a wave 0.3 σ high, as
/// long as five points, the root mean square of errors was 2.3 `u_mm`. Takes n·log k time for k kept points.
///
/// # Panics
///
/// At 2³² kept points.
pub fn average(
    points: &[PointMm],
    kept: &[PointMm],
    sigma_mm: f64,
    known_mm: impl Fn(PointMm) -> Option<f64> + Sync,
) -> Averaged {
    let cells = Cells::new(points, kept);
    let of = |point: &PointMm| known_mm(*point).unwrap_or(f64::NAN);
    let heights = Heights {
        points,
        kept,
        known_mm: points.par_iter().map(of).collect(),
        known_of_kept_mm: kept.par_iter().map(of).collect(),
    };
    let ladders: Vec<Ladder> = (0..kept.len())
        .into_par_iter()
        .map(|number| Ladder::over(&heights.offsets_mm(number, cells.of(number))))
        .collect();
    let choosing = Choosing { cells: &cells, heights: &heights, ladders: &ladders, sigma_mm };
    let points: Vec<AveragedPoint> = (0..kept.len())
        .into_par_iter()
        .map(|number| {
            let at = kept[number];
            match choosing.best(number) {
                Some(best) => AveragedPoint {
                    point_mm: [at[0], at[1], at[2] + best.reading.height_mm],
                    u_mm: (sigma_mm * best.reading.factor).hypot(best.bias_mm),
                    bias_mm: best.bias_mm,
                    measurements: best.count as u64,
                },
                None => {
                    AveragedPoint { point_mm: at, u_mm: sigma_mm, bias_mm: 0.0, measurements: 1 }
                }
            }
        })
        .collect();
    let averaged = points.iter().filter(|point| point.measurements > 1).count() as u64;
    Averaged { points, averaged }
}

/// Measured and kept points, with the surface that is known under them, NaN where there is none.
struct Heights<'a> {
    points: &'a [PointMm],
    kept: &'a [PointMm],
    known_mm: Vec<f64>,
    known_of_kept_mm: Vec<f64>,
}

impl Heights<'_> {
    /// The offsets of points from a kept one, heights over the surface that is known. Where none is known under the kept
    /// point they are those of the points as they are, else points over none are left out.
    fn offsets_mm(&self, number: usize, of: &[u32]) -> Vec<[f64; 3]> {
        let (at, under_mm) = (self.kept[number], self.known_of_kept_mm[number]);
        let offset = |&index: &u32| {
            let [x, y, z] = self.points[index as usize];
            let risen_mm = self.known_mm[index as usize] - under_mm;
            [x - at[0], y - at[1], z - at[2] - if under_mm.is_nan() { 0.0 } else { risen_mm }]
        };
        of.iter().map(offset).filter(|offset| !offset[2].is_nan()).collect()
    }
}

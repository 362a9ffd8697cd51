//! A smooth surface through scattered points when no nominal is known.
//!
//! Penalised B-splines (Eilers & Marx, Stat. Sci. 11 (1996) 89; over a rectangle: Eilers, Currie & Durbán,
//! Comput. Stat. Data Anal. 50 (2006) 61): the sum of the squares of the residuals in z plus λ times that of
//! the second differences of the coefficients along x and along y is least. Differences are per cell, so
//! cells should be about square. λ is chosen by generalised cross validation (Craven & Wahba, Numer. Math. 31
//! (1979) 377) or so that the residuals have a given standard deviation.
//!
//! The penalty carries the splines across areas without points; the surface is defined only in cells that
//! hold a point.

mod accumulated;
mod band;
mod map_cells;
mod moments;
mod reference;
mod running;

pub use reference::{
    Base, Knots, Reference, ReferenceError, ReferenceSettings, provisional, reference,
};
pub use running::LiveReference;

use std::f64::consts::TAU;

use thiserror::Error;

use crate::PointMm;
use crate::shape::{Cells, SplineError, SplineSurface, spline_weights};
use band::{Band, Factor};

/// How smooth the surface is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Smoothing {
    /// By generalised cross validation: for noise without correlation whose size is not known.
    CrossValidation,
    /// So that the residuals have this standard deviation.
    Noise {
        /// Standard deviation of the noise of z in mm.
        sigma_mm: f64,
    },
    /// By a given λ relative to the point density: 0.001 follows the points, 1000 nearly a plane per few cells.
    Relative {
        /// λ over the ratio of the traces of the normal matrix and of the penalty.
        lambda: f64,
    },
}

/// The result of a spline fit.
#[derive(Clone, Debug, PartialEq)]
pub struct SplineFit {
    /// The surface, in the frame of the points.
    pub surface: SplineSurface,
    /// λ relative to the point density, as in [`Smoothing::Relative`].
    pub lambda: f64,
    /// Whether λ is the smallest or largest looked at: what was asked for lies beyond, as where the cells are
    /// too coarse to follow the points to within the noise, or the points have no curvature above it.
    pub at_limit: bool,
    /// Wavelength in mm along x and along y of which half the height is followed: longer waves are in the
    /// surface, shorter ones in the residuals. By the response 1/(1 + λ′·(k·step)⁴) of penalised splines to a wave
    /// of wave number k, with λ′ the weight of the penalty per point of a cell; not below two cells, the shortest
    /// wave splines have.
    pub cutoff_mm: [f64; 2],
    /// Effective number of parameters: the trace of the matrix that takes heights to fitted heights.
    pub effective_parameters: f64,
    /// Estimated standard deviation of the noise in mm: root of the square of the residuals over the points
    /// less the effective parameters. `None` without degrees of freedom.
    pub noise_mm: Option<f64>,
    /// Root mean square of the residuals in z, in mm.
    pub residual_rms_mm: f64,
    /// Points used.
    pub used: usize,
    /// Points left out because a coordinate was not finite.
    pub not_finite: usize,
    /// Points left out because they lie in no cell.
    pub outside: usize,
}

/// Why there is no spline fit.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SplineFitError {
    /// The cells are none.
    #[error("the cells are not usable")]
    Cells(#[from] SplineError),
    /// A number for the smoothing that is not positive and finite.
    #[error("{name} of the smoothing is {value}, expected a positive number")]
    Smoothing {
        /// Which: `sigma_mm` or `lambda`.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// Points that leave the surface free.
    #[error(
        "{used} points in the cells do not determine a surface ({outside} more lie outside, {not_finite} are not finite). Measure four or more, on three or more lines along x and y"
    )]
    Undetermined {
        /// Points in the cells.
        used: usize,
        /// Points outside.
        outside: usize,
        /// Points that are not finite.
        not_finite: usize,
    },
}

/// Fits a spline surface to points, by their z. `O(n + splines·nx²)` for each λ looked at, of which there are
/// 1 to 40.
pub fn fit_spline(
    points: &[PointMm],
    cells: &Cells,
    smoothing: Smoothing,
) -> Result<SplineFit, SplineFitError> {
    cells.validate()?;
    let positive = |name, value: f64| {
        let valid = value.is_finite() && value > 0.0;
        if valid { Ok(()) } else { Err(SplineFitError::Smoothing { name, value }) }
    };
    match smoothing {
        Smoothing::CrossValidation => {}
        Smoothing::Noise { sigma_mm } => positive("sigma_mm", sigma_mm)?,
        Smoothing::Relative { lambda } => positive("lambda", lambda)?,
    }
    let problem = Problem::new(points, cells);
    let Problem { used, not_finite, outside, .. } = problem;
    let undetermined = SplineFitError::Undetermined { used, outside, not_finite };
    let defined: Vec<bool> = problem.counts.iter().map(|&count| count > 0).collect();
    let system = problem.system(points).ok_or(undetermined)?;
    let (trial, at_limit) = system.smoothed(smoothing);
    let trial = trial.ok_or(undetermined)?;
    let surface = SplineSurface::new(*cells, &trial.coefficients_mm, &defined)?;
    Ok(SplineFit { not_finite, outside, ..spline_fit(surface, &trial, at_limit, &system) })
}

/// Report of the splines of a trial.
fn spline_fit(surface: SplineSurface, trial: &Trial, at_limit: bool, system: &System) -> SplineFit {
    let freedom = system.used as f64 - trial.effective;
    let holding = surface.defined().iter().filter(|defined| **defined).count();
    let per_cell = system.used as f64 / holding as f64;
    let waves = (TAU * (trial.lambda * system.unit / per_cell).sqrt().sqrt()).max(2.0);
    let cells = surface.cells();
    SplineFit {
        surface,
        lambda: trial.lambda,
        at_limit,
        cutoff_mm: [waves * cells.step_x_mm, waves * cells.step_y_mm],
        effective_parameters: trial.effective,
        noise_mm: (freedom > 1e-6).then(|| (trial.square / freedom).sqrt()),
        residual_rms_mm: (trial.square / system.used as f64).sqrt(),
        used: system.used,
        not_finite: 0,
        outside: 0,
    }
}

/// The normal equations of the splines alone.
struct Problem<'a> {
    cells: &'a Cells,
    /// Bᵀ·B.
    gram: Band,
    /// Bᵀ·z.
    along: Vec<f64>,
    /// Points in each cell.
    counts: Vec<u32>,
    used: usize,
    not_finite: usize,
    outside: usize,
}

impl<'a> Problem<'a> {
    fn new(points: &[PointMm], cells: &'a Cells) -> Problem<'a> {
        let size = cells.splines();
        let mut problem = Problem {
            cells,
            gram: Band::new(size, 3 * (cells.nx + 3) + 3),
            along: vec![0.0; size],
            counts: vec![0; cells.nx * cells.ny],
            used: 0,
            not_finite: 0,
            outside: 0,
        };
        for point in points {
            if !point.iter().all(|coordinate| coordinate.is_finite()) {
                problem.not_finite += 1;
                continue;
            }
            let Some((cell, splines)) = row(cells, point) else {
                problem.outside += 1;
                continue;
            };
            problem.used += 1;
            problem.counts[cell] = problem.counts[cell].saturating_add(1);
            for (k, &(index, value)) in splines.iter().enumerate() {
                problem.along[index] += value * point[2];
                for &(other, beside) in &splines[..=k] {
                    problem.gram.add(index, other, value * beside);
                }
            }
        }
        problem
    }
}

/// The cell of a point, and index and value of the 16 splines there, ascending.
fn row(cells: &Cells, point: &PointMm) -> Option<(usize, [(usize, f64); 16])> {
    let (cell, [u, v]) = cells.at(point[0], point[1])?;
    let ([along, ..], [across, ..]) = (spline_weights(u), spline_weights(v));
    let first = cells.first_spline(cell);
    let spline = |k: usize| (first + k / 4 * (cells.nx + 3) + k % 4, across[k / 4] * along[k % 4]);
    Some((cell, std::array::from_fn(spline)))
}

/// The problem about a first solution, so that figures of the residuals do not cancel against the heights.
#[derive(Clone, Debug)]
struct System {
    /// Bᵀ·B.
    gram: Band,
    penalty: Band,
    /// λ for a relative λ of 1.
    unit: f64,
    begin_mm: Vec<f64>,
    /// Bᵀ·r of the first solution's residuals r, and rᵀ·r.
    along: Vec<f64>,
    square: f64,
    used: usize,
}

/// A solution for one λ.
#[derive(Clone, Debug)]
struct Trial {
    lambda: f64,
    coefficients_mm: Vec<f64>,
    /// Sum of the squares of the residuals in mm².
    square: f64,
    effective: f64,
}

impl Problem<'_> {
    /// The problem about its first solution; `None` where the points leave the surface free to rounding.
    fn system(self, points: &[PointMm]) -> Option<System> {
        let Problem { cells, gram, along: heights, used, .. } = self;
        let penalty = penalty(cells.nx + 3, cells.ny + 3);
        let unit = gram.trace() / penalty.trace();
        if used < LEAST_USED {
            return None;
        }
        let begin_mm = gram.plus(FIRST * unit, &penalty).factor()?.solve(&heights);
        let (mut along, mut square) = (vec![0.0; begin_mm.len()], 0.0);
        for point in points.iter().filter(|point| point[2].is_finite()) {
            let Some((_, splines)) = row(cells, point) else { continue };
            let fitted: f64 = splines.iter().map(|&(index, value)| value * begin_mm[index]).sum();
            let residual = point[2] - fitted;
            square += residual * residual;
            for (index, value) in splines {
                along[index] += value * residual;
            }
        }
        Some(System { gram, penalty, unit, begin_mm, along, square, used })
    }
}

impl System {
    /// The solution of the smoothness that is asked for, and whether its λ is at a limit.
    fn smoothed(&self, smoothing: Smoothing) -> (Option<Trial>, bool) {
        match smoothing {
            Smoothing::CrossValidation => self.cross_validated(),
            Smoothing::Noise { sigma_mm } => self.of_noise(sigma_mm),
            Smoothing::Relative { lambda } => (self.trial(lambda), false),
        }
    }

    /// The same where a little fewer points had their best λ `near`: cross validation of many splines looks no farther
    /// than the nearest minimum.
    fn smoothed_near(&self, smoothing: Smoothing, near: f64) -> (Option<Trial>, bool) {
        match smoothing {
            Smoothing::CrossValidation if self.begin_mm.len() > FEW_SPLINES => {
                self.cross_validated_near(near)
            }
            _ => self.smoothed(smoothing),
        }
    }

    /// The sum of the squares of the residuals in mm² where the coefficients have changed so far.
    fn square_mm2(&self, change_mm: &[f64]) -> f64 {
        let gained: f64 = change_mm.iter().zip(&self.along).map(|(a, b)| a * b).sum();
        let moved = self.gram.times(change_mm);
        let moved: f64 = change_mm.iter().zip(moved).map(|(a, b)| a * b).sum();
        (self.square - 2.0 * gained + moved).max(0.0)
    }

    /// How far the coefficients are from the first solution where the penalty has this weight, and the factor that
    /// tells. `None` where the points leave the surface free to rounding.
    fn change(&self, weight: f64) -> Option<(Vec<f64>, Factor)> {
        let factor = self.gram.plus(weight, &self.penalty).factor()?;
        let pulled = self.penalty.times(&self.begin_mm);
        let rhs: Vec<f64> =
            self.along.iter().zip(&pulled).map(|(along, pull)| along - weight * pull).collect();
        Some((factor.solve(&rhs), factor))
    }

    /// `None` where the points leave the surface free to rounding.
    fn trial(&self, lambda: f64) -> Option<Trial> {
        let (change, factor) = self.change(lambda * self.unit)?;
        Some(Trial {
            lambda,
            coefficients_mm: self.begin_mm.iter().zip(&change).map(|(a, b)| a + b).collect(),
            square: self.square_mm2(&change),
            effective: factor.trace_of_solution(&self.gram),
        })
    }

    /// n·(sum of squares)/(n − effective parameters)², but for the n.
    fn score(&self, trial: &Trial) -> f64 {
        let freedom = self.used as f64 - trial.effective;
        // Where nothing is left over both go to zero, and their ratio says nothing.
        let says = freedom > 0.02 * self.used as f64;
        if says { trial.square / (freedom * freedom) } else { f64::INFINITY }
    }

    /// The minimum of the score.
    fn cross_validated(&self) -> (Option<Trial>, bool) {
        let mut search = Search { system: self, middle: SMALLEST, best: None };
        for exponent in SMALLEST as i32..=LARGEST as i32 {
            search.try_at(f64::from(exponent));
        }
        let at_limit = search.is_at_limit();
        let mut step = 0.5;
        while step > 0.05 {
            let centre = search.middle;
            search.try_at(centre - step);
            search.try_at(centre + step);
            step *= 0.5;
        }
        (search.best.map(|(_, trial)| trial), at_limit)
    }

    /// The minimum of the score that is nearest downhill, in the steps in which the search among all ends.
    fn cross_validated_near(&self, near: f64) -> (Option<Trial>, bool) {
        let (lowest, highest) = (SMALLEST - 1.0, LARGEST + 1.0);
        let middle = ((near.log10() / LAST_STEP).round() * LAST_STEP).clamp(lowest, highest);
        let mut search = Search { system: self, middle, best: None };
        search.try_at(middle);
        for step in [-LAST_STEP, LAST_STEP] {
            loop {
                let next = search.middle + step;
                if !(lowest..=highest).contains(&next) || !search.try_at(next) {
                    break;
                }
            }
        }
        let at_limit = search.is_at_limit();
        (search.best.map(|(_, trial)| trial), at_limit)
    }

    /// The λ at which the estimated noise is `sigma_mm`: it grows with λ.
    fn of_noise(&self, sigma_mm: f64) -> (Option<Trial>, bool) {
        let too_smooth = |trial: &Trial| {
            trial.square > sigma_mm * sigma_mm * (self.used as f64 - trial.effective)
        };
        let (mut low, mut high) = (SMALLEST, LARGEST);
        let smoothest = self.trial(10_f64.powf(high));
        if smoothest.as_ref().is_some_and(|trial| !too_smooth(trial)) {
            return (smoothest, true);
        }
        let roughest = self.trial(10_f64.powf(low));
        if roughest.as_ref().is_some_and(too_smooth) {
            return (roughest, true);
        }
        let mut last = None;
        while high - low > 0.01 {
            let middle = low.midpoint(high);
            let trial = self.trial(10_f64.powf(middle));
            if trial.as_ref().is_some_and(too_smooth) {
                high = middle;
            } else {
                low = middle;
            }
            last = trial.or(last);
        }
        (last, false)
    }
}

/// A search for the least score.
struct Search<'a> {
    system: &'a System,
    /// The power of ten of the best λ so far.
    middle: f64,
    best: Option<(f64, Trial)>,
}

impl Search<'_> {
    /// Looks at a power of ten; whether it is better than those before.
    fn try_at(&mut self, exponent: f64) -> bool {
        let Some(trial) = self.system.trial(10_f64.powf(exponent)) else { return false };
        let value = self.system.score(&trial);
        let better = self.best.as_ref().is_none_or(|(least, _)| value < *least);
        if better {
            self.middle = exponent;
            self.best = Some((value, trial));
        }
        better
    }

    fn is_at_limit(&self) -> bool {
        self.middle <= SMALLEST || self.middle >= LARGEST
    }
}

/// DᵀD of the second differences along every row and every column of coefficients.
fn penalty(columns: usize, rows: usize) -> Band {
    let mut penalty = Band::new(columns * rows, 3 * columns + 3);
    let mut difference = |first: usize, stride: usize| {
        for (k, a) in [1.0, -2.0, 1.0].into_iter().enumerate() {
            for (l, b) in [1.0, -2.0, 1.0].into_iter().enumerate().take(k + 1) {
                penalty.add(first + k * stride, first + l * stride, a * b);
            }
        }
    };
    for row in 0..rows {
        for column in 0..columns {
            if column + 2 < columns {
                difference(row * columns + column, 1);
            }
            if row + 2 < rows {
                difference(row * columns + column, columns);
            }
        }
    }
    penalty
}

/// Relative λ of the first solution.
const FIRST: f64 = 1e-3;
/// Powers of ten of the smallest and largest relative λ looked at.
const SMALLEST: f64 = -8.0;
const LARGEST: f64 = 6.0;
/// Step of the powers in which the search among all ends: 0.5 halved until it is below 0.05 after the last.
const LAST_STEP: f64 = 0.0625;
/// So few splines are solved so fast that all smoothnesses are looked at every time.
const FEW_SPLINES: usize = 600;
/// Points below which no surface is looked for.
const LEAST_USED: usize = 4;

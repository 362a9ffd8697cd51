//! Running figures while points still arrive.
//!
//! Every point is linearised once, at a reference pose and shape: its distance d and its row of the
//! Jacobian J go into a triangular factor and into one cell of a map. An estimate solves the small linear
//! problem that is left, so its cost does not depend on the number of points. When the number of points
//! has doubled, the reference becomes the full fit of all points so far, and all are linearised anew. Of many points
//! the estimate becomes the reference where the fit of a sample confirms it, and a few are linearised anew with each
//! point that comes: none of them waits for all others (see `succession.rs`). Over the life of an estimator that is `O(1)` a point.
//!
//! What is provisional: a distance changes with the pose by J·δ and by terms of second order, about |δ|²
//! times the curvature of the surface for shifts and |δ|²·|p| for turns. These terms are smooth over the
//! part, so they are measured at the centroid of each cell and taken for all its points; what is left is
//! their bend within a cell. PV looks at the points that were largest and smallest in their cell at the
//! reference: a point that has overtaken them since by the change of slope is missed, which is at most the
//! cell's size times that change. Points are in or out of the aperture as the reference has it.
//! [`Live::settle`] removes all three. Figures of a small patch are those of a pose with the tilts left out
//! (see [`LiveSettings::rank_tolerance`]), and never of a step that makes the sum of squares larger.

//!
//! Points with uncertainties have their rows summed twice: by weight 1/u², for the pose, and alike, for the figures,
//! which know no weights.
//!
//! With a robust loss rows are summed by the weights they have at the reference, too, and counted by classes of their
//! distance, block by block of cells: from these an estimate weighs all points anew, at the scale they have now (see
//! `reweighing.rs`). So it hangs neither on the pose at which a point came nor on when it is asked for. What is
//! provisional beyond the above is what changes in the weights within a class and a block since the reference. Against
//! the robust fit of the same points: pose within half its uncertainty, RMS within 0.5 % and PV within 1 % (seen: a quarter,
//! mostly a twentieth, and a millionth for both); where form error is 200 times the noise and the part still grows, so that a
//! quarter more points move the pose by many of its uncertainties, within 1.5 of these and 0.1 % and 0.2 % (seen: 0.8,
//! 0.005 % and 0.03 %). On patches that hardly tell tilts from shifts the fit itself has several solutions, and the estimate may lie
//! at another.

mod accumulator;
mod classes;
mod linearised;
mod middle;
mod problem;
mod referring;
mod reweighing;
mod succession;
mod weighted;

pub use accumulator::Accumulator;

use thiserror::Error;

use crate::deviation::NM_PER_MM;
use crate::fit::slant::Slant;
use crate::fit::{Estimate, Fit, FitSettings, method};
use crate::live::linearised::Linearised;
use crate::live::succession::{CATCHES_UP, Upcoming};
use crate::{
    Excluded, Figures, FitError, Loss, Nominal, Parameter, PointMm, Pose, Robust, Undetermined,
};

/// A regular grid of cells in the x-y plane of the part frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Left border in mm.
    pub x_min_mm: f64,
    /// Right border in mm.
    pub x_max_mm: f64,
    /// Lower border in mm.
    pub y_min_mm: f64,
    /// Upper border in mm.
    pub y_max_mm: f64,
    /// Cells along x, 1 to 1024.
    pub nx: usize,
    /// Cells along y, 1 to 1024.
    pub ny: usize,
}

/// Work of a running estimator.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveSettings {
    /// The fit it approaches.
    pub fit: FitSettings,
    /// The cells of the map. Points beyond it count in the figures all the same.
    pub grid: Grid,
    /// As [`FitSettings::rank_tolerance`], for references made on the way; the larger of both counts.
    /// A small patch of an asphere tells tilt from shift so badly that the vertex would wander by more
    /// than the part's size: until the patch has grown, tilts stay at their start.
    pub rank_tolerance: f64,
    /// The direction along which uncertainties are given, a unit vector of the measured frame: each reference turns them
    /// into uncertainties along the normal anew, as [`along_normal_mm`](crate::along_normal_mm) does with a fit of points that count alike.
    /// `None`: they are along the normal.
    pub uncertain_along: Option<[f64; 3]>,
}

impl LiveSettings {
    /// Settings with a tolerance of 2e-4 on the way, and uncertainties along the normal.
    pub fn new(fit: FitSettings, grid: Grid) -> LiveSettings {
        LiveSettings { fit, grid, rank_tolerance: 2e-4, uncertain_along: None }
    }

    /// How the direction of the uncertainties stands on a fit; `None`: they are along the normal.
    fn slant(&self, fit: &Fit) -> Option<Slant> {
        self.uncertain_along.map(|along| Slant::new(along, &fit.nominal, &fit.pose))
    }

    fn validate(&self) -> Result<(), LiveError> {
        if let Some(found) = self.uncertain_along {
            let length = found.iter().map(|share| share * share).sum::<f64>().sqrt();
            if (length - 1.0).abs() > UNIT || length.is_nan() {
                return Err(LiveError::Direction { found });
            }
        }
        self.grid.validate()
    }
}

/// Why a running estimator cannot be made, or not take what it was given.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum LiveError {
    /// A grid without cells, with too many, or with borders that are not finite or not in order.
    #[error(
        "map grid of {nx} × {ny} cells from ({x_min_mm}, {y_min_mm}) to ({x_max_mm}, {y_max_mm}) mm is empty or larger than {MAX_CELLS} × {MAX_CELLS}",
        nx = .0.nx, ny = .0.ny, x_min_mm = .0.x_min_mm, y_min_mm = .0.y_min_mm,
        x_max_mm = .0.x_max_mm, y_max_mm = .0.y_max_mm
    )]
    Grid(Grid),
    /// A direction of uncertainties that is none.
    #[error("uncertainties along {found:?}, expected a direction of length 1, as [0, 0, 1]")]
    Direction {
        /// Value found.
        found: [f64; 3],
    },
    /// An uncertainty that gives no weight.
    #[error(
        "the uncertainty of the point is {found_mm} mm, expected a positive finite length; leave a point out that is not to count"
    )]
    Uncertainty {
        /// Value found, in mm.
        found_mm: f64,
    },
    /// Points with and without uncertainties.
    #[error(
        "a point with an uncertainty after {points} points without, expected one for each point or none at all"
    )]
    Mixed {
        /// Points without.
        points: usize,
    },
    /// A reference that was not found by the loss it is to serve.
    #[error("the reference was found by the criterion \"{found}\", expected \"{expected}\"")]
    Reference {
        /// Its criterion.
        found: &'static str,
        /// That of the settings.
        expected: &'static str,
    },
    /// Estimators that cannot be merged.
    #[error("the {what} of the two estimators differ, expected the same in both")]
    Different {
        /// What differs: nominal, settings, reference or kinds of weights.
        what: &'static str,
    },
}

/// Mean deviations over a grid. What is linear in x and y, a tilt, has at the centroid of a cell exactly the
/// mean of its points.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The cells.
    pub grid: Grid,
    /// Mean deviation in nm, row after row from the smallest y, x fastest; NaN where no point has landed.
    pub mean_nm: Vec<f64>,
    /// Points in each cell, in the same order.
    pub counts: Vec<usize>,
    /// Mean place of these points in the part frame, mm; NaN where no point has landed.
    pub centroids_mm: Vec<[f64; 2]>,
}

/// Running figures. All are provisional: see [`Live`].
#[derive(Clone, Debug, PartialEq)]
pub struct LiveEstimate {
    /// From the part frame into the measured frame.
    pub pose: Pose,
    /// The nominal with its fitted shape.
    pub nominal: Nominal,
    /// The free and determinate parameters.
    pub estimates: Vec<Estimate>,
    /// Free parameters the points do not determine yet; they stand at their start.
    pub indeterminate: Vec<Parameter>,
    /// The same with the reason, as of the reference.
    pub undetermined: Vec<Undetermined>,
    /// The deviation.
    pub figures: Figures,
    /// Its map.
    pub map: Map,
    /// Mean square of the deviation in each cell of the map, in nm²; NaN where no point has landed. The scatter
    /// within a cell is that at the reference.
    pub mean_squares_nm2: Vec<f64>,
    /// What points with uncertainties tell beyond; `None` if they have none.
    pub weights: Option<LiveWeights>,
    /// What the robust loss did, counts to the width of a class; `None` for least squares.
    pub robust: Option<Robust>,
    /// As [`Fit::effective_points`](crate::Fit::effective_points).
    pub effective_points: f64,
    /// The RMS in mm that would be left if all points counted alike and by squares: no pose leaves less. With a robust loss
    /// half a percent below that, for what a linear problem may miss.
    pub least_rms_mm: f64,
    /// Points used.
    pub count: usize,
    /// Points left out.
    pub excluded: Excluded,
    /// Points there were when the reference was made.
    pub reference_count: usize,
}

/// Data known of the weights of a running fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveWeights {
    /// Smallest standard uncertainty of a point used, along the normal, in mm.
    pub u_min_mm: f64,
    /// The largest.
    pub u_max_mm: f64,
    /// As [`Fit::reduced_chi_square`](crate::Fit::reduced_chi_square).
    pub reduced_chi_square: Option<f64>,
}

impl LiveEstimate {
    /// The criterion, as reports give it and [`Fit::method`](crate::Fit::method) has it.
    pub fn method(&self) -> &'static str {
        method(self.weights.is_some(), self.robust.map_or(Loss::Squares, |robust| robust.loss))
    }

    /// The smallest RMS in nm that any pose and shape leave of these points: the RMS itself, unless they have weights
    /// or a robust loss.
    pub fn least_rms_nm(&self) -> f64 {
        NM_PER_MM * self.least_rms_mm
    }

    /// Whether every free parameter that points on this nominal can determine at all is determined.
    pub fn is_complete(&self) -> bool {
        self.undetermined.iter().all(|undetermined| undetermined.by_shape)
    }
}

/// The running estimator.
///
/// Its figures approach those of [`fit`](fn@crate::fit) over the same points, or of [`fit_weighted`](crate::fit_weighted) where these have uncertainties,
/// and reach them by [`Live::settle`]. Before that they leave out what the second-order change of the distances does within a cell of the map (far
/// below a picometre for scans that correct the pose by micrometres), and PV may miss a point that has
/// overtaken the extreme of its own cell.
///
/// It keeps every point: 24 bytes each, 32 with its uncertainty, beside about 400 bytes for each cell of the map; with a
/// robust loss twice that, and some 10 MB for classes.
#[derive(Clone, Debug)]
pub struct Live {
    nominal: Nominal,
    settings: LiveSettings,
    points: Vec<PointMm>,
    /// One for each point, or none.
    uncertainties_mm: Vec<f64>,
    /// Number of points at which the next reference is made, and at which the next one is a fit of its own.
    next_reference: usize,
    next_fit: usize,
    reference: Option<Linearised>,
    /// The reference that follows, as far as it is made.
    upcoming: Option<Box<Upcoming>>,
    failure: Option<FitError>,
}

impl Live {
    /// An estimator without points. Fails on an impossible grid and on a direction of uncertainties that is not of unit
    /// length; what else is wrong with nominal or settings, the first fit finds: see [`Live::failure`].
    pub fn new(nominal: Nominal, settings: LiveSettings) -> Result<Live, LiveError> {
        settings.validate()?;
        let next_reference = FIRST_REFERENCE.max(2 * settings.fit.free.len());
        Ok(Live {
            nominal,
            settings,
            points: Vec::new(),
            uncertainties_mm: Vec::new(),
            next_reference,
            next_fit: next_reference,
            reference: None,
            upcoming: None,
            failure: None,
        })
    }

    /// Takes a point of the measured frame. `O(p²)` for p free parameters, but `O(n·p²)` whenever the
    /// number of points n has doubled, with a robust loss whenever it has grown by a quarter: amortised constant. By squares
    /// it is `O(p²)` for each point beyond the first 131,072, unless the fit of a sample contradicts the estimate.
    ///
    /// After points with uncertainties there is no estimate any more, as there is no fit of such points:
    /// [`Live::failure`] says so.
    pub fn push(&mut self, point: PointMm) {
        self.take(point, None);
        if !self.uncertainties_mm.is_empty() {
            let (points, found) = (self.points.len(), self.uncertainties_mm.len());
            (self.reference, self.upcoming) = (None, None);
            self.failure = Some(FitError::UncertaintyCount { points, found });
        }
    }

    /// As [`Live::push`], with the standard uncertainty of the point in mm, along
    /// [`LiveSettings::uncertain_along`]: it counts by 1/u², as in [`fit_weighted`](crate::fit_weighted). Its row is summed
    /// twice.
    ///
    /// Fails with an uncertainty that is not positive and finite, and after points without one; then nothing changes.
    pub fn push_weighted(&mut self, point: PointMm, u_mm: f64) -> Result<(), LiveError> {
        let u_mm = positive(u_mm)?;
        let points = self.points.len() - self.uncertainties_mm.len();
        if points > 0 {
            return Err(LiveError::Mixed { points });
        }
        self.uncertainties_mm.push(u_mm);
        self.take(point, Some(u_mm));
        Ok(())
    }

    fn take(&mut self, point: PointMm, u_mm: Option<f64>) {
        self.points.push(point);
        if self.points.len() >= self.next_reference {
            self.refer_on_the_way(self.points.len() - 1);
        } else if let Some(reference) = &mut self.reference {
            reference.add(point, u_mm, &self.settings);
            self.succeed(CATCHES_UP);
        }
    }

    /// Takes all points of another estimator, as if they had been pushed here after those that are here; its
    /// reference is given up for the one here. Fails unless nominal and settings are the same, and the points of both
    /// have uncertainties or those of neither; then nothing changes. `O(m·p²)` for its m points, and a full fit if the number of points has doubled since
    /// the last.
    ///
    /// After [`Live::settle`] the figures are those of one estimator up to the rounding of another order of
    /// the points. Parts whose points are not needed afterwards are better taken by [`Accumulator`]s.
    pub fn merge(&mut self, other: Live) -> Result<(), LiveError> {
        if self.nominal != other.nominal {
            return Err(LiveError::Different { what: "nominal" });
        }
        if self.settings != other.settings {
            return Err(LiveError::Different { what: "settings" });
        }
        let lacks = |live: &Live| live.points.len() > live.uncertainties_mm.len();
        let has = |live: &Live| !live.uncertainties_mm.is_empty();
        if lacks(self) && has(&other) || has(self) && lacks(&other) {
            return Err(LiveError::Different { what: "kinds of weights" });
        }
        let new = self.points.len();
        self.points.extend(&other.points);
        self.uncertainties_mm.extend(&other.uncertainties_mm);
        if self.points.len() >= self.next_reference {
            self.refer_on_the_way(new);
        } else if let Some(reference) = &mut self.reference {
            reference.add_all(&other.points, &other.uncertainties_mm, &self.settings);
            self.succeed(usize::MAX);
        }
        Ok(())
    }

    /// Makes the fit of all points so far the reference. Thereafter, until the next point, the estimate is
    /// that of the full fit. `O(n·p²)`.
    pub fn settle(&mut self) {
        self.refer(&self.settings.fit.clone());
        self.plan();
    }

    /// The figures of the points so far; `None` before the first fit could be made, or if the points
    /// taken since do not lie in the aperture. The cost does not depend on the number of points.
    pub fn estimate(&self) -> Option<LiveEstimate> {
        self.reference.as_ref()?.estimate(&self.settings.grid)
    }

    /// Points that stand for how far apart the surface lies at its worst: the highest and the lowest of each block
    /// of `side` by `side` cells of the map, at least 1, measured frame. Their minimum zone is never wider than that of
    /// all points. Empty before the first fit. `O(cells)`.
    pub fn extremes(&self, side: usize) -> Vec<PointMm> {
        let reference = self.reference.as_ref();
        reference.map_or_else(Vec::new, |found| found.extremes(&self.settings.grid, side.max(1)))
    }

    /// Points taken, of whatever kind.
    pub fn taken(&self) -> usize {
        self.points.len()
    }

    /// Why the latest attempt at a full fit gave none; `None` if it gave one or there was no attempt.
    pub fn failure(&self) -> Option<&FitError> {
        self.failure.as_ref()
    }
}

/// The uncertainty, if it gives a weight.
fn positive(u_mm: f64) -> Result<f64, LiveError> {
    let gives_weight = u_mm.is_normal() && u_mm > 0.0;
    if gives_weight { Ok(u_mm) } else { Err(LiveError::Uncertainty { found_mm: u_mm }) }
}

impl Grid {
    pub(crate) fn validate(&self) -> Result<(), LiveError> {
        let ordered = |low: f64, high: f64| low.is_finite() && high.is_finite() && low < high;
        let counted = |cells: usize| (1..=MAX_CELLS).contains(&cells);
        let fine = ordered(self.x_min_mm, self.x_max_mm)
            && ordered(self.y_min_mm, self.y_max_mm)
            && counted(self.nx)
            && counted(self.ny);
        if fine { Ok(()) } else { Err(LiveError::Grid(*self)) }
    }

    /// Number of cells.
    pub(crate) fn cells(&self) -> usize {
        self.nx * self.ny
    }

    /// The cell of a place; one past the last cell for places beyond the grid.
    pub(crate) fn cell(&self, x_mm: f64, y_mm: f64) -> usize {
        let share = |value: f64, low: f64, high: f64| (value - low) / (high - low);
        let u = share(x_mm, self.x_min_mm, self.x_max_mm);
        let v = share(y_mm, self.y_min_mm, self.y_max_mm);
        if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
            return self.cells();
        }
        let column = ((u * self.nx as f64) as usize).min(self.nx - 1);
        let row = ((v * self.ny as f64) as usize).min(self.ny - 1);
        row * self.nx + column
    }
}

/// Points before the first attempt at a fit.
const FIRST_REFERENCE: usize = 16;
/// A length is 1 within this.
const UNIT: f64 = 1e-9;
/// Largest number of cells along one side.
const MAX_CELLS: usize = 1024;

//! Running figures without the points: sums at a fixed reference that merge.

use crate::fit::method;
use crate::live::classes::side;
use crate::live::linearised::Linearised;
use crate::live::reweighing::mean_uncertainty_mm;
use crate::live::{LiveError, LiveEstimate, LiveSettings, positive};
use crate::{Fit, Loss, PointMm};

/// All that running figures need of points, linearised at one reference. It keeps none of them: its size is
/// that of the map, however many points it has taken.
///
/// Parts of a scan can be taken by different threads or machines and merged, as long as they share the
/// reference: a fit of some of the points, or of an earlier part of the same make and place. What is
/// provisional about the figures is said at [`crate::Live`]; the nearer the reference, the less. A robust loss takes its
/// first weights from pose and scale of the reference; estimates weigh all points anew, by the scale these have.
///
/// ```
/// use asphera_form::{Accumulator, FitSettings, Grid, LiveSettings, Nominal, fit};
///
/// let point = |i: i32| [f64::from(i % 7), f64::from(i / 7), 1e-5 * f64::from(i * i % 11)];
/// let points: Vec<_> = (0..70).map(point).collect();
/// let reference = fit(&points[..20], &Nominal::Plane, &FitSettings::default())?;
/// let grid = Grid { x_min_mm: 0.0, x_max_mm: 6.0, y_min_mm: 0.0, y_max_mm: 9.0, nx: 3, ny: 3 };
/// let settings = LiveSettings::new(FitSettings::default(), grid);
/// let empty = Accumulator::new(reference, settings)?;
///
/// let (mut first, mut second) = (empty.clone(), empty);
/// points[..40].iter().for_each(|&point| first.push(point));
/// points[40..].iter().for_each(|&point| second.push(point));
/// first.merge(second)?;
/// assert_eq!(first.estimate().map(|estimate| estimate.count), Some(70));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Accumulator {
    settings: LiveSettings,
    sums: Linearised,
}

impl Accumulator {
    /// Without points, at the pose and shape of `reference`; its estimates are what may change. Fails on an
    /// impossible grid, on a direction of uncertainties that is not of unit length, and on a reference that was found by
    /// another loss.
    pub fn new(reference: Fit, settings: LiveSettings) -> Result<Accumulator, LiveError> {
        settings.validate()?;
        let loss = reference.robust.map_or(Loss::Squares, |robust| robust.loss);
        if loss != settings.fit.loss {
            let expected = method(reference.reduced_chi_square.is_some(), settings.fit.loss);
            return Err(LiveError::Reference { found: reference.method, expected });
        }
        let made_at = reference.used;
        let slant = settings.slant(&reference);
        let side = side(settings.grid.nx.max(settings.grid.ny));
        let unit_mm = mean_uncertainty_mm(&reference);
        let sums = Linearised::new(reference, slant, made_at, side, unit_mm, &settings);
        Ok(Accumulator { settings, sums })
    }

    /// Takes a point of the measured frame. `O(p²)` for p free parameters. Beside points with uncertainties it has no
    /// weight: then there is no estimate any more.
    pub fn push(&mut self, point: PointMm) {
        self.sums.add(point, None, &self.settings);
    }

    /// As [`Accumulator::push`], with the standard uncertainty of the point in mm: it counts by 1/u², as in
    /// [`crate::fit_weighted`].
    ///
    /// Fails with an uncertainty that is not positive and finite, and where points without one are used already; then
    /// nothing changes.
    pub fn push_weighted(&mut self, point: PointMm, u_mm: f64) -> Result<(), LiveError> {
        let u_mm = positive(u_mm)?;
        match self.sums.without_uncertainty() {
            0 => self.sums.add(point, Some(u_mm), &self.settings),
            points => return Err(LiveError::Mixed { points }),
        }
        Ok(())
    }

    /// Takes everything another accumulator has taken. The figures are those of all points in one
    /// accumulator up to the rounding of the sums; of points equally far out the one that is here counts.
    /// Fails unless both have the same reference and settings, and points of one have uncertainties if those of the
    /// other have; then nothing changes. `O(p³)`, and `O(p)` a cell.
    pub fn merge(&mut self, other: Accumulator) -> Result<(), LiveError> {
        if self.settings != other.settings {
            return Err(LiveError::Different { what: "settings" });
        }
        if !self.sums.is_compatible(&other.sums) {
            return Err(LiveError::Different { what: "reference" });
        }
        let one_lacks =
            |a: &Linearised, b: &Linearised| a.has_uncertainties() && b.without_uncertainty() > 0;
        if one_lacks(&self.sums, &other.sums) || one_lacks(&other.sums, &self.sums) {
            return Err(LiveError::Different { what: "kinds of weights" });
        }
        self.sums.merge(other.sums);
        Ok(())
    }

    /// The figures of the points so far; `None` with fewer points than parameters, and if only some of them have
    /// uncertainties.
    pub fn estimate(&self) -> Option<LiveEstimate> {
        self.sums.estimate(&self.settings.grid)
    }
}

//! Running figures without the points: sums at a fixed reference that merge.

use crate::live::linearised::Linearised;
use crate::live::{LiveError, LiveEstimate, LiveSettings};
use crate::{Fit, PointMm};

/// All that running figures need of points, linearised at one reference. It keeps none of them: its size is
/// that of the map, however many points it has taken.
///
/// Parts of a scan can be taken by different threads or machines and merged, as long as they share the
/// reference: a fit of some of the points, or of an earlier part of the same make and place. What is
/// provisional about the figures is said at [`crate::Live`]; the nearer the reference, the less.
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
    /// impossible grid.
    pub fn new(reference: Fit, settings: LiveSettings) -> Result<Accumulator, LiveError> {
        settings.grid.validate()?;
        let made_at = reference.used;
        let sums = Linearised::new(reference, made_at, &settings.grid);
        Ok(Accumulator { settings, sums })
    }

    /// Takes a point of the measured frame. `O(p²)` for p free parameters.
    pub fn push(&mut self, point: PointMm) {
        self.sums.add(point, &self.settings);
    }

    /// Takes everything another accumulator has taken. The figures are those of all points in one
    /// accumulator up to the rounding of the sums; of points equally far out the one that is here counts.
    /// Fails unless both have the same reference and settings, and then changes nothing. `O(p³)`, and
    /// `O(p)` a cell.
    pub fn merge(&mut self, other: Accumulator) -> Result<(), LiveError> {
        if self.settings != other.settings {
            return Err(LiveError::Different { what: "settings" });
        }
        if !self.sums.is_compatible(&other.sums) {
            return Err(LiveError::Different { what: "reference" });
        }
        self.sums.merge(other.sums);
        Ok(())
    }

    /// The figures of the points so far; `None` with fewer points than parameters.
    pub fn estimate(&self) -> Option<LiveEstimate> {
        self.sums.estimate(&self.settings.grid)
    }
}

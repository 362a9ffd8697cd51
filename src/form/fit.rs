//! The orthogonal-distance least-squares fit of a nominal to points.

use thiserror::Error;

use crate::refine::{Limits, Refined, refine};
use crate::selection::Selection;
use crate::{
    Aperture, ApertureError, Excluded, Nominal, NominalError, Parameter, PointMm, Pose,
    Termination, start,
};

/// Name of the criterion, as reports give it.
pub const METHOD: &str = "orthogonal least squares";

/// What to fit and how far to go.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSettings {
    /// The parameters that may change. Empty is allowed: then the start is only evaluated.
    pub free: Vec<Parameter>,
    /// Points outside it, in the part frame under the fitted pose, do not count.
    pub aperture: Aperture,
    /// Where to begin, and the value of every pose parameter that is not free or not determined.
    pub start: Pose,
    /// Largest number of steps of one refinement. A refinement follows every change of the points in the
    /// aperture.
    pub max_iterations: usize,
    /// A step that moves the surface at the points by less than this root mean square, in mm, is the
    /// last; never less than rounding of the coordinates makes meaningful.
    pub tolerance_mm: f64,
    /// A parameter is indeterminate if it makes the smallest singular value of the Jacobian, with columns
    /// scaled to unit length, smaller than this share of the largest.
    pub rank_tolerance: f64,
}

impl Default for FitSettings {
    /// The five rigid motions of a rotationally symmetric part, no aperture, start at the identity, 50
    /// iterations, 0.1 fm, rank to 1e-10.
    fn default() -> FitSettings {
        FitSettings {
            free: Parameter::RIGID.to_vec(),
            aperture: Aperture::None,
            start: Pose::default(),
            max_iterations: 50,
            tolerance_mm: 1e-13,
            rank_tolerance: 1e-10,
        }
    }
}

/// A fitted parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Which.
    pub parameter: Parameter,
    /// Its value in [`Parameter::unit`].
    pub value: f64,
    /// Its standard uncertainty (k = 1) in the same unit, from σ²·(JᵀJ)⁻¹; `None` without degrees of
    /// freedom.
    ///
    /// It assumes deviations without correlation. Form error is correlated, and figures of this kind are
    /// then too small by a factor of 2 to 4 (Forbes, Metrologia 43 (2006) S282).
    pub u: Option<f64>,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// [`METHOD`].
    pub method: &'static str,
    /// Why the iteration ended.
    pub termination: Termination,
    /// Steps in all.
    pub iterations: usize,
    /// Free and determinate parameters, in the order they were asked for.
    pub estimates: Vec<Estimate>,
    /// Free parameters the points do not determine; they stayed at their start.
    pub indeterminate: Vec<Parameter>,
    /// From the part frame into the measured frame.
    pub pose: Pose,
    /// The nominal with its fitted shape.
    pub nominal: Nominal,
    /// The pose the iteration began with: the start of the settings or, for points far from it, one
    /// computed from the points.
    pub start: Pose,
    /// Standard deviation of the distances in mm: root of the sum of squares over `dof`; 0 if `dof` is 0.
    pub sigma_mm: f64,
    /// Degrees of freedom: points used less parameters estimated.
    pub dof: usize,
    /// Points used.
    pub used: usize,
    /// Points left out.
    pub excluded: Excluded,
    /// Largest over smallest singular value of the scaled Jacobian of the estimated parameters.
    pub condition: f64,
}

/// Why there is no fit.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FitError {
    /// The nominal is none.
    #[error("the nominal is not usable")]
    Nominal(#[from] NominalError),
    /// The aperture is none.
    #[error("the aperture is not usable")]
    Aperture(#[from] ApertureError),
    /// A parameter was asked for that this nominal does not have.
    #[error("a {kind} has no parameter {parameter}")]
    NoSuchParameter {
        /// The parameter.
        parameter: Parameter,
        /// Kind of the nominal.
        kind: &'static str,
    },
    /// A parameter was asked for twice.
    #[error("parameter {0} is listed twice")]
    Repeated(Parameter),
    /// The start is not finite.
    #[error("the start pose has a number that is not finite")]
    Start,
    /// There is no finite point.
    #[error("none of {given} points is finite")]
    NoPoints {
        /// Points given.
        given: usize,
    },
    /// No finite point lies in the aperture.
    #[error("none of {finite} finite points lies in the aperture")]
    OutsideAperture {
        /// Finite points.
        finite: usize,
    },
    /// No point in the aperture stands over the nominal.
    #[error("none of {inside} points in the aperture stands over the nominal")]
    OutsideDomain {
        /// Points in the aperture.
        inside: usize,
    },
    /// Fewer points than parameters.
    #[error("{used} usable points, at least {needed} needed for the free parameters")]
    TooFewPoints {
        /// Usable points.
        used: usize,
        /// How many the free parameters need.
        needed: usize,
        /// Points left out.
        excluded: Excluded,
    },
    /// Coordinates so large that their squares are not finite.
    #[error("the sums over {used} points overflow")]
    Overflow {
        /// Usable points.
        used: usize,
    },
}

/// Fits `nominal` to `points` of the measured frame by least squares of the orthogonal distances.
///
/// Gauss-Newton with Levenberg-Marquardt damping where a step does not help; each step from a QR
/// factorisation of the analytic Jacobian. Which points lie in the aperture is decided under the current
/// pose, and the fit repeated until that no longer changes. Indeterminate parameters are left out and
/// reported. The same points in the same order give the same bits, whatever the number of threads.
///
/// `O(n·p²)` a step for n points and p parameters, and `O(n)` memory. Failing to converge is no error:
/// see [`Fit::termination`].
pub fn fit(points: &[PointMm], nominal: &Nominal, settings: &FitSettings) -> Result<Fit, FitError> {
    check(nominal, settings)?;
    let start = start::find(points, nominal, settings);
    let select =
        |pose: &Pose, shape: &Nominal| Selection::new(points, shape, pose, &settings.aperture);
    let mut selection = select(&start, nominal);
    let (mut pose, mut shape) = (start, *nominal);
    let mut iterations = 0;
    let mut coarse = true;
    let mut round = 0;
    loop {
        round += 1;
        require(&selection, points.len(), nominal, settings)?;
        let used = selection.points.len();
        let last = round == MAX_ROUNDS;
        let limits = Limits {
            tolerance_mm: if coarse && !last { COARSE_MM } else { settings.tolerance_mm },
            iterations: settings.max_iterations,
            rank_tolerance: settings.rank_tolerance,
        };
        let mut refined = refine(&selection.points, pose, shape, &settings.free, limits)
            .ok_or(FitError::Overflow { used })?;
        iterations += refined.iterations;
        (pose, shape) = (refined.pose, refined.nominal);
        let next = select(&pose, &shape);
        let changed = selection.memberships.iter().zip(&next.memberships);
        let changed = changed.filter(|(old, new)| old != new).count();
        if changed == 0 && (!coarse || last) {
            return Ok(report(refined, &selection, start, iterations, settings));
        }
        if last {
            refined.termination = Termination::UnstableAperture { changed };
            return Ok(report(refined, &selection, start, iterations, settings));
        }
        coarse = coarse && changed > 0;
        selection = next;
    }
}

fn check(nominal: &Nominal, settings: &FitSettings) -> Result<(), FitError> {
    nominal.validate()?;
    settings.aperture.validate()?;
    if !settings.start.is_finite() {
        return Err(FitError::Start);
    }
    for (index, &parameter) in settings.free.iter().enumerate() {
        if !nominal.has(parameter) {
            return Err(FitError::NoSuchParameter { parameter, kind: nominal.kind() });
        }
        if settings.free[..index].contains(&parameter) {
            return Err(FitError::Repeated(parameter));
        }
    }
    Ok(())
}

fn require(
    selection: &Selection,
    given: usize,
    nominal: &Nominal,
    settings: &FitSettings,
) -> Result<(), FitError> {
    let excluded = selection.excluded;
    let finite = given - excluded.not_finite;
    let inside = finite - excluded.outside_aperture;
    let used = selection.points.len();
    let needed = points_needed(nominal, &settings.free);
    if finite == 0 {
        Err(FitError::NoPoints { given })
    } else if inside == 0 {
        Err(FitError::OutsideAperture { finite })
    } else if used == 0 {
        Err(FitError::OutsideDomain { inside })
    } else if used < needed {
        Err(FitError::TooFewPoints { used, needed, excluded })
    } else {
        Ok(())
    }
}

/// How many of the free parameters points on this kind of surface can determine, at least 1.
fn points_needed(nominal: &Nominal, free: &[Parameter]) -> usize {
    use Parameter::{Rx, Ry, Rz, Tx, Ty};
    let idle = |parameter: Parameter| match nominal {
        Nominal::Plane => matches!(parameter, Tx | Ty | Rz),
        // A turn about the vertex moves the centre of a sphere as a shift does.
        Nominal::Sphere { .. } => match parameter {
            Rx => free.contains(&Ty),
            Ry => free.contains(&Tx),
            Rz => true,
            _ => false,
        },
        Nominal::Asphere(_) => parameter == Rz,
    };
    free.iter().filter(|&&parameter| !idle(parameter)).count().max(1)
}

fn report(
    refined: Refined,
    selection: &Selection,
    start: Pose,
    iterations: usize,
    settings: &FitSettings,
) -> Fit {
    let Refined { pose, nominal, system, kept, last, termination, .. } = refined;
    let used = selection.points.len();
    let dof = used - kept.len();
    let mut change = vec![0.0; settings.free.len()];
    kept.iter().zip(&last.change).for_each(|(&index, &step)| change[index] = step);
    let sigma_mm = if dof == 0 { 0.0 } else { (system.square_after(&change) / dof as f64).sqrt() };
    let estimates = kept.iter().zip(&last.variance_factors).filter_map(|(&index, factor)| {
        let parameter = settings.free[index];
        let value = parameter.value(&pose, &nominal)?;
        Some(Estimate { parameter, value, u: (dof > 0).then(|| sigma_mm * factor.sqrt()) })
    });
    let estimates = estimates.collect();
    let indeterminate = (0..settings.free.len()).filter(|index| !kept.contains(index));
    Fit {
        method: METHOD,
        termination,
        iterations,
        estimates,
        indeterminate: indeterminate.map(|index| settings.free[index]).collect(),
        pose,
        nominal,
        start,
        sigma_mm,
        dof,
        used,
        excluded: selection.excluded,
        condition: last.condition,
    }
}

/// Refinements until the points in the aperture must have settled.
const MAX_ROUNDS: usize = 12;
/// Until the points in the aperture settle, a fit to a nanometre is good enough.
const COARSE_MM: f64 = 1e-6;

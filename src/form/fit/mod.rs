//! The orthogonal-distance fit of a nominal to points: least squares, weighted or robust.

mod caution;
pub(crate) mod covariance;
mod error;
pub(crate) mod freedoms;
mod mirrored;
pub(crate) mod model;
mod motion;
pub(crate) mod plane;
pub(crate) mod refine;
pub(crate) mod robust;
mod scale;
mod search;
pub(crate) mod selection;
pub(crate) mod slant;
pub(crate) mod solve;
pub(crate) mod start;
pub(crate) mod svd;
pub(crate) mod symmetry;
pub(crate) mod triangle;
pub(crate) mod weight;

pub use caution::{Caution, Units};
pub use covariance::{Combination, Covariance, Undetermined};
pub use error::FitError;
pub use freedoms::Freedoms;
pub use refine::Termination;
pub use robust::{Loss, Robust};
pub use scale::suspected as suspected_units;
pub use selection::Excluded;
pub use slant::along_normal_mm;

use crate::fit::covariance::undetermined;
use crate::fit::refine::{LeastSquares, Limits, Refined, priority, refine};
use crate::fit::robust::{ScaledLoss, refine_robustly};
use crate::fit::selection::Selection;
use crate::fit::solve::System;
use crate::fit::symmetry::determined_by_shape;
use crate::fit::triangle::Spread;
use crate::fit::weight::Weights;
use crate::{Aperture, Nominal, Parameter, PointMm, Pose};
use asphera_geometry::BoxMm;

/// Name of the criterion of least squares without weights, as reports give it.
pub const METHOD: &str = "orthogonal least squares";

/// Sides from which a part may have been measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MeasuredFrom {
    /// That of the start. Points that only fit the other one are a doubt.
    #[default]
    Given,
    /// That of the start, or the other one where only that fits.
    Either,
}

/// Choice of what to fit and how far to go.
#[derive(Clone, Debug, PartialEq)]
pub struct FitSettings {
    /// The parameters that may change. Empty is allowed: then the start is only evaluated.
    pub free: Vec<Parameter>,
    /// How much a deviation counts.
    pub loss: Loss,
    /// The scale of a robust loss in mm, above 0: the standard deviation of most distances, with uncertainties
    /// that of a point of mean weight. `None`: found from the distances. Squares have none.
    pub loss_scale_mm: Option<f64>,
    /// Points outside it, in the part frame under the fitted pose, do not count.
    pub aperture: Aperture,
    /// Where to begin, and the value of every pose parameter that is not free or not determined.
    pub start: Pose,
    /// Whether to look for the part elsewhere where the fit from the start explains the points badly: far
    /// away, tilted, upside down, and turned about its axis if that is free. Needs free shifts.
    pub search: bool,
    /// The sides from which the part may have been measured. The search looks at both; the start's is preferred.
    pub side: MeasuredFrom,
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
    /// Least squares of the five rigid motions of a rotationally symmetric part, no aperture, start at the
    /// identity with a search, 50 iterations, 0.1 fm, rank to 1e-10.
    fn default() -> FitSettings {
        FitSettings {
            free: Parameter::RIGID.to_vec(),
            loss: Loss::Squares,
            loss_scale_mm: None,
            aperture: Aperture::None,
            start: Pose::default(),
            search: true,
            side: MeasuredFrom::Given,
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
    /// It is about how far the best fit to this very part depends on which points were taken, at random, of it. Form error does
    /// not change from one such choice to the next; where it counts, as of another part, or where the errors of the
    /// machine are correlated, u is larger by a factor of 2 to 4 and more (Forbes, Metrologia 43 (2006) S282): see
    /// `asphera-uncertainty`.
    pub u: Option<f64>,
}

/// Figures of the distances of all points used, without weights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Residuals {
    /// Root of the mean square about the nominal in mm.
    pub rms_mm: f64,
    /// Smallest in mm.
    pub low_mm: f64,
    /// Largest in mm.
    pub high_mm: f64,
}

/// The result of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The criterion: [`METHOD`], or with weights or a robust loss what reports call that.
    pub method: &'static str,
    /// Why the iteration ended.
    pub termination: Termination,
    /// Steps in all.
    pub iterations: usize,
    /// How often distances and derivatives of all points were worked out.
    pub evaluations: usize,
    /// Free and determinate parameters, in the order they were asked for.
    pub estimates: Vec<Estimate>,
    /// Covariances of the estimates, under the assumption of [`Estimate::u`]; `None` without degrees of
    /// freedom.
    pub covariance: Option<Covariance>,
    /// The directions of the estimates in which the fit could move them.
    pub freedoms: Freedoms,
    /// Free parameters the points do not determine; they stayed at their start. Of a combination of shifts or of turns that
    /// stayed at its start, the parameter that leads it.
    pub indeterminate: Vec<Parameter>,
    /// Counterpart with the reason.
    pub undetermined: Vec<Undetermined>,
    /// The combination of the estimates that is determined worst; `None` without estimates.
    pub weakest: Option<Combination>,
    /// From the part frame into the measured frame.
    pub pose: Pose,
    /// The nominal with its fitted shape.
    pub nominal: Nominal,
    /// The pose the iteration began with: the start of the settings or, for points far from it, one
    /// computed from the points.
    pub start: Pose,
    /// Standard deviation of the distances in mm: root of the sum of squares over `dof`; 0 if `dof` is 0.
    /// With uncertainties that of a point of mean weight; with a robust loss the one that goes with the
    /// covariance (see [`Robust::scale_mm`] for the scale).
    pub sigma_mm: f64,
    /// With uncertainties, the sum of the squares of distance over uncertainty, over `dof`: about 1 if the
    /// uncertainties tell all there is. `None` without, or without degrees of freedom.
    pub reduced_chi_square: Option<f64>,
    /// Figures of the distances.
    pub residuals: Residuals,
    /// Degrees of freedom: points used less directions in which parameters were estimated.
    pub dof: usize,
    /// Points used.
    pub used: usize,
    /// (Σw)²/Σw² over the weights of the points: how many points of equal weight count as much (Kish).
    pub effective_points: f64,
    /// Effect of the robust loss; `None` for least squares.
    pub robust: Option<Robust>,
    /// Points left out.
    pub excluded: Excluded,
    /// Largest over smallest singular value of the scaled Jacobian of the estimated parameters.
    pub condition: f64,
    /// Cautions that the figures must be read with.
    pub cautions: Vec<Caution>,
}

/// Fits `nominal` to `points` of the measured frame by the orthogonal distances.
///
/// Gauss-Newton with Levenberg-Marquardt damping where a step does not help; each step from a QR
/// factorisation of the analytic Jacobian. Which points lie in the aperture is decided under the current
/// pose, and the fit repeated until that no longer changes. Indeterminate parameters are left out and
/// reported. The same points in the same order give the same bits, whatever the number of threads.
///
/// `O(n·p²)` a step for n points and p parameters, and `O(n)` memory. Failing to converge is no error:
/// see [`Fit::termination`]; nor is a fit that must be read with care: see [`Fit::cautions`].
pub fn fit(points: &[PointMm], nominal: &Nominal, settings: &FitSettings) -> Result<Fit, FitError> {
    fit_weighted(points, None, nominal, settings)
}

/// As [`fit`], with the standard uncertainty of each point's distance in mm: a point counts by 1/u².
///
/// Fails unless there is one positive finite uncertainty for each point, those left out included.
pub fn fit_weighted(
    points: &[PointMm],
    uncertainties_mm: Option<&[f64]>,
    nominal: &Nominal,
    settings: &FitSettings,
) -> Result<Fit, FitError> {
    check(nominal, settings)?;
    let weights = uncertainties_mm.map(|u_mm| Weights::new(u_mm, points.len())).transpose()?;
    match solve(points, weights.as_ref(), nominal, settings) {
        Ok(mut fit) => {
            let units = scale::suspected(points, nominal, settings, Some(fit.residuals.rms_mm));
            fit.cautions.extend(units.map(Caution::Units));
            fit.cautions.extend(mirrored::suspected(
                points,
                nominal,
                settings,
                fit.residuals.rms_mm,
            ));
            Ok(fit)
        }
        Err(error) => match scale::suspected(points, nominal, settings, None) {
            Some(units) if error.is_of_place() => Err(FitError::Units(units)),
            _ => Err(error),
        },
    }
}

/// The fit, without a look at units and signs.
pub(crate) fn solve(
    points: &[PointMm],
    weights: Option<&Weights>,
    nominal: &Nominal,
    settings: &FitSettings,
) -> Result<Fit, FitError> {
    check_height(points, nominal, settings)?;
    let roots = weights.map(|weights| weights.roots.as_slice());
    let start = start::find(points, nominal, settings);
    let mut selection = Selection::new(points, roots, nominal, &start, &settings.aperture);
    let (mut pose, mut shape) = (start, nominal.clone());
    let (mut iterations, mut evaluations) = (0, 0);
    let mut coarse = true;
    // The linear problem where a coarse round has ended.
    let mut known: Option<(System, Spread)> = None;
    let mut round = 0;
    loop {
        round += 1;
        require(&selection, points, &pose, &shape, settings)
            .map_err(|error| strayed(error, &pose, &settings.start))?;
        let used = selection.points.len();
        let last = round == MAX_ROUNDS;
        let limits = Limits {
            tolerance_mm: if coarse && !last { COARSE_MM } else { settings.tolerance_mm },
            iterations: settings.max_iterations,
            rank_tolerance: settings.rank_tolerance,
            polish: !coarse || last,
            damping: 0.0,
            start: settings.start,
        };
        let mut solved = refine_by(&selection, pose, shape, settings, limits, known.take())
            .ok_or(FitError::Overflow { used })?;
        iterations += solved.refined.iterations;
        evaluations += solved.refined.evaluations;
        (solved.refined.iterations, solved.refined.evaluations) = (iterations, evaluations);
        (pose, shape) = (solved.refined.pose, solved.refined.nominal.clone());
        let next = selection.memberships_under(points, &shape, &pose, &settings.aperture);
        let changed = selection.memberships.iter().zip(&next);
        let changed = changed.filter(|(old, new)| old != new).count();
        let settled = changed == 0 && (!coarse || last);
        if last && !settled {
            solved.refined.termination = Termination::UnstableAperture { changed };
        }
        if settled || last {
            return Ok(report(solved, points, &selection, weights, start, settings));
        }
        if changed == 0 && !limits.polish {
            known = Some((solved.refined.system, solved.refined.spread));
        }
        coarse = coarse && changed > 0;
        if changed > 0 {
            selection = Selection::of(points, roots, next);
        }
    }
}

/// A refinement by whatever loss, and what a robust one adds.
struct Solved {
    refined: Refined,
    robust: Option<Robust>,
    /// That of a robust loss.
    sigma_mm: Option<f64>,
    effective_points: f64,
}

fn refine_by(
    selection: &Selection,
    pose: Pose,
    shape: Nominal,
    settings: &FitSettings,
    limits: Limits,
    known: Option<(System, Spread)>,
) -> Option<Solved> {
    let FitSettings { free, loss, .. } = settings;
    if *loss == Loss::Squares {
        let (points, roots) = (&selection.points, selection.roots.as_deref());
        let effective_points = roots.map_or(points.len() as f64, |roots| {
            let sum: f64 = roots.iter().map(|root| root * root).sum();
            let square: f64 = roots.iter().map(|root| root.powi(4)).sum();
            sum * sum / square
        });
        let refined = refine(LeastSquares { points, roots, free }, pose, shape, limits, known)?;
        return Some(Solved { refined, robust: None, sigma_mm: None, effective_points });
    }
    let scaled = ScaledLoss { loss: *loss, given_mm: settings.loss_scale_mm };
    let solved = refine_robustly(selection, pose, shape, free, limits, scaled)?;
    Some(Solved {
        refined: solved.refined,
        robust: Some(solved.robust),
        sigma_mm: solved.sigma_mm,
        effective_points: solved.effective_points,
    })
}

fn check(nominal: &Nominal, settings: &FitSettings) -> Result<(), FitError> {
    nominal.validate()?;
    settings.aperture.validate()?;
    settings.loss.validate()?;
    if let Some(found_mm) = settings.loss_scale_mm.filter(|mm| !(mm.is_normal() && *mm > 0.0)) {
        return Err(FitError::LossScale { found_mm });
    }
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

/// Whether the nominal is a surface as far out as the points reach, wherever they lie on it: on what rises by a power of ten in a hair's
/// breadth feet are looked for over minutes. An aperture is checked with the nominal.
fn check_height(
    points: &[PointMm],
    nominal: &Nominal,
    settings: &FitSettings,
) -> Result<(), FitError> {
    let has_powers = matches!(nominal, Nominal::Asphere(_) | Nominal::Freeform(_));
    if !has_powers || settings.aperture != Aperture::None {
        return Ok(());
    }
    let (low, high) = extremes(points);
    let reach_mm = 0.5 * (high[0] - low[0]).max(high[1] - low[1]);
    if !reach_mm.is_finite() {
        return Ok(());
    }
    let about = [[reach_mm, 0.0], [0.0, reach_mm], [-reach_mm, 0.0], [0.0, -reach_mm]];
    let heights = about.iter().filter_map(|[x_mm, y_mm]| nominal.height_mm(*x_mm, *y_mm));
    let height_mm = heights.map(f64::abs).fold(f64::INFINITY, f64::min);
    if height_mm.is_finite() && height_mm > HIGHEST_MM {
        return Err(FitError::TooHigh { reach_mm, height_mm });
    }
    Ok(())
}

/// The largest height of a surface that is taken for one, mm. What stands a kilometre above its vertex has a coefficient of
/// another unit.
pub const HIGHEST_MM: f64 = 1e6;

/// No point is in the aperture any more, for the fit moved it away from them.
fn strayed(error: FitError, pose: &Pose, start: &Pose) -> FitError {
    let (tx_mm, ty_mm) = (pose.tx_mm - start.tx_mm, pose.ty_mm - start.ty_mm);
    match error {
        FitError::OutsideAperture { .. } if [tx_mm, ty_mm] != [0.0; 2] => {
            FitError::Strayed { tx_mm, ty_mm }
        }
        error => error,
    }
}

fn require(
    selection: &Selection,
    points: &[PointMm],
    pose: &Pose,
    nominal: &Nominal,
    settings: &FitSettings,
) -> Result<(), FitError> {
    let (given, excluded) = (points.len(), selection.excluded);
    let finite = given - excluded.not_finite;
    let inside = finite - excluded.outside_aperture;
    let used = selection.points.len();
    if finite == 0 {
        return Err(FitError::NoPoints { given });
    }
    if inside == 0 {
        let (low_mm, high_mm) = extremes(points);
        return Err(FitError::OutsideAperture { finite, low_mm, high_mm });
    }
    if used == 0 {
        let nearest_mm = selection.beyond_mm(points, pose).fold(f64::INFINITY, f64::min);
        return Err(FitError::OutsideDomain { inside, domain_mm: nominal.domain_mm(), nearest_mm });
    }
    let needed = points_needed(selection, pose, nominal, &settings.free);
    if used < needed { Err(FitError::TooFewPoints { used, needed, excluded }) } else { Ok(()) }
}

/// The smallest and the largest coordinates of the finite points.
pub(crate) fn extremes(points: &[PointMm]) -> (PointMm, PointMm) {
    let finite =
        points.iter().filter(|point| point.iter().all(|coordinate| coordinate.is_finite()));
    let BoxMm { low, high } = BoxMm::about(finite.copied());
    (low, high)
}

/// How many of the free parameters points on this kind of surface can determine, at least 1.
fn points_needed(
    selection: &Selection,
    pose: &Pose,
    nominal: &Nominal,
    free: &[Parameter],
) -> usize {
    use Parameter::{Rx, Ry, Rz, Tx, Ty};
    // As long as there are more points than parameters, it does not matter.
    if !nominal.is_rotational() && selection.points.len() < free.len() {
        return determined_by_shape(nominal, pose, free, selection.reach_mm(pose)).len().max(1);
    }
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
        Nominal::Freeform(_) => true,
    };
    free.iter().filter(|&&parameter| !idle(parameter)).count().max(1)
}

fn report(
    solved: Solved,
    points: &[PointMm],
    selection: &Selection,
    weights: Option<&Weights>,
    start: Pose,
    settings: &FitSettings,
) -> Fit {
    let Solved { refined, robust, sigma_mm: robust_sigma_mm, effective_points } = solved;
    let Refined { pose, nominal, system, freedoms, held, last, termination, spread, .. } = refined;
    let pose = pose.within_half_turns();
    let used = selection.points.len();
    let dof = used - freedoms.count();
    let moving = freedoms.moving();
    let mut change = vec![0.0; settings.free.len()];
    moving.iter().zip(&last.change).for_each(|(&index, &step)| change[index] = step);
    let sigma_mm = match (robust, dof) {
        (_, 0) => 0.0,
        (None, _) => (system.square_after(&change) / dof as f64).sqrt(),
        (Some(_), _) => robust_sigma_mm.unwrap_or(0.0),
    };
    let known = dof > 0 && (robust.is_none() || robust_sigma_mm.is_some());
    let estimates = moving.iter().zip(&last.variance_factors).filter_map(|(&index, factor)| {
        let parameter = settings.free[index];
        let value = parameter.value(&pose, &nominal)?;
        Some(Estimate { parameter, value, u: known.then(|| sigma_mm * factor.sqrt()) })
    });
    let estimates = estimates.collect();
    let indeterminate: Vec<Parameter> =
        held.iter().map(|held| settings.free[held.leading]).collect();
    let undetermined = if held.is_empty() {
        Vec::new()
    } else {
        let reach_mm = selection.reach_mm(&pose);
        let felt = determined_by_shape(&nominal, &pose, &settings.free, reach_mm);
        let lacking = |group: &Vec<usize>| group.iter().filter(|&i| !felt.contains(i)).count();
        let by_shape: Vec<usize> = priority(&settings.free, &nominal).iter().map(lacking).collect();
        undetermined(&system, &held, &settings.free, (&nominal, &pose), &by_shape)
    };
    let parameters = moving.iter().map(|&index| settings.free[index]);
    let weakest = (!moving.is_empty())
        .then(|| Combination::new(parameters, &last.weakest, last.condition.recip(), &nominal));
    let mut cautions = cautions(points, selection, &pose, &nominal, settings);
    cautions.extend(ill_conditioned(last.condition, weakest.as_ref()));
    let estimated = freedoms.count();
    if used >= ENOUGH * estimated && effective_points < (ENOUGH * estimated) as f64 {
        cautions.push(Caution::FewCount { effective: effective_points, used, estimated });
    }
    Fit {
        method: method(weights.is_some(), settings.loss),
        termination,
        iterations: refined.iterations,
        evaluations: refined.evaluations,
        estimates,
        covariance: known.then(|| Covariance::new(moving.len(), &last.inverse_gram(), sigma_mm)),
        freedoms: freedoms.of_moving(),
        indeterminate,
        undetermined,
        weakest,
        start,
        reduced_chi_square: weights
            .filter(|_| known)
            .map(|weights| (sigma_mm / weights.reference_mm).powi(2)),
        residuals: Residuals {
            rms_mm: (spread.square_mm2 / used as f64).sqrt(),
            low_mm: spread.low_mm,
            high_mm: spread.high_mm,
        },
        sigma_mm,
        dof,
        used,
        effective_points,
        robust,
        excluded: selection.excluded,
        condition: last.condition,
        cautions,
        pose,
        nominal,
    }
}

fn cautions(
    points: &[PointMm],
    selection: &Selection,
    pose: &Pose,
    nominal: &Nominal,
    settings: &FitSettings,
) -> Vec<Caution> {
    let mut cautions = Vec::new();
    let axis = |pose: &Pose| pose.rotation().map(|row| row[2]);
    let along: f64 = axis(pose).iter().zip(axis(&settings.start)).map(|(a, b)| a * b).sum();
    if along < 0.0 {
        cautions.push(Caution::UpsideDown { allowed: settings.side == MeasuredFrom::Either });
    }
    if selection.excluded.outside_domain > 0 {
        cautions.push(Caution::BeyondDomain {
            domain_mm: nominal.domain_mm(),
            beyond: selection.excluded.outside_domain,
            farthest_mm: selection.beyond_mm(points, pose).fold(0.0, f64::max),
        });
    }
    cautions
}

fn ill_conditioned(condition: f64, weakest: Option<&Combination>) -> Option<Caution> {
    let combination = weakest.filter(|_| condition > ILL_CONDITIONED)?.clone();
    Some(Caution::IllConditioned { condition, combination })
}

pub(crate) fn method(weighted: bool, loss: Loss) -> &'static str {
    match (loss, weighted) {
        (Loss::Squares, false) => METHOD,
        (Loss::Squares, true) => "weighted orthogonal least squares",
        (Loss::Huber { .. }, false) => "orthogonal Huber M-estimate",
        (Loss::Huber { .. }, true) => "weighted orthogonal Huber M-estimate",
        (Loss::Tukey { .. }, false) => "orthogonal Tukey M-estimate",
        (Loss::Tukey { .. }, true) => "weighted orthogonal Tukey M-estimate",
    }
}

/// Refinements until the points in the aperture must have settled.
const MAX_ROUNDS: usize = 12;
/// Until the points in the aperture settle, a fit to a nanometre is good enough.
const COARSE_MM: f64 = 1e-6;
/// Points for each parameter, counted by their weights, below which a fit rests on single points.
const ENOUGH: usize = 3;
/// A condition that costs half the digits of a parameter.
const ILL_CONDITIONED: f64 = 1e6;

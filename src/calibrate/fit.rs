//! The fit: unknowns that the points determine, by Gauss and Newton.

use asphera_form::linear::{Step, System};
use nalgebra::DMatrix;

use crate::artefact::{Artefact, Pose, Settings};
use crate::check::check;
use crate::columns::Columns;
use crate::correction::{Axes, Correction};
use crate::correlation::inflation;
use crate::error::CalibrateError;
use crate::map::HeightMap;
use crate::parameter::Machine;
use crate::result::{Calibration, Estimate, Term};
use crate::rows::Problem;
use crate::start::start;

/// Finds the errors of a machine, and beside them the form of the artefact, from all poses at once.
///
/// Least squares of the distances from the artefact along its normal, linearised again in each step. A certified
/// radius with an uncertainty counts as one more measurement of it. `O(n·p²)` for n points and p unknowns.
///
/// A parameter or term is given up, and named, where the points do not tell it from others, or where its u moves
/// points by more than 1 µm: a value of that kind would spoil more than it mends.
///
/// # Errors
///
/// [`CalibrateError`].
pub fn calibrate(
    machine: Machine,
    artefact: Artefact,
    poses: &[Pose],
    settings: &Settings,
) -> Result<Calibration, CalibrateError> {
    check(machine, artefact, poses, settings)?;
    let orders = [settings.map_order, settings.form_order];
    let mut parameters = settings.parameters.clone();
    parameters.sort_unstable();
    let columns = Columns::new(parameters, orders, poses.len());
    let mut problem = Problem::new(artefact, poses, columns);
    let mut state = start(&mut problem)?;
    let places: Vec<usize> = problem.columns.places().collect();
    let before = rest(&problem, &mut state, &places, None)?;
    check_artefact(&problem, &before)?;
    let sizes = sizes(&problem);
    let mut free = determinate(&problem, &state, &sizes);
    loop {
        let fit = weighed(&problem, &mut state, &free)?;
        let Some(at) = worthless(&problem, &free, &fit.covariance, &sizes) else {
            return Ok(report(machine, &problem, &state, &free, &fit, before.rms_mm));
        };
        free.retain(|other| *other != at);
        state[at] = 0.0;
    }
}

/// The unknown to be given up, where the u of any moves points too far to be of use: the worst, or one of a later group
/// that it cannot be told from, as what moves the one moves the other.
fn worthless(
    problem: &Problem<'_>,
    free: &[usize],
    covariance: &[f64],
    sizes: &[f64],
) -> Option<usize> {
    let size = free.len();
    let u = |index: usize| covariance[index * size + index].sqrt();
    let moved_mm = |index: usize| u(index) * sizes[free[index]];
    let worst = (0..size).max_by(|&left, &right| moved_mm(left).total_cmp(&moved_mm(right)))?;
    if moved_mm(worst) <= WORTH_MM {
        return None;
    }
    let groups = problem.columns.groups();
    let rank = |index: usize| {
        let group = groups.iter().position(|group| group.contains(&free[index]));
        let correlation = covariance[worst * size + index].abs() / (u(worst) * u(index));
        (group.unwrap_or(0), correlation)
    };
    let alike = (0..size).map(|index| (index, rank(index))).filter(|(_, rank)| rank.1 >= ALIKE);
    let last = alike
        .max_by(|(_, left), (_, right)| left.0.cmp(&right.0).then(left.1.total_cmp(&right.1)))?;
    Some(free[last.0])
}

/// Unknowns correlated more than this are not told apart.
const ALIKE: f64 = 0.9;

/// A parameter whose u moves points farther than this is not worth its use.
const WORTH_MM: f64 = 1e-3;

/// Columns nearer to dependence than this are dependent.
const LEAST_RATIO: f64 = 1e-7;

/// Steps after which a fit does not come to rest.
const STEPS: u32 = 40;

/// A step that moves points by less, as a root mean square, is rounding.
const AT_REST_MM: f64 = 1e-11;

/// Unknowns at rest, with what the residuals tell.
struct Fit {
    rms_mm: f64,
    inflation: f64,
    /// Covariances of the free unknowns, row after row.
    covariance: Vec<f64>,
    /// Their standard uncertainties.
    u: Vec<f64>,
}

/// Moves the free unknowns until they rest. `weight` is that of the certified radius, where it is free.
fn rest(
    problem: &Problem<'_>,
    state: &mut [f64],
    free: &[usize],
    weight: Option<f64>,
) -> Result<Fit, CalibrateError> {
    for _ in 0..STEPS {
        let certified = match problem.artefact {
            Artefact::Sphere { radius_mm, .. } => radius_mm,
            Artefact::Flat => 0.0,
        };
        let excess_mm = state[problem.columns.radius()] - certified;
        let triangle = problem.triangle(state, weight.map(|weight| [weight, excess_mm]), false);
        if !triangle.is_finite() {
            break;
        }
        let step = System::new(&triangle).solve(free, 0.0);
        free.iter().zip(&step.change).for_each(|(&at, change)| state[at] += change);
        if step.motion_mm < AT_REST_MM {
            return Ok(concluded(problem, state, free, &step, weight));
        }
    }
    Err(CalibrateError::NotConverged { iterations: STEPS })
}

/// Noise and uncertainties, by the residuals at rest.
///
/// Covariances are those of residuals whose variance differs from place to place, as that of a probe along z does on a
/// slope: (JᵀJ)⁻¹·(Σ r²·j·jᵀ)·(JᵀJ)⁻¹ (H. White, Econometrica 48 (1980) 817-838), times n/(n − p).
fn concluded(
    problem: &Problem<'_>,
    state: &[f64],
    free: &[usize],
    step: &Step,
    weight: Option<f64>,
) -> Fit {
    let residuals = problem.residuals(state);
    let count: usize = residuals.iter().map(Vec::len).sum();
    let square: f64 = residuals.iter().flatten().map(|residual| residual * residual).sum();
    let inflation = inflation(&residuals);
    let correction = inflation * count as f64 / count.saturating_sub(free.len()).max(1) as f64;
    let squares = problem.triangle(state, None, true);
    let size = free.len();
    let factor =
        DMatrix::from_fn(squares.columns(), size, |row, column| squares.entry(row, free[column]));
    let mut middle = factor.tr_mul(&factor) * correction;
    if let (Some(weight), Some(at)) =
        (weight, free.iter().position(|at| *at == problem.columns.radius()))
    {
        // The certified radius is off by as much as the noise over its weight.
        middle[(at, at)] += weight.powi(4) * (u_radius_mm(problem)).powi(2);
    }
    let inverse = DMatrix::from_vec(size, size, step.inverse_gram());
    let covariance = &inverse * middle * &inverse;
    let u = (0..size).map(|index| covariance[(index, index)].max(0.0).sqrt()).collect();
    let rms_mm = (square / count as f64).sqrt();
    Fit { rms_mm, inflation, covariance: covariance.transpose().iter().copied().collect(), u }
}

fn u_radius_mm(problem: &Problem<'_>) -> f64 {
    match problem.artefact {
        Artefact::Sphere { u_radius_mm, .. } => u_radius_mm,
        Artefact::Flat => 0.0,
    }
}

/// The fit with the radius as uncertain as its certificate says: its weight follows from the noise, which follows from
/// the fit.
fn weighed(
    problem: &Problem<'_>,
    state: &mut [f64],
    free: &[usize],
) -> Result<Fit, CalibrateError> {
    let radius = problem.columns.radius();
    let held: Vec<usize> = free.iter().copied().filter(|at| *at != radius).collect();
    let mut fit = rest(problem, state, &held, None)?;
    if !free.contains(&radius) {
        return Ok(fit);
    }
    for _ in 0..2 {
        // Residuals of nothing but rounding still need a weight.
        let noise_mm = (fit.rms_mm * fit.inflation.sqrt()).max(f64::EPSILON);
        fit = rest(problem, state, free, Some(noise_mm / u_radius_mm(problem)))?;
    }
    Ok(fit)
}

/// Unknowns that the points tell apart, and that the linear problem finds well enough to be of use.
fn determinate(problem: &Problem<'_>, state: &[f64], sizes: &[f64]) -> Vec<usize> {
    let mut groups = problem.columns.groups();
    // Its certificate determines the radius, or holds it.
    let radius = problem.columns.radius();
    groups.retain(|group| *group != [radius]);
    let system = System::new(&problem.triangle(state, None, false));
    let mut free = system.determinate(&groups, LEAST_RATIO);
    loop {
        let step = system.solve(&free, 0.0);
        let mut change = vec![0.0; problem.columns.count()];
        free.iter().zip(&step.change).for_each(|(&at, moved)| change[at] = *moved);
        let rows = system.rows().saturating_sub(free.len()).max(1);
        let variance = system.square_after(&change) / rows as f64;
        let covariance: Vec<f64> =
            step.inverse_gram().iter().map(|entry| entry * variance).collect();
        match worthless(problem, &free, &covariance, sizes) {
            Some(at) => free.retain(|other| *other != at),
            None => break,
        }
    }
    if u_radius_mm(problem) > 0.0 {
        free.push(radius);
        free.sort_unstable();
    }
    free
}

/// How far a value of 1 of each unknown moves points, as a root mean square; 0 of places and the radius, which stay.
fn sizes(problem: &Problem<'_>) -> Vec<f64> {
    let columns = &problem.columns;
    let mut sizes = vec![0.0; columns.count()];
    let axes = || problem.poses.iter().flat_map(|pose| &pose.axes);
    let count = axes().count() as f64;
    for (at, parameter) in columns.parameters().zip(&columns.parameters) {
        let square = |axes: &Axes| {
            let (place, outward) = axes.place();
            parameter.effect(place, outward).iter().map(|entry| entry * entry).sum::<f64>()
        };
        sizes[at] = (axes().map(square).sum::<f64>() / count).sqrt();
    }
    columns.map().chain(columns.form()).for_each(|at| sizes[at] = 1.0);
    sizes
}

fn report(
    machine: Machine,
    problem: &Problem<'_>,
    state: &[f64],
    free: &[usize],
    fit: &Fit,
    before_mm: f64,
) -> Calibration {
    let columns = &problem.columns;
    let u_of = |at: usize| free.iter().position(|free| *free == at).map(|index| fit.u[index]);
    let found = columns.parameters().zip(&columns.parameters);
    let parameters: Vec<Estimate> = found
        .clone()
        .filter_map(|(at, &parameter)| Some(Estimate { parameter, value: state[at], u: u_of(at)? }))
        .collect();
    let undetermined = found.filter(|(at, _)| u_of(*at).is_none()).map(|(_, &name)| name).collect();
    let terms = |range: std::ops::Range<usize>, orders: &[(u32, i32)]| -> Vec<Term> {
        let all = range.zip(orders);
        let term = |(at, &(n, m))| Some(Term { n, m, value_mm: state[at], u_mm: u_of(at)? });
        all.filter_map(term).collect()
    };
    let missing = |range: std::ops::Range<usize>, orders: &[(u32, i32)]| -> Vec<(u32, i32)> {
        range.zip(orders).filter(|(at, _)| u_of(*at).is_none()).map(|(_, &order)| order).collect()
    };
    let (map, form) = (terms(columns.map(), &columns.map), terms(columns.form(), &columns.form));
    let values = parameters.iter().map(|found| (found.parameter, found.value)).collect();
    let heights = map.iter().map(|term| (term.n, term.m, term.value_mm)).collect();
    let height_map = HeightMap::new(problem.map_radius_mm, heights);
    let correction = Correction::new(machine, values, height_map);
    Calibration {
        correction: correction.expect("checked parameters, finite values"),
        covariance: covariance(problem, free, fit),
        parameters,
        undetermined,
        map,
        map_undetermined: missing(columns.map(), &columns.map),
        form_rms_mm: root_of_squares(&form),
        form,
        form_undetermined: missing(columns.form(), &columns.form),
        form_radius_mm: problem.form_radius_mm,
        radius_mm: u_of(columns.radius()).map(|u| [state[columns.radius()], u]),
        places: (0..problem.poses.len())
            .map(|pose| {
                let start = columns.place(pose).start;
                [0, 1, 2].map(|axis| state[start + axis])
            })
            .collect(),
        before_mm,
        after_mm: fit.rms_mm,
        inflation: fit.inflation,
        points: problem.poses.iter().map(|pose| pose.axes.len()).sum(),
    }
}

/// Covariances of the parameters, which are the first unknowns.
fn covariance(problem: &Problem<'_>, free: &[usize], fit: &Fit) -> Vec<f64> {
    let count = free.iter().filter(|at| problem.columns.parameters().contains(at)).count();
    let rows = fit.covariance.chunks(free.len().max(1)).take(count);
    rows.flat_map(|row| row[..count].to_vec()).collect()
}

/// Root of the sum of the squares of terms, as they are orthogonal over the disc, and its u.
fn root_of_squares(terms: &[Term]) -> Option<[f64; 2]> {
    let root = terms.iter().map(|term| term.value_mm * term.value_mm).sum::<f64>().sqrt();
    let product: f64 = terms.iter().map(|term| (term.value_mm * term.u_mm).powi(2)).sum();
    (!terms.is_empty() && root > 0.0).then(|| [root, product.sqrt() / root])
}

/// Before any correction the points lie near the artefact, or it is another one.
fn check_artefact(problem: &Problem<'_>, before: &Fit) -> Result<(), CalibrateError> {
    let reach_mm = problem.map_radius_mm.max(problem.form_radius_mm);
    if before.rms_mm > LARGEST_SHARE * reach_mm {
        let found = format!(
            "the points lie {:.6} mm from the artefact as a root mean square, more than {LARGEST_SHARE} of their reach, {reach_mm:.6} mm",
            before.rms_mm
        );
        return Err(CalibrateError::NotTheArtefact { found });
    }
    Ok(())
}

/// Errors of a machine are a smaller share of the artefact.
const LARGEST_SHARE: f64 = 0.01;

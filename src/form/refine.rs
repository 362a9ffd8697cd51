//! Gauss-Newton steps, damped where they must be, on a fixed selection of points.

use crate::model::Model;
use crate::solve::{Step, System};
use crate::triangle::Triangle;
use crate::{Nominal, Parameter, PointMm, Pose};

/// Why the iteration of a fit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Termination {
    /// The last step moved the surface at the points by less than the tolerance.
    Converged {
        /// Root mean square motion of the last step in mm.
        motion_mm: f64,
        /// The tolerance in mm.
        tolerance_mm: f64,
    },
    /// No step, however short, made the sum of squares smaller.
    NoDescent {
        /// Root mean square motion in mm of the undamped step that is left.
        motion_mm: f64,
    },
    /// The largest number of steps was made.
    MaxIterations {
        /// That number.
        limit: usize,
        /// Root mean square motion of the last step in mm.
        motion_mm: f64,
    },
    /// Which points lie in the aperture went on changing with every fit.
    UnstableAperture {
        /// How many points changed sides after the last fit.
        changed: usize,
    },
}

impl Termination {
    /// Whether the result is the least-squares solution.
    pub fn is_converged(&self) -> bool {
        matches!(self, Termination::Converged { .. })
    }
}

/// Pose, shape, and the linear problem there.
#[derive(Clone, Debug)]
pub(crate) struct Refined {
    pub(crate) pose: Pose,
    pub(crate) nominal: Nominal,
    pub(crate) system: System,
    /// Indices of the determinate parameters among the free ones.
    pub(crate) kept: Vec<usize>,
    pub(crate) last: Step,
    pub(crate) termination: Termination,
    pub(crate) iterations: usize,
}

/// What a refinement may do.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) tolerance_mm: f64,
    pub(crate) iterations: usize,
    pub(crate) rank_tolerance: f64,
}

/// Moves pose and shape to the least-squares solution for `points`, each of which must have a foot.
/// `None` if the numbers overflow.
pub(crate) fn refine(
    points: &[PointMm],
    mut pose: Pose,
    mut nominal: Nominal,
    free: &[Parameter],
    limits: Limits,
) -> Option<Refined> {
    let mut system = linearise(points, &pose, &nominal, free)?;
    let kept = system.determinate(&priority(free, &nominal), limits.rank_tolerance);
    let rounding_mm = ROUNDING * magnitude_mm(points);
    let tolerance_mm = limits.tolerance_mm.max(rounding_mm);
    let mut damping = 0.0;
    let mut iterations = 0;
    let (termination, last) = loop {
        let newton = system.solve(&kept, 0.0);
        let motion_mm = newton.motion_mm;
        if motion_mm <= tolerance_mm {
            // The step is below the tolerance but free of charge.
            apply(&kept, free, &newton, &mut pose, &mut nominal);
            break (Termination::Converged { motion_mm, tolerance_mm }, newton);
        }
        if iterations >= limits.iterations {
            let limit = limits.iterations;
            break (Termination::MaxIterations { limit, motion_mm }, newton);
        }
        iterations += 1;
        let step = if damping > 0.0 { system.solve(&kept, damping) } else { newton.clone() };
        let (mut trial_pose, mut trial_nominal) = (pose, nominal);
        apply(&kept, free, &step, &mut trial_pose, &mut trial_nominal);
        let trial = linearise(points, &trial_pose, &trial_nominal, free);
        match trial {
            Some(trial) if trial.square() <= system.square() + noise(&system, rounding_mm) => {
                (pose, nominal, system) = (trial_pose, trial_nominal, trial);
                damping = if damping > LEAST_DAMPING { damping * DAMPING_DOWN } else { 0.0 };
            }
            _ => {
                damping = (damping * DAMPING_UP).max(LEAST_DAMPING);
                if damping > MOST_DAMPING {
                    break (Termination::NoDescent { motion_mm }, newton);
                }
            }
        }
    };
    Some(Refined { pose, nominal, system, kept, last, termination, iterations })
}

/// The order in which parameters are admitted: a plane is laid by its height and tilts, any other surface
/// by its shifts first; the turn about the axis comes last.
pub(crate) fn priority(free: &[Parameter], nominal: &Nominal) -> Vec<usize> {
    let plane = matches!(nominal, Nominal::Plane);
    let rank = |parameter: Parameter| match parameter {
        Parameter::Tz => 0,
        Parameter::Tx | Parameter::Ty => 1 + 2 * usize::from(plane),
        Parameter::Rx | Parameter::Ry => 2,
        Parameter::Radius => 4,
        Parameter::Conic => 5,
        Parameter::A(order) => usize::from(order) + 5,
        Parameter::Rz => 100,
    };
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by_key(|&index| (rank(free[index]), free[index]));
    order
}

fn linearise(
    points: &[PointMm],
    pose: &Pose,
    nominal: &Nominal,
    free: &[Parameter],
) -> Option<System> {
    if !pose.is_finite() || nominal.validate().is_err() {
        return None;
    }
    let triangle = Triangle::of_points(&Model::new(nominal, pose, free), points)?;
    triangle.is_finite().then(|| System::new(&triangle))
}

fn apply(kept: &[usize], free: &[Parameter], step: &Step, pose: &mut Pose, nominal: &mut Nominal) {
    for (&index, &change) in kept.iter().zip(&step.change) {
        free[index].add(change, pose, nominal);
    }
}

/// How far rounding of the coordinates may change the sum of squares: (d + e)² − d² = 2·d·e + e², summed
/// by the inequality of Cauchy and Schwarz.
fn noise(system: &System, rounding_mm: f64) -> f64 {
    let all_mm = (system.rows() as f64).sqrt() * rounding_mm;
    2.0 * system.square().sqrt() * all_mm + all_mm * all_mm
}

/// Largest coordinate in mm.
fn magnitude_mm(points: &[PointMm]) -> f64 {
    points.iter().flatten().fold(0.0, |largest: f64, coordinate| largest.max(coordinate.abs()))
}

/// Motion below this share of the largest coordinate is rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// Damping of the first damped step, relative to columns of unit length.
const LEAST_DAMPING: f64 = 1e-3;
const DAMPING_UP: f64 = 10.0;
const DAMPING_DOWN: f64 = 0.1;
const MOST_DAMPING: f64 = 1e10;

//! Gauss-Newton steps, damped where they must be, on a fixed selection of points.

use crate::fit::freedoms::{Chosen, Freedoms, Held};
use crate::fit::model::Model;
use crate::fit::solve::{Step, System};
use crate::fit::triangle::{Spread, Triangle};
use crate::nominal::parameter::moved;
use crate::{Nominal, Parameter, PointMm, Pose};

/// Why the iteration of a fit ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Termination {
    /// The last step moved the surface at the points by less than the tolerance: that of the settings or,
    /// where that is not reached within the steps allowed, what changes no parameter by more than a
    /// thousandth of its uncertainty.
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
    /// The determinate directions of the free parameters.
    pub(crate) freedoms: Freedoms,
    /// Combinations that the points do not feel.
    pub(crate) held: Vec<Held>,
    pub(crate) last: Step,
    pub(crate) termination: Termination,
    pub(crate) iterations: usize,
    /// How often distances and derivatives of all points were worked out.
    pub(crate) evaluations: usize,
    /// The distances where `system` was made.
    pub(crate) spread: Spread,
}

/// Bounds of a refinement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) tolerance_mm: f64,
    pub(crate) iterations: usize,
    pub(crate) rank_tolerance: f64,
    /// Whether to go on below the tolerance where convergence is slow. Gauss and Newton's method converges
    /// linearly where deviations are large, and then one step more is not exact: parameters may be off by the
    /// tolerance times the condition.
    pub(crate) polish: bool,
    /// Damping of the first step, relative to columns of unit length: far from the solution a long step
    /// along a weak combination of parameters leads astray.
    pub(crate) damping: f64,
    /// Where what the points do not feel is held.
    pub(crate) start: Pose,
}

/// Squares of distances that are to be least.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LeastSquares<'a> {
    pub(crate) points: &'a [PointMm],
    /// The distance of each point counts times its own of these.
    pub(crate) roots: Option<&'a [f64]>,
    pub(crate) free: &'a [Parameter],
}

impl LeastSquares<'_> {
    /// The linear problem at a pose of a nominal. `None` if the numbers overflow.
    pub(crate) fn linearise(&self, pose: &Pose, nominal: &Nominal) -> Option<(System, Spread)> {
        let model = Model::new(nominal, pose, self.free);
        let (triangle, spread) = Triangle::of_points(&model, self.points, self.roots)?;
        triangle.is_finite().then(|| (System::new(&triangle), spread))
    }
}

/// Moves pose and shape to the solution, each point of which must have a foot. `known` is the linear problem at
/// pose and nominal, where it has been worked out already. `None` if the numbers overflow.
pub(crate) fn refine(
    squares: LeastSquares<'_>,
    mut pose: Pose,
    mut nominal: Nominal,
    limits: Limits,
    known: Option<(System, Spread)>,
) -> Option<Refined> {
    let LeastSquares { points, free, .. } = squares;
    let mut evaluations = usize::from(known.is_none());
    let (mut system, mut spread) = match known {
        Some(known) => known,
        None => squares.linearise(&pose, &nominal)?,
    };
    let order = priority(free, &nominal);
    let Chosen { freedoms, held } =
        Chosen::new(&system, free, &order, [&pose, &limits.start], limits.rank_tolerance);
    let rounding_mm = rounding_mm(points);
    let tolerance_mm = limits.tolerance_mm.max(rounding_mm);
    let mut damping = limits.damping;
    let mut iterations = 0;
    let mut last_motion_mm = 0.0;
    let (termination, last) = loop {
        let newton = system.solve_along(&freedoms, 0.0);
        let motion_mm = newton.motion_mm;
        let slow = motion_mm > SLOW * last_motion_mm && motion_mm < HALVED * last_motion_mm;
        let polishes = limits.polish && slow && iterations < limits.iterations;
        last_motion_mm = motion_mm;
        if motion_mm <= tolerance_mm && !polishes {
            // The step is below the tolerance but free of charge. One that is only coarsely below may be
            // long along a weak combination, and nobody has looked where it leads.
            if limits.polish {
                (pose, nominal) = after(&freedoms, free, &newton, &pose, &nominal)?;
            }
            break (Termination::Converged { motion_mm, tolerance_mm }, newton);
        }
        if iterations >= limits.iterations {
            break (after_all_steps(&system, limits.iterations, motion_mm), newton);
        }
        iterations += 1;
        // What begins to shorten the step along the weakest combination of parameters.
        let least = FIRST_DAMPING / (newton.condition * newton.condition);
        let step =
            if damping > 0.0 { system.solve_along(&freedoms, damping) } else { newton.clone() };
        let mut step_to = |step: &Step, pose: &Pose, nominal: &Nominal| {
            let (pose, nominal) = after(&freedoms, free, step, pose, nominal)?;
            evaluations += 1;
            let (system, spread) = squares.linearise(&pose, &nominal)?;
            Some((pose, nominal, system, spread))
        };
        let enough = system.square() + noise(&system, rounding_mm);
        let trial = step_to(&step, &pose, &nominal).and_then(|trial| {
            if trial.2.square() <= enough {
                return Some(trial);
            }
            // A long step along a curved valley ends on its slope: a tilt about the vertex lifts the rim by
            // the square of the angle. The next step from there goes down again, and must not go along the
            // valley once more: on the slope the way along it is not what it is in the valley.
            let back = trial.2.solve_along(&freedoms, damping.max(ACROSS / newton.condition));
            step_to(&back, &trial.0, &trial.1).filter(|next| next.2.square() <= enough)
        });
        match trial {
            Some(trial) => {
                (pose, nominal, system, spread) = trial;
                damping = if damping > least { damping * DAMPING_DOWN } else { 0.0 };
            }
            _ if motion_mm <= tolerance_mm => {
                break (Termination::Converged { motion_mm, tolerance_mm }, newton);
            }
            _ => {
                damping = (damping * DAMPING_UP).max(least);
                if damping > MOST_DAMPING {
                    break (Termination::NoDescent { motion_mm }, newton);
                }
            }
        }
    };
    Some(Refined {
        pose,
        nominal,
        system,
        freedoms,
        held,
        last,
        termination,
        iterations,
        evaluations,
        spread,
    })
}

/// Why an iteration ends that has made all the steps it may, `limit` of them, where the next would still move by
/// `motion_mm`.
fn after_all_steps(system: &System, limit: usize, motion_mm: f64) -> Termination {
    // What is left is nothing beside what the deviations leave open, of any parameter.
    let tolerance_mm = NEGLIGIBLE * system.square().sqrt() / system.rows() as f64;
    if motion_mm <= tolerance_mm {
        Termination::Converged { motion_mm, tolerance_mm }
    } else {
        Termination::MaxIterations { limit, motion_mm }
    }
}

/// The groups in which parameters are admitted: a plane is laid by its height and tilts, any other surface
/// by its shifts first. The turn about the axis comes last on a rotational nominal; a freeform is laid by
/// all six motions before its own parameters follow, in their order.
///
/// On a rotational nominal each parameter is its own group. Which combination of its shifts or of its turns a freeform
/// does not feel depends on how it lies, so it has the shifts across and the turns in one group each: see
/// [`freedoms`](super::freedoms).
pub(crate) fn priority(free: &[Parameter], nominal: &Nominal) -> Vec<Vec<usize>> {
    let plane = matches!(nominal, Nominal::Plane);
    let freeform = !nominal.is_rotational();
    let rank = |parameter: Parameter| match parameter {
        Parameter::Tz => 0,
        Parameter::Tx | Parameter::Ty => 1 + 2 * usize::from(plane),
        Parameter::Rx | Parameter::Ry => 2,
        Parameter::Radius => 4,
        Parameter::Conic => 5,
        Parameter::A(order) => usize::from(order) + 5,
        Parameter::Rz if freeform => 2,
        Parameter::Rz => 100,
        Parameter::Shape(index) => 100 + usize::from(index),
    };
    let mut order: Vec<usize> = (0..free.len()).collect();
    order.sort_by_key(|&index| (rank(free[index]), free[index]));
    if !freeform {
        return order.into_iter().map(|index| vec![index]).collect();
    }
    order.chunk_by(|&a, &b| rank(free[a]) == rank(free[b])).map(<[usize]>::to_vec).collect()
}

fn after(
    freedoms: &Freedoms,
    free: &[Parameter],
    step: &Step,
    pose: &Pose,
    nominal: &Nominal,
) -> Option<(Pose, Nominal)> {
    let changes =
        freedoms.moving().iter().zip(&step.change).map(|(&index, &change)| (free[index], change));
    moved(changes, pose, nominal)
}

/// How far rounding of the coordinates may change the sum of squares: (d + e)² − d² = 2·d·e + e², summed
/// by the inequality of Cauchy and Schwarz.
fn noise(system: &System, rounding_mm: f64) -> f64 {
    let all_mm = (system.rows() as f64).sqrt() * rounding_mm;
    2.0 * system.square().sqrt() * all_mm + all_mm * all_mm
}

/// Motions and differences of distances below it are rounding, in mm: a share of the largest coordinate.
pub(crate) fn rounding_mm(points: &[PointMm]) -> f64 {
    let largest = |most: f64, coordinate: &f64| most.max(coordinate.abs());
    ROUNDING * points.iter().flatten().fold(0.0, largest)
}

/// Motion below this share of the largest coordinate is rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;
/// A motion that shrinks to more than this share of the last one shrinks slowly.
const SLOW: f64 = 1e-4;
/// A motion that does not shrink to this share of the last one is rounding.
const HALVED: f64 = 0.5;
/// A step that is so small a share of the uncertainty of every parameter is as good as none.
const NEGLIGIBLE: f64 = 1e-3;
/// Damping of the first damped step, relative to the square of the smallest singular value of the scaled
/// Jacobian.
const FIRST_DAMPING: f64 = 0.1;
const DAMPING_UP: f64 = 10.0;
const DAMPING_DOWN: f64 = 0.1;
const MOST_DAMPING: f64 = 1e10;
/// Damping of a step across a valley but not along it, times the condition: between the squares of the
/// singular values, which go from 1 down to 1 over the square of the condition.
const ACROSS: f64 = 1e-2;

//! Robust losses while points arrive: weights of the reference, and what changes in them since.
//!
//! A robust fit solves Σ ψ(e/s)·J = 0 for distances e at the scale s, and s hangs on all e. With the weights w₀ that the
//! points have at the reference, their rows add up like any others: a linear problem, exact at the reference. What a
//! change of pose or scale then makes of the weights, ψ − w₀·e, is small, hangs on e and is smooth in the place; so it
//! is worked out for whole classes of points that lie in one block of cells, equally far off ([`Classes`]). Median and
//! median absolute deviation come from the same classes. The steps are those of the fit (`fit/robust.rs`): Huber's loss
//! finds the scale, Tukey's keeps it, each reweighted until it no longer moves.
//!
//! So no point is shut out by the pose at which it came: points that weigh nothing at the reference lie in their class
//! and weigh again where another pose makes them near.

use nalgebra::{DMatrix, DVector};

use crate::fit::freedoms::Freedoms;
use crate::fit::robust::{Moments, NORMAL, SETTLED};
use crate::live::Grid;
use crate::live::classes::{Classes, Occupied};
use crate::live::middle::{Evenly, median_deviation};
use crate::live::problem::{Problem, dot};
use crate::live::weighted::Weighted;
use crate::{Fit, FitSettings, Loss, Robust};

/// The sums by the weights of a robust loss at the reference.
#[derive(Clone, Debug)]
pub(crate) struct Reweighing {
    at: At,
    stages: Vec<(Loss, Weighted)>,
    classes: Classes,
    /// Points given, used or not, and the sum of their weights by uncertainty.
    given: f64,
    weight: f64,
}

/// Parameters that a reference fixes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct At {
    loss: Loss,
    given_mm: Option<f64>,
    tolerance_mm: f64,
    /// A point of this uncertainty weighs 1; 1 without uncertainties.
    unit_mm: f64,
    /// The scale of the weights in the sums, in mm times the root of a weight by uncertainty.
    scale: f64,
    /// The scale of the points at the reference over what their classes tell.
    calibration: f64,
}

/// The solution at a moment.
#[derive(Clone, Debug)]
pub(crate) struct Reweighed {
    pub(crate) change: Vec<f64>,
    pub(crate) bends: Vec<f64>,
    /// Where the scale was found.
    pub(crate) first_change: Vec<f64>,
    pub(crate) robust: Robust,
    /// The standard deviation that goes with (JᵀJ)⁻¹, in mm times the root of a weight by uncertainty.
    pub(crate) sigma: Option<f64>,
    /// (Σw)²/Σw².
    pub(crate) effective_points: f64,
}

/// Terms that linearisation leaves out.
struct Bends {
    /// The second-order terms of every cell.
    cells: Vec<f64>,
    /// Their means over each block: one row of derivatives and distance a block.
    blocks: Vec<Vec<f64>>,
}

/// Gives the second-order terms of every cell at a change; `None` where there are none.
type BendsAt<'a> = &'a dyn Fn(&[f64]) -> Option<Vec<f64>>;
/// Gives their means over the blocks.
type MeanBends<'a> = &'a dyn Fn(&Classes, &[f64]) -> Vec<Vec<f64>>;

/// One stage on its way.
struct Stage<'a> {
    loss: Loss,
    problem: &'a Problem<'a>,
    /// JᵀJ of the problem.
    gram: DMatrix<f64>,
    classes: &'a [Occupied<'a>],
    /// What each class has in the problem: Σψ over its roots, in scales, and the weight of the loss.
    known: Vec<[f64; 2]>,
    freedoms: &'a Freedoms,
}

/// A step of one stage.
struct Step {
    change: Vec<f64>,
    /// How far it moves the surface, root mean square, in mm times the root of a weight by uncertainty.
    motion: f64,
}

impl Reweighing {
    /// Without points. `unit_mm` is the uncertainty of a point of mean weight at the reference, 1 without uncertainties;
    /// the reference was found by the loss of the settings. `None` for squares.
    pub(crate) fn new(
        reference: &Fit,
        settings: &FitSettings,
        grid: &Grid,
        side: usize,
        unit_mm: f64,
        columns: usize,
    ) -> Option<Reweighing> {
        let robust = reference.robust.filter(|_| settings.loss != Loss::Squares)?;
        let tolerance_mm = settings.tolerance_mm.max(f64::MIN_POSITIVE);
        let at = At {
            loss: settings.loss,
            given_mm: settings.loss_scale_mm,
            tolerance_mm,
            unit_mm,
            scale: robust.scale_mm.max(tolerance_mm),
            calibration: 1.0,
        };
        let weighted = |loss| (loss, Weighted::new(columns, grid.cells() + 1, unit_mm));
        Some(Reweighing {
            at,
            stages: settings.loss.stages().into_iter().map(weighted).collect(),
            classes: Classes::new(grid, side, columns - 1, settings.loss),
            given: 0.0,
            weight: 0.0,
        })
    }

    /// Notes a point, used or not, by its uncertainty along the normal.
    pub(crate) fn note(&mut self, u_mm: Option<f64>) {
        self.given += 1.0;
        self.weight += self.root(u_mm).powi(2);
    }

    /// Adds the row of a point in a cell.
    pub(crate) fn add(&mut self, row: &[f64], u_mm: Option<f64>, cell: usize) {
        let root = self.root(u_mm);
        let derivatives = &row[..row.len() - 1];
        let distance = root * row[row.len() - 1] / self.at.scale;
        self.classes.add(cell, root, distance, derivatives);
        for (loss, weighted) in &mut self.stages {
            let weight = loss.weight(distance);
            if weight > 0.0 {
                weighted.add_by(row, root * weight.sqrt(), cell);
            }
        }
    }

    /// Reference without its points.
    pub(crate) fn emptied(&self, grid: &Grid, columns: usize) -> Reweighing {
        let empty = |&(loss, _): &(Loss, Weighted)| {
            (loss, Weighted::new(columns, grid.cells() + 1, self.at.unit_mm))
        };
        Reweighing {
            at: self.at,
            stages: self.stages.iter().map(empty).collect(),
            classes: self.classes.emptied(),
            given: 0.0,
            weight: 0.0,
        }
    }

    pub(crate) fn merge(&mut self, other: Reweighing) {
        for ((_, own), (_, other)) in self.stages.iter_mut().zip(other.stages) {
            own.merge(other);
        }
        self.classes.merge(other.classes);
        self.given += other.given;
        self.weight += other.weight;
    }

    /// Whether the weights of another are those of the same scale.
    pub(crate) fn is_compatible(&self, other: &Reweighing) -> bool {
        self.at == other.at
    }

    pub(crate) fn unit_mm(&self) -> f64 {
        self.at.unit_mm
    }

    /// (Σw)²/Σw² by the weights at the reference.
    pub(crate) fn effective_points(&self) -> f64 {
        self.stages.last().map_or(0.0, |(_, weighted)| weighted.effective_points())
    }

    /// Holds what the classes tell of the scale at the reference against that of the points themselves, which is known.
    pub(crate) fn calibrate(&mut self, found: &Reweighed, scale_mm: f64) {
        let ratio = scale_mm / found.robust.scale_mm;
        if ratio.is_normal() && found.robust.scale_mm > self.at.tolerance_mm {
            self.at.calibration = ratio;
        }
    }

    fn root(&self, u_mm: Option<f64>) -> f64 {
        u_mm.map_or(1.0, |u_mm| self.at.unit_mm / u_mm)
    }

    /// Root of the mean weight by uncertainty.
    fn mean_root(&self) -> f64 {
        (self.weight / self.given.max(1.0)).sqrt()
    }

    /// The solution for the points so far. `bends` gives the second-order terms of every cell at a change, `mean_bends`
    /// their means over every block. At the scale `fixed_mm`, if there is one, the scale told is what the
    /// classes tell, uncalibrated. `None` where it is beyond the reach of linearisation.
    pub(crate) fn solve(
        &self,
        freedoms: &Freedoms,
        fixed_mm: Option<f64>,
        bends: BendsAt<'_>,
        mean_bends: MeanBends<'_>,
    ) -> Option<Reweighed> {
        let classes = self.classes.occupied();
        let parameters = freedoms.moving().len();
        let mut change = vec![0.0; parameters];
        let bends_at = |change: &[f64]| {
            let cells = bends(change)?;
            Some(Bends { blocks: mean_bends(&self.classes, &cells), cells })
        };
        let mut bent = bends_at(&change)?;
        let floor = self.mean_root() * self.at.tolerance_mm;
        let given_mm = self.at.given_mm.or(fixed_mm);
        let mut scale = given_mm.map_or(self.at.scale, |mm| mm * self.mean_root());
        let mut first_change = change.clone();
        let (mut rounds, mut told) = (0, scale);
        for (index, (loss, weighted)) in self.stages.iter().enumerate() {
            let problem = weighted.problem()?;
            let stage = Stage::new(*loss, &problem, &classes, freedoms);
            let is_last = index + 1 == self.stages.len();
            for bending in 0..BENDINGS {
                let mut rounds_here = 0;
                let (mut last_motion, mut by_slopes) = (f64::INFINITY, false);
                let gram = problem.bent_gram(&stage.gram, &bent.cells);
                while rounds_here < MAX_ROUNDS {
                    rounds_here += 1;
                    let before = scale;
                    if index == 0 && given_mm.is_none() {
                        let found = self.found_scale(&classes, &bent, &change);
                        scale = (self.at.calibration * found).max(floor);
                    }
                    let scales = [self.at.scale, scale];
                    let step = stage.step(&change, &bent, scales, &gram, by_slopes)?;
                    let motion = step.motion;
                    change.iter_mut().zip(&step.change).for_each(|(total, part)| *total += part);
                    follow(&mut bent.cells, &step.change);
                    bent.blocks = mean_bends(&self.classes, &bent.cells);
                    by_slopes = motion < SHRINKS * last_motion;
                    last_motion = motion;
                    let enough = if is_last { SETTLED } else { NEARLY };
                    if motion <= enough * scale && (scale - before).abs() <= enough * scale {
                        break;
                    }
                }
                rounds += rounds_here;
                if last_motion.is_nan() || last_motion > NEAR * scale {
                    return None;
                }
                if index == 0 {
                    first_change.clone_from(&change);
                    told = match fixed_mm {
                        Some(_) => self.found_scale(&classes, &bent, &change),
                        None => scale,
                    };
                }
                if bending > 0 && rounds_here == 1 {
                    break;
                }
                bent = bends_at(&change)?;
            }
        }
        let loss = self.at.loss;
        let (moments, below_half, zero) =
            counted(loss, &classes, &bent, &change, [self.at.scale, scale]);
        let robust = Robust {
            loss,
            scale_mm: told / self.mean_root(),
            scale_given: self.at.given_mm.is_some(),
            below_half,
            zero,
            rounds,
        };
        let sigma = moments.sigma_in_scales(freedoms.count()).map(|sigma| sigma * scale);
        let effective_points = self.effective_points_at(&classes, &bent, &change, scale);
        Some(Reweighed { change, bends: bent.cells, first_change, robust, sigma, effective_points })
    }

    /// (Σw)²/Σw² at a change: exact at the reference, and changed as the classes tell.
    fn effective_points_at(
        &self,
        classes: &[Occupied<'_>],
        bends: &Bends,
        change: &[f64],
        scale: f64,
    ) -> f64 {
        let of_classes = |bends: &Bends, change: &[f64], scale: f64| {
            effective(self.at.loss, classes, bends, change, [self.at.scale, scale])
        };
        let parameters = change.len();
        let still = vec![0.0; parameters];
        let flat = Bends {
            cells: Vec::new(),
            blocks: vec![vec![0.0; parameters + 1]; self.classes.blocks()],
        };
        let before = of_classes(&flat, &still, self.at.scale);
        let grown = of_classes(bends, change, scale) / before;
        self.effective_points() * if grown.is_finite() { grown } else { 1.0 }
    }

    /// 1.4826·MAD of the distances at a change.
    fn found_scale(&self, classes: &[Occupied<'_>], bends: &Bends, change: &[f64]) -> f64 {
        let evenly = classes.iter().map(|class| Evenly {
            middle: class.distance
                + class.root / class.count * bends.moved(class, change, self.at.scale),
            half: class.half,
            count: class.count,
        });
        NORMAL * self.at.scale * median_deviation(&evenly.collect::<Vec<_>>())
    }
}

impl Bends {
    /// By how many scales a class moves, but for the root of its weight.
    fn moved(&self, class: &Occupied<'_>, change: &[f64], scale: f64) -> f64 {
        let bend = self.blocks[class.block][change.len()];
        (dot(class.row, change) / class.weight + bend) / scale
    }
}

impl<'a> Stage<'a> {
    fn new(
        loss: Loss,
        problem: &'a Problem<'a>,
        classes: &'a [Occupied<'a>],
        freedoms: &'a Freedoms,
    ) -> Stage<'a> {
        let parameters = freedoms.moving().len();
        let none = vec![0.0; parameters];
        let at_none = problem.system.gradient(&none);
        let mut gram = DMatrix::zeros(parameters, parameters);
        for j in 0..parameters {
            let mut unit = none.clone();
            unit[j] = 1.0;
            let column = problem.system.gradient(&unit);
            (0..parameters).for_each(|i| gram[(i, j)] = column[i] - at_none[i]);
        }
        let known = classes
            .iter()
            .map(|class| [mean_psi(loss, class.distance, class.half), loss.weight(class.distance)]);
        Stage { loss, problem, gram, known: known.collect(), classes, freedoms }
    }

    /// One step, by the weights or, if that is asked for and well determined, by the slopes of ψ: Newton's, which goes
    /// the whole way where it is short. `None` if there is none.
    fn step(
        &self,
        change: &[f64],
        bends: &Bends,
        [from_scale, scale]: [f64; 2],
        gram: &DMatrix<f64>,
        by_slopes: bool,
    ) -> Option<Step> {
        let p = change.len();
        if p == 0 {
            return Some(Step { change: Vec::new(), motion: 0.0 });
        }
        let ratio = scale / from_scale;
        let mut gradient = self.problem.gradient(change, &bends.cells);
        let (mut weights, mut slopes) = (gram.clone(), gram.clone());
        let mut row = vec![0.0; p];
        for (class, [psi, weight]) in self.classes.iter().zip(&self.known) {
            let shift = class.mean_root * bends.moved(class, change, from_scale);
            let (distance, half) = ((class.distance + shift) / ratio, class.half / ratio);
            let now = ratio * mean_psi(self.loss, distance, half);
            let of_psi = class.root * (now - psi - weight * shift) * from_scale;
            let of_weight = class.weight * (self.loss.weight(distance) - weight);
            let bend = &bends.blocks[class.block];
            for (j, entry) in row.iter_mut().enumerate() {
                *entry = class.row[j] / class.weight + bend[j];
                gradient[j] += of_psi * *entry;
            }
            add_square(&mut weights, &row, of_weight);
            if by_slopes {
                let of_slope = class.weight * (mean_slope(self.loss, distance, half) - weight);
                add_square(&mut slopes, &row, of_slope);
            }
        }
        // Where rounding leaves no sums of squares, those of the reference are some.
        let mut step = match solved(&weights, &gradient, self.freedoms) {
            Some(step) => step,
            None => {
                weights.copy_from(gram);
                solved(&weights, &gradient, self.freedoms)?
            }
        };
        let square = |step: &DVector<f64>| step.dot(&(&weights * step));
        if by_slopes
            && let Some(newton) = solved(&slopes, &gradient, self.freedoms)
            && square(&newton) < LONGEST * LONGEST * square(&step)
        {
            step = newton;
        }
        let count: f64 = self.classes.iter().map(|class| class.count).sum();
        let motion = (square(&step) / count).sqrt();
        (motion >= 0.0).then(|| Step { change: step.iter().map(|part| -part).collect(), motion })
    }
}

/// Moves the bends along with a step, as far as the bent derivatives tell.
fn follow(bends: &mut [f64], step: &[f64]) {
    let p = step.len();
    for bend in bends.chunks_exact_mut(p + 1) {
        bend[p] += dot(bend, step);
    }
}

/// Adds a row times itself times a factor.
fn add_square(gram: &mut DMatrix<f64>, row: &[f64], factor: f64) {
    if factor != 0.0 {
        for (j, b) in row.iter().enumerate() {
            let of_column = factor * b;
            gram.column_mut(j).iter_mut().zip(row).for_each(|(sum, a)| *sum += a * of_column);
        }
    }
}

/// The solution of a small system of equations along the directions there are; `None` if its matrix is not positive definite.
fn solved(gram: &DMatrix<f64>, gradient: &[f64], freedoms: &Freedoms) -> Option<DVector<f64>> {
    let Some(directions) = freedoms.directions() else { return solved_by_each(gram, gradient) };
    let along = directions.tr_mul(&DVector::from_column_slice(gradient));
    let turned = directions.tr_mul(&(gram * directions));
    Some(directions * solved_by_each(&turned, along.as_slice())?)
}

fn solved_by_each(gram: &DMatrix<f64>, gradient: &[f64]) -> Option<DVector<f64>> {
    let p = gradient.len();
    let lengths = DVector::from_fn(p, |j, _| gram[(j, j)].sqrt());
    if lengths.iter().any(|length| !length.is_normal()) {
        return None;
    }
    let scaled = DMatrix::from_fn(p, p, |i, j| gram[(i, j)] / (lengths[i] * lengths[j]));
    let along = DVector::from_fn(p, |j, _| gradient[j] / lengths[j]);
    Some(scaled.cholesky()?.solve(&along).component_div(&lengths))
}

/// The mean of ψ′ over an interval of distances in scales.
fn mean_slope(loss: Loss, distance: f64, half: f64) -> f64 {
    let psi = |distance: f64| loss.weight(distance) * distance;
    if half > 0.0 {
        (psi(distance + half) - psi(distance - half)) / (2.0 * half)
    } else {
        loss.slope(distance)
    }
}

/// The mean of ψ in scales over an interval of distances.
fn mean_psi(loss: Loss, distance: f64, half: f64) -> f64 {
    if half > 0.0 {
        (loss.cost(distance + half) - loss.cost(distance - half)) / (2.0 * half)
    } else {
        loss.weight(distance) * distance
    }
}

/// The sums for uncertainties, and the points that weigh less than one half and nothing, at a change of the parameters;
/// `scales` are those of the reference and of now.
fn counted(
    loss: Loss,
    classes: &[Occupied<'_>],
    bends: &Bends,
    change: &[f64],
    [from_scale, scale]: [f64; 2],
) -> (Moments, usize, usize) {
    let ratio = scale / from_scale;
    let mut moments = Moments::default();
    let [half_from, zero_from] = edges(loss);
    let (mut below_half, mut zero) = (0.0, 0.0);
    for class in classes {
        let distance =
            (class.distance + class.mean_root * bends.moved(class, change, from_scale)) / ratio;
        let half = class.half / ratio;
        let psi = mean_psi(loss, distance, half);
        let slope = mean_slope(loss, distance, half);
        moments.count += class.count;
        moments.psi_square += class.count * psi * psi;
        moments.slope += class.count * slope;
        moments.slope_square += class.count * slope * slope;
        below_half += class.count * beyond(distance.abs(), half, half_from);
        zero += class.count * beyond(distance.abs(), half, zero_from);
    }
    (moments, below_half.round() as usize, zero.round() as usize)
}

/// (Σw)²/Σw² as classes have it, whose points count alike by their uncertainties; `scales` as in [`counted`].
fn effective(
    loss: Loss,
    classes: &[Occupied<'_>],
    bends: &Bends,
    change: &[f64],
    [from_scale, scale]: [f64; 2],
) -> f64 {
    let (mut sum, mut square) = (0.0, 0.0);
    for class in classes {
        let moved = class.mean_root * bends.moved(class, change, from_scale);
        let weight = loss.weight((class.distance + moved) * from_scale / scale);
        sum += class.weight * weight;
        square += class.weight * (class.mean_root * weight).powi(2);
    }
    sum * sum / square
}

/// The share of points spread evenly about a distance that lies beyond an edge.
fn beyond(distance: f64, half: f64, edge: f64) -> f64 {
    if half > 0.0 {
        ((distance + half - edge) / (2.0 * half)).clamp(0.0, 1.0)
    } else {
        f64::from(distance > edge)
    }
}

/// Distances in scales from which a point weighs less than one half, and nothing.
fn edges(loss: Loss) -> [f64; 2] {
    match loss {
        Loss::Squares => [f64::INFINITY; 2],
        Loss::Huber { k } => [2.0 * k, f64::INFINITY],
        Loss::Tukey { k } => [k * (1.0 - 0.5_f64.sqrt()).sqrt(), k],
    }
}

/// The uncertainty of a point of mean weight, as a fit tells it; `None` if it has no uncertainties or fits exactly.
pub(crate) fn mean_uncertainty_mm(fit: &Fit) -> Option<f64> {
    let mm = fit.sigma_mm / fit.reduced_chi_square?.sqrt();
    mm.is_normal().then_some(mm)
}

/// Rounds of one stage.
const MAX_ROUNDS: usize = 100;
/// Share of the scale by which the surface may still move after them: more is no solution.
const NEAR: f64 = 1e-2;
/// A step by slopes follows one that is so much shorter than the one before it.
const SHRINKS: f64 = 0.8;
/// It may be longer than one by weights by this factor.
const LONGEST: f64 = 4.0;
/// Times the second-order terms are worked out.
const BENDINGS: usize = 6;
/// Share of the scale by which the surface may still move where only the scale is looked for.
const NEARLY: f64 = 1e-5;

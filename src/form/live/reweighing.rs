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

/// What a reference fixes.
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
}

/// What the cells say at a change of the parameters: mean row of each block, and its bend in the last entry.
struct Places {
    rows: Vec<Vec<f64>>,
}

/// One stage on its way.
struct Stage<'a> {
    loss: Loss,
    problem: &'a Problem<'a>,
    /// JᵀJ of the problem.
    gram: DMatrix<f64>,
    classes: &'a [Occupied],
    /// What each class has in the problem: Σψ over its roots, in scales, and the weight of the loss.
    known: Vec<[f64; 2]>,
}

impl Reweighing {
    /// Without points. `unit_mm` is the uncertainty of a point of mean weight at the reference, 1 without uncertainties;
    /// the reference was found by the loss of the settings. `None` for squares.
    pub(crate) fn new(
        reference: &Fit,
        settings: &FitSettings,
        grid: &Grid,
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
            classes: Classes::new(grid, settings.loss),
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
        let distance = root * row[row.len() - 1] / self.at.scale;
        self.classes.add(cell, root, distance);
        for (loss, weighted) in &mut self.stages {
            let weight = loss.weight(distance);
            if weight > 0.0 {
                weighted.add_by(row, root * weight.sqrt(), cell);
            }
        }
    }

    /// The same reference without its points.
    pub(crate) fn emptied(&self, grid: &Grid, columns: usize) -> Reweighing {
        let empty = |&(loss, _): &(Loss, Weighted)| {
            (loss, Weighted::new(columns, grid.cells() + 1, self.at.unit_mm))
        };
        Reweighing {
            at: self.at,
            stages: self.stages.iter().map(empty).collect(),
            classes: Classes::new(grid, self.at.loss),
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

    /// The solution for the points so far. `bends` gives the second-order terms of every cell at a change, `mean_rows`
    /// the mean row of every block with these terms. At the scale `fixed_mm`, if there is one, the scale told is what the
    /// classes tell, uncalibrated. `None` where it is beyond the reach of linearisation.
    pub(crate) fn solve(
        &self,
        parameters: usize,
        fixed_mm: Option<f64>,
        bends: &dyn Fn(&[f64]) -> Option<Vec<f64>>,
        mean_rows: &dyn Fn(&Classes, &[f64]) -> Vec<Vec<f64>>,
    ) -> Option<Reweighed> {
        let classes = self.classes.occupied();
        let mut change = vec![0.0; parameters];
        let mut bent = bends(&change)?;
        let mut places = Places { rows: mean_rows(&self.classes, &bent) };
        let floor = self.mean_root() * self.at.tolerance_mm;
        let given_mm = self.at.given_mm.or(fixed_mm);
        let mut scale = given_mm.map_or(self.at.scale, |mm| mm * self.mean_root());
        let mut first_change = change.clone();
        let (mut rounds, mut told) = (0, scale);
        for (index, (loss, weighted)) in self.stages.iter().enumerate() {
            let problem = weighted.problem()?;
            let stage = Stage::new(*loss, &problem, &classes, parameters);
            let is_last = index + 1 == self.stages.len();
            for bending in 0..BENDINGS {
                let mut rounds_here = 0;
                loop {
                    rounds_here += 1;
                    if rounds_here > MAX_ROUNDS {
                        return None;
                    }
                    let before = scale;
                    if index == 0 && given_mm.is_none() {
                        let told = self.found_scale(&classes, &places, &change);
                        scale = (self.at.calibration * told).max(floor);
                    }
                    let motion = stage.step(&mut change, &bent, &places, self.at.scale, scale)?;
                    let enough = if is_last { SETTLED } else { NEARLY };
                    if motion <= enough * scale && (scale - before).abs() <= enough * scale {
                        break;
                    }
                }
                rounds += rounds_here;
                if index == 0 {
                    first_change.clone_from(&change);
                    told = match fixed_mm {
                        Some(_) => self.found_scale(&classes, &places, &change),
                        None => scale,
                    };
                }
                if bending > 0 && rounds_here == 1 {
                    break;
                }
                bent = bends(&change)?;
                places = Places { rows: mean_rows(&self.classes, &bent) };
                // The scale alone does not need them.
                if !is_last {
                    break;
                }
            }
        }
        let loss = self.at.loss;
        let (moments, below_half, zero) = counted(loss, &classes, &places, &change, [self.at.scale, scale]);
        let robust = Robust {
            loss,
            scale_mm: told / self.mean_root(),
            scale_given: self.at.given_mm.is_some(),
            below_half,
            zero,
            rounds,
        };
        let sigma = moments.sigma_in_scales(parameters).map(|sigma| sigma * scale);
        Some(Reweighed { change, bends: bent, first_change, robust, sigma })
    }

    /// 1.4826·MAD of the distances at a change.
    fn found_scale(&self, classes: &[Occupied], places: &Places, change: &[f64]) -> f64 {
        let moved = places.moved(change, self.at.scale);
        let evenly = classes.iter().map(|class| Evenly {
            middle: class.distance + class.root / class.count * moved[class.block],
            half: class.half,
            count: class.count,
        });
        NORMAL * self.at.scale * median_deviation(&evenly.collect::<Vec<_>>())
    }
}

impl Places {
    /// By how many scales each block moves.
    fn moved(&self, change: &[f64], scale: f64) -> Vec<f64> {
        let p = change.len();
        self.rows.iter().map(|row| (dot(row, change) + row[p]) / scale).collect()
    }
}

impl<'a> Stage<'a> {
    fn new(
        loss: Loss,
        problem: &'a Problem<'a>,
        classes: &'a [Occupied],
        parameters: usize,
    ) -> Stage<'a> {
        let none = vec![0.0; parameters];
        let at_none = problem.system.gradient(&none);
        let mut gram = DMatrix::zeros(parameters, parameters);
        for j in 0..parameters {
            let mut unit = none.clone();
            unit[j] = 1.0;
            let column = problem.system.gradient(&unit);
            (0..parameters).for_each(|i| gram[(i, j)] = column[i] - at_none[i]);
        }
        let known = classes.iter().map(|class| {
            [mean_psi(loss, class.distance, class.half), loss.weight(class.distance)]
        });
        Stage { loss, problem, gram, known: known.collect(), classes }
    }

    /// One reweighted step; how far it moves the surface, root mean square, in mm times a root. `None` if there is none.
    fn step(
        &self,
        change: &mut [f64],
        bends: &[f64],
        places: &Places,
        from_scale: f64,
        scale: f64,
    ) -> Option<f64> {
        let p = change.len();
        if p == 0 {
            return Some(0.0);
        }
        let moved = places.moved(change, from_scale);
        let ratio = scale / from_scale;
        // For each block: what its points add to Σψ, in units of the reference's scale, and to Σw.
        let mut added = vec![[0.0; 2]; places.rows.len()];
        for (class, [psi, weight]) in self.classes.iter().zip(&self.known) {
            let shift = class.mean_root * moved[class.block];
            let distance = (class.distance + shift) / ratio;
            let now = ratio * mean_psi(self.loss, distance, class.half / ratio);
            let [of_psi, of_weight] = &mut added[class.block];
            *of_psi += class.root * (now - psi - weight * shift);
            *of_weight += class.root * class.mean_root * (self.loss.weight(distance) - weight);
        }
        let mut gradient = DVector::from_vec(self.problem.gradient(change, bends));
        let mut gram = self.gram.clone();
        for (row, [psi, weight]) in places.rows.iter().zip(&added) {
            for j in 0..p {
                gradient[j] += row[j] * psi * from_scale;
                for i in 0..p {
                    gram[(i, j)] += row[i] * row[j] * weight;
                }
            }
        }
        let lengths = DVector::from_fn(p, |j, _| gram[(j, j)].sqrt());
        if lengths.iter().any(|length| !length.is_normal()) {
            return None;
        }
        let scaled = DMatrix::from_fn(p, p, |i, j| gram[(i, j)] / (lengths[i] * lengths[j]));
        let along = gradient.component_div(&lengths);
        let step = scaled.cholesky()?.solve(&along);
        let square = along.dot(&step);
        for j in 0..p {
            change[j] -= step[j] / lengths[j];
        }
        let count: f64 = self.classes.iter().map(|class| class.count).sum();
        (square >= 0.0).then(|| (square / count).sqrt())
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
    classes: &[Occupied],
    places: &Places,
    change: &[f64],
    [from_scale, scale]: [f64; 2],
) -> (Moments, usize, usize) {
    let moved = places.moved(change, from_scale);
    let ratio = scale / from_scale;
    let mut moments = Moments::default();
    let [half_from, zero_from] = edges(loss);
    let (mut below_half, mut zero) = (0.0, 0.0);
    for class in classes {
        let distance = (class.distance + class.mean_root * moved[class.block]) / ratio;
        let half = class.half / ratio;
        let psi = mean_psi(loss, distance, half);
        let at = |distance: f64| loss.weight(distance) * distance;
        let slope = if half > 0.0 {
            (at(distance + half) - at(distance - half)) / (2.0 * half)
        } else {
            loss.slope(distance)
        };
        moments.count += class.count;
        moments.psi_square += class.count * psi * psi;
        moments.slope += class.count * slope;
        moments.slope_square += class.count * slope * slope;
        below_half += class.count * beyond(distance.abs(), half, half_from);
        zero += class.count * beyond(distance.abs(), half, zero_from);
    }
    (moments, below_half.round() as usize, zero.round() as usize)
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
const MAX_ROUNDS: usize = 60;
/// Times the second-order terms are worked out.
const BENDINGS: usize = 6;
/// Share of the scale by which the surface may still move where only the scale is looked for.
const NEARLY: f64 = 1e-5;

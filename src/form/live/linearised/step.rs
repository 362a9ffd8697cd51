//! From the sums to the change of the parameters, with what linearisation leaves out.

use super::Linearised;
use crate::fit::model::Model;
use crate::live::classes::Classes;
use crate::live::problem::{Problem, dot};
use crate::nominal::parameter::moved;
use crate::{Nominal, Pose};

impl Linearised {
    /// The mean of the bends over the points of each block of cells.
    pub(super) fn mean_bends(&self, classes: &Classes, bends: &[f64]) -> Vec<Vec<f64>> {
        let columns = self.free.len() + 1;
        let mut means = vec![vec![0.0; columns]; classes.blocks()];
        let mut counts = vec![0.0; classes.blocks()];
        for (index, (cell, bend)) in self.cells.iter().zip(bends.chunks_exact(columns)).enumerate()
        {
            let Some(cell) = cell else { continue };
            let (block, count) = (classes.block(index), cell.count as f64);
            counts[block] += count;
            means[block].iter_mut().zip(bend).for_each(|(sum, bend)| *sum += count * bend);
        }
        for (mean, count) in means.iter_mut().zip(counts).filter(|(_, count)| *count > 0.0) {
            mean.iter_mut().for_each(|entry| *entry /= count);
        }
        means
    }

    /// The change of the parameters from the reference, and the bends there.
    ///
    /// Where few points determine the parameters badly, the linear solution may lie beyond the reach of
    /// linearisation. Then damped steps are tried, down to none, until one does not make the sum of
    /// squares larger.
    pub(super) fn change(&self, problem: &Problem<'_>) -> (Vec<f64>, Vec<f64>) {
        if let Some(found) = self.undamped(problem) {
            return found;
        }
        let (still, flat) = self.none();
        let most = problem.square(&still, &flat);
        for damping in DAMPINGS {
            let change = problem.system.solve_along(&self.fit.freedoms, damping).change;
            let Some(bends) = self.bends(&change) else { continue };
            if problem.square(&change, &bends) <= most {
                return (change, bends);
            }
        }
        (still, flat)
    }

    /// The linear solution with its corrections, unless it makes the sum of squares larger.
    pub(super) fn undamped(&self, problem: &Problem<'_>) -> Option<(Vec<f64>, Vec<f64>)> {
        let (still, flat) = self.none();
        let most_mm = problem.square(&still, &flat).sqrt();
        let rows = problem.system.rows() as f64;
        let slack_mm = (most_mm + rows.sqrt() * CORRECTED_MM * problem.root_weight) * SLACK;
        let found = self.newton(problem)?;
        (problem.square(&found.0, &found.1).sqrt() <= most_mm + slack_mm).then_some(found)
    }

    /// No change, and the bends there.
    fn none(&self) -> (Vec<f64>, Vec<f64>) {
        let p = self.free.len();
        (vec![0.0; p], vec![0.0; self.cells.len() * (p + 1)])
    }

    /// The linear solution with its corrections for the terms of second order; `None` if these grow.
    fn newton(&self, problem: &Problem<'_>) -> Option<(Vec<f64>, Vec<f64>)> {
        let Problem { system, root_weight, .. } = problem;
        let step = system.solve_along(&self.fit.freedoms, 0.0);
        let mut change = step.change.clone();
        let mut bends = self.bends(&change)?;
        let mut before_mm = (step.motion_mm / root_weight).max(CORRECTED_MM);
        for _ in 0..CORRECTIONS {
            let gradient = problem.gradient(&change, &bends);
            let correction = step.undo_gram(&gradient);
            // gᵀ·(JᵀJ)⁻¹·g is the square of the motion at the points, summed.
            let square = dot(&gradient, &correction).max(0.0);
            let motion_mm = (square / system.rows() as f64).sqrt() / root_weight;
            if motion_mm > before_mm || motion_mm.is_nan() {
                return None;
            }
            change.iter_mut().zip(&correction).for_each(|(total, part)| *total -= part);
            bends = self.bends(&change)?;
            if motion_mm <= CORRECTED_MM {
                break;
            }
            before_mm = motion_mm;
        }
        Some((change, bends))
    }

    /// Pose and shape after a change of the parameters; `None` if they are none.
    pub(super) fn moved(&self, change: &[f64]) -> Option<(Pose, Nominal)> {
        let changes = self.free.iter().copied().zip(change.iter().copied());
        moved(changes, &self.fit.pose, &self.fit.nominal)
    }

    /// What linearisation leaves out, for every cell: by how much the derivatives and, beyond J·δ, the
    /// distance change at its centroid. Zero where the centroid has no foot.
    /// One row of derivatives and distance a cell.
    pub(super) fn bends(&self, change: &[f64]) -> Option<Vec<f64>> {
        let (pose, nominal) = self.moved(change)?;
        let before = Model::new(&self.fit.nominal, &self.fit.pose, &self.free);
        let after = Model::new(&nominal, &pose, &self.free);
        let p = change.len();
        let mut old = vec![0.0; p + 1];
        let mut bends = vec![0.0; self.cells.len() * (p + 1)];
        for (cell, bend) in self.cells.iter().zip(bends.chunks_exact_mut(p + 1)) {
            let Some(cell) = cell else { continue };
            let centroid = cell.point_sum_mm.map(|sum| sum / cell.count as f64);
            if before.row(centroid, &mut old).is_none() || after.row(centroid, bend).is_none() {
                bend.fill(0.0);
                continue;
            }
            bend[p] -= dot(&old, change);
            bend.iter_mut().zip(&old).for_each(|(new, old)| *new -= old);
        }
        Some(bends)
    }
}

/// Largest number of Gauss-Newton steps for the terms of second order: one or two are usual.
const CORRECTIONS: usize = 8;
/// A correction that moves the surface by less than this root mean square is the last.
const CORRECTED_MM: f64 = 1e-12;
/// Damping of the steps that are tried when the linear solution fails.
const DAMPINGS: [f64; 5] = [1e-8, 1e-6, 1e-4, 1e-2, 1.0];
/// Share by which the root of the sum of squares may seem to grow by rounding.
const SLACK: f64 = 1e-9;

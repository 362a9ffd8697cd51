//! The small linear problem an estimate solves, of points that count alike or by their weights.

use nalgebra::DMatrix;

use crate::fit::solve::System;

/// The linear problem at the reference, and what the cells add to it beyond linearisation.
pub(crate) struct Problem<'a> {
    pub(crate) system: System,
    /// One for each cell; `None` where no point has landed.
    pub(crate) cells: Vec<Option<Sums<'a>>>,
    /// Root of the mean weight: what a length of the system is over one of the surface.
    pub(crate) root_weight: f64,
}

/// The points of one cell.
#[derive(Clone, Copy)]
pub(crate) struct Sums<'a> {
    /// Sums of the derivatives and of the distances, times the weights.
    pub(crate) rows: &'a [f64],
    /// Sum of the weights.
    pub(crate) weight: f64,
}

impl Problem<'_> {
    /// Jᵀ·d at the changed parameters: that of the linear problem, and what the bends add to d and to J.
    pub(crate) fn gradient(&self, change: &[f64], bends: &[f64]) -> Vec<f64> {
        let p = change.len();
        let mut gradient = self.system.gradient(change);
        for (Sums { rows, weight }, bend) in self.occupied(bends) {
            let sum_mm = rows[p] + dot(rows, change) + weight * bend[p];
            for (j, entry) in gradient.iter_mut().enumerate() {
                *entry += rows[j] * bend[p] + bend[j] * sum_mm;
            }
        }
        gradient
    }

    /// JᵀJ with the bends in J: that of the linear problem, `gram`, and what the bends add.
    pub(crate) fn bent_gram(&self, gram: &DMatrix<f64>, bends: &[f64]) -> DMatrix<f64> {
        let p = gram.ncols();
        let mut gram = gram.clone();
        for (Sums { rows, weight }, bend) in self.occupied(bends) {
            for j in 0..p {
                for i in 0..p {
                    gram[(i, j)] +=
                        bend[i] * rows[j] + rows[i] * bend[j] + weight * bend[i] * bend[j];
                }
            }
        }
        gram
    }

    /// Sum of the squares of the distances at the changed parameters in mm², times the weights.
    pub(crate) fn square(&self, change: &[f64], bends: &[f64]) -> f64 {
        let p = change.len();
        let added: f64 = self
            .occupied(bends)
            .map(|(Sums { rows, weight }, bend)| {
                let linear_mm = rows[p] + dot(rows, change);
                bend[p] * (2.0 * linear_mm + weight * bend[p])
            })
            .sum();
        (self.system.square_after(change) + added).max(0.0)
    }

    /// Cells with points, and their bends.
    fn occupied<'a>(&'a self, bends: &'a [f64]) -> impl Iterator<Item = (Sums<'a>, &'a [f64])> {
        let pairs = self.cells.iter().zip(bends.chunks_exact(bends.len() / self.cells.len()));
        pairs.filter_map(|(cell, bend)| cell.map(|cell| (cell, bend)))
    }
}

/// J·δ of the first entries of a row.
pub(crate) fn dot(row: &[f64], change: &[f64]) -> f64 {
    row.iter().zip(change).map(|(entry, step)| entry * step).sum()
}

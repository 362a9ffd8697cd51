//! Weighted linear least squares over the points of a sample.

use rayon::prelude::*;

use super::Sample;
use crate::fit::solve::System;
use crate::fit::triangle::{CHUNK, Triangle};

/// A least-squares solution.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// One a column; `None` where the places do not tell it from columns before it.
    pub(crate) coefficients: Vec<Option<f64>>,
}

impl Solution {
    /// The coefficient of a column; 0 where it is not determined.
    pub(crate) fn or_zero(&self, column: usize) -> f64 {
        self.coefficients[column].unwrap_or(0.0)
    }

    /// Whether every column is determined.
    pub(crate) fn is_complete(&self) -> bool {
        self.coefficients.iter().all(Option::is_some)
    }
}

/// Minimises the area-weighted sum of the squares of deviation minus Σ coefficient·column.
///
/// `columns` writes the `count` columns at a place in mm. Columns that come first are preferred where they
/// depend on one another. By Householder reflections over fixed chunks joined in order, so the result does
/// not depend on the number of threads; `O(n·count²)`.
pub(crate) fn least_squares(
    sample: &Sample,
    count: usize,
    columns: impl Fn([f64; 2], &mut [f64]) + Sync,
) -> Solution {
    let factor = |chunk: usize| {
        let mut triangle = Triangle::new(count + 1);
        let mut row = vec![0.0; count + 1];
        let end = sample.len().min((chunk + 1) * CHUNK);
        for i in chunk * CHUNK..end {
            columns(sample.places_mm()[i], &mut row[..count]);
            // The system below is |J·δ + d| → min: with d the negative deviation, δ are the coefficients.
            row[count] = -sample.values_nm()[i];
            let root = sample.areas()[i].sqrt();
            row.iter_mut().for_each(|entry| *entry *= root);
            triangle.push(&row);
        }
        triangle.flush();
        triangle
    };
    let chunks = sample.len().div_ceil(CHUNK);
    let factors: Vec<Triangle> = (0..chunks).into_par_iter().map(factor).collect();
    let system = System::new(&joined(factors, count + 1));
    let all: Vec<usize> = (0..count).collect();
    // Fewer columns are never worse conditioned: if all together are determined, none need be tried alone.
    let whole = (system.rows() >= count).then(|| system.solve(&all, 0.0));
    let (kept, step) = match whole.filter(|step| step.condition * RANK_TOLERANCE < 1.0) {
        Some(step) => (all, step),
        None => {
            let in_turn: Vec<Vec<usize>> = all.iter().map(|&column| vec![column]).collect();
            let kept = system.determinate(&in_turn, RANK_TOLERANCE);
            let step = system.solve(&kept, 0.0);
            (kept, step)
        }
    };
    let mut coefficients = vec![None; count];
    for (&column, &value) in kept.iter().zip(&step.change) {
        coefficients[column] = Some(value);
    }
    Solution { coefficients }
}

/// The factor of all rows: the rows of each further factor are absorbed like rows of the problem. The
/// first one is kept as it is, so that few rows still count as few.
pub(crate) fn joined(factors: Vec<Triangle>, columns: usize) -> Triangle {
    let mut factors = factors.into_iter();
    let mut all = factors.next().unwrap_or_else(|| Triangle::new(columns));
    for factor in factors {
        for i in 0..columns {
            let row: Vec<f64> = (0..columns).map(|j| factor.entry(i, j)).collect();
            all.push(&row);
        }
    }
    all.flush();
    all
}

/// Columns closer than this to those before them are indeterminate: noise of the deviations would appear a
/// million times larger in their coefficients.
const RANK_TOLERANCE: f64 = 1e-6;

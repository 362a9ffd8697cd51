//! Weighted linear least squares over the points of a sample.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::Sample;
use asphera_form::linear::{CHUNK, System, Triangle};

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
}

/// The area-weighted least-squares problem of deviation minus Σ coefficient·column.
///
/// `columns` writes the `count` columns at a place in mm. By Householder reflections over fixed chunks joined in order, so
/// the result does not depend on the number of threads; `O(n·count²)`.
pub(crate) fn factored(
    sample: &Sample,
    count: usize,
    columns: impl Fn([f64; 2], &mut [f64]) + Sync,
) -> System {
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
    System::new(&joined(factors, count + 1))
}

/// Σ area²·column·columnᵀ: the covariance of the right-hand side of the normal equations of [`factored`], for independent
/// noise of 1 nm at every point. `O(n·count²)`.
pub(crate) fn noise_gram(
    sample: &Sample,
    count: usize,
    columns: impl Fn([f64; 2], &mut [f64]) + Sync,
) -> DMatrix<f64> {
    let of_chunk = |chunk: usize| {
        let mut gram = DMatrix::zeros(count, count);
        let mut row = vec![0.0; count];
        let end = sample.len().min((chunk + 1) * CHUNK);
        for i in chunk * CHUNK..end {
            columns(sample.places_mm()[i], &mut row);
            row.iter_mut().for_each(|entry| *entry *= sample.areas()[i]);
            for (j, entry) in row.iter().enumerate() {
                // Below the diagonal alone: it is symmetric.
                let mut column = gram.column_mut(j);
                let below = column.iter_mut().skip(j).zip(&row[j..]);
                below.for_each(|(sum, other)| *sum += entry * other);
            }
        }
        gram
    };
    let chunks = sample.len().div_ceil(CHUNK);
    let grams: Vec<DMatrix<f64>> = (0..chunks).into_par_iter().map(of_chunk).collect();
    let mut gram = grams.into_iter().fold(DMatrix::zeros(count, count), |sum, gram| sum + gram);
    gram.fill_upper_triangle_with_lower_triangle();
    gram
}

/// Minimises the area-weighted sum of the squares of deviation minus Σ coefficient·column, as [`factored`] has it. Columns
/// that come first are preferred where they depend on one another.
pub(crate) fn least_squares(
    sample: &Sample,
    count: usize,
    columns: impl Fn([f64; 2], &mut [f64]) + Sync,
) -> Solution {
    let system = factored(sample, count, columns);
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
pub fn joined(factors: Vec<Triangle>, columns: usize) -> Triangle {
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
pub(crate) const RANK_TOLERANCE: f64 = 1e-6;

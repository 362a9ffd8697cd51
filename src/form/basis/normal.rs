//! Normal equations solved for the terms they determine.

use nalgebra::{DMatrix, DVector};

/// The Cholesky factor of the Gram matrix of those columns that do not lie in the span of the ones before.
#[derive(Clone, Debug)]
pub(super) struct Normal {
    /// The columns kept, ascending.
    kept: Vec<usize>,
    /// Root of the diagonal of the Gram matrix, of each kept column.
    lengths: Vec<f64>,
    /// L of the Gram matrix of the kept columns scaled to unit length.
    lower: DMatrix<f64>,
    condition: f64,
}

impl Normal {
    /// Factors a Gram matrix. A column is dropped if the sine of its angle with the span of the columns kept
    /// before it is at most [`SMALLEST_SINE`]. `O(columns³)`.
    pub(super) fn new(gram: &DMatrix<f64>) -> Normal {
        let n = gram.nrows();
        let mut kept: Vec<usize> = Vec::new();
        let mut lengths: Vec<f64> = Vec::new();
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for candidate in 0..n {
            let length = gram[(candidate, candidate)].sqrt();
            // Not a number and zero are refused alike.
            if length.is_nan() || length <= 0.0 {
                continue;
            }
            let mut row: Vec<f64> = Vec::with_capacity(kept.len() + 1);
            for (k, &column) in kept.iter().enumerate() {
                let along: f64 = rows[k].iter().zip(&row).map(|(a, b)| a * b).sum();
                let cosine = gram[(candidate, column)] / (length * lengths[k]);
                row.push((cosine - along) / rows[k][k]);
            }
            let square = 1.0 - row.iter().map(|entry| entry * entry).sum::<f64>();
            if square > SMALLEST_SINE * SMALLEST_SINE {
                row.push(square.sqrt());
                rows.push(row);
                kept.push(candidate);
                lengths.push(length);
            }
        }
        let size = kept.len();
        let lower = DMatrix::from_fn(size, size, |i, j| if j <= i { rows[i][j] } else { 0.0 });
        let scaled = DMatrix::from_fn(size, size, |i, j| {
            gram[(kept[i], kept[j])] / (lengths[i] * lengths[j])
        });
        let condition = if size == 0 { 1.0 } else { root_of_condition(scaled) };
        Normal { kept, lengths, lower, condition }
    }

    pub(super) fn kept(&self) -> &[usize] {
        &self.kept
    }

    /// Largest over smallest singular value of the kept columns, scaled to unit length.
    pub(super) fn condition(&self) -> f64 {
        self.condition
    }

    /// The coefficient of every kept column, for Aᵀ·z of all columns.
    pub(super) fn solve(&self, along: &[f64]) -> Vec<f64> {
        let scaled = self.kept.iter().zip(&self.lengths).map(|(&j, length)| along[j] / length);
        let mut solution = DVector::from_iterator(self.kept.len(), scaled);
        self.lower.solve_lower_triangular_mut(&mut solution);
        self.lower.tr_solve_lower_triangular_mut(&mut solution);
        solution.iter().zip(&self.lengths).map(|(entry, length)| entry / length).collect()
    }

    /// (AᵀA)⁻¹ of the kept columns. `O(columns³)`.
    pub(super) fn inverse(&self) -> DMatrix<f64> {
        let size = self.kept.len();
        let mut root = DMatrix::identity(size, size);
        self.lower.solve_lower_triangular_mut(&mut root);
        for (mut column, length) in root.column_iter_mut().zip(&self.lengths) {
            column /= *length;
        }
        root.tr_mul(&root)
    }
}

/// Root of the largest over the smallest eigenvalue.
fn root_of_condition(scaled: DMatrix<f64>) -> f64 {
    let eigenvalues = scaled.symmetric_eigenvalues();
    // Rounding could carry the smallest below zero.
    (eigenvalues.max() / eigenvalues.min().max(f64::EPSILON)).sqrt()
}

/// Squared it is a hundred times the rounding of a Gram matrix.
pub(super) const SMALLEST_SINE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    fn gram(columns: &[&[f64]]) -> DMatrix<f64> {
        DMatrix::from_fn(columns.len(), columns.len(), |i, j| {
            columns[i].iter().zip(columns[j]).map(|(a, b)| a * b).sum()
        })
    }

    #[test]
    fn straight_line_through_four_points() {
        // 1 and x at x = 0, 1, 2, 3; y = 1, 3, 4, 4: b = 1, a = 1.5; the inverse is [[0.7, −0.3], [−0.3, 0.2]].
        let normal = Normal::new(&gram(&[&[1.0; 4], &[0.0, 1.0, 2.0, 3.0]]));
        let solution = normal.solve(&[12.0, 23.0]);
        assert!((solution[0] - 1.5).abs() < 1e-14 && (solution[1] - 1.0).abs() < 1e-14);
        let inverse = normal.inverse();
        for (entry, expected) in inverse.iter().zip([0.7, -0.3, -0.3, 0.2]) {
            assert!((entry - expected).abs() < 1e-14, "{inverse}");
        }
        // The cosine between the columns is 6/√(4·14).
        let cosine = 6.0 / 56_f64.sqrt();
        assert!((normal.condition() - ((1.0 + cosine) / (1.0 - cosine)).sqrt()).abs() < 1e-13);
    }

    #[test]
    fn dependent_and_empty_columns_are_dropped() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0];
        let affine = x.map(|x| 1e-9 * (2.0 + 3.0 * x));
        let square = x.map(|x| x * x);
        let normal = Normal::new(&gram(&[&[1.0; 5], &[0.0; 5], &x, &affine, &square]));
        assert_eq!(normal.kept(), [0, 2, 4]);
        let none = Normal::new(&DMatrix::zeros(2, 2));
        assert!(none.kept().is_empty() && none.solve(&[0.0, 0.0]).is_empty());
        assert_eq!(none.condition(), 1.0);
    }
}

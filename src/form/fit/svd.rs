//! Singular values of small matrices, with small ones to full relative accuracy.
//!
//! One-sided Jacobi rotations (Hestenes, J. SIAM 6 (1958) 51; accuracy: Demmel & Veselić, SIAM J. Matrix
//! Anal. 13 (1992) 1204). The bidiagonal method of nalgebra 0.35 lost three digits of the reconstruction
//! on Jacobians of this crate and percents of an uncertainty, which is why it is not used here.

use nalgebra::DMatrix;

/// A = (U·Σ)·Vᵀ.
#[derive(Clone, Debug)]
pub(crate) struct Svd {
    /// Columns are orthogonal; their lengths are the singular values.
    pub(crate) scaled_u: DMatrix<f64>,
    /// In the order of the columns, not sorted.
    pub(crate) sigma: Vec<f64>,
    /// Orthogonal.
    pub(crate) v: DMatrix<f64>,
}

impl Svd {
    /// Decomposes a finite matrix: pairs of columns are turned until all are orthogonal.
    pub(crate) fn new(mut matrix: DMatrix<f64>) -> Svd {
        let n = matrix.ncols();
        let mut v = DMatrix::identity(n, n);
        for _ in 0..SWEEPS {
            let mut turned = false;
            for p in 0..n {
                for q in p + 1..n {
                    let (a, b) = (matrix.column(p).norm_squared(), matrix.column(q).norm_squared());
                    let along = matrix.column(p).dot(&matrix.column(q));
                    if along.abs() <= ORTHOGONAL * (a * b).sqrt() {
                        continue;
                    }
                    turned = true;
                    let cotangent = (b - a) / (2.0 * along);
                    let tangent = cotangent.signum()
                        / (cotangent.abs() + (1.0 + cotangent * cotangent).sqrt());
                    let cos = (1.0 + tangent * tangent).sqrt().recip();
                    turn(&mut matrix, p, q, cos, cos * tangent);
                    turn(&mut v, p, q, cos, cos * tangent);
                }
            }
            if !turned {
                break;
            }
        }
        let sigma = matrix.column_iter().map(|column| column.norm()).collect();
        Svd { scaled_u: matrix, sigma, v }
    }

    /// The right singular vector of the smallest singular value; empty without columns.
    pub(crate) fn weakest(&self) -> Vec<f64> {
        let columns = 0..self.sigma.len();
        let smallest = columns.min_by(|&a, &b| self.sigma[a].total_cmp(&self.sigma[b]));
        smallest.map_or_else(Vec::new, |k| self.v.column(k).iter().copied().collect())
    }

    /// Largest and smallest singular value; both 0 without columns.
    pub(crate) fn extremes(&self) -> (f64, f64) {
        let largest = self.sigma.iter().copied().fold(0.0, f64::max);
        (largest, self.sigma.iter().copied().fold(largest, f64::min))
    }
}

fn turn(matrix: &mut DMatrix<f64>, p: usize, q: usize, cos: f64, sin: f64) {
    for i in 0..matrix.nrows() {
        let (a, b) = (matrix[(i, p)], matrix[(i, q)]);
        matrix[(i, p)] = cos * a - sin * b;
        matrix[(i, q)] = sin * a + cos * b;
    }
}

/// Convergence is quadratic: six or seven sweeps are usual.
const SWEEPS: usize = 60;
/// Cosine of the angle between columns that count as orthogonal.
const ORTHOGONAL: f64 = 4.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn check(matrix: DMatrix<f64>) -> Svd {
        let n = matrix.ncols();
        let svd = Svd::new(matrix.clone());
        let scale = matrix.amax().max(f64::MIN_POSITIVE);
        assert!((&svd.scaled_u * svd.v.transpose() - &matrix).amax() <= 1e-14 * scale * n as f64);
        assert!((svd.v.tr_mul(&svd.v) - DMatrix::identity(n, n)).amax() < 1e-14);
        let gram = svd.scaled_u.tr_mul(&svd.scaled_u);
        for i in 0..n {
            for j in (0..n).filter(|&j| j != i) {
                assert!(gram[(i, j)].abs() <= 1e-14 * svd.sigma[i] * svd.sigma[j]);
            }
        }
        svd
    }

    /// 1, 10⁻³, 10⁻⁶ and 10⁻⁹ between two reflections.
    #[test]
    fn small_singular_values_come_back() {
        let reflection = |seed: f64| {
            let axis = nalgebra::DVector::from_fn(4, |i, _| (seed + 1.7 * i as f64).sin());
            DMatrix::identity(4, 4) - &axis * axis.transpose() * (2.0 / axis.norm_squared())
        };
        let diagonal = nalgebra::DVector::from_vec(vec![1.0, 1e-3, 1e-6, 1e-9]);
        let svd = check(reflection(0.3) * DMatrix::from_diagonal(&diagonal) * reflection(2.2));
        let mut sigma = svd.sigma.clone();
        sigma.sort_by(|a, b| b.total_cmp(a));
        for (found, truth) in sigma.iter().zip(diagonal.iter()) {
            assert!((found - truth).abs() < 1e-15, "{found:e} {truth:e}");
        }
        let (largest, smallest) = svd.extremes();
        assert!(largest == sigma[0] && smallest == sigma[3]);
    }

    #[test]
    fn zero_and_empty_matrices() {
        assert_eq!(check(DMatrix::zeros(3, 2)).sigma, [0.0, 0.0]);
        assert_eq!(Svd::new(DMatrix::zeros(0, 0)).extremes(), (0.0, 0.0));
        assert_eq!(check(DMatrix::from_row_slice(1, 1, &[-2.0])).sigma, [2.0]);
    }

    proptest! {
        #[test]
        fn any_matrix_is_reconstructed(
            entries in prop::collection::vec(-1.0..1.0f64, 30), columns in 1..6usize,
        ) {
            check(DMatrix::from_fn(30 / columns.max(5), columns, |i, j| entries[i * columns.min(5) + j]));
        }
    }
}

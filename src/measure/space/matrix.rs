//! Small symmetric systems: eigenvectors of three by three, normal equations of a fit.

use asphera_geometry::vector::Vector;

/// The most unknowns of a fit.
pub(super) const MOST: usize = 5;

/// The eigenvectors of a symmetric matrix `[xx, yy, zz, xy, yz, zx]`, the one of the least eigenvalue first, by Jacobi's
/// rotations (G. H. Golub, C. F. Van Loan, Matrix Computations, section 8.5).
pub(super) fn eigenvectors([xx, yy, zz, xy, yz, zx]: [f64; 6]) -> [Vector; 3] {
    let mut a = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for row in &mut a {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
            let (of_p, of_q) = (a[p], a[q]);
            a[p] = std::array::from_fn(|k| c * of_p[k] - s * of_q[k]);
            a[q] = std::array::from_fn(|k| s * of_p[k] + c * of_q[k]);
            for row in &mut v {
                (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
            }
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| a[i][i].total_cmp(&a[j][j]));
    order.map(|column| [v[0][column], v[1][column], v[2][column]])
}

/// Sums of a least-squares problem of up to [`MOST`] unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Normal {
    products: [[f64; MOST]; MOST],
    right: [f64; MOST],
    /// Sum of the squares of the residuals.
    pub(super) squares: f64,
}

impl Normal {
    pub(super) fn add(&mut self, row: &[f64; MOST], residual: f64) {
        for (at, one) in row.iter().enumerate() {
            for (sum, other) in self.products[at].iter_mut().zip(row) {
                *sum += one * other;
            }
            self.right[at] += one * residual;
        }
        self.squares += residual * residual;
    }

    pub(super) fn join(&mut self, other: &Normal) {
        for (own, other) in self.products.iter_mut().zip(&other.products) {
            own.iter_mut().zip(other).for_each(|(own, other)| *own += other);
        }
        self.right.iter_mut().zip(&other.right).for_each(|(own, other)| *own += other);
        self.squares += other.squares;
    }

    /// The step of the first `count` unknowns to the least sum, and the diagonal of the inverse; `None` where the points do not
    /// determine them. Columns are scaled to length one, and factored after Cholesky.
    pub(super) fn solved(&self, count: usize) -> Option<([f64; MOST], [f64; MOST])> {
        let scale: Vec<f64> = (0..count).map(|at| self.products[at][at].sqrt()).collect();
        if scale.iter().any(|scale| !scale.is_normal()) {
            return None;
        }
        let mut lower = [[0.0; MOST]; MOST];
        for row in 0..count {
            for column in 0..=row {
                let scaled = self.products[row][column] / (scale[row] * scale[column]);
                let taken: f64 = (0..column).map(|k| lower[row][k] * lower[column][k]).sum();
                let left = scaled - taken;
                if row == column {
                    if left <= LEAST_PIVOT {
                        return None;
                    }
                    lower[row][row] = left.sqrt();
                } else {
                    lower[row][column] = left / lower[column][column];
                }
            }
        }
        let solve = |right: &[f64; MOST]| {
            let mut found = [0.0; MOST];
            for row in 0..count {
                let taken: f64 = (0..row).map(|k| lower[row][k] * found[k]).sum();
                found[row] = (right[row] - taken) / lower[row][row];
            }
            for row in (0..count).rev() {
                let taken: f64 = (row + 1..count).map(|k| lower[k][row] * found[k]).sum();
                found[row] = (found[row] - taken) / lower[row][row];
            }
            found
        };
        let (mut right, mut inverse) = ([0.0; MOST], [0.0; MOST]);
        for at in 0..count {
            right[at] = -self.right[at] / scale[at];
            let mut one = [0.0; MOST];
            one[at] = 1.0;
            inverse[at] = solve(&one)[at] / (scale[at] * scale[at]);
        }
        let mut step = solve(&right);
        step.iter_mut().zip(&scale).for_each(|(step, scale)| *step /= scale);
        Some((step, inverse))
    }
}

const SWEEPS: usize = 12;
/// A square sine of an angle below it: the columns are told apart by nothing.
const LEAST_PIVOT: f64 = 1e-13;

#[cfg(test)]
mod tests {
    use super::*;
    use asphera_geometry::vector::{cross, dot};

    #[test]
    fn eigenvectors_are_those_the_matrix_was_made_of() {
        let z = [0.48, 0.6, 0.64];
        let [x, y] = super::super::shape::across(z);
        assert!((dot(cross(x, y), z) - 1.0).abs() < 1e-15);
        let entry = |i: usize, j: usize| x[i] * x[j] + 5.0 * y[i] * y[j] + 9.0 * z[i] * z[j];
        let found = eigenvectors([
            entry(0, 0),
            entry(1, 1),
            entry(2, 2),
            entry(0, 1),
            entry(1, 2),
            entry(2, 0),
        ]);
        for (found, expected) in found.into_iter().zip([x, y, z]) {
            assert!(dot(found, expected).abs() > 1.0 - 1e-14, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn a_line_is_fitted_with_its_variances_and_a_single_place_is_no_line() {
        // Of places -2 to 2 the variances of height and slope are 1/5 and 1/10.
        let mut normal = Normal::default();
        for x in -2..=2 {
            normal.add(&[1.0, f64::from(x), 0.0, 0.0, 0.0], -(3.0 + 0.5 * f64::from(x)));
        }
        let (step, inverse) = normal.solved(2).unwrap();
        assert!((step[0] - 3.0).abs() < 1e-14 && (step[1] - 0.5).abs() < 1e-14);
        assert!((inverse[0] - 0.2).abs() < 1e-14 && (inverse[1] - 0.1).abs() < 1e-14);
        let mut single = Normal::default();
        single.add(&[1.0, 2.0, 0.0, 0.0, 0.0], 1.0);
        single.add(&[1.0, 2.0, 0.0, 0.0, 0.0], 2.0);
        assert!(single.solved(2).is_none());
    }
}

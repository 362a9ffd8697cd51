//! Eigenvalues of small symmetric matrices by Jacobi's rotations (G. H. Golub, C. F. Van Loan, Matrix Computations, 4th
//! edition, algorithm 8.5.3).

/// Eigenvalues, the largest first, with their eigenvectors as rows.
pub(crate) fn eigen<const D: usize>(mut matrix: [[f64; D]; D]) -> ([f64; D], [[f64; D]; D]) {
    let mut vectors: [[f64; D]; D] =
        std::array::from_fn(|row| std::array::from_fn(|column| f64::from(u8::from(row == column))));
    for _ in 0..SWEEPS {
        let off: f64 = (0..D)
            .flat_map(|p| (p + 1..D).map(move |q| (p, q)))
            .map(|(p, q)| matrix[p][q].abs())
            .sum();
        if off <= 0.0 {
            break;
        }
        for p in 0..D {
            for q in p + 1..D {
                rotate(&mut matrix, &mut vectors, p, q);
            }
        }
    }
    let mut order: [usize; D] = std::array::from_fn(|at| at);
    order.sort_by(|&a, &b| matrix[b][b].total_cmp(&matrix[a][a]));
    (order.map(|at| matrix[at][at]), order.map(|at| vectors[at]))
}

/// Turns axes p and q so that their off-diagonal element becomes 0.
fn rotate<const D: usize>(
    matrix: &mut [[f64; D]; D],
    vectors: &mut [[f64; D]; D],
    p: usize,
    q: usize,
) {
    let element = matrix[p][q];
    let slope = (matrix[q][q] - matrix[p][p]) / (2.0 * element);
    if element == 0.0 || slope.is_nan() {
        return;
    }
    let tangent = slope.signum() / (slope.abs() + slope.hypot(1.0));
    let cosine = 1.0 / tangent.hypot(1.0);
    let sine = tangent * cosine;
    for row in matrix.iter_mut() {
        (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
    }
    for at in 0..D {
        let (a, b) = (matrix[p][at], matrix[q][at]);
        (matrix[p][at], matrix[q][at]) = (cosine * a - sine * b, sine * a + cosine * b);
        let (a, b) = (vectors[p][at], vectors[q][at]);
        (vectors[p][at], vectors[q][at]) = (cosine * a - sine * b, sine * a + cosine * b);
    }
    (matrix[p][q], matrix[q][p]) = (0.0, 0.0);
}

/// Sweeps over all pairs at most; four dimensions need some six.
const SWEEPS: usize = 50;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_eigenvectors() {
        let matrix = [[3.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 2.0]];
        let (values, vectors) = eigen(matrix);
        let trace: f64 = values.iter().sum();
        assert!((trace - 7.0).abs() < 1e-14, "{values:?}");
        for (value, vector) in values.iter().zip(&vectors) {
            for row in 0..3 {
                let product: f64 = (0..3).map(|at| matrix[row][at] * vector[at]).sum();
                assert!((product - value * vector[row]).abs() < 1e-14);
            }
        }
        assert!(values[0] >= values[1] && values[1] >= values[2]);
    }

    #[test]
    fn nothing_and_huge_ratios_do_not_fail() {
        assert_eq!(eigen([[0.0; 4]; 4]).0, [0.0; 4]);
        let (values, _) = eigen([[1e-300, 1e-10], [1e-10, 1e20]]);
        assert!(values.iter().all(|value| value.is_finite()));
    }
}

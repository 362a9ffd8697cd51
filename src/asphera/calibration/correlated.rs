//! Correlated uncertainties of parameters as errors that are independent of each other.

use asphera_calibrate::Parameter;

/// Standard uncertainties of the parameters of a calibration, and their correlations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Uncertainties {
    /// Parameters with their standard uncertainties: ratios, rad or mm.
    pub parameters: Vec<(Parameter, f64)>,
    /// Independent errors: what each adds to the parameters, in their order, for one standard deviation of it. Empty where no
    /// correlations are known.
    pub errors: Vec<Vec<f64>>,
}

impl Uncertainties {
    /// Uncertainties without correlations.
    pub(super) fn new(parameters: Vec<(Parameter, f64)>) -> Uncertainties {
        Uncertainties { parameters, errors: Vec::new() }
    }

    /// The same with correlations of pairs, each once; those of other pairs are 0. `None` where they cannot all hold: one is beyond
    /// ±1, of a parameter that is not here, or of one with itself.
    ///
    /// The errors are the columns of the Cholesky factor of the covariances (Golub & Van Loan, Matrix Computations, 4th ed., 4.2). A
    /// pivot of 0 leaves its column out.
    pub(super) fn correlated(self, pairs: &[(Parameter, Parameter, f64)]) -> Option<Uncertainties> {
        let size = self.parameters.len();
        let place = |wanted| self.parameters.iter().position(|(parameter, _)| *parameter == wanted);
        let mut factor = vec![vec![0.0; size]; size];
        (0..size).for_each(|index| factor[index][index] = 1.0);
        for &(first, second, value) in pairs {
            let (row, column) = (place(first)?, place(second)?);
            let is_new = factor[row][column] == 0.0;
            if row == column || !is_new || !(-1.0..=1.0).contains(&value) {
                return None;
            }
            (factor[row][column], factor[column][row]) = (value, value);
        }
        for column in 0..size {
            let pivot = factor[column][column];
            if pivot < -ROUNDING {
                return None;
            }
            let root = if pivot > ROUNDING { pivot.sqrt() } else { 0.0 };
            for (row, entries) in factor.iter_mut().enumerate().skip(column) {
                // Beside a pivot of 0 a correlation of another size is impossible.
                if root == 0.0 && row > column && entries[column].abs() > ROUNDING.sqrt() {
                    return None;
                }
                entries[column] = if root > 0.0 { entries[column] / root } else { 0.0 };
            }
            for row in column + 1..size {
                for other in column + 1..=row {
                    factor[row][other] -= factor[row][column] * factor[other][column];
                }
            }
        }
        let error = |column: usize| {
            let rows = self.parameters.iter().enumerate();
            rows.map(|(row, (_, u))| if row < column { 0.0 } else { u * factor[row][column] })
                .collect()
        };
        let errors: Vec<Vec<f64>> = (0..size).map(error).collect();
        let is_some = |error: &Vec<f64>| error.iter().any(|of| *of != 0.0);
        Some(Uncertainties { errors: errors.into_iter().filter(is_some).collect(), ..self })
    }
}

/// Pivots of correlations that are this small are rounding of numbers with some 12 digits.
const ROUNDING: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use super::*;
    use Parameter::{ScaleX, ScaleY, ScaleZ};

    fn of(pairs: &[(Parameter, Parameter, f64)]) -> Option<Uncertainties> {
        let parameters = vec![(ScaleX, 1e-6), (ScaleY, 2e-6), (ScaleZ, 4e-6)];
        Uncertainties::new(parameters).correlated(pairs)
    }

    /// Products of the errors are the covariances: uᵢ·uⱼ·rᵢⱼ.
    #[test]
    fn errors_have_the_covariances() {
        let (r, s, t) = (0.5, -0.25, 0.125);
        let found = of(&[(ScaleX, ScaleY, r), (ScaleX, ScaleZ, s), (ScaleZ, ScaleY, t)]).unwrap();
        let covariance = |i: usize, j: usize| {
            found.errors.iter().map(|error| error[i] * error[j]).sum::<f64>() * 1e12
        };
        for (i, j, expected) in [
            (0, 0, 1.0),
            (1, 1, 4.0),
            (2, 2, 16.0),
            (0, 1, 2.0 * r),
            (0, 2, 4.0 * s),
            (1, 2, 8.0 * t),
        ] {
            assert!((covariance(i, j) - expected).abs() < 1e-12, "{i} {j}: {}", covariance(i, j));
        }
    }

    #[test]
    fn parameters_that_go_together_are_one_error() {
        let all = [(ScaleX, ScaleY, 1.0), (ScaleX, ScaleZ, 1.0), (ScaleY, ScaleZ, 1.0)];
        assert_eq!(of(&all).unwrap().errors, [[1e-6, 2e-6, 4e-6]]);
        let other = [(ScaleX, ScaleY, -1.0), (ScaleX, ScaleZ, 1.0), (ScaleY, ScaleZ, -1.0)];
        assert_eq!(of(&other).unwrap().errors, [[1e-6, -2e-6, 4e-6]]);
    }

    #[test]
    fn what_cannot_hold_is_refused() {
        for pairs in [
            vec![(ScaleX, ScaleY, 1.1)],
            vec![(ScaleX, ScaleY, f64::NAN)],
            vec![(ScaleX, ScaleX, 0.5)],
            vec![(ScaleX, Parameter::TiltX, 0.5)],
            vec![(ScaleX, ScaleY, 0.5), (ScaleY, ScaleX, 0.5)],
            // x goes with y and z, which go against each other.
            vec![(ScaleX, ScaleY, 1.0), (ScaleX, ScaleZ, 1.0), (ScaleY, ScaleZ, -1.0)],
            vec![(ScaleX, ScaleY, 0.9), (ScaleX, ScaleZ, 0.9), (ScaleY, ScaleZ, -0.9)],
        ] {
            assert_eq!(of(&pairs), None, "{pairs:?}");
        }
    }
}

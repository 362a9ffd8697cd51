//! Errors of one axis along its travel.

use std::f64::consts::TAU;

use thiserror::Error;

/// Errors of an axis at positions along it, linear between them.
///
/// An error is what the axis indicates minus where it is. Positions and errors are mm of a linear axis, rad of a rotary one.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisErrors {
    /// Invariant: at least two; positions rise; all is finite.
    rows: Vec<[f64; 2]>,
    is_rotary: bool,
    /// Standard uncertainty of the error of each row; empty where none is stated.
    u: Vec<f64>,
}

/// Why rows are no errors of an axis. Rows count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum AxisErrorsError {
    /// Nothing lies between less than two rows.
    #[error("expected two rows or more, found {found}")]
    TooFew {
        /// How many there are.
        found: usize,
    },
    /// A position or an error is NaN or infinite.
    #[error("row {row}: expected finite numbers")]
    NotFinite {
        /// Row of the number.
        row: usize,
    },
    /// A position is not above that of the row before.
    #[error("row {row}: expected a position above {before}, found {found}")]
    NotRising {
        /// The later row.
        row: usize,
        /// Position of the row before.
        before: f64,
        /// Position of this one.
        found: f64,
    },
    /// An error changes by as much as the position, so that corrected positions would not rise.
    #[error(
        "row {row}: expected an error that changes less than the position, found {change} over {step}"
    )]
    TooSteep {
        /// The later row.
        row: usize,
        /// Change of the error from the row before.
        change: f64,
        /// Change of the position.
        step: f64,
    },
    /// A table of a rotary axis is longer than a turn.
    #[error("row {row}: expected positions within one turn, found {turns} turns")]
    BeyondTurn {
        /// The first row beyond it.
        row: usize,
        /// Its distance from the first row, in turns.
        turns: f64,
    },
    /// The uncertainty of an error is negative or not finite, or missing.
    #[error("row {row}: expected a standard uncertainty of 0 or more")]
    Uncertainty {
        /// Its row.
        row: usize,
    },
    /// The ends of a whole turn are one place with two errors.
    #[error(
        "row {row}: expected the error of row 0, which is a turn before: {first}, found {found}"
    )]
    OpenTurn {
        /// The last row.
        row: usize,
        /// Error of row 0.
        first: f64,
        /// Error of the last row.
        found: f64,
    },
}

impl AxisErrors {
    /// The errors of a linear axis by rows of position and error, mm.
    ///
    /// # Errors
    ///
    /// The first row that cannot be used.
    pub fn linear(rows: Vec<[f64; 2]>) -> Result<AxisErrors, AxisErrorsError> {
        check(&rows)?;
        Ok(AxisErrors { rows, is_rotary: false, u: Vec::new() })
    }

    /// The errors of a rotary axis by rows of position and error, rad. Positions span a turn at most; every turn has the same
    /// errors. A whole turn needs the error of its first row in its last one.
    ///
    /// # Errors
    ///
    /// The first row that cannot be used.
    pub fn rotary(rows: Vec<[f64; 2]>) -> Result<AxisErrors, AxisErrorsError> {
        check(&rows)?;
        let (first, last) = (rows[0], rows.len() - 1);
        let beyond = rows.iter().position(|[position, _]| position - first[0] > TAU + TURN_RAD);
        if let Some(row) = beyond {
            return Err(AxisErrorsError::BeyondTurn {
                row,
                turns: (rows[row][0] - first[0]) / TAU,
            });
        }
        let is_whole = rows[last][0] - first[0] >= TAU - TURN_RAD;
        if is_whole && (rows[last][1] - first[1]).abs() > CLOSED_RAD {
            let (first, found) = (first[1], rows[last][1]);
            return Err(AxisErrorsError::OpenTurn { row: last, first, found });
        }
        Ok(AxisErrors { rows, is_rotary: true, u: Vec::new() })
    }

    /// The same with a standard uncertainty of the error of each row, mm or rad.
    ///
    /// # Errors
    ///
    /// The first row whose uncertainty is negative or not finite. Without one for each row, that after the last.
    pub fn with_uncertainties(self, u: Vec<f64>) -> Result<AxisErrors, AxisErrorsError> {
        let wrong = u.iter().position(|u| !(u.is_finite() && *u >= 0.0));
        let missing = (u.len() != self.rows.len()).then_some(u.len().min(self.rows.len()));
        match wrong.or(missing) {
            Some(row) => Err(AxisErrorsError::Uncertainty { row }),
            None => Ok(AxisErrors { u, ..self }),
        }
    }

    /// Independent errors that stand for the uncertainties of the rows; 0 where none are stated.
    ///
    /// How the errors of rows go together is not known. So each counts as an error of its own, and once more in one error that all
    /// rows have together. Of more than 16 rows neighbours count as one.
    pub fn uncertain_errors(&self) -> usize {
        if self.u.is_empty() { 0 } else { 1 + self.u.len().div_ceil(self.rows_together()) }
    }

    /// The share of an uncertain error at an indicated position, mm or rad, for one standard uncertainty; 0 beyond the rows. Error 0
    /// is that of all rows together. `O(log rows)`.
    pub fn uncertain_error_at(&self, error: usize, position: f64) -> f64 {
        let Some((after, share)) = self.between(position) else { return 0.0 };
        let last = self.rows.len() - 1;
        let is_closed = self.is_rotary && self.rows[last][0] - self.rows[0][0] >= TAU - TURN_RAD;
        let of_row = |row: usize| {
            // The ends of a whole turn are one row.
            let row = if is_closed && row == last { 0 } else { row };
            let counts = error == 0 || row / self.rows_together() == error - 1;
            self.u.get(row).copied().filter(|_| counts).unwrap_or(0.0)
        };
        (1.0 - share) * of_row(after - 1) + share * of_row(after)
    }

    /// Rows that count as one.
    fn rows_together(&self) -> usize {
        self.rows.len().div_ceil(MOST_ERRORS)
    }

    /// Where the axis is when it indicates `position`: the position without its error. `None` beyond the rows, and of no
    /// finite position. `O(log rows)`.
    pub fn corrected(&self, position: f64) -> Option<f64> {
        Some(position - self.error_at(position)?)
    }

    /// The error at an indicated position.
    fn error_at(&self, position: f64) -> Option<f64> {
        let (after, share) = self.between(position)?;
        let ([_, error], [_, next]) = (self.rows[after - 1], self.rows[after]);
        Some(error + (next - error) * share)
    }

    /// The row after an indicated position, and the share of the way to it from the row before; `None` beyond the rows.
    fn between(&self, position: f64) -> Option<(usize, f64)> {
        let (first, last) = (self.rows[0][0], self.rows[self.rows.len() - 1][0]);
        let margin = if self.is_rotary { TURN_RAD } else { (last - first) * MARGIN };
        let place =
            if self.is_rotary { first + (position - first).rem_euclid(TAU) } else { position };
        // Just before the first row of a table of less than a turn.
        let place = if self.is_rotary && place - TAU >= first - margin && place > last + margin {
            place - TAU
        } else {
            place
        };
        if !(first - margin..=last + margin).contains(&place) {
            return None;
        }
        let after =
            self.rows.partition_point(|[row, _]| *row <= place).clamp(1, self.rows.len() - 1);
        let ([from, _], [to, _]) = (self.rows[after - 1], self.rows[after]);
        Some((after, ((place - from) / (to - from)).clamp(0.0, 1.0)))
    }
}

/// Independent errors of the rows of one table at most: each costs two fits.
const MOST_ERRORS: usize = 16;

/// Rounding at the ends is no position beyond them: this share of the travel …
const MARGIN: f64 = 1e-9;

/// … and of a rotary axis so much of an angle, which four decimals of a degree have.
const TURN_RAD: f64 = 1e-6;

/// Difference of the errors at both ends of a turn that is rounding.
const CLOSED_RAD: f64 = 1e-9;

fn check(rows: &[[f64; 2]]) -> Result<(), AxisErrorsError> {
    if rows.len() < 2 {
        return Err(AxisErrorsError::TooFew { found: rows.len() });
    }
    let is_finite = |row: &[f64; 2]| row.iter().all(|value| value.is_finite());
    if let Some(row) = rows.iter().position(|row| !is_finite(row)) {
        return Err(AxisErrorsError::NotFinite { row });
    }
    for (at, pair) in rows.windows(2).enumerate() {
        let ([before, error], [found, next]) = (pair[0], pair[1]);
        let (row, step, change) = (at + 1, found - before, next - error);
        if step <= 0.0 {
            return Err(AxisErrorsError::NotRising { row, before, found });
        }
        if !(change.abs() < step && step.is_finite()) {
            return Err(AxisErrorsError::TooSteep { row, change, step });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Values of `numpy.interp(x, xp, fp)`, numpy 2.4.6, printed with repr:
    ///
    /// ```text
    /// xp = [-12.5, -3.0, 0.0, 4.25, 30.0]; fp = [1e-4, -2.5e-4, 0.0, 3.3e-4, -7e-5]
    /// [numpy.interp(x, xp, fp) for x in (-12.5, -10.0, -3.0, -1.1, 0.0, 2.0, 4.25, 17.125, 30.0)]
    /// ```
    #[test]
    fn errors_between_rows_are_those_of_numpy() {
        let rows = vec![[-12.5, 1e-4], [-3.0, -2.5e-4], [0.0, 0.0], [4.25, 3.3e-4], [30.0, -7e-5]];
        let errors = AxisErrors::linear(rows).unwrap();
        for (position, expected) in NUMPY {
            let found = errors.error_at(position).unwrap();
            assert!((found - expected).abs() < 1e-18, "{position}: {found}, expected {expected}");
            assert_eq!(errors.corrected(position), Some(position - found));
        }
        for beyond in [-12.5001, 30.0001, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(errors.corrected(beyond), None, "{beyond}");
        }
    }

    const NUMPY: [(f64, f64); 9] = [
        (-12.5, 0.0001),
        (-10.0, 7.894736842105265e-06),
        (-3.0, -0.00025),
        (-1.1, -9.166666666666668e-05),
        (0.0, 0.0),
        (2.0, 0.0001552941176470588),
        (4.25, 0.00033),
        (17.125, 0.00013000000000000004),
        (30.0, -7e-05),
    ];

    #[test]
    fn every_turn_has_the_same_errors() {
        let rows = vec![[0.5, 1e-5], [2.0, 3e-5], [0.5 + TAU, 1e-5]];
        let errors = AxisErrors::rotary(rows).unwrap();
        for turns in [-3.0, 0.0, 1.0, 1000.0] {
            let found = errors.error_at(1.25 + turns * TAU).unwrap();
            assert!((found - 2e-5).abs() < 1e-16, "{turns}: {found}");
        }
        assert!((errors.error_at(0.5).unwrap() - 1e-5).abs() < 1e-18);
        // 0.25 rad before the first row, in the last piece of the turn.
        let expected = 1e-5 + 2e-5 * 0.25 / (TAU - 1.5);
        assert!((errors.error_at(0.25).unwrap() - expected).abs() < 1e-16);
        assert_eq!(errors.corrected(f64::NAN), None);
    }

    #[test]
    fn uncertainties_are_those_of_the_rows_and_of_all_together() {
        let table = AxisErrors::linear(vec![[0.0, 0.0], [1.0, 1e-4], [3.0, 0.0]]).unwrap();
        assert_eq!((table.uncertain_errors(), table.uncertain_error_at(0, 1.0)), (0, 0.0));
        let table = table.with_uncertainties(vec![0.25, 0.5, 1.0]).unwrap();
        assert_eq!(table.uncertain_errors(), 4);
        let at =
            |position: f64| [0, 1, 2, 3].map(|error| table.uncertain_error_at(error, position));
        assert_eq!(at(0.0), [0.25, 0.25, 0.0, 0.0]);
        assert_eq!(at(2.0), [0.75, 0.0, 0.25, 0.5]);
        assert_eq!(at(3.5), [0.0; 4]);
        // Of many rows neighbours go together, and all add up to the error of all.
        let rows: Vec<[f64; 2]> = (0..100).map(|i| [f64::from(i), 0.0]).collect();
        let table = AxisErrors::linear(rows).unwrap().with_uncertainties(vec![1e-5; 100]).unwrap();
        assert_eq!(table.uncertain_errors(), 16);
        let sum: f64 = (1..16).map(|error| table.uncertain_error_at(error, 41.3)).sum();
        assert!((sum - 1e-5).abs() < 1e-18, "{sum}");
        for wrong in [vec![1e-5; 99], vec![-1.0; 100], vec![f64::NAN; 100], vec![0.0; 101]] {
            let rows: Vec<[f64; 2]> = (0..100).map(|i| [f64::from(i), 0.0]).collect();
            let found = AxisErrors::linear(rows).unwrap().with_uncertainties(wrong);
            assert!(matches!(found, Err(AxisErrorsError::Uncertainty { .. })), "{found:?}");
        }
    }

    /// The ends of a whole turn are one row, with one uncertainty.
    #[test]
    fn a_whole_turn_has_no_seam() {
        let rows = vec![[0.0, 1e-5], [2.0, 3e-5], [TAU, 1e-5]];
        let table = AxisErrors::rotary(rows).unwrap().with_uncertainties(vec![1e-6, 2e-6, 9e-6]);
        let table = table.unwrap();
        for error in 0..table.uncertain_errors() {
            let [before, after] =
                [-1e-9, 1e-9].map(|position| table.uncertain_error_at(error, position));
            assert!((before - after).abs() < 1e-14, "{error}: {before} {after}");
        }
    }

    #[test]
    fn a_table_of_half_a_turn_ends_there() {
        let errors = AxisErrors::rotary(vec![[-1.0, 0.0], [2.0, 3e-5]]).unwrap();
        assert!((errors.error_at(0.5 + TAU).unwrap() - 1.5e-5).abs() < 1e-16);
        for beyond in [2.1, -1.1, 3.0 + TAU] {
            assert_eq!(errors.corrected(beyond), None, "{beyond}");
        }
        // Rounding at either end.
        assert_eq!(errors.error_at(-1.0 - 1e-12), Some(0.0));
        assert_eq!(errors.error_at(2.0 + 1e-12), Some(3e-5));
    }

    #[test]
    fn rows_that_are_no_table_are_named() {
        use AxisErrorsError::{BeyondTurn, NotFinite, NotRising, OpenTurn, TooFew, TooSteep};
        let linear = |rows: &[[f64; 2]]| AxisErrors::linear(rows.to_vec()).unwrap_err();
        let rotary = |rows: &[[f64; 2]]| AxisErrors::rotary(rows.to_vec()).unwrap_err();
        assert_eq!(linear(&[]), TooFew { found: 0 });
        assert_eq!(rotary(&[[0.0, 0.0]]), TooFew { found: 1 });
        assert_eq!(linear(&[[0.0, 0.0], [1.0, f64::NAN]]), NotFinite { row: 1 });
        assert_eq!(linear(&[[f64::NEG_INFINITY, 0.0], [1.0, 0.0]]), NotFinite { row: 0 });
        let twice = [[0.0, 0.0], [1.0, 0.0], [1.0, 0.0]];
        assert_eq!(linear(&twice), NotRising { row: 2, before: 1.0, found: 1.0 });
        let back = [[2.0, 0.0], [1.0, 0.0]];
        assert_eq!(linear(&back), NotRising { row: 1, before: 2.0, found: 1.0 });
        let steep = [[0.0, 0.0], [1.0, 1.0]];
        assert_eq!(linear(&steep), TooSteep { row: 1, change: 1.0, step: 1.0 });
        assert!(matches!(linear(&[[-1e308, 0.0], [1e308, 0.0]]), TooSteep { row: 1, .. }));
        let long = [[0.0, 0.0], [3.0, 0.0], [2.0 * TAU, 0.0]];
        assert_eq!(rotary(&long), BeyondTurn { row: 2, turns: 2.0 });
        let open = [[0.0, 1e-6], [TAU, 2e-6]];
        assert_eq!(rotary(&open), OpenTurn { row: 1, first: 1e-6, found: 2e-6 });
    }

    proptest! {
        /// A position with its error added, corrected, is back where it was; positions keep their order.
        #[test]
        fn corrected_positions_are_those_of_the_axis(
            steps in prop::collection::vec((0.1..5.0_f64, -0.04..0.04_f64), 2..20),
            shares in prop::array::uniform2(0.0..1.0_f64),
        ) {
            let mut position = -20.0;
            let rows: Vec<[f64; 2]> = steps
                .iter()
                .map(|(step, error)| {
                    position += step;
                    [position, *error]
                })
                .collect();
            let (first, last) = (rows[0], rows[rows.len() - 1]);
            let errors = AxisErrors::linear(rows.clone()).unwrap();
            let at = |share: f64| first[0] + (last[0] - first[0]) * share;
            let [one, two] = shares.map(|share| errors.corrected(at(share)).unwrap());
            let ([from, to], [one, two]) = (shares.map(at), [one, two]);
            prop_assert!((to - from).abs() < 1e-9 || (one < two) == (from < to));
            for [position, error] in rows {
                let corrected = errors.corrected(position).unwrap();
                prop_assert!((corrected + error - position).abs() < 1e-14);
            }
        }
    }
}

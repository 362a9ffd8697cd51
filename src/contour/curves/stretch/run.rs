//! Least squares under one equality and bounds: how far the vertices of a run move.

/// Sums of the equations of a run.
pub(super) struct Run {
    /// Normal equations: of each row the last entry is the right side.
    rows: Vec<Vec<f64>>,
    /// The equality: its terms, and the right side.
    balance: Vec<f64>,
}

/// Number of an unknown, if it is one, and its factor.
type Term = (Option<usize>, f64);

impl Run {
    pub(super) fn new(count: usize) -> Run {
        Run { rows: vec![vec![0.0; count + 1]; count], balance: vec![0.0; count + 1] }
    }

    /// Adds the square of a sum of terms and a constant.
    pub(super) fn bend(&mut self, terms: &[Term], constant: f64) {
        let count = self.rows.len();
        let known: Vec<(usize, f64)> =
            terms.iter().filter_map(|&(unknown, factor)| Some((unknown?, factor))).collect();
        for &(i, a) in &known {
            for &(j, b) in &known {
                self.rows[i][j] += a * b;
            }
            self.rows[i][count] -= a * constant;
        }
    }

    /// Adds terms and a constant to what must be zero.
    pub(super) fn balance(&mut self, terms: &[Term], constant: f64) {
        let count = self.rows.len();
        for &(unknown, factor) in terms {
            if let Some(unknown) = unknown {
                self.balance[unknown] += factor;
            }
        }
        self.balance[count] -= constant;
    }

    /// The unknowns, none larger than its bound; zeros where the equations do not tell them.
    pub(super) fn solved(&self, bounds: &[f64]) -> Vec<f64> {
        let count = self.rows.len();
        let mut found: Vec<Option<f64>> = vec![None; count];
        loop {
            let free: Vec<usize> = (0..count).filter(|&it| found[it].is_none()).collect();
            let Some(values) = self.of_free(&free, &found) else { break };
            let mut is_out = false;
            for (&unknown, value) in free.iter().zip(&values) {
                if value.abs() > bounds[unknown] {
                    found[unknown] = Some(bounds[unknown].copysign(*value));
                    is_out = true;
                }
            }
            if !is_out {
                for (unknown, value) in free.into_iter().zip(values) {
                    found[unknown] = Some(value);
                }
                break;
            }
        }
        found.into_iter().map(|value| value.unwrap_or(0.0)).collect()
    }

    /// The unknowns that are free, with the others as they are.
    fn of_free(&self, free: &[usize], found: &[Option<f64>]) -> Option<Vec<f64>> {
        let count = self.rows.len();
        let fixed = |row: &[f64]| -> f64 {
            let terms = row.iter().zip(found);
            terms.map(|(factor, value)| factor * value.unwrap_or(0.0)).sum()
        };
        let size = free.len();
        let mut rows = vec![vec![0.0; size + 2]; size + 1];
        for (i, &of) in free.iter().enumerate() {
            for (j, &by) in free.iter().enumerate() {
                rows[i][j] = self.rows[of][by];
            }
            rows[i][size] = self.balance[of];
            rows[size][i] = self.balance[of];
            rows[i][size + 1] = self.rows[of][count] - fixed(&self.rows[of]);
        }
        rows[size][size + 1] = self.balance[count] - fixed(&self.balance);
        let mut values = eliminated(rows)?;
        values.truncate(size);
        (size > 0).then_some(values)
    }
}

/// The solution of linear equations by elimination with pivots; none if they are dependent.
fn eliminated(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let count = rows.len();
    for column in 0..count {
        let pivot = (column..count).fold(column, |best, row| {
            if rows[row][column].abs() > rows[best][column].abs() { row } else { best }
        });
        rows.swap(column, pivot);
        let lead = rows[column].clone();
        if lead[column] == 0.0 {
            return None;
        }
        for row in rows.iter_mut().skip(column + 1) {
            let share = row[column] / lead[column];
            if share != 0.0 {
                for (value, lead) in row.iter_mut().zip(&lead).skip(column) {
                    *value -= share * lead;
                }
            }
        }
    }
    let mut found = vec![0.0; count];
    for row in (0..count).rev() {
        let sum: f64 = (row + 1..count).map(|column| rows[row][column] * found[column]).sum();
        found[row] = (rows[row][count] - sum) / rows[row][row];
    }
    found.iter().all(|value| value.is_finite()).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three numbers nearest to 1, 2 and 6 whose sum is 3, and with the last at most 2.
    #[test]
    fn equality_and_bounds_hold() {
        let mut run = Run::new(3);
        for (unknown, wanted) in [1.0, 2.0, 6.0].into_iter().enumerate() {
            run.bend(&[(Some(unknown), 1.0)], -wanted);
        }
        let all: Vec<Term> = (0..3).map(|unknown| (Some(unknown), 1.0)).collect();
        run.balance(&all, -3.0);
        let close = |found: &[f64], wanted: [f64; 3]| {
            found.iter().zip(wanted).all(|(found, wanted)| (found - wanted).abs() < 1e-12)
        };
        assert!(close(&run.solved(&[9.0; 3]), [-1.0, 0.0, 4.0]));
        assert!(close(&run.solved(&[9.0, 9.0, 2.0]), [0.0, 1.0, 2.0]));
        // All at their bounds: the equality gives way.
        assert!(close(&run.solved(&[0.1; 3]), [-0.1, 0.1, 0.1]) || run.solved(&[0.1; 3])[2] == 0.1);
        assert_eq!(Run::new(2).solved(&[1.0; 2]), [0.0; 2]);
    }
}

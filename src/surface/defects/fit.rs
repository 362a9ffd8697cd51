//! A quartic through the cells of a window that no defect moves.
//!
//! 1. Least squares. If no cell stands off by more than four standard deviations, as the median of
//!    the residuals tells them, that is all: most windows of a good surface cost no more.
//! 2. Otherwise Huber's weights with so low a limit that they come near to least absolute deviations,
//!    then Tukey's biweight (P. J. Huber, E. M. Ronchetti, Robust Statistics, 2009, section 7.8, both
//!    by weighted least squares again and again, the scale from the median every time). All samples
//!    lie where they were put, so a wrong height has no leverage.
//! 3. At last least squares without the cells that still stand off and, as a defect's flanks reach
//!    farther than what is seen of it, without those about them.

use super::cells::QUARTIC;

/// The terms of a quartic, and one for each of the steps that may cross a window.
pub(super) const TERMS: usize = QUARTIC + STEPS_MAX;
/// Most steps in one window.
pub(super) const STEPS_MAX: usize = 3;

/// The mean of a cell as one observation.
#[derive(Clone)]
pub(super) struct Row {
    pub(super) terms: [f64; TERMS],
    pub(super) height_mm: f64,
    /// Samples in the cell.
    pub(super) count: f64,
    /// Column and row in the window.
    pub(super) place: [usize; 2],
}

/// Fit.
#[derive(Clone)]
pub(super) struct Fitted {
    pub(super) terms: [f64; TERMS],
    /// How many of the terms were fitted; the others are 0.
    count: usize,
    /// Samples that counted.
    pub(super) samples: f64,
    /// L of the normal equations' matrix L·Lᵀ, for samples of variance 1.
    root: Matrix,
}

type Matrix = [[f64; TERMS]; TERMS];

impl Fitted {
    /// Variance of the fitted height at a place of such terms, for samples of variance 1.
    pub(super) fn variance(&self, terms: &[f64; TERMS]) -> f64 {
        let mut white = [0.0; TERMS];
        for i in 0..self.count {
            let known: f64 = white[..i].iter().zip(&self.root[i]).map(|(p, q)| p * q).sum();
            white[i] = (terms[i] - known) / self.root[i][i];
        }
        white.iter().map(|part| part * part).sum()
    }
}

/// Memory that one window leaves to the next.
#[derive(Default)]
pub(super) struct Work {
    pub(super) rows: Vec<Row>,
    weights: Vec<f64>,
    residuals: Vec<f64>,
    sizes: Vec<f64>,
    out: Vec<bool>,
}

impl Work {
    /// Fits the first `terms` of the rows; `None` where they do not determine them.
    pub(super) fn fit(&mut self, terms: usize) -> Option<Fitted> {
        if self.rows.len() < 2 * terms {
            return None;
        }
        self.weights.clear();
        self.weights.extend(self.rows.iter().map(|row| row.count));
        let (mut found, mut root) = self.solve(terms)?;
        let (mut scale, worst) = self.gauge(&found, terms);
        if worst > OFF * scale {
            for round in 0..HUBER_ROUNDS + TUKEY_ROUNDS {
                for ((weight, row), residual) in
                    self.weights.iter_mut().zip(&self.rows).zip(&self.residuals)
                {
                    let off = residual.abs() * row.count.sqrt();
                    *weight = row.count
                        * if round < HUBER_ROUNDS {
                            (HUBER * scale / off).min(1.0)
                        } else {
                            (1.0 - (off / (TUKEY * scale)).powi(2)).max(0.0).powi(2)
                        };
                }
                // A scale of zero: more than half of the cells are followed to the last bit.
                if scale == 0.0 {
                    break;
                }
                (found, _) = self.solve(terms)?;
                scale = self.gauge(&found, terms).0;
            }
            self.leave_out(scale);
            (found, root) = self.solve(terms)?;
        }
        let samples = self.weights.iter().sum();
        Some(Fitted { terms: found, count: terms, samples, root })
    }

    /// The residuals; their scale for a single sample, and the worst in its unit.
    fn gauge(&mut self, found: &[f64; TERMS], terms: usize) -> (f64, f64) {
        self.residuals.clear();
        self.residuals
            .extend(self.rows.iter().map(|row| row.height_mm - product(&row.terms, found)));
        self.sizes.clear();
        self.sizes.extend(
            self.rows.iter().zip(&self.residuals).map(|(row, size)| size.abs() * row.count.sqrt()),
        );
        let middle = self.sizes.len() / 2;
        let worst = self.sizes.iter().copied().fold(0.0, f64::max);
        let median = *self.sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
        let count = self.rows.len() as f64;
        (super::tail::NORMAL * median * (count / (count - terms as f64)).sqrt(), worst)
    }

    fn leave_out(&mut self, scale: f64) {
        let side = 1 + self.rows.iter().flat_map(|row| row.place).max().unwrap_or(0);
        self.out.clear();
        self.out.resize(side * side, false);
        let off = |row: &Row, residual: &f64| residual.abs() * row.count.sqrt() / scale;
        for (row, residual) in self.rows.iter().zip(&self.residuals) {
            if off(row, residual) > FAR {
                let [column, line] = row.place;
                for j in line.saturating_sub(1)..(line + 2).min(side) {
                    for i in column.saturating_sub(1)..(column + 2).min(side) {
                        self.out[j * side + i] = true;
                    }
                }
            }
        }
        for ((weight, row), residual) in
            self.weights.iter_mut().zip(&self.rows).zip(&self.residuals)
        {
            let out = self.out[row.place[1] * side + row.place[0]] || off(row, residual) > OFF;
            *weight = if out { 0.0 } else { row.count };
        }
    }

    /// Weighted least squares by the normal equations, and the root of their matrix; `None` where terms depend on each
    /// other.
    fn solve(&self, terms: usize) -> Option<([f64; TERMS], Matrix)> {
        let mut matrix = [[0.0; TERMS]; TERMS];
        let mut right = [0.0; TERMS];
        for (row, &weight) in self.rows.iter().zip(&self.weights) {
            if weight == 0.0 {
                continue;
            }
            for i in 0..terms {
                let scaled = weight * row.terms[i];
                right[i] += scaled * row.height_mm;
                for (entry, term) in matrix[i][..=i].iter_mut().zip(&row.terms) {
                    *entry += scaled * term;
                }
            }
        }
        for j in 0..terms {
            let whole = matrix[j][j];
            let (above, below) = matrix.split_at_mut(j + 1);
            let row = &mut above[j];
            let pivot = whole - row[..j].iter().map(|entry| entry * entry).sum::<f64>();
            // Written so that NaN fails.
            if !(pivot * CONDITION * CONDITION >= whole && whole > 0.0) {
                return None;
            }
            row[j] = pivot.sqrt();
            for other in below.iter_mut().take(terms - j - 1) {
                let known: f64 = other[..j].iter().zip(&row[..j]).map(|(p, q)| p * q).sum();
                other[j] = (other[j] - known) / row[j];
            }
        }
        for i in 0..terms {
            let known: f64 = (0..i).map(|j| matrix[i][j] * right[j]).sum();
            right[i] = (right[i] - known) / matrix[i][i];
        }
        for i in (0..terms).rev() {
            let known: f64 = (i + 1..terms).map(|j| matrix[j][i] * right[j]).sum();
            right[i] = (right[i] - known) / matrix[i][i];
        }
        Some((right, matrix))
    }
}

fn product(left: &[f64; TERMS], right: &[f64; TERMS]) -> f64 {
    left.iter().zip(right).map(|(p, q)| p * q).sum()
}

/// Standard deviations from which on a cell is looked at: of normal noise one in 16,000 is.
const OFF: f64 = 4.0;
/// Standard deviations from which on a cell and those about it are left out.
const FAR: f64 = 6.0;
const HUBER: f64 = 0.5;
/// 95 % efficiency under normal noise.
const TUKEY: f64 = 4.685;
const HUBER_ROUNDS: usize = 10;
const TUKEY_ROUNDS: usize = 8;
/// Largest ratio of the length of a term to its distance from the span of those before it.
const CONDITION: f64 = 1e4;

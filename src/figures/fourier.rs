//! Discrete Fourier transforms of any length, by rustfft.
//!
//! The one place of the crate that names that library. Its scalar planner is used: one that picks the
//! instructions of the machine at hand would give other last bits on another machine.

use std::sync::Arc;

use nalgebra::Complex;
use rayon::prelude::*;
use rustfft::{Fft, FftDirection, FftPlannerScalar};

/// The forward transform of one length, with its tables: X_k = Σ x_j·exp(−2πi·jk/n). `O(n log n)`.
pub(crate) struct Fourier {
    plan: Arc<dyn Fft<f64>>,
}

impl Fourier {
    /// For a length of at least 1.
    pub(crate) fn new(length: usize) -> Fourier {
        Fourier { plan: FftPlannerScalar::new().plan_fft(length, FftDirection::Forward) }
    }

    /// Transforms in place a list of the length.
    pub(crate) fn transform(&self, values: &mut [Complex<f64>]) {
        debug_assert_eq!(values.len(), self.plan.len(), "the length the tables are made for");
        self.plan.process(values);
    }
}

/// The forward transform of a map along both axes, row after row; the result is transposed, so that it is
/// `columns` rows of `rows` entries. Neither may be 0.
pub(crate) fn transform_map(
    mut values: Vec<Complex<f64>>,
    rows: usize,
    columns: usize,
) -> Vec<Complex<f64>> {
    let along_x = Fourier::new(columns);
    values.par_chunks_mut(columns).for_each(|row| along_x.transform(row));
    let mut values = transposed(&values, rows, columns);
    let along_y = Fourier::new(rows);
    values.par_chunks_mut(rows).for_each(|column| along_y.transform(column));
    values
}

/// A map of `rows` times `columns`, row after row, column after column.
pub(crate) fn transposed(
    values: &[Complex<f64>],
    rows: usize,
    columns: usize,
) -> Vec<Complex<f64>> {
    (0..values.len()).map(|i| values[i % rows * columns + i / rows]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// exp(πi·x).
    fn turn(x: f64) -> Complex<f64> {
        let (sin, cos) = (std::f64::consts::PI * x).sin_cos();
        Complex::new(cos, sin)
    }

    #[test]
    fn every_length_gives_the_sum_of_the_definition() {
        for length in (1..=40).chain([97, 100, 128, 255, 360]) {
            let values: Vec<Complex<f64>> = (0..length)
                .map(|j| Complex::new(((j * 37 + 5) % 23) as f64 - 11.0, ((j * 11) % 7) as f64))
                .collect();
            let mut found = values.clone();
            Fourier::new(length).transform(&mut found);
            for (k, found) in found.iter().enumerate() {
                let terms = values.iter().enumerate();
                let expected: Complex<f64> = terms
                    .map(|(j, value)| {
                        value * turn(-2.0 * ((j * k) % length) as f64 / length as f64)
                    })
                    .sum();
                assert!((found - expected).norm() < 1e-11 * length as f64, "{length} {k}");
            }
        }
    }
}

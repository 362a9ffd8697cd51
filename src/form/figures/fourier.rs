//! Discrete Fourier transforms of any length.
//!
//! Powers of two by Cooley & Tukey, Math. Comput. 19 (1965) 297; other lengths as a convolution by
//! Bluestein, IEEE Trans. Audio Electroacoust. 18 (1970) 451. `O(n log n)`.

use std::f64::consts::PI;

use nalgebra::Complex;

/// A transform of one length, with its tables: X_k = Σ x_j·exp(−2πi·jk/n).
pub(crate) struct Fourier {
    length: usize,
    /// exp(−2πi·k/padded) for the first half of the padded length, which is a power of two.
    turns: Vec<Complex<f64>>,
    /// For a length that is no power of two.
    chirp: Option<Chirp>,
}

/// jk = (j² + k² − (k − j)²)/2 makes the transform a convolution with exp(πi·j²/n).
struct Chirp {
    /// exp(−πi·j²/n).
    factors: Vec<Complex<f64>>,
    /// Transform of the conjugate factors, laid out around 0.
    kernel: Vec<Complex<f64>>,
}

impl Fourier {
    /// For a length of at least 1.
    pub(crate) fn new(length: usize) -> Fourier {
        let padded =
            if length.is_power_of_two() { length } else { (2 * length).next_power_of_two() };
        let turns = (0..padded / 2).map(|k| turn(-2.0 * k as f64 / padded as f64)).collect();
        let mut fourier = Fourier { length, turns, chirp: None };
        if padded != length {
            // exp(−πi·j²/n) has period 2n in j²; reducing keeps the angle exact.
            let factor = |j: usize| turn(-((j * j % (2 * length)) as f64) / length as f64);
            let factors: Vec<Complex<f64>> = (0..length).map(factor).collect();
            let mut kernel = vec![Complex::new(0.0, 0.0); padded];
            for (j, factor) in factors.iter().enumerate() {
                kernel[j] = factor.conj();
                kernel[(padded - j) % padded] = factor.conj();
            }
            fourier.power_of_two(&mut kernel);
            fourier.chirp = Some(Chirp { factors, kernel });
        }
        fourier
    }

    /// Transforms in place a list of the length.
    pub(crate) fn transform(&self, values: &mut [Complex<f64>]) {
        debug_assert_eq!(values.len(), self.length, "the length the tables are made for");
        let Some(chirp) = &self.chirp else { return self.power_of_two(values) };
        let mut padded = vec![Complex::new(0.0, 0.0); chirp.kernel.len()];
        for ((place, value), factor) in padded.iter_mut().zip(&*values).zip(&chirp.factors) {
            *place = value * factor;
        }
        self.power_of_two(&mut padded);
        // The inverse transform is the conjugate of the transform of the conjugate, over the length.
        for (value, kernel) in padded.iter_mut().zip(&chirp.kernel) {
            *value = (*value * kernel).conj();
        }
        self.power_of_two(&mut padded);
        let scale = 1.0 / padded.len() as f64;
        for ((value, convolved), factor) in values.iter_mut().zip(&padded).zip(&chirp.factors) {
            *value = convolved.conj() * factor * scale;
        }
    }

    fn power_of_two(&self, values: &mut [Complex<f64>]) {
        let length = values.len();
        if length < 2 {
            return;
        }
        let unused = usize::BITS - length.trailing_zeros();
        for i in 0..length {
            let mirrored = i.reverse_bits() >> unused;
            if i < mirrored {
                values.swap(i, mirrored);
            }
        }
        let mut half = 1;
        while half < length {
            let stride = length / (2 * half);
            for block in values.chunks_exact_mut(2 * half) {
                let (low, high) = block.split_at_mut(half);
                for (k, (low, high)) in low.iter_mut().zip(high).enumerate() {
                    let turned = *high * self.turns[k * stride];
                    (*low, *high) = (*low + turned, *low - turned);
                }
            }
            half *= 2;
        }
    }
}

/// exp(πi·x).
fn turn(x: f64) -> Complex<f64> {
    let (sin, cos) = (PI * x).sin_cos();
    Complex::new(cos, sin)
}

#[cfg(test)]
mod tests {
    use super::*;

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

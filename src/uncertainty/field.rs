//! A long-wave error as a sum of few independent functions.
//!
//! A Cholesky factorisation of the kernel over some places, the place that is known least next, broken off
//! when little is left (Harbrecht, Peters & Schneider, Appl. Numer. Math. 62 (2012) 428): m functions v with
//! k(x, x′) = Σ v(x)·v(x′) + remainder, where the remainder is nowhere negative at x = x′ and goes down to zero.
//! What is left of the variance at a place is taken for independent noise there: every variance is exact, and
//! only correlations over less than the distance of the places chosen are lost.

use super::budget::LongWave;

/// The functions of one long-wave error.
#[derive(Clone, Debug)]
pub(super) struct Field {
    wave: LongWave,
    /// The places chosen, in the order they were.
    pivots_mm: Vec<[f64; 2]>,
    /// Row k of the factor over the places chosen: its first k + 1 entries, in units of the standard deviation.
    factor: Vec<Vec<f64>>,
}

/// The functions at the places the field was made from.
pub(super) struct AtNodes {
    /// One row a place, in mm.
    pub(super) values_mm: Vec<Vec<f64>>,
    /// Variance left out at each place in mm².
    pub(super) remainder_mm2: Vec<f64>,
}

impl Field {
    /// `O(n·m²)` for n places and m functions.
    pub(super) fn new(wave: &LongWave, nodes_mm: &[[f64; 2]]) -> (Field, AtNodes) {
        let mut field = Field { wave: *wave, pivots_mm: Vec::new(), factor: Vec::new() };
        let mut left = vec![1.0; nodes_mm.len()];
        let mut rows: Vec<Vec<f64>> = vec![Vec::new(); nodes_mm.len()];
        let wanted = LEFT_OUT * nodes_mm.len() as f64;
        while field.factor.len() < MOST_FUNCTIONS && left.iter().sum::<f64>() > wanted {
            let first = (0, f64::NEG_INFINITY);
            let (pivot, most) = left.iter().enumerate().fold(first, |best, (index, &value)| {
                if value > best.1 { (index, value) } else { best }
            });
            let at_pivot = rows[pivot].clone();
            let root = most.sqrt();
            for (index, row) in rows.iter_mut().enumerate() {
                let known: f64 = row.iter().zip(&at_pivot).map(|(a, b)| a * b).sum();
                let value = (field.correlation(nodes_mm[index], nodes_mm[pivot]) - known) / root;
                row.push(value);
                left[index] = (left[index] - value * value).max(0.0);
            }
            left[pivot] = 0.0;
            field.factor.push(rows[pivot].clone());
            field.pivots_mm.push(nodes_mm[pivot]);
        }
        let sigma_mm = wave.sigma_mm;
        rows.iter_mut().flatten().for_each(|value| *value *= sigma_mm);
        let remainder_mm2 = left.iter().map(|left| left * sigma_mm * sigma_mm).collect();
        (field, AtNodes { values_mm: rows, remainder_mm2 })
    }

    /// Number of functions.
    pub(super) fn functions(&self) -> usize {
        self.factor.len()
    }

    /// The functions at any place, in mm. `O(m²)`.
    pub(super) fn at(&self, place_mm: [f64; 2]) -> Vec<f64> {
        let mut values: Vec<f64> = Vec::with_capacity(self.functions());
        for (row, &pivot_mm) in self.factor.iter().zip(&self.pivots_mm) {
            let known: f64 = values.iter().zip(row).map(|(a, b)| a * b).sum();
            let own = row[values.len()];
            values.push((self.correlation(place_mm, pivot_mm) - known) / own);
        }
        values.iter_mut().for_each(|value| *value *= self.wave.sigma_mm);
        values
    }

    /// Weights c such that Σ functions·factors at any place is [`Field::sum_at`] with c: Lᵀ·c = factors.
    pub(super) fn weights(&self, factors: &[f64]) -> Vec<f64> {
        let mut weights = factors.to_vec();
        for k in (0..weights.len()).rev() {
            weights[k] /= self.factor[k][k];
            for j in 0..k {
                weights[j] -= self.factor[k][j] * weights[k];
            }
        }
        weights
    }

    /// The error at a place in mm, in `O(m)`.
    pub(super) fn sum_at(&self, place_mm: [f64; 2], weights: &[f64]) -> f64 {
        let pairs = self.pivots_mm.iter().zip(weights);
        let sum: f64 =
            pairs.map(|(&pivot, weight)| weight * self.correlation(place_mm, pivot)).sum();
        sum * self.wave.sigma_mm
    }

    fn correlation(&self, a_mm: [f64; 2], b_mm: [f64; 2]) -> f64 {
        let h_mm = (a_mm[0] - b_mm[0]).hypot(a_mm[1] - b_mm[1]);
        self.wave.kernel.correlation(h_mm / self.wave.length_mm)
    }
}

/// Mean share of the variance that may be left out.
const LEFT_OUT: f64 = 1e-3;
/// Reached by exponential kernels, and by smooth ones of a tenth of the aperture or less.
const MOST_FUNCTIONS: usize = 160;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::Kernel;

    fn nodes() -> Vec<[f64; 2]> {
        (0..500).map(|i| [0.04 * f64::from(i % 25), 0.05 * f64::from(i / 25)]).collect()
    }

    fn sum(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a * b).sum()
    }

    #[test]
    fn functions_add_up_to_the_kernel() {
        for (kernel, length_mm, off) in
            [(Kernel::Gaussian, 0.4, 0.03), (Kernel::Exponential, 0.8, 0.2)]
        {
            let wave = LongWave { sigma_mm: 2.0, length_mm, kernel, dof: f64::INFINITY };
            let nodes = nodes();
            let (field, at) = Field::new(&wave, &nodes);
            for i in (0..500).step_by(7) {
                let variance = sum(&at.values_mm[i], &at.values_mm[i]) + at.remainder_mm2[i];
                assert!((variance - 4.0).abs() < 1e-12);
                for j in (0..500).step_by(11).filter(|&j| j != i) {
                    let h = (nodes[i][0] - nodes[j][0]).hypot(nodes[i][1] - nodes[j][1]);
                    let truth = 4.0 * kernel.correlation(h / length_mm);
                    let found = sum(&at.values_mm[i], &at.values_mm[j]);
                    assert!((found - truth).abs() < off * 4.0, "{found} {truth}");
                }
                let again = field.at(nodes[i]);
                let largest = again.iter().zip(&at.values_mm[i]).map(|(a, b)| (a - b).abs());
                assert!(largest.fold(0.0, f64::max) < 1e-9);
                let factors: Vec<f64> = (0..field.functions()).map(|k| (k as f64).sin()).collect();
                let at_once = field.sum_at(nodes[i], &field.weights(&factors));
                assert!((at_once - sum(&again, &factors)).abs() < 1e-8);
            }
        }
    }

    #[test]
    fn equal_places_and_none() {
        let wave = LongWave {
            sigma_mm: 1.0,
            length_mm: 1.0,
            kernel: Kernel::Gaussian,
            dof: f64::INFINITY,
        };
        let (field, at) = Field::new(&wave, &[[1.0, 2.0]; 9]);
        assert_eq!((field.functions(), at.remainder_mm2), (1, vec![0.0; 9]));
        assert_eq!(Field::new(&wave, &[]).0.functions(), 0);
    }
}

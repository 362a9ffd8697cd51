//! Weights from the standard uncertainties of points.

use crate::FitError;

/// Roots of the weights 1/u², scaled so that the mean weight is 1, and what they were scaled by.
#[derive(Clone, Debug)]
pub struct Weights {
    /// `reference_mm / u` for each point.
    pub roots: Vec<f64>,
    /// The uncertainty of a point of weight 1: the root of the harmonic mean of u².
    pub reference_mm: f64,
}

impl Weights {
    /// From one standard uncertainty in mm for each of `points` points. Fails unless there are as many and
    /// all are positive and finite.
    pub fn new(uncertainties_mm: &[f64], points: usize) -> Result<Weights, FitError> {
        if uncertainties_mm.len() != points {
            return Err(FitError::UncertaintyCount { points, found: uncertainties_mm.len() });
        }
        let bad = |u: &f64| !(u.is_normal() && *u > 0.0);
        if let Some(index) = uncertainties_mm.iter().position(bad) {
            return Err(FitError::Uncertainty { index, found_mm: uncertainties_mm[index] });
        }
        let least = uncertainties_mm.iter().copied().fold(f64::INFINITY, f64::min);
        let square: f64 = uncertainties_mm.iter().map(|u| (least / u) * (least / u)).sum();
        // Without points there is nothing to scale by.
        let reference_mm = if points == 0 { 1.0 } else { least / (square / points as f64).sqrt() };
        let roots = uncertainties_mm.iter().map(|u| reference_mm / u).collect();
        Ok(Weights { roots, reference_mm })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_weight_is_one() {
        let weights = Weights::new(&[1e-5, 2e-5, 4e-5, 1e-5], 4).expect("valid uncertainties");
        let mean = weights.roots.iter().map(|root| root * root).sum::<f64>() / 4.0;
        assert!((mean - 1.0).abs() < 1e-15);
        assert!((weights.roots[0] / weights.roots[2] - 4.0).abs() < 1e-15);
        // 4 / (1 + 1/4 + 1/16 + 1) of u² = 1e-10.
        assert!((weights.reference_mm - 1e-5 * (4.0_f64 / 2.3125).sqrt()).abs() < 1e-20);
    }

    #[test]
    fn the_first_impossible_uncertainty_is_named() {
        for bad in [0.0, -1e-6, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE / 2.0] {
            let error = Weights::new(&[1e-6, bad, -1.0], 3).expect_err("an impossible one");
            assert!(
                matches!(error, FitError::Uncertainty { index: 1, found_mm } if found_mm.to_bits() == bad.to_bits())
            );
        }
        let error = Weights::new(&[1e-6], 2).expect_err("too few");
        assert_eq!(error, FitError::UncertaintyCount { points: 2, found: 1 });
    }
}

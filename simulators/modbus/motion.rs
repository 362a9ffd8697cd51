//! What the simulated device looks at.

use std::f64::consts::TAU;

use asphera_link::Nanos;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

/// A surface that goes to and fro, with noise.
#[derive(Clone, Debug)]
pub struct Sine {
    /// Mean distance in mm.
    pub mean_mm: f64,
    /// Amplitude in mm.
    pub amplitude_mm: f64,
    /// Period in s; greater than zero.
    pub period_s: f64,
    /// Standard deviation of the noise in µm.
    pub noise_um: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Sine {
    /// The distance in mm at a time. The noise of the n-th call depends on the seed alone.
    pub fn distance_mm(self) -> impl FnMut(Nanos) -> f64 + Send + 'static {
        let mut random = Pcg64Mcg::seed_from_u64(self.seed);
        move |now| {
            let phase = (now.as_secs_f64() / self.period_s).fract() * TAU;
            let noise_mm = self.noise_um * 1e-3 * normal(&mut random);
            self.mean_mm + self.amplitude_mm * phase.sin() + noise_mm
        }
    }
}

/// A standard normal number: Box and Muller, A Note on the Generation of Random Normal Deviates,
/// Ann. Math. Statist. 29 (1958), doi:10.1214/aoms/1177706645.
fn normal(random: &mut Pcg64Mcg) -> f64 {
    // In (0, 1], so that the logarithm is finite.
    let mut uniform = || ((random.next_u64() >> 11) + 1) as f64 / (1_u64 << 53) as f64;
    (-2.0 * uniform().ln()).sqrt() * (TAU * uniform()).cos()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_spread_asked_for_and_repeats_with_its_seed() {
        let still =
            Sine { mean_mm: 70.0, amplitude_mm: 0.0, period_s: 1.0, noise_um: 2.0, seed: 7 };
        let mut first = still.clone().distance_mm();
        let mut second = still.distance_mm();
        let samples: Vec<f64> = (0..20_000).map(|_| first(Nanos::ZERO)).collect();
        assert!(samples.iter().all(|sample| *sample == second(Nanos::ZERO)));
        let mean = samples.iter().sum::<f64>() / samples.len() as f64;
        let variance =
            samples.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / samples.len() as f64;
        // Five standard errors of the mean and of the variance.
        assert!((mean - 70.0).abs() < 5.0 * 0.002 / 20_000_f64.sqrt());
        assert!((variance.sqrt() - 0.002).abs() < 5.0 * 0.002 / 40_000_f64.sqrt());
    }

    #[test]
    fn a_quarter_of_the_period_is_the_crest() {
        let sine = Sine { mean_mm: 70.0, amplitude_mm: 5.0, period_s: 4.0, noise_um: 0.0, seed: 0 };
        assert_eq!(sine.distance_mm()(Nanos::from_millis(1000)), 75.0);
    }
}

//! Gaussian noise that depends on a seed and a number alone.

use std::f64::consts::TAU;

/// A standard normal number.
pub(crate) fn standard_normal(seed: u64, k: u64) -> f64 {
    let uniform = |salt: u64| {
        let bits = mixed(seed ^ mixed(k.wrapping_mul(2).wrapping_add(salt)));
        // 53 bits, never 0.
        ((bits >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
    };
    (-2.0 * uniform(0).ln()).sqrt() * (TAU * uniform(1)).cos()
}

/// SplitMix64 (Steele, Lea & Flood, OOPSLA 2014).
fn mixed(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_deviation_are_those_of_the_standard_normal() {
        let numbers: Vec<f64> = (0..100_000).map(|k| standard_normal(7, k)).collect();
        let mean = numbers.iter().sum::<f64>() / 1e5;
        let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 1e5;
        assert!(mean.abs() < 0.01 && (variance - 1.0).abs() < 0.02, "{mean} {variance}");
    }
}

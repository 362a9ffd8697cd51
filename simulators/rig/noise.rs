//! Noise that depends on a seed and the number of the trigger alone.

use std::f64::consts::TAU;

/// The standard normal number of trigger `k` for a seed.
///
/// Counter-based: any trigger's number can be had without those before it, so neither the order
/// nor the number of the triggers matters. Two uniform numbers by SplitMix64 (Steele, Lea & Flood,
/// OOPSLA 2014, <https://doi.org/10.1145/2660193.2660195>) make one by the method of Box & Muller
/// (Ann. Math. Stat. 29 (1958) 610). Its largest amount is 8.6.
pub(crate) fn standard_normal(seed: u64, k: u64) -> f64 {
    let counter = k.wrapping_mul(2);
    let radius = (-2.0 * (1.0 - uniform(seed, counter)).ln()).sqrt();
    radius * (TAU * uniform(seed, counter.wrapping_add(1))).cos()
}

/// The number at place `counter` of the stream of a seed, from 0 up to and without 1, in steps
/// of 2⁻⁵³.
pub(crate) fn uniform(seed: u64, counter: u64) -> f64 {
    let key = mix(seed.wrapping_add(GAMMA));
    let bits = mix(key.wrapping_add(counter.wrapping_add(1).wrapping_mul(GAMMA)));
    (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// The output function of SplitMix64: every bit of the result depends on every bit of `z`.
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The odd integer nearest to 2⁶⁴ over the golden ratio.
const GAMMA: u64 = 0x9E37_79B9_7F4A_7C15;

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs for seed 1234567 in the reference implementation's published test vector
    /// (<https://rosettacode.org/wiki/Pseudo-random_numbers/Splitmix64>).
    #[test]
    fn the_generator_is_splitmix64() {
        let outputs: Vec<u64> =
            (1..=3u64).map(|i| mix(1_234_567_u64.wrapping_add(i.wrapping_mul(GAMMA)))).collect();
        assert_eq!(
            outputs,
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

    /// Moments against those of the normal distribution, within five standard errors.
    #[test]
    fn moments_are_those_of_a_normal_distribution() {
        let n = 200_000_u64;
        for seed in [0, 1, u64::MAX] {
            let values: Vec<f64> = (0..n).map(|k| standard_normal(seed, k)).collect();
            let moment = |power: i32| values.iter().map(|v| v.powi(power)).sum::<f64>() / n as f64;
            let error = 5.0 / (n as f64).sqrt();
            assert!(moment(1).abs() < error);
            assert!((moment(2) - 1.0).abs() < error * 2_f64.sqrt());
            assert!(moment(3).abs() < error * 15_f64.sqrt());
            assert!((moment(4) - 3.0).abs() < error * 96_f64.sqrt());
            for lag in [1, 2, 178] {
                let pairs = values.iter().zip(&values[lag..]);
                let correlation = pairs.map(|(a, b)| a * b).sum::<f64>() / n as f64;
                assert!(correlation.abs() < error, "seed {seed}, lag {lag}: {correlation}");
            }
        }
    }

    #[test]
    fn seeds_differ_and_repeat() {
        assert_eq!(standard_normal(7, 3).to_bits(), standard_normal(7, 3).to_bits());
        assert_ne!(standard_normal(7, 3), standard_normal(8, 3));
        assert_ne!(standard_normal(7, 3), standard_normal(7, 4));
    }
}

//! Random numbers by counting: Philox 4×32 with ten rounds.
//!
//! Salmon, Moraes, Dror & Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011,
//! doi:10.1145/2063384.2063405. A number is a function of seed, draw, stream and index, so the order in which
//! threads ask for numbers does not matter.

use std::f64::consts::TAU;

/// The numbers of one draw.
#[derive(Clone, Copy, Debug)]
pub struct Numbers {
    key: [u32; 2],
    draw: u32,
    stream: u32,
}

impl Numbers {
    /// The numbers of a draw and a stream of it.
    pub fn new(seed: u64, draw: u32, stream: u32) -> Numbers {
        Numbers { key: [seed as u32, (seed >> 32) as u32], draw, stream }
    }

    /// A number in [0, 1).
    pub fn uniform(&self, index: usize) -> f64 {
        let index = index as u64;
        let [high, low, _, _] =
            philox([index as u32, (index >> 32) as u32, self.draw, self.stream], self.key);
        uniform(high, low)
    }

    /// A standard normal number, by Box and Muller from 53 bits each.
    pub fn normal(&self, index: usize) -> f64 {
        let pair = (index / 2) as u64;
        let [a, b, c, d] =
            philox([pair as u32, (pair >> 32) as u32, self.draw, self.stream], self.key);
        // In (0, 1], so that the logarithm is finite.
        let radius = (-2.0 * (1.0 - uniform(a, b)).ln()).sqrt();
        let (sin, cos) = (TAU * uniform(c, d)).sin_cos();
        radius * if index.is_multiple_of(2) { cos } else { sin }
    }

    /// One of `count` things, at least one, each as likely as the next. Of the same numbers [`Numbers::normal`] makes others.
    pub fn one_of(&self, index: usize, count: usize) -> usize {
        let index = index as u64;
        // A half of the counter that normal numbers do not reach.
        let high = (index >> 32) as u32 | 1 << 31;
        let [a, b, ..] = philox([index as u32, high, self.draw, self.stream], self.key);
        ((uniform(a, b) * count as f64) as usize).min(count - 1)
    }
}

/// In [0, 1), a multiple of 2⁻⁵³.
fn uniform(high: u32, low: u32) -> f64 {
    let bits = (u64::from(high) << 32 | u64::from(low)) >> 11;
    bits as f64 / (1_u64 << 53) as f64
}

fn philox(mut counter: [u32; 4], mut key: [u32; 2]) -> [u32; 4] {
    for round in 0..ROUNDS {
        if round > 0 {
            key = [key[0].wrapping_add(WEYL[0]), key[1].wrapping_add(WEYL[1])];
        }
        let first = u64::from(MULTIPLIERS[0]) * u64::from(counter[0]);
        let second = u64::from(MULTIPLIERS[1]) * u64::from(counter[2]);
        counter = [
            (second >> 32) as u32 ^ counter[1] ^ key[0],
            second as u32,
            (first >> 32) as u32 ^ counter[3] ^ key[1],
            first as u32,
        ];
    }
    counter
}

const ROUNDS: usize = 10;
/// Constants of the paper: the multipliers of its section 4.3, and the steps of the key, golden ratio and √3 − 1.
const MULTIPLIERS: [u32; 2] = [0xD251_1F53, 0xCD9E_8D57];
const WEYL: [u32; 2] = [0x9E37_79B9, 0xBB67_AE85];

#[cfg(test)]
mod tests {
    use super::*;

    /// The known answers published with the authors' library Random123 (file `kat_vectors`).
    #[test]
    fn known_answers() {
        let answers = [
            ([0; 4], [0; 2], [0x6627_e8d5, 0xe169_c58d, 0xbc57_ac4c, 0x9b00_dbd8]),
            ([u32::MAX; 4], [u32::MAX; 2], [0x408f_276d, 0x41c8_3b0e, 0xa20b_c7c6, 0x6d54_51fd]),
            (
                [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344],
                [0xa409_3822, 0x299f_31d0],
                [0xd16c_fe09, 0x94fd_cceb, 0x5001_e420, 0x2412_6ea1],
            ),
        ];
        for (counter, key, answer) in answers {
            assert_eq!(philox(counter, key), answer);
        }
    }

    #[test]
    fn normal_numbers_have_the_moments_of_the_normal_distribution() {
        let count = 200_000;
        let numbers = Numbers::new(7, 3, 1);
        let mut moments = [0.0; 4];
        for index in 0..count {
            let value = numbers.normal(index);
            for (power, moment) in (1..).zip(&mut moments) {
                *moment += value.powi(power) / count as f64;
            }
        }
        // Five standard errors: √(1/n), √(2/n), √(15/n), √(96/n).
        let error = |variance: f64| 5.0 * (variance / count as f64).sqrt();
        assert!(moments[0].abs() < error(1.0) && (moments[1] - 1.0).abs() < error(2.0));
        assert!(moments[2].abs() < error(15.0) && (moments[3] - 3.0).abs() < error(96.0));
        assert_ne!(numbers.normal(0), Numbers::new(7, 4, 1).normal(0));
        assert_ne!(numbers.normal(0), Numbers::new(7, 3, 2).normal(0));
        assert_ne!(numbers.normal(0), Numbers::new(7 << 32, 3, 1).normal(0));
    }
}

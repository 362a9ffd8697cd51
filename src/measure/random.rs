//! Random numbers of the tests: Knuth's MMIX generator, so that the points of a seed stay the same.

use std::f64::consts::TAU;

/// A sequence by its state.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    fn step(&mut self) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        self.0
    }

    /// Even in [0, 1), by 53 bits.
    pub(crate) fn next(&mut self) -> f64 {
        (self.step() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Even from -0.5 to below 0.5, by 31 bits.
    pub(crate) fn centred(&mut self) -> f64 {
        (self.step() >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
    }

    /// Standard normal, by Box and Muller.
    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * (1.0 - self.next()).ln()).sqrt() * (TAU * self.next()).cos()
    }
}

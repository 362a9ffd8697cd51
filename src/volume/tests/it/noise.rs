//! Numbers at random, and volumes of them.

use asphera_volume::Samples;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(Pcg64::seed_from_u64(seed))
    }

    pub(crate) fn word(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Between 0 and 1.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A volume whose samples are foreground with the given share.
    pub(crate) fn volume(&mut self, size: [usize; 3], share: f64) -> Samples {
        Samples::from_fn(size, |_, _, _| self.unit() < share).unwrap()
    }

    /// A rotation, every one as likely (Shoemake 1992: a quaternion on the sphere).
    pub(crate) fn rotation(&mut self) -> [[f64; 3]; 3] {
        let (u, a, b) = (self.unit(), self.between(0.0, 6.3), self.between(0.0, 6.3));
        let (r, s) = ((1.0 - u).sqrt(), u.sqrt());
        let turn = std::f64::consts::TAU / 6.3;
        let [x, y, z, w] = [
            r * (a * turn).sin(),
            r * (a * turn).cos(),
            s * (b * turn).sin(),
            s * (b * turn).cos(),
        ];
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}

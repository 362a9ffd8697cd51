//! Places and numbers that the tests of figures share, too.

use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A spiral from the centre outwards, equal area a point.
pub(crate) fn spiral(count: usize, radius_mm: f64) -> Vec<[f64; 2]> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count)
        .map(|i| {
            let r = radius_mm * ((i as f64 + 0.5) / count as f64).sqrt();
            let phi = golden * i as f64;
            [r * phi.cos(), r * phi.sin()]
        })
        .collect()
}

/// A generator with a fixed seed.
pub(crate) struct Noise(Pcg64Mcg);

impl Noise {
    pub(crate) fn new(seed: u64) -> Noise {
        Noise(Pcg64Mcg::seed_from_u64(seed))
    }

    /// Uniform between −1 and 1.
    pub(crate) fn next(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

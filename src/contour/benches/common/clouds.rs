//! Points of benchmarks: a closed curve in the order in which it is traced, in no order, and all over a square.

use std::f64::consts::TAU;

use asphera_contour::PlaceMm;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

pub(crate) const SEED: u64 = 1;

/// Samples of a flower of twelve leaves in the order in which it is traced, their places jittered along it.
pub(crate) fn flower(count: usize) -> Vec<PlaceMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let step = TAU / count as f64;
    (0..count)
        .map(|index| {
            let angle = (index as f64 + 0.3 * unit(&mut random)) * step;
            let radius = 10.0 + 3.0 * (12.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect()
}

/// The points in no order: Fisher and Yates's shuffle.
pub(crate) fn shuffled(mut points: Vec<PlaceMm>) -> Vec<PlaceMm> {
    let mut random = Pcg64::seed_from_u64(SEED + 1);
    for last in (1..points.len()).rev() {
        points.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
    }
    points
}

/// Points at random in a square of 1 mm.
pub(crate) fn square(count: usize) -> Vec<PlaceMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count).map(|_| [0; 2].map(|_| unit(&mut random))).collect()
}

fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}

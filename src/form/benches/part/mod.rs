//! The asphere the benchmarks measure, and points of it.

use asphera_form::{Asphere, Nominal, PointMm, Pose};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

pub(crate) const SEED: u64 = 2012;
pub(crate) const RADIUS_MM: f64 = 9.0;

/// Thorlabs AL1815-C.
pub(crate) fn nominal() -> Nominal {
    let coefficients = [
        (4, 3.69067205091e-5),
        (6, -1.285461192617e-8),
        (8, -1.400167659754e-10),
        (10, -2.51311664812e-13),
        (12, 5.01789877647e-16),
        (14, 5.855871513042e-18),
        (16, -1.127794407419e-20),
    ];
    Nominal::Asphere(Asphere::new(11.65, -1.1, &coefficients).expect("a valid prescription"))
}

/// Uniform over the disc, a form error of so many mm at x, y and 20 nm of noise, half a milliradian and 30 µm
/// out of place.
pub(crate) fn points(count: usize, error_mm: impl Fn(f64, f64) -> f64) -> Vec<PointMm> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let pose =
        Pose { tx_mm: 0.03, ty_mm: -0.02, tz_mm: 0.4, rx_rad: 5e-4, ry_rad: -3e-4, rz_rad: 0.0 };
    let nominal = nominal();
    (0..count)
        .map(|_| {
            let r = RADIUS_MM * uniform().sqrt();
            let phi = std::f64::consts::TAU * uniform();
            let (x, y) = (r * phi.cos(), r * phi.sin());
            let off_mm = error_mm(x, y) + 2e-5 * (uniform() - 0.5);
            pose.to_measured([x, y, nominal.sag_mm(r) + off_mm])
        })
        .collect()
}

//! A lens, its place and normal errors, which the tests of uncertainties share, too.

use asphera_form::{Asphere, Nominal, Pose};
use rand_core::Rng;
use rand_pcg::Pcg64Mcg;

/// Thorlabs AL1815-C, semi-diameter 9 mm. The Zemax file lists PARM 1 (r²) as 0; what follows is r⁴ on.
pub(crate) fn al1815() -> Nominal {
    let coefficients = [
        (4, 3.69067205091e-5),
        (6, -1.285461192617e-8),
        (8, -1.400167659754e-10),
        (10, -2.51311664812e-13),
        (12, 5.01789877647e-16),
        (14, 5.855871513042e-18),
        (16, -1.127794407419e-20),
    ];
    Nominal::Asphere(Asphere::new(11.65, -1.1, &coefficients).unwrap())
}

/// Half a milliradian of tilt and thirty micrometres of decentre.
pub(crate) fn misaligned() -> Pose {
    Pose { tx_mm: 0.030, ty_mm: -0.021, tz_mm: 0.4, rx_rad: 5e-4, ry_rad: -3e-4, rz_rad: 0.0 }
}

/// Independent numbers of the standard normal distribution (Box and Muller).
pub(crate) fn normals(generator: &mut Pcg64Mcg, count: usize) -> Vec<f64> {
    let mut uniform = || ((generator.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
    (0..count)
        .map(|_| {
            let (radius, angle) = (uniform(), uniform());
            (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
        })
        .collect()
}

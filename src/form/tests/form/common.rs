//! Parts and samples the tests share.

use asphera_form::{Asphere, Nominal, Pose};
use rand_core::{Rng, SeedableRng};
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

/// Largest difference of two poses, mm and rad alike.
pub(crate) fn pose_difference(a: &Pose, b: &Pose) -> f64 {
    [
        a.tx_mm - b.tx_mm,
        a.ty_mm - b.ty_mm,
        a.tz_mm - b.tz_mm,
        a.rx_rad - b.rx_rad,
        a.ry_rad - b.ry_rad,
        a.rz_rad - b.rz_rad,
    ]
    .iter()
    .fold(0.0, |largest, difference| largest.max(difference.abs()))
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

/// Boustrophedon lines over the disc.
pub(crate) fn raster(count: usize, radius: f64) -> Vec<[f64; 2]> {
    let pitch = (std::f64::consts::PI * radius * radius / count as f64).sqrt();
    let lines = (2.0 * radius / pitch) as i32;
    let mut places = Vec::new();
    for line in 0..lines {
        let y = -radius + (f64::from(line) + 0.5) * pitch;
        let row = (0..lines).map(|column| -radius + (f64::from(column) + 0.5) * pitch);
        let mut row: Vec<[f64; 2]> =
            row.map(|x| [x, y]).filter(|p| p[0].hypot(p[1]) <= radius).collect();
        if line % 2 == 1 {
            row.reverse();
        }
        places.append(&mut row);
    }
    places
}

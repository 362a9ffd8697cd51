//! The two measured lenses of W. El-Hayek et al., J. Phys.: Conf. Ser. 483 (2014) 012003
//! (doi:10.1088/1742-6596/483/1/012003, section 6), simulated.
//!
//! The paper gives the form of the equation, the numbers of points and how they were taken, not the
//! constants of its lens. Those here are of a catalogue lens, Thorlabs AL1815-C: R 11.65 mm, κ
//! -1.1, A4 3.69067e-5 mm⁻³, free diameter 18 mm; the higher orders move it by less than the noise
//! of its edge and are left out.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Half the free diameter in mm.
const APERTURE_MM: f64 = 9.0;
const RADIUS_MM: f64 = 11.65;
const CONIC: f64 = -1.1;
const A4_PER_MM3: f64 = 3.690_672_050_91e-5;

/// Pitch of the first lens's grid in mm: 1668² = 2,782,224 points over 5 mm × 5 mm.
const GRID_PITCH_MM: f64 = 0.003;
/// Points of the second lens, a spiral over its whole surface.
const SPIRAL_POINTS: usize = 1_044_336;

/// Height of the lens in mm at the distance r from its axis.
fn sag_mm(r_mm: f64) -> f64 {
    let squared = r_mm * r_mm;
    let root = (1.0 - (1.0 + CONIC) * squared / (RADIUS_MM * RADIUS_MM)).sqrt();
    squared / (RADIUS_MM * (1.0 + root)) + A4_PER_MM3 * squared * squared
}

/// The smaller principal radius of curvature at a point in mm: an upper bound of the local feature
/// size, and the local feature size itself where the medial axis begins, at the centres of
/// curvature about the vertex.
pub(crate) fn lfs_mm([x, y, _]: PointMm) -> Option<f64> {
    let r_mm = x.hypot(y);
    let u = r_mm / RADIUS_MM;
    let root = (1.0 - (1.0 + CONIC) * u * u).sqrt();
    let slope = u / root + 4.0 * A4_PER_MM3 * r_mm.powi(3);
    let second_per_mm = 1.0 / (RADIUS_MM * root.powi(3)) + 12.0 * A4_PER_MM3 * r_mm * r_mm;
    let stretch = 1.0_f64.hypot(slope);
    let across_per_mm = if r_mm > 0.0 { slope / (r_mm * stretch) } else { second_per_mm };
    Some((second_per_mm / stretch.powi(3)).max(across_per_mm).recip())
}

/// The first lens: `side`² points row by row about its vertex, every other row backwards.
pub(crate) fn grid_lens(side: usize, sigma_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    let middle = (side - 1) as f64 / 2.0;
    (0..side)
        .flat_map(|row| (0..side).map(move |i| (row, if row % 2 == 0 { i } else { side - 1 - i })))
        .map(|(row, column)| {
            let [x, y] = [column, row].map(|index| (index as f64 - middle) * GRID_PITCH_MM);
            [x, y, sag_mm(x.hypot(y)) + sigma_mm * normal(&mut random)]
        })
        .collect()
}

/// The second lens, or its middle: `count` points along a spiral from the centre outwards, evenly
/// over the area, at the density of [`SPIRAL_POINTS`] over the aperture.
pub(crate) fn spiral_lens(count: usize, sigma_mm: f64, seed: u64) -> Vec<PointMm> {
    spiral(count, SPIRAL_POINTS, sigma_mm, seed)
}

/// The whole surface of the second lens, `count` points over its free diameter: slopes up to 45°.
pub(crate) fn whole_lens(count: usize, sigma_mm: f64, seed: u64) -> Vec<PointMm> {
    spiral(count, count, sigma_mm, seed)
}

/// The same on a raster.
pub(crate) fn rastered_lens(pitch_mm: f64) -> Vec<PointMm> {
    let half = (APERTURE_MM / pitch_mm).ceil() as i32;
    (-half..=half)
        .flat_map(|row| (-half..=half).map(move |column| [column, row]))
        .map(|place| place.map(|index| pitch_mm * f64::from(index)))
        .filter(|[x, y]| x.hypot(*y) <= APERTURE_MM)
        .map(|[x, y]| [x, y, sag_mm(x.hypot(y))])
        .collect()
}

/// The first `count` of so many points over the aperture.
fn spiral(count: usize, over_aperture: usize, sigma_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    let pitch_mm = APERTURE_MM * (TAU / 2.0 / over_aperture as f64).sqrt();
    (0..count)
        .map(|index| {
            let turn = (2.0 * TAU * index as f64).sqrt();
            let r_mm = pitch_mm * turn / TAU;
            let z_mm = sag_mm(r_mm) + sigma_mm * normal(&mut random);
            [r_mm * turn.cos(), r_mm * turn.sin(), z_mm]
        })
        .collect()
}

/// Normally distributed with deviation 1 (Box and Muller).
fn normal(random: &mut Pcg64) -> f64 {
    let mut unit = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    (-2.0 * (1.0 - unit()).ln()).sqrt() * (TAU * unit()).cos()
}

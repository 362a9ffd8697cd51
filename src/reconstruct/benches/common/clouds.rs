//! Clouds of points that are reconstructed: scans with noise of 5 nm, and exact ones, whose points tie.

use std::f64::consts::{PI, TAU};

use asphera_geometry::PointMm;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

pub(crate) const SEED: u64 = 1;
const NOISE_MM: f64 = 5e-6;

/// Ball of 10 mm along a spiral from pole to pole, its points as far apart as its tracks.
pub(crate) fn ball_spiral(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let tracks = (PI * count as f64).sqrt() / 2.0;
    (0..count)
        .map(|index| {
            let z = 1.0 - (2 * index + 1) as f64 / count as f64;
            let turn = TAU * tracks * z.acos() / PI;
            let radius_mm = 10.0 + noise_mm(&mut random);
            let out_mm = radius_mm * (1.0 - z * z).max(0.0).sqrt();
            [out_mm * turn.cos(), out_mm * turn.sin(), radius_mm * z]
        })
        .collect()
}

/// Square raster on an asphere of 10 mm.
pub(crate) fn asphere_grid(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    let grid = lens_grid(count);
    grid.into_iter().map(|[x, y, z]| [x, y, z + noise_mm(&mut random)]).collect()
}

/// The same without noise.
pub(crate) fn lens_grid(count: usize) -> Vec<PointMm> {
    let side = (count as f64).sqrt() as usize;
    (0..side * side)
        .map(|at| {
            let [x, y] = [at % side, at / side].map(|at| 10.0 * at as f64 / side as f64 - 5.0);
            let squared = x * x + y * y;
            let root = (1.0 - squared / 400.0).sqrt();
            [x, y, squared / (20.0 * (1.0 + root)) + 1e-5 * squared * squared]
        })
        .collect()
}

/// Rings of a torus, each with as many points.
pub(crate) fn torus_rings(count: usize) -> Vec<PointMm> {
    let around = (count as f64 / 3.0).sqrt() as usize;
    let rings = count / around;
    (0..around * rings)
        .map(|at| {
            let turn = |at: usize, of: usize| TAU * at as f64 / of as f64;
            let (u, v) = (turn(at / around, rings), turn(at % around, around));
            let out = 3.0 + v.cos();
            [out * u.cos(), out * u.sin(), v.sin()]
        })
        .collect()
}

/// Ball whose points lie on one sphere but for rounding.
pub(crate) fn exact_ball(count: usize) -> Vec<PointMm> {
    (0..count)
        .map(|index| {
            let z = 1.0 - (2 * index + 1) as f64 / count as f64;
            let turn = 2.399_963_229_728_653 * index as f64;
            let out = (1.0 - z * z).sqrt();
            [10.0 * out * turn.cos(), 10.0 * out * turn.sin(), 10.0 * z]
        })
        .collect()
}

/// Cube of points in no order.
pub(crate) fn random_cube(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(SEED);
    (0..count).map(|_| [0; 3].map(|_| unit(&mut random))).collect()
}

fn noise_mm(random: &mut Pcg64) -> f64 {
    NOISE_MM * (2.0 * unit(random) - 1.0)
}

fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}

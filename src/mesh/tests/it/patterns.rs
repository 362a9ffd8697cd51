//! Scan patterns with seeded noise, shared by tests and benchmarks.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

/// Distance between neighbours in mm.
pub(crate) const PITCH_MM: f64 = 0.005;

/// A smooth height in mm: a sphere of radius 50 mm near its vertex.
pub(crate) fn sag_mm(x: f64, y: f64) -> f64 {
    let squared = x * x + y * y;
    squared / (50.0 + (2500.0 - squared).max(0.0).sqrt())
}

/// `side`² points on exact multiples of the pitch, row by row, every other row backwards.
pub(crate) fn raster(side: usize) -> Vec<PointMm> {
    raster_with(side, || 0.0)
}

/// The same, each coordinate moved by up to `share` of the pitch to either side.
pub(crate) fn jittered_raster(side: usize, share: f64, seed: u64) -> Vec<PointMm> {
    let mut rng = Pcg64::seed_from_u64(seed);
    raster_with(side, || share * (2.0 * unit(&mut rng) - 1.0))
}

/// `count` points along an Archimedean spiral from the centre, one pitch apart along it and across.
pub(crate) fn spiral(count: usize) -> Vec<PointMm> {
    (0..count)
        .map(|i| {
            // The arc up to the angle t is about pitch·t²/(2·2π) long.
            let turn = (2.0 * TAU * i as f64).sqrt();
            let radius = PITCH_MM * turn / TAU;
            lifted(radius * turn.cos(), radius * turn.sin())
        })
        .collect()
}

/// `count` points scattered evenly over a square of `side_mm`, in no order.
pub(crate) fn scattered(count: usize, side_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut rng = Pcg64::seed_from_u64(seed);
    (0..count).map(|_| lifted(side_mm * unit(&mut rng), side_mm * unit(&mut rng))).collect()
}

fn raster_with(side: usize, mut offset: impl FnMut() -> f64) -> Vec<PointMm> {
    (0..side)
        .flat_map(|row| (0..side).map(move |i| (row, if row % 2 == 0 { i } else { side - 1 - i })))
        .map(|(row, column)| {
            let x = (column as f64 + offset()) * PITCH_MM;
            let y = (row as f64 + offset()) * PITCH_MM;
            lifted(x, y)
        })
        .collect()
}

fn lifted(x: f64, y: f64) -> PointMm {
    [x, y, sag_mm(x, y)]
}

/// Evenly distributed from 0 to below 1.
fn unit(rng: &mut Pcg64) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

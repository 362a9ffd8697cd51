//! Bodies and bands whose surfaces are known.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

/// A torus as a lattice of `rings` × `around` points, with its own triangles: two a point.
pub(crate) fn torus(rings: u32, around: u32) -> (Vec<PointMm>, Vec<[u32; 3]>) {
    let place = |i: u32, j: u32| {
        let (u, v) =
            (TAU * f64::from(i) / f64::from(rings), TAU * f64::from(j) / f64::from(around));
        let out = 3.0 + v.cos();
        [out * u.cos(), out * u.sin(), v.sin()]
    };
    let points = (0..rings).flat_map(|i| (0..around).map(move |j| place(i, j))).collect();
    let at = |i: u32, j: u32| (i % rings) * around + j % around;
    let facets = (0..rings).flat_map(|i| {
        (0..around).flat_map(move |j| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
    });
    (points, facets.collect())
}

/// A Möbius band of radius 3 and width 1: `along` × `across` points, and its own triangles.
pub(crate) fn moebius(along: u32, across: u32) -> (Vec<PointMm>, Vec<[u32; 3]>) {
    let place = |i: u32, j: u32| {
        let u = TAU * f64::from(i) / f64::from(along);
        let t = f64::from(j) / f64::from(across - 1) - 0.5;
        let out = 3.0 + t * (u / 2.0).cos();
        [out * u.cos(), out * u.sin(), t * (u / 2.0).sin()]
    };
    let points = (0..along).flat_map(|i| (0..across).map(move |j| place(i, j))).collect();
    // Once round, the band comes back upside down.
    let at = |i: u32, j: u32| if i < along { i * across + j } else { across - 1 - j };
    let facets = (0..along).flat_map(|i| {
        (0..across - 1).flat_map(move |j| {
            [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]
        })
    });
    (points, facets.collect())
}

/// A ball of radius 5 by the spiral of Fibonacci, every coordinate off by up to `noise_mm`.
pub(crate) fn ball(count: usize, noise_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    let turn = TAU * (2.0 - 0.5 * (1.0 + 5_f64.sqrt()));
    (0..count)
        .map(|index| {
            let z = 1.0 - (2.0 * index as f64 + 1.0) / count as f64;
            let (out, angle) = ((1.0 - z * z).sqrt(), turn * index as f64);
            [5.0 * out * angle.cos(), 5.0 * out * angle.sin(), 5.0 * z]
                .map(|value| value + noise_mm * (2.0 * uniform(&mut random) - 1.0))
        })
        .collect()
}

/// A number from 0 to below 1.
pub(crate) fn uniform(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 * 2_f64.powi(-53)
}

/// Puts points in a random order.
pub(crate) fn shuffle(points: &mut [PointMm], seed: u64) {
    let mut random = Pcg64::seed_from_u64(seed);
    for last in (1..points.len()).rev() {
        points.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
    }
}

/// The places of the corners of facets, whatever the order of points and facets.
pub(crate) fn places(points: &[PointMm], facets: &[[u32; 3]]) -> Vec<[[u64; 3]; 3]> {
    let of = |facet: &[u32; 3]| {
        let mut places = facet.map(|corner| points[corner as usize].map(f64::to_bits));
        places.sort_unstable();
        places
    };
    let mut all: Vec<_> = facets.iter().map(of).collect();
    all.sort_unstable();
    all
}

//! Points that tests share.

use asphera_contour::{Graph, Method, PlaceMm, Samples, Triangulation};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

/// A generator of random numbers with a seed.
pub(crate) struct Random(Pcg64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(Pcg64::seed_from_u64(seed))
    }

    /// A number from 0 to below 1.
    pub(crate) fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2_f64.powi(-53)
    }

    /// A number from `low` to below `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Fisher and Yates's shuffle.
    pub(crate) fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, (self.share() * (last + 1) as f64) as usize);
        }
    }
}

pub(crate) fn triangulation(points: &[PlaceMm]) -> Triangulation {
    Triangulation::new(Samples::new(points).unwrap())
}

/// Points at random in a square of 10 mm.
pub(crate) fn scattered(count: usize, seed: u64) -> Vec<PlaceMm> {
    let mut random = Random::new(seed);
    (0..count).map(|_| [random.between(0.0, 10.0), random.between(0.0, 10.0)]).collect()
}

/// Points of a small lattice, some of them left out, some there twice.
pub(crate) fn lattice(count: usize, seed: u64) -> Vec<PlaceMm> {
    let mut random = Random::new(seed);
    let mut whole = || (random.share() * 8.0).floor();
    (0..count).map(|_| [whole(), whole()]).collect()
}

/// Points evenly round a circle of 5 mm.
pub(crate) fn circle(count: usize) -> Vec<PlaceMm> {
    let turn = std::f64::consts::TAU / count as f64;
    let at = |index: usize| (index as f64 * turn).sin_cos();
    (0..count).map(|index| [5.0 * at(index).1, 5.0 * at(index).0]).collect()
}

/// The edges of a closed polygon through points in order.
pub(crate) fn closed(count: usize) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = (0..count as u32)
        .map(|row| {
            let next = (row + 1) % count as u32;
            [row.min(next), row.max(next)]
        })
        .collect();
    edges.sort_unstable();
    edges
}

/// The edges of a graph by rows.
pub(crate) fn by_row(graph: &Graph, of: &Triangulation) -> Vec<[u32; 2]> {
    graph.edges_by_row(of.samples())
}

pub(crate) fn distance(p: PlaceMm, q: PlaceMm) -> f64 {
    (p[0] - q[0]).hypot(p[1] - q[1])
}

/// Whether a method makes its curve of some samples only, beside the others.
pub(crate) fn thins(method: &Method) -> bool {
    matches!(method, Method::Lee | Method::OptimalTransport)
}

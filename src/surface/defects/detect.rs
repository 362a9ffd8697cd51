//! Sets of neighbours whose residuals noise does not explain.
//!
//! 1. *Statistics.* At every vertex the sum of the residuals over its rings 0, 0 to 1, and 0 to 2,
//!    over the standard deviation that white noise of σ gives it: that of so many samples, and that of the
//!    reference, which they share. Under white noise each is normal with deviation 1. Wide and
//!    shallow defects show in the wider ones, single readings in the first. If half of all vertices
//!    tell a larger deviation, because the noise is not white or the form not followed, it takes the
//!    place of 1; beside the border half of the vertices as near to it, over some way along it (`rim_zones.rs`).
//! 2. *Threshold.* With n vertices there are 3n statistics. Each may exceed ±k with probability
//!    e/3n, so the expected number of false defects is at most e (C. E. Bonferroni's bound: however
//!    the statistics depend on each other). Where the tails of the noise are longer than normal, k is larger, of single
//!    readings more than of means (`tail.rs`).
//! 3. *Growth.* From a vertex above k its defect goes on along the edges over vertices of the same
//!    sign above 2.5 (J. Canny, IEEE Trans. Pattern Anal. 8 (1986) 679-698, section VIII:
//!    hysteresis).
//! 4. *Which rings.* The same defect seen at several ring numbers is told by those that make its sum
//!    the most significant.

use asphera_geometry::{Sets, VertexId};
use rayon::prelude::*;

use super::rim_zones::RimZones;
use super::tail::{self, Tail};
use crate::curvature::Adjacency;

/// Ring numbers.
pub(super) const SCALES: usize = 3;
/// Samples within so many rings, on a surface of triangles.
pub(super) const SAMPLES: [f64; SCALES] = [1.0, 7.0, 19.0];
/// Where growth ends, in standard deviations.
const GROWTH: f64 = 2.5;
/// Vertices that are worked on with the same memory; fixed, so that threads do not show.
const CHUNK: usize = 1 << 16;

/// A defect as a set of vertices.
pub(super) struct Found {
    /// Whether the surface stands out there.
    pub(super) raised: bool,
    /// Ascending.
    pub(super) vertices: Vec<VertexId>,
    /// The sum of its residuals over that sum's standard deviation.
    pub(super) significance: f64,
}

/// What was found, and above what.
pub(super) struct Detection {
    pub(super) found: Vec<Found>,
    /// For single readings, in standard deviations.
    pub(super) threshold: f64,
    /// By ring numbers, what the deviation of the statistics was taken for.
    pub(super) scales: [f64; SCALES],
}

/// `values` are residuals over σ for all vertices, NaN where not known; `shared` the variances of the reference there, over
/// σ²; `zones` which vertices lie alike beside the border; `colour` the least that counts as the
/// deviation of the statistics.
pub(super) fn detect(
    adjacency: &Adjacency,
    (values, shared): (&[f64], &[f64]),
    (zones, tail, colour): (&RimZones, Tail, [f64; SCALES]),
    false_expected: f64,
) -> Detection {
    let known = values.iter().filter(|value| value.is_finite()).count();
    let tests = (SCALES * known) as f64;
    let probability = (false_expected / tests).min(0.1);
    let statistics = statistics(adjacency, values, shared);
    let mut scales = [1.0; SCALES];
    let mut factors = Vec::with_capacity(SCALES);
    let mut components = Vec::new();
    for (ring, scale) in scales.iter_mut().enumerate() {
        let mut sizes: Vec<f64> =
            statistics.iter().map(|of| of[ring].abs()).filter(|size| size.is_finite()).collect();
        *scale = tail::scale(&mut sizes).unwrap_or(1.0).max(colour[ring]);
        let factor = zones.factors(|vertex| statistics[vertex][ring] / *scale);
        let by_scale =
            |vertex: usize| statistics[vertex][ring] / (*scale * factor[zones.of(vertex)]);
        let threshold = tail.threshold(probability, SAMPLES[ring]);
        grow(adjacency, by_scale, threshold, |raised, vertices| {
            components.push((ring, raised, vertices));
        });
        factors.push(factor);
    }
    let deviation = |ring: usize, vertex: usize| scales[ring] * factors[ring][zones.of(vertex)];
    let found = choose(&components, values, deviation);
    Detection { found, threshold: tail.threshold(probability, 1.0), scales }
}

fn statistics(adjacency: &Adjacency, values: &[f64], shared: &[f64]) -> Vec<[f64; SCALES]> {
    let parts: Vec<Vec<[f64; SCALES]>> = (0..values.len().div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * CHUNK..((chunk + 1) * CHUNK).min(values.len());
            let mut seen = vec![VertexId::MAX; values.len()];
            range
                .map(|vertex| {
                    let sums = sums(adjacency, values, vertex as VertexId, &mut seen);
                    sums.map(|(sum, count)| sum / (count + count * count * shared[vertex]).sqrt())
                })
                .collect()
        })
        .collect();
    parts.concat()
}

/// The sum of the values about a vertex and their number, by rings. `seen` holds by whom a vertex was visited last.
fn sums(
    adjacency: &Adjacency,
    values: &[f64],
    vertex: VertexId,
    seen: &mut [VertexId],
) -> [(f64, f64); SCALES] {
    let value = values[vertex as usize];
    if !value.is_finite() {
        return [(f64::NAN, 1.0); SCALES];
    }
    seen[vertex as usize] = vertex;
    let (mut sum, mut count) = (value, 1.0_f64);
    let mut add = |other: VertexId, seen: &mut [VertexId]| {
        let last = &mut seen[other as usize];
        if *last != vertex {
            *last = vertex;
            let value = values[other as usize];
            if value.is_finite() {
                sum += value;
                count += 1.0;
            }
        }
        (sum, count)
    };
    let mut first = (value, 1.0);
    for &other in adjacency.neighbours(vertex) {
        first = add(other, seen);
    }
    let mut second = first;
    for &inner in adjacency.neighbours(vertex) {
        for &other in adjacency.neighbours(inner) {
            second = add(other, seen);
        }
    }
    [(value, 1.0), first, second]
}

/// Calls `with` for the sign and the vertices of every set that is grown.
fn grow(
    adjacency: &Adjacency,
    statistic: impl Fn(usize) -> f64,
    threshold: f64,
    mut with: impl FnMut(bool, Vec<VertexId>),
) {
    let mut state: Vec<i8> = (0..adjacency.len())
        .map(|vertex| {
            let value = statistic(vertex);
            i8::from(value > GROWTH) - i8::from(value < -GROWTH)
        })
        .collect();
    for first in 0..adjacency.len() {
        if state[first] == 0 || statistic(first).abs() <= threshold {
            continue;
        }
        let sign = state[first];
        state[first] = 0;
        let mut vertices = vec![first as VertexId];
        let mut next = 0;
        while let Some(&vertex) = vertices.get(next) {
            next += 1;
            for &other in adjacency.neighbours(vertex) {
                if state[other as usize] == sign {
                    state[other as usize] = 0;
                    vertices.push(other);
                }
            }
        }
        vertices.sort_unstable();
        with(sign > 0, vertices);
    }
}

/// Of the sets that overlap, those of the ring number that makes them most significant.
fn choose(
    components: &[(usize, bool, Vec<VertexId>)],
    values: &[f64],
    deviation: impl Fn(usize, usize) -> f64,
) -> Vec<Found> {
    let mut sets = Sets::new(components.len());
    let mut holders: Vec<(VertexId, bool, usize)> = components
        .iter()
        .enumerate()
        .flat_map(|(index, (_, raised, vertices))| {
            vertices.iter().map(move |&vertex| (vertex, *raised, index))
        })
        .collect();
    holders.sort_unstable();
    for pair in holders.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            sets.join(pair[0].2, pair[1].2);
        }
    }
    let mut by_root: Vec<(usize, usize)> =
        (0..components.len()).map(|index| (sets.root(index), index)).collect();
    by_root.sort_unstable();
    by_root
        .chunk_by(|left, right| left.0 == right.0)
        .filter_map(|cluster| {
            (0..SCALES)
                .filter_map(|ring| {
                    let mut vertices: Vec<VertexId> = cluster
                        .iter()
                        .map(|&(_, index)| &components[index])
                        .filter(|component| component.0 == ring)
                        .flat_map(|component| component.2.iter().copied())
                        .collect();
                    vertices.sort_unstable();
                    let parts = vertices.iter().map(|&vertex| vertex as usize);
                    let sum: f64 =
                        parts.map(|vertex| values[vertex] / deviation(ring, vertex)).sum();
                    let significance = sum.abs() / (vertices.len() as f64).sqrt();
                    let raised = components[cluster[0].1].1;
                    (!vertices.is_empty()).then_some(Found { raised, vertices, significance })
                })
                .reduce(
                    |best, other| if other.significance > best.significance { other } else { best },
                )
        })
        .collect()
}

//! Sets of neighbours whose residuals noise does not explain.
//!
//! 1. *Statistics.* At every vertex the residuals about it are added up, over the standard deviation that white noise of
//!    σ gives their sum: that of the samples, and that of the reference, which they share. Their weights fall with the
//!    rings as exp(-r²/2s²), for s of 0, 1, 1.7 and 3.65: such a sum is the most sensitive one to a pit of that width.
//!    Under white noise each is normal with deviation 1. If half of all vertices
//!    tell a larger deviation, because the noise is not white or the form not followed, it takes the
//!    place of 1; beside the border half of the vertices as near to it, over some way along it (`rim_zones.rs`).
//! 2. *Threshold.* With n vertices there are 4n statistics. Each may exceed ±k with probability
//!    e/4n, so the expected number of false defects is at most e (C. E. Bonferroni's bound: however
//!    the statistics depend on each other). Where the tails of the noise are longer than normal, k is larger, of single
//!    readings more than of sums (`tail.rs`).
//! 3. *Growth.* From a vertex above k its defect goes on along the edges over vertices of the same
//!    sign above 2.5 (J. Canny, IEEE Trans. Pattern Anal. 8 (1986) 679-698, section VIII:
//!    hysteresis).
//! 4. *Which width.* Of the same defect seen at several widths that counts which makes its sum the most significant.

use asphera_geometry::{Sets, VertexId};
use rayon::prelude::*;

use super::rim_zones::RimZones;
use super::tail::{self, Tail};
use crate::curvature::Adjacency;

/// Widths of sums.
pub(super) const SCALES: usize = 4;
/// Samples that tell as much as those of a sum, (Σw²)²/Σw⁴, where every vertex has six neighbours.
pub(super) const SAMPLES: [f64; SCALES] = [1.0, 6.5, 17.5, 51.8];
/// Rings that take part, the vertex as the first.
const RINGS: usize = 5;
/// What each ring counts: exp(-r²/2s²) for s of 0, 1, 1.7 and 3.65.
const WEIGHTS: [[f64; RINGS]; SCALES] = [
    [1.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 0.6065, 0.1353, 0.0111, 0.0003],
    [1.0, 0.8411, 0.5006, 0.2107, 0.0628],
    [1.0, 0.9632, 0.8606, 0.7134, 0.5485],
];
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
    /// By widths, what the deviation of the statistics was taken for.
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
            let mut about = Vec::new();
            range
                .map(|vertex| {
                    let sums = sums(adjacency, values, vertex as VertexId, (&mut seen, &mut about));
                    WEIGHTS.map(|weights| weighted(&sums, weights, shared[vertex]))
                })
                .collect()
        })
        .collect();
    parts.concat()
}

/// The weighted sum of the values of rings over its standard deviation, for values of deviation 1 of which a variance is
/// `shared`.
fn weighted(rings: &[(f64, f64); RINGS], weights: [f64; RINGS], shared: f64) -> f64 {
    let (mut sum, mut variance, mut common) = (0.0, 0.0, 0.0);
    for ((ring, count), weight) in rings.iter().zip(weights) {
        sum += weight * ring;
        variance += weight * weight * count;
        common += weight * count;
    }
    sum / (variance + common * common * shared).sqrt()
}

/// The sum of the values about a vertex and their number, by rings. `seen` holds by whom a vertex was visited last, `about` is
/// room for those.
fn sums(
    adjacency: &Adjacency,
    values: &[f64],
    vertex: VertexId,
    (seen, about): (&mut [VertexId], &mut Vec<VertexId>),
) -> [(f64, f64); RINGS] {
    let value = values[vertex as usize];
    if !value.is_finite() {
        return [(f64::NAN, 1.0); RINGS];
    }
    seen[vertex as usize] = vertex;
    about.clear();
    about.push(vertex);
    let mut rings = [(0.0, 0.0); RINGS];
    rings[0] = (value, 1.0);
    let mut from = 0;
    for ring in &mut rings[1..] {
        let to = about.len();
        for at in from..to {
            for &other in adjacency.neighbours(about[at]) {
                let last = &mut seen[other as usize];
                if *last != vertex {
                    *last = vertex;
                    about.push(other);
                    let value = values[other as usize];
                    if value.is_finite() {
                        *ring = (ring.0 + value, ring.1 + 1.0);
                    }
                }
            }
        }
        from = to;
    }
    rings
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of a lattice where every vertex has six neighbours.
    const COUNTS: [f64; RINGS] = [1.0, 6.0, 12.0, 18.0, 24.0];

    #[test]
    fn weights_are_those_of_gaussians_and_tell_as_much_as_so_many_samples() {
        for (scale, width) in [1.0_f64, 1.7, 3.65].into_iter().enumerate() {
            let weights = WEIGHTS[scale + 1];
            for (ring, weight) in weights.into_iter().enumerate() {
                let truth = (-(ring as f64).powi(2) / (2.0 * width * width)).exp();
                assert!((weight - truth).abs() < 1e-4, "{width} {ring} {weight} {truth}");
            }
            let sum = |power: i32| -> f64 {
                weights.iter().zip(COUNTS).map(|(weight, count)| count * weight.powi(power)).sum()
            };
            let samples = sum(2).powi(2) / sum(4);
            assert!((samples - SAMPLES[scale + 1]).abs() < 0.06, "{width} {samples}");
        }
    }

    /// No sum over these rings tells a pit better than the one whose weights are its own depths. Some sum reaches nine tenths
    /// of that for any width of 2 to 10 spacings at half of the depth.
    #[test]
    fn some_sum_tells_each_width() {
        for tenths in 20..=100 {
            let width = f64::from(tenths) / 10.0;
            let pit = |r: f64| (-4.0 * 2.0_f64.ln() * (r / width).powi(2)).exp();
            let heights: [f64; RINGS] = std::array::from_fn(|ring| pit(ring as f64));
            let best: f64 = heights.iter().zip(COUNTS).map(|(h, count)| h * h * count).sum();
            let found = WEIGHTS.map(|weights| {
                let rings =
                    std::array::from_fn(|ring| (COUNTS[ring] * heights[ring], COUNTS[ring]));
                weighted(&rings, weights, 0.0)
            });
            let found = found.into_iter().fold(0.0, f64::max);
            assert!(found > 0.9 * best.sqrt(), "{width} {found} {}", best.sqrt());
        }
    }

    #[test]
    fn a_shared_variance_counts_by_the_square_of_all() {
        let rings = COUNTS.map(|count| (count, count));
        let alike = weighted(&rings, [1.0; RINGS], 0.25);
        assert!((alike - 61.0 / (61.0_f64 + 61.0 * 61.0 * 0.25).sqrt()).abs() < 1e-12);
    }
}

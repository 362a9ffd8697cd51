//! DISCUR and VICUR: samples are joined as the eye joins them, by nearness and by going on smoothly.

mod chains;

use self::chains::Chains;
use super::regular::angle_rad;
use crate::triangulation::{EdgeId, distance_mm};
use crate::{Graph, SampleId, Triangulation};

/// DISCUR: Delaunay edges, shortest first, again and again until none is added, each between samples with fewer than two
/// edges.
///
/// Two samples without an edge are joined. Else, for an end q of a chain with its last edge qr and the candidate p: with
/// h = (|pq| + |qr|)/2, s = ||pq| - |qr||/√2, and h' and σ the mean and standard deviation of the chain's edge lengths, they
/// are joined if |pq| < h'·(h/s)·(1 + h'/σ)^(σ/h') at one of the chain ends. No parameter; corners that are densely sampled are
/// kept. Y. Zeng, T. A. Nguyen, B. Yan, S. Li, *A distance-based parameter free algorithm for curve reconstruction*,
/// Computer-Aided Design 40 (2008) 210-222; as a public program works, the text was not at hand. Proven by its authors under a
/// condition of its own that is not stated here. Lengths are ordered exactly, the figures are computed in doubles. n·log n
/// time for each of some rounds.
pub fn discur(triangulation: &Triangulation) -> Graph {
    grown(triangulation, |chains, p, q| {
        let reaches = |end: SampleId, candidate: SampleId| {
            let last = chains.other(end)?;
            let [at, from, to] = [end, last, candidate].map(|sample| triangulation.place(sample));
            let [own_mm, new_mm] = [distance_mm(at, from), distance_mm(at, to)];
            let [half, step] = [0.5 * (new_mm + own_mm), (new_mm - own_mm).abs() / 2.0_f64.sqrt()];
            let (mean_mm, deviation_mm) = chains.lengths(end);
            let spread = match deviation_mm > 0.0 {
                true => (1.0 + mean_mm / deviation_mm).powf(deviation_mm / mean_mm),
                false => 1.0,
            };
            // A step of zero makes the bound infinite.
            Some(new_mm * step < mean_mm * half * spread)
        };
        let at_ends = [reaches(p, q), reaches(q, p)];
        at_ends == [None, None] || at_ends.contains(&Some(true))
    })
}

/// VICUR: the same rounds, but an end q of a chain takes its best candidate only.
///
/// A candidate p, a Delaunay neighbour with fewer than two edges, within twice the mean length of the chain's edges, whose edge
/// meets the last one at 45° or more, is the better the larger
/// 1 / (c·(α/ᾱ - 1)² + (1 - c)/4·(d/(d̄ + σ))² + 1), where α is that angle, ᾱ the mean angle along the chain (π if there is
/// none), d = |pq|, d̄ and σ mean and standard deviation of the chain's edge lengths. c from 0 to 1 is the weight of smoothness
/// against nearness. T. A. Nguyen, Y. Zeng, *VICUR: A human-vision-based algorithm for curve reconstruction*, Robotics and
/// Computer-Integrated Manufacturing 24 (2008) 824-834; as a public program works, the text was not at hand. Nothing is proven
/// of it here. Computed in doubles. n·log n time for each of some rounds.
///
/// # Panics
///
/// If c is not from 0 to 1.
pub fn vicur(triangulation: &Triangulation, c: f64) -> Graph {
    assert!((0.0..=1.0).contains(&c), "expected c from 0 to 1, found {c}");
    grown(triangulation, |chains, p, q| {
        let takes = |end: SampleId, candidate: SampleId| match chains.other(end) {
            Some(last) => best(triangulation, chains, end, last, c) == Some(candidate),
            None => true,
        };
        takes(p, q) && takes(q, p)
    })
}

/// The candidate of the least c·(α/ᾱ - 1)² + (1 - c)/4·(d/(d̄ + σ))², of equal ones that of the smallest number.
fn best(
    triangulation: &Triangulation,
    chains: &Chains,
    end: SampleId,
    last: SampleId,
    c: f64,
) -> Option<SampleId> {
    let (mean_mm, deviation_mm) = chains.lengths(end);
    let mean_angle_rad = chains.angle_rad(end);
    let [at, from] = [end, last].map(|sample| triangulation.place(sample));
    let cost = |candidate: SampleId| {
        let to = triangulation.place(candidate);
        let (angle_rad, length_mm) = (angle_rad(at, from, to), distance_mm(at, to));
        let is_near = length_mm <= 2.0 * mean_mm && angle_rad >= std::f64::consts::FRAC_PI_4;
        let [turn, way] = [angle_rad / mean_angle_rad - 1.0, length_mm / (mean_mm + deviation_mm)];
        is_near.then_some(c * turn * turn + 0.25 * (1.0 - c) * way * way)
    };
    let free = triangulation.spokes(end).iter().map(|spoke| spoke.to);
    let free = free.filter(|&sample| sample != last && chains.degree(sample) < 2);
    let costs = free.filter_map(|sample| Some((cost(sample)?, sample)));
    costs.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, sample)| sample)
}

/// Chains grown by the edges that a rule takes.
fn grown(
    triangulation: &Triangulation,
    joins: impl Fn(&Chains, SampleId, SampleId) -> bool,
) -> Graph {
    let mut chains = Chains::new(triangulation);
    let offer = |chains: &mut Chains, [p, q]: [SampleId; 2]| {
        if chains.degree(p) == 2 || chains.degree(q) == 2 {
            return false;
        }
        let is_taken = joins(chains, p, q);
        if is_taken {
            chains.join(p, q);
        }
        !is_taken
    };
    // Most samples are full after the shortest edges. Of the others only those between two that are not need an order.
    let count = triangulation.len();
    let [short, mut long] = triangulation.parted_by_length(count + count / 4);
    let mut open: Vec<[SampleId; 2]> = Vec::new();
    let mut first_round = |chains: &mut Chains, edges: &[EdgeId]| {
        // All ends are fetched at once: one by one each would wait for memory.
        let sorted = triangulation.sorted_by_length(edges).into_iter();
        let ends: Vec<[SampleId; 2]> = sorted.map(|edge| triangulation.ends(edge)).collect();
        open.extend(ends.into_iter().filter(|&ends| offer(chains, ends)));
    };
    first_round(&mut chains, &short);
    long.retain(|&edge| triangulation.ends(edge).iter().all(|&end| chains.degree(end) < 2));
    first_round(&mut chains, &long);
    let mut before = triangulation.edges().len();
    // Edges between full samples go in silence; what counts is that a round neither adds nor drops any.
    while open.len() != before {
        before = open.len();
        open.retain(|&ends| offer(&mut chains, ends));
    }
    chains.graph()
}

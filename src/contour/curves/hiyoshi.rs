//! Hiyoshi: every sample has two edges, and their sum is least.

mod blossom;
mod forest;
mod matching;

use asphera_geometry::Sets;

use self::matching::{Start, matching};
use super::ruler::Ruler;
use crate::graphs::sigdt;
use crate::triangulation::EdgeId;
use crate::{Graph, SampleId, Triangulation};

/// Most samples of one set that [`hiyoshi`] takes; of more, those of each part that the sphere-of-influence graph joins.
pub const MOST_FOR_MATCHING: usize = 2_000;

/// The Delaunay edges of least total length that give every sample two: closed curves.
///
/// H. Hiyoshi, *Optimization-based approach for curve and surface reconstruction*, Computer-Aided Design 41 (2009) 366-374, takes the
/// 2-factor of maximum weight L - |e|, L the longest edge: that of least length. It is right for ε < 1/3 and adjacent edges of a ratio below
/// 1.46; the text was not at hand. Each sample becomes two nodes and each edge two that are each other's partners unless the edge is
/// taken (W. T. Tutte, Canadian Journal of Mathematics 6 (1954) 347-352); a matching of least cost is found. Lengths are rounded to 2⁻⁴¹
/// of the box at most, their sums are exact. Where no 2-factor exists, as of open curves on one line, as many ends as possible are
/// joined, with no claim to the least length.
///
/// Of more than [`MOST_FOR_MATCHING`] samples each part joined by [`sigdt`] is solved for itself: none if a part has more.
/// n²·log n time or more.
pub fn hiyoshi(triangulation: &Triangulation) -> Option<Graph> {
    let ruler = Ruler::new(triangulation.samples().places());
    let count = triangulation.len();
    if count <= MOST_FOR_MATCHING {
        let all: Vec<EdgeId> = (0..triangulation.edges().len() as EdgeId).collect();
        return Some(Graph::new(factor(triangulation, &ruler, &all)));
    }
    let mut sets = Sets::new(count);
    for &[p, q] in sigdt(triangulation).edges() {
        sets.join(p as usize, q as usize);
    }
    let (part_of, parts) = sets.numbered();
    let mut sizes = vec![0_usize; parts as usize];
    part_of.iter().for_each(|&part| sizes[part as usize] += 1);
    if sizes.iter().any(|&size| size > MOST_FOR_MATCHING) {
        return None;
    }
    let mut edges: Vec<Vec<EdgeId>> = vec![Vec::new(); parts as usize];
    for (id, edge) in (0..).zip(triangulation.edges()) {
        let [p, q] = edge.ends.map(|end| part_of[end as usize]);
        if p == q {
            edges[p as usize].push(id);
        }
    }
    Some(Graph::new(edges.iter().flat_map(|edges| factor(triangulation, &ruler, edges))))
}

/// The edges of least total length, of those given, that give every sample of theirs two.
fn factor(triangulation: &Triangulation, ruler: &Ruler, edges: &[EdgeId]) -> Vec<[SampleId; 2]> {
    let ends: Vec<[SampleId; 2]> = edges.iter().map(|&edge| triangulation.ends(edge)).collect();
    let mut samples: Vec<SampleId> = ends.as_flattened().to_vec();
    samples.sort_unstable();
    samples.dedup();
    let lengths: Vec<i64> = edges
        .iter()
        .map(|&edge| {
            let [p, q] = triangulation.ends_mm(edge);
            ruler.length(p, q)
        })
        .collect();
    let local = |sample: SampleId| samples.partition_point(|&other| other < sample);
    let first_port = 2 * samples.len();
    let mut potentials = vec![0; first_port + 2 * edges.len()];
    let mut least = vec![i64::MAX; samples.len()];
    // The two ports of an edge are partners at first: no edge is taken.
    let mut start_edges: Vec<[usize; 2]> =
        (0..edges.len()).map(|edge| [first_port + 2 * edge, first_port + 2 * edge + 1]).collect();
    let mut costs = vec![0; edges.len()];
    for (edge, (ends, &length)) in ends.iter().zip(&lengths).enumerate() {
        for (side, &end) in ends.iter().enumerate() {
            let sample = local(end);
            least[sample] = least[sample].min(length);
            for copy in [2 * sample, 2 * sample + 1] {
                start_edges.push([copy, first_port + 2 * edge + side]);
                costs.push(length);
            }
        }
    }
    for (sample, &length) in least.iter().enumerate() {
        potentials[2 * sample] = -2 * length;
        potentials[2 * sample + 1] = -2 * length;
    }
    let matched = (0..edges.len()).collect();
    let is_matched = matching(&Start { edges: start_edges, costs, potentials, matched });
    ends.into_iter().zip(is_matched).filter(|(_, is_idle)| !is_idle).map(|(ends, _)| ends).collect()
}

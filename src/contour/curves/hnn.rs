//! HNN-Crust.

use asphera_geometry::predicates::compare_distances;
use rayon::prelude::*;

use crate::{Graph, SampleId, Triangulation};

/// HNN-Crust: every sample p chooses its nearest one q, and the nearest s that is nearer to p than to q. An edge is kept
/// if both its ends chose it.
///
/// Proven: of a smooth curve without ends, sampled with ρ < 0.9 (with ε < 0.47), it is exactly the edges between samples
/// that follow each other. Decided exactly. S. Ohrhallinger, S. A. Mitchell, M. Wimmer, Computer Graphics Forum 35 (2016)
/// 167-176; condition and definition are certain. Unlike the authors' program the search for s does not end after a number
/// of neighbours. n·log n time on points that are about as dense everywhere; a sample whose s lies far off asks about all
/// that are nearer.
pub fn hnn_crust(triangulation: &Triangulation) -> Graph {
    let chosen = choices(triangulation);
    let is_chosen = |by: SampleId, other: SampleId| chosen[by as usize].contains(&Some(other));
    let edges = (0..).zip(&chosen).flat_map(|(sample, both)| {
        both.iter()
            .flatten()
            .filter(move |&&other| is_chosen(other, sample))
            .map(move |&other| [sample, other])
    });
    Graph::new(edges)
}

/// HNN-Crust with all edges that one of their ends chose.
pub fn one_sided_hnn_crust(triangulation: &Triangulation) -> Graph {
    let chosen = choices(triangulation);
    let edges = (0..)
        .zip(&chosen)
        .flat_map(|(sample, both)| both.iter().flatten().map(move |&other| [sample, other]));
    Graph::new(edges)
}

/// The up to two samples that every sample chooses.
fn choices(triangulation: &Triangulation) -> Vec<[Option<SampleId>; 2]> {
    (0..triangulation.len() as SampleId)
        .into_par_iter()
        .map(|sample| {
            let Some(nearest) = triangulation.nearest(sample) else { return [None; 2] };
            [Some(nearest.to), second(triangulation, sample, nearest.to)]
        })
        .collect()
}

/// The nearest sample that is nearer to a sample than to its nearest one. Such a one is also farther from the nearest one
/// than the sample is, which the definition asks for as well.
fn second(triangulation: &Triangulation, sample: SampleId, nearest: SampleId) -> Option<SampleId> {
    let [at, first] = [sample, nearest].map(|sample| triangulation.place(sample));
    let is_behind = |other: SampleId| {
        let other = triangulation.place(other);
        compare_distances(at, other, first, other).is_lt()
    };
    // Delaunay edges connect the samples of a half-plane: if there is one, a neighbour is one.
    triangulation.nearest_of(sample, is_behind)
}

//! NN-Crust.

use asphera_geometry::predicates::{compare_distances, scalar_product};

use crate::{Graph, SampleId, Triangulation};

/// NN-Crust: every sample is joined to its nearest one, and to the nearest Delaunay neighbour that it sees more than 90°
/// from that.
///
/// Proven: of a smooth curve without ends, sampled with ε < 1/3, it is exactly the edges between samples that follow each
/// other. Decided exactly. T. K. Dey, P. Kumar, SODA 1999, 893-894; condition and definition are certain. An end of a curve
/// has no second neighbour where all others lie ahead. Linear time after the triangulation.
pub fn nn_crust(triangulation: &Triangulation) -> Graph {
    let edges = (0..triangulation.len() as SampleId).flat_map(|sample| {
        let nearest = triangulation.nearest(sample);
        let second = nearest.and_then(|nearest| {
            let [at, first] = [sample, nearest.to].map(|sample| triangulation.place(sample));
            let behind = triangulation
                .spokes(sample)
                .iter()
                .filter(|spoke| scalar_product(at, first, triangulation.place(spoke.to)).is_lt());
            // Compared here: the order of all lengths takes longer than all else.
            behind.min_by(|a, b| {
                let [to_a, to_b] = [a.to, b.to].map(|other| triangulation.place(other));
                compare_distances(at, to_a, at, to_b).then(a.to.cmp(&b.to))
            })
        });
        let both = [nearest, second.copied()];
        both.into_iter().flatten().map(move |spoke| [sample, spoke.to])
    });
    Graph::new(edges)
}

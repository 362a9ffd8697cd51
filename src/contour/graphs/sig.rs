//! The sphere-of-influence graph.

use asphera_geometry::WeightedTree;
use asphera_geometry::predicates::compare_with_sum;

use crate::samples::SampleId;
use crate::triangulation::distance_mm;
use crate::{Graph, Triangulation};

/// The sphere-of-influence graph: edges pq no longer than the distances of p and of q to their nearest samples together.
///
/// At most 15·n edges, not all of them Delaunay edges. Decided exactly. G. T. Toussaint, *A graph-theoretical primal
/// sketch*, Computational Morphology (1988) 229-260. n·log n time.
pub fn sig(triangulation: &Triangulation) -> Graph {
    let places = triangulation.samples().places();
    let radius_mm = |sample: SampleId| {
        let nearest = triangulation.nearest(sample);
        nearest.map_or(0.0, |spoke| {
            distance_mm(triangulation.place(sample), triangulation.place(spoke.to))
        })
    };
    let radii_mm: Vec<f64> = (0..places.len() as SampleId).map(radius_mm).collect();
    let tree = WeightedTree::new(
        places.iter().zip(&radii_mm).map(|(&[x, y], &radius)| ([x, y, 0.0], -radius)),
    );
    let mut edges = Vec::new();
    for (sample, &[x, y]) in (0..).zip(places) {
        let radius = radii_mm[sample as usize];
        tree.visit(
            |bounds, weight_mm| {
                let distance_mm = bounds.squared_distance_mm2([x, y, 0.0]).sqrt();
                // A box is left out only if it is farther off than rounding can tell.
                distance_mm * (1.0 - 1e-9) <= (radius - weight_mm) * (1.0 + 1e-9)
            },
            |other| {
                if sample < other && influence(triangulation, sample, other) {
                    edges.push([sample, other]);
                }
                false
            },
        );
    }
    Graph::new(edges)
}

/// The Delaunay edges of the sphere-of-influence graph. Linear time.
pub fn sigdt(triangulation: &Triangulation) -> Graph {
    Graph::of_edges(triangulation, |edge| {
        let [p, q] = triangulation.ends(edge);
        influence(triangulation, p, q)
    })
}

/// Whether the discs about two samples that reach to their nearest ones meet.
pub(crate) fn influence(triangulation: &Triangulation, p: SampleId, q: SampleId) -> bool {
    let [Some(to_p), Some(to_q)] = [p, q].map(|sample| triangulation.nearest(sample)) else {
        return false;
    };
    let [p, q, near_p, near_q] = [p, q, to_p.to, to_q.to].map(|sample| triangulation.place(sample));
    compare_with_sum(p, q, near_p, near_q).is_le()
}

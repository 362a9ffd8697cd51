//! The conservative crust.

use asphera_geometry::WeightedTree;
use rayon::prelude::*;

use crate::graphs::is_gabriel;
use crate::triangulation::EdgeId;
use crate::{Graph, SampleId, Triangulation};

/// The conservative crust: Gabriel edges pq for which the discs of radius |pq|/ρ about p and about q hold no Voronoi
/// vertex.
///
/// Every edge has a reason in the samples: edges are left out rather than guessed, so curves may have ends and outliers
/// stay alone. A smaller ρ is more conservative. T. K. Dey, K. Mehlhorn, E. A. Ramos, Computational Geometry 15 (2000)
/// 229-244; the definition is known at second hand. The Voronoi vertices are rounded. n·log n time.
///
/// # Panics
///
/// If ρ is not above 0 or not finite.
pub fn conservative_crust(triangulation: &Triangulation, rho: f64) -> Graph {
    assert!(rho.is_finite() && rho > 0.0, "expected a finite ρ above 0, found {rho}");
    let centres = triangulation.centres_mm().iter().map(|&[x, y]| ([x, y, 0.0], 0.0));
    let tree = WeightedTree::new(centres.filter(|([x, y, _], _)| x.is_finite() && y.is_finite()));
    let is_candidate: Vec<bool> = (0..triangulation.edges().len() as EdgeId)
        .map(|edge| is_gabriel(triangulation, edge))
        .collect();
    let reach_mm = |edge: EdgeId| triangulation.length_mm(edge) / rho;
    let distance_mm = |sample: SampleId| {
        let [x, y] = triangulation.place(sample);
        let spokes = triangulation.spokes(sample).iter().map(|spoke| spoke.edge);
        let reaches = spokes.filter(|&edge| is_candidate[edge as usize]).map(reach_mm);
        // A vertex farther than that decides nothing, and there are many at nearly the same distance; more than rounding is added.
        let most_mm = reaches.fold(0.0, f64::max) * (1.0 + 1e-9);
        tree.least_below([x, y, 0.0], most_mm).unwrap_or(f64::INFINITY)
    };
    let samples = (0..triangulation.len() as SampleId).into_par_iter();
    let distances_mm: Vec<f64> = samples.map(distance_mm).collect();
    Graph::of_edges(triangulation, |edge| {
        let ends = triangulation.ends(edge);
        is_candidate[edge as usize]
            && ends.iter().all(|&end| distances_mm[end as usize] >= reach_mm(edge))
    })
}

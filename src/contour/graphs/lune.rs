//! Graphs whose edges have an empty lune: the relative neighbourhood graph and the lune-based β-skeleton.

use asphera_geometry::predicates::compare_distances;

use super::is_gabriel;
use crate::samples::PlaceMm;
use crate::{Graph, Triangulation};

/// The relative neighbourhood graph: edges pq without a sample x that is nearer to p and to q than they are to each other.
///
/// Decided exactly. G. T. Toussaint, Pattern Recognition 12 (1980) 261-268. Only Gabriel edges are asked about, each by a
/// search of the region in a k-d tree: n·log n time on points without a far larger density somewhere.
pub fn rng(triangulation: &Triangulation) -> Graph {
    lunes(triangulation, |p, q| {
        let length = squared(p, q);
        Lune {
            centres: [p, q],
            squared: length,
            holds: move |x: PlaceMm| {
                compare_distances(p, x, p, q).is_lt() && compare_distances(q, x, p, q).is_lt()
            },
        }
    })
}

/// The lune-based β-skeleton for β ≥ 1: edges pq with no sample within both discs of radius β·|pq|/2 about
/// (1 - β/2)·p + (β/2)·q and its mirror image.
///
/// β = 1 is [`super::gabriel`] and β = 2 is [`rng`], both decided exactly; other β are decided in doubles. D. G.
/// Kirkpatrick, J. D. Radke, Computational Morphology (1985) 217-248; their text was not at hand. Time as [`rng`].
///
/// # Panics
///
/// If β is below 1 or not finite.
pub fn lune_beta_skeleton(triangulation: &Triangulation, beta: f64) -> Graph {
    assert!(beta.is_finite() && beta >= 1.0, "expected a finite β of at least 1, found {beta}");
    if beta == 1.0 {
        return super::gabriel(triangulation);
    }
    if beta == 2.0 {
        return rng(triangulation);
    }
    let half = 0.5 * beta;
    lunes(triangulation, |p, q| {
        let beside =
            |p: PlaceMm, q: PlaceMm| [p[0] + half * (q[0] - p[0]), p[1] + half * (q[1] - p[1])];
        let centres = [beside(p, q), beside(q, p)];
        let squared_radius = half * half * squared(p, q);
        Lune {
            centres,
            squared: squared_radius,
            holds: move |x: PlaceMm| {
                x != p
                    && x != q
                    && centres.iter().all(|&centre| squared(x, centre) < squared_radius)
            },
        }
    })
}

/// Two discs of one radius, and which places count as within both.
struct Lune<F> {
    centres: [PlaceMm; 2],
    /// The squared radius in mm².
    squared: f64,
    holds: F,
}

/// The Gabriel edges whose lune is empty.
fn lunes<F: Fn(PlaceMm) -> bool>(
    triangulation: &Triangulation,
    lune: impl Fn(PlaceMm, PlaceMm) -> Lune<F>,
) -> Graph {
    let places = triangulation.samples().places();
    Graph::of_edges(triangulation, |edge| {
        if !is_gabriel(triangulation, edge) {
            return false;
        }
        let [p, q] = triangulation.ends_mm(edge);
        let Lune { centres, squared, holds } = lune(p, q);
        let ends = triangulation.ends(edge);
        // What is within mostly lies beside the edge.
        let beside = ends.iter().flat_map(|&end| triangulation.spokes(end));
        if beside.into_iter().any(|spoke| holds(places[spoke.to as usize])) {
            return false;
        }
        // A box is left out only if it is farther off than rounding can tell.
        let reach = squared * (1.0 + 1e-9);
        !triangulation.tree().visit(
            |bounds, _| {
                centres.iter().all(|&[x, y]| bounds.squared_distance_mm2([x, y, 0.0]) <= reach)
            },
            |sample| holds(places[sample as usize]),
        )
    })
}

fn squared(p: PlaceMm, q: PlaceMm) -> f64 {
    let [x, y] = [p[0] - q[0], p[1] - q[1]];
    x * x + y * y
}

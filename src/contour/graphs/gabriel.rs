//! The Gabriel graph.

use asphera_geometry::predicates::scalar_product;

use crate::triangulation::EdgeId;
use crate::{Graph, Triangulation};

/// The Gabriel graph: edges about which the open disc with the edge as diameter holds no sample.
///
/// An edge of the triangulation is one if neither opposite corner sees it under more than 90°, decided exactly. K. R.
/// Gabriel, R. R. Sokal, Systematic Zoology 18 (1969) 259-278. Of a rectangle of samples both diagonals have an empty open
/// disc; the one that the triangulation holds is taken. Linear time.
pub fn gabriel(triangulation: &Triangulation) -> Graph {
    Graph::of_edges(triangulation, |edge| is_gabriel(triangulation, edge))
}

/// Whether an edge of the triangulation is one of the Gabriel graph.
pub(crate) fn is_gabriel(triangulation: &Triangulation, edge: EdgeId) -> bool {
    let [p, q] = triangulation.ends_mm(edge);
    let sees = |apex| scalar_product(triangulation.place(apex), p, q).is_ge();
    triangulation.opposite(edge).into_iter().flatten().all(sees)
}

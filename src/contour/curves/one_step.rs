//! The one-step crust, and with it the medial axis.

use asphera_geometry::predicates::{compare_angle_sum, scalar_product};

use crate::triangulation::EdgeId;
use crate::{Graph, PlaceMm, Triangulation};

/// The one-step crust and the skeleton beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct OneStep {
    /// The curve.
    pub crust: Graph,
    /// The Voronoi edges of the other Delaunay edges, from circumcentre to circumcentre in mm: the medial axis of the
    /// curve with hairs where samples are coarse. Those that run to infinity are left out. They are rounded.
    pub skeleton_mm: Vec<[PlaceMm; 2]>,
}

/// The one-step crust: edges whose two opposite angles are together at most 90°.
///
/// That is, some disc through both ends shuts out both ends of the dual Voronoi edge. It holds the crust and is part of the
/// Gabriel graph. Decided exactly. C. M. Gold, J. Snoeyink, Algorithmica 30 (2001) 144-163, after C. M. Gold, Vision
/// Interface 1999; the test is that of their result, their text was not at hand. No condition is stated here under which
/// it equals the curve. Linear time.
pub fn one_step_crust(triangulation: &Triangulation) -> OneStep {
    let centres = triangulation.centres_mm();
    let skeleton_mm = (0..)
        .zip(triangulation.edges())
        .filter_map(|(id, edge)| {
            let [left, right] = edge.triangles();
            let ends = [left?, right?].map(|triangle| centres[triangle as usize]);
            (ends[0] != ends[1] && !is_crust(triangulation, id)).then_some(ends)
        })
        .collect();
    OneStep { crust: one_step_curve(triangulation), skeleton_mm }
}

/// The curve of [`one_step_crust`] alone.
pub(crate) fn one_step_curve(triangulation: &Triangulation) -> Graph {
    Graph::of_edges(triangulation, |edge| is_crust(triangulation, edge))
}

fn is_crust(triangulation: &Triangulation, edge: EdgeId) -> bool {
    let [p, q] = triangulation.ends_mm(edge);
    let apexes =
        triangulation.opposite(edge).map(|apex| apex.map(|apex| triangulation.place(apex)));
    match apexes {
        [Some(left), Some(right)] => compare_angle_sum(p, q, left, right).is_le(),
        [Some(apex), None] | [None, Some(apex)] => scalar_product(apex, p, q).is_ge(),
        [None, None] => true,
    }
}

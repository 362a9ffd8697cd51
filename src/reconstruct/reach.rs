//! How wide the facets at a point may be, by its neighbours.
//!
//! It keeps lids off the mouths of open surfaces: a facet across a mouth is wide beside the spacing of the points at its rim.

use crate::delaunay::Delaunay;
use crate::neighbours::Neighbours;

/// The largest radius of a sphere or circle through each vertex that counts as of the surface, mm: half the reach of
/// [`crate::local()`], 2.3 times the distance of the 16th neighbour.
pub(crate) fn widest_mm(delaunay: &Delaunay) -> Vec<f64> {
    let numbered = delaunay.points_mm.iter().copied().zip(0..).collect();
    let tree = Neighbours::of(numbered);
    let far = tree.map_nearest(NEAREST, |_, near, _: &mut ()| {
        near.last().map_or(0.0, |&(square, _)| square.sqrt())
    });
    let mut widest = vec![0.0; far.len()];
    for (&vertex, far) in tree.ids.iter().zip(far) {
        widest[vertex as usize] = REACH / 2.0 * far;
    }
    widest
}

const NEAREST: usize = 16;
const REACH: f64 = 2.3;

//! How wide the facets at a point may be, by its neighbours.
//!
//! It takes lids off the mouths of open surfaces: a facet across a mouth is wide beside the spacing of the points at its rim.

use crate::delaunay::Delaunay;
use crate::neighbours::Neighbours;
use crate::sampling::radius_mm;

/// The reach of each vertex.
pub(crate) struct Reach {
    /// The largest radius of a sphere or circle through each vertex that counts as of the surface, mm: half the reach of
    /// [`crate::local()`], 2.3 times the distance of the 16th neighbour.
    widest_mm: Vec<f64>,
}

impl Reach {
    pub(crate) fn of(delaunay: &Delaunay) -> Reach {
        let numbered = delaunay.points_mm.iter().copied().zip(0..).collect();
        let tree = Neighbours::of(numbered);
        let far = tree.map_nearest(NEAREST, |_, near, _: &mut ()| {
            near.last().map_or(0.0, |&(square, _)| square.sqrt())
        });
        let mut widest_mm = vec![0.0; far.len()];
        for (&vertex, far) in tree.ids.iter().zip(far) {
            widest_mm[vertex as usize] = REACH / 2.0 * far;
        }
        Reach { widest_mm }
    }

    /// Whether a sphere or circle through a vertex is within its reach.
    pub(crate) fn holds(&self, vertex: u32, radius_mm: f64) -> bool {
        radius_mm <= self.widest_mm[vertex as usize]
    }

    /// Whether the circle of a facet is beyond the reach of all its corners.
    pub(crate) fn is_lid(&self, delaunay: &Delaunay, facet: [u32; 3]) -> bool {
        let radius_mm = radius_mm(facet.map(|corner| delaunay.place(corner)));
        !facet.iter().any(|&corner| self.holds(corner, radius_mm))
    }
}

const NEAREST: usize = 16;
/// How far a point sees, in distances of that neighbour.
pub(crate) const REACH: f64 = 2.3;

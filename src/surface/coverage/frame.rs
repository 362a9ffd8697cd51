//! What lies outside the hull of a mesh, cut into triangles.
//!
//! From a centre inside the hull a ray leads through each vertex of the hull to a point far outside.
//! Between two rays and beyond the side of the hull lies a quadrilateral, of two triangles:
//!
//! ```text
//!   far(i+1) ______________ far(i)        rays: from a vertex of the hull to its far point
//!            \        __ - /
//!             \ __ -      /
//!     hull(i+1) \________/ hull(i)        the mesh lies below
//! ```
//!
//! With them the aperture is filled by triangles, those of the mesh and these, and what is outside
//! the hull is treated as what a mesh bridges. Where the aperture reaches past the hull by less than
//! the target's gap the pieces on both sides of a ray are not one region: a seam of the width of half
//! a scan line all around the part would else join everything that touches the border.

use std::cmp::Ordering;

use asphera_geometry::predicates::{Place, orientation};
use asphera_geometry::{PointMm, VertexId, place};

/// The triangles about a mesh.
pub(super) struct Frame {
    /// The hull, counter-clockwise.
    pub(super) hull: Vec<VertexId>,
    /// A point far outside for each vertex of the hull; it has the number `first_far` and so on.
    pub(super) far: Vec<Place>,
    /// The number of the first far point: one above those of the mesh.
    pub(super) first_far: VertexId,
    /// The triangles, counter-clockwise, two for each side of the hull.
    pub(super) triangles: Vec<[VertexId; 3]>,
}

impl Frame {
    /// The frame of a mesh with this hull that contains all of the bounds; none if the hull is not a line
    /// about its centre.
    pub(super) fn new(
        points: &[PointMm],
        hull: Vec<VertexId>,
        [low, high]: [Place; 2],
    ) -> Option<Frame> {
        let at = |vertex: VertexId| place(points[vertex as usize]);
        let count = hull.len() as f64;
        let first = at(hull[0]);
        let centre = [0, 1].map(|axis| {
            let offsets = hull.iter().map(|&vertex| at(vertex)[axis] - first[axis]);
            first[axis] + offsets.sum::<f64>() / count
        });
        let mut nearest_mm = f64::INFINITY;
        for (&p, &q) in hull.iter().zip(hull.iter().cycle().skip(1)) {
            let (p, q) = (at(p), at(q));
            if orientation(centre, p, q) != Ordering::Greater {
                return None;
            }
            let [x, y] = [q[0] - p[0], q[1] - p[1]];
            let twice = x * (centre[1] - p[1]) - y * (centre[0] - p[0]);
            nearest_mm = nearest_mm.min(twice / x.hypot(y));
        }
        let reach_mm = [[low[0], low[1]], [high[0], low[1]], [low[0], high[1]], [high[0], high[1]]]
            .map(|corner| (corner[0] - centre[0]).hypot(corner[1] - centre[1]))
            .into_iter()
            .fold(0.0, f64::max);
        let scale = (2.0 * reach_mm / nearest_mm).max(2.0);
        let far: Vec<Place> = hull
            .iter()
            .map(|&vertex| {
                [0, 1].map(|axis| centre[axis] + scale * (at(vertex)[axis] - centre[axis]))
            })
            .collect();
        if !far.as_flattened().iter().all(|mm| mm.is_finite()) {
            return None;
        }
        let first_far = points.len() as VertexId;
        let mut about = Vec::with_capacity(2 * hull.len());
        for i in 0..hull.len() {
            let j = (i + 1) % hull.len();
            let (far_i, far_j) = (first_far + i as VertexId, first_far + j as VertexId);
            about.push([hull[j], hull[i], far_i]);
            about.push([hull[j], far_i, far_j]);
        }
        Some(Frame { hull, far, first_far, triangles: about })
    }

    /// The vertex of the hull where the ray that is this side begins, if it is one.
    pub(super) fn ray(&self, [p, q]: [VertexId; 2]) -> Option<VertexId> {
        let (vertex, far) = (p.min(q), p.max(q));
        let index = far.checked_sub(self.first_far)? as usize;
        (self.hull.get(index) == Some(&vertex)).then_some(vertex)
    }
}

#[cfg(test)]
mod tests {
    use asphera_mesh::Mesh;

    use super::*;
    use crate::rim::{Outline, hull};

    #[test]
    fn a_frame_turns_about_the_mesh_and_fills_what_is_outside() {
        let mut mesh = Mesh::new();
        mesh.insert(&[
            [0.0, 0.0, 0.0],
            [2.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [2.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 0.5, 0.0],
        ]);
        let bounds = [[-3.0, -3.0], [9.0, 4.0]];
        let triangles = mesh.triangles();
        let outline = Outline::new(mesh.points().len(), &triangles);
        let hull = hull(&triangles, &outline).unwrap();
        let frame = Frame::new(mesh.points(), hull, bounds).unwrap();
        assert_eq!(frame.hull, [0, 2, 1, 3, 4]);
        assert_eq!(frame.triangles.len(), 10);
        let at = |vertex: VertexId| match vertex.checked_sub(frame.first_far) {
            Some(index) => frame.far[index as usize],
            None => place(mesh.points()[vertex as usize]),
        };
        for corners in &frame.triangles {
            let [p, q, r] = corners.map(at);
            assert_eq!(orientation(p, q, r), Ordering::Greater, "{corners:?}");
        }
        for corner in [[-3.0, -3.0], [9.0, -3.0], [-3.0, 4.0], [9.0, 4.0]] {
            let inside = frame.triangles.iter().filter(|corners| {
                let [p, q, r] = corners.map(at);
                [(p, q), (q, r), (r, p)].iter().all(|&(p, q)| orientation(p, q, corner).is_ge())
            });
            assert!(inside.count() >= 1, "{corner:?}");
        }
        assert_eq!(frame.ray([8, 1]), Some(1));
        assert_eq!((frame.ray([8, 2]), frame.ray([0, 2])), (None, None));
    }

    #[test]
    fn what_is_no_whole_mesh_has_no_hull() {
        let hull = |triangles: &[[VertexId; 3]]| hull(triangles, &Outline::new(5, triangles));
        // Two triangles that share a corner only.
        assert_eq!(hull(&[[0, 1, 2], [2, 3, 4]]), None);
        assert_eq!(hull(&[]), None);
        assert_eq!(hull(&[[0, 1, 2], [1, 3, 2]]), Some(vec![0, 1, 3, 2]));
    }
}

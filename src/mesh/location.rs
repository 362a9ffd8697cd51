//! Where a place lies in a mesh.

use asphera_geometry::{Rejection, VertexId};

/// Where a place (x, y) lies in a mesh, told exactly. It depends on the place and the vertices
/// alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Location {
    /// Inside a triangle, on none of its edges.
    Inside {
        /// Its corners, counter-clockwise from the smallest on, as in [`crate::Mesh::triangles`].
        triangle: [VertexId; 3],
    },
    /// On an edge, between its ends. So too on the line of a mesh without triangles.
    OnEdge {
        /// Its ends, the smaller first.
        edge: [VertexId; 2],
    },
    /// Exactly at a vertex.
    At {
        /// The vertex.
        vertex: VertexId,
    },
    /// Outside the convex hull.
    Outside {
        /// Of the edges of the hull that have the place on their outer side the nearest. It leads
        /// counter-clockwise about the mesh. If a vertex is the nearest of the hull, and two such
        /// edges meet there, it is the one that ends there.
        edge: [VertexId; 2],
    },
    /// The mesh has no triangles, since all its vertices lie on one line, and the place lies on
    /// none of the edges between them: beside the line or beyond its ends.
    OffLine,
    /// The mesh has no vertices.
    Empty,
    /// The mesh admits no point there.
    Rejected(Rejection),
}

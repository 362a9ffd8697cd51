//! What became of a pushed point, and how many there were of each kind.

use asphera_geometry::{Rejection, VertexId};

/// Fate of one pushed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// It waits for its batch to fill; see [`crate::Mesh::flush`].
    Pending,
    /// It is this vertex of the mesh.
    Vertex(VertexId),
    /// It lies exactly in the place (x, y) of an earlier vertex, and at its height within the
    /// conflict tolerance. The mesh keeps the earlier one.
    Duplicate {
        /// The vertex that stands there.
        of: VertexId,
    },
    /// It lies exactly in the place (x, y) of an earlier vertex, but at another height: the surface
    /// is not projectable there, or one of the two measurements is wrong. The mesh keeps the
    /// earlier one.
    Conflict {
        /// The vertex that stands there.
        of: VertexId,
        /// Height of this point above that vertex in mm; negative below.
        height_mm: f64,
    },
    /// It was this vertex of the mesh until it was withdrawn; see [`crate::Mesh::remove`].
    Withdrawn(VertexId),
    /// It cannot be meshed.
    Rejected(Rejection),
}

/// How many points, vertices, triangles and edges a mesh has.
///
/// Every pushed point is counted once: `pushed = vertices + withdrawn + duplicates + conflicts +
/// rejected + pending`. With at least one vertex Euler's relation
/// `vertices - edges + triangles = 1` holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Points pushed.
    pub pushed: u64,
    /// Vertices of the mesh.
    pub vertices: u64,
    /// Triangles of the mesh; none while all vertices lie on one line.
    pub triangles: u64,
    /// Edges of the mesh. While all vertices lie on one line: those between neighbours on it.
    pub edges: u64,
    /// Vertices on the boundary of the convex hull, those inside a straight side of it included.
    /// While all vertices lie on one line: all of them.
    pub hull: u64,
    /// Vertices taken out of the mesh again.
    pub withdrawn: u64,
    /// Points in the place of an earlier vertex and at its height.
    pub duplicates: u64,
    /// Points in the place of an earlier vertex but at another height.
    pub conflicts: u64,
    /// Points that are not finite or out of range.
    pub rejected: u64,
    /// Points waiting for their batch to fill.
    pub pending: u64,
}

/// How many edges there are, and vertices on the hull.
///
/// Euler's relation, and each triangle has three edges, each inner edge two triangles.
pub(crate) fn edges_and_hull(vertices: u64, triangles: u64) -> (u64, u64) {
    let edges = (vertices + triangles).saturating_sub(1);
    let hull = if triangles == 0 { vertices } else { 2 * edges - 3 * triangles };
    (edges, hull)
}

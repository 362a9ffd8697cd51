//! From triangle to triangle of a mesh.

use asphera_geometry::predicates::Place;
use asphera_geometry::{VertexId, place};
use asphera_mesh::{Mesh, Neighbours};

/// A mesh seen by one who walks over it and remembers the last vertices that were passed.
///
/// A path pivots about a vertex for some triangles before it leaves it behind, so most of what is
/// asked for is known already.
pub(super) struct Walk<'a> {
    mesh: &'a Mesh,
    known: Vec<(VertexId, Neighbours)>,
    /// Which of the known is forgotten next.
    oldest: usize,
}

impl<'a> Walk<'a> {
    pub(super) fn new(mesh: &'a Mesh) -> Walk<'a> {
        Walk { mesh, known: Vec::with_capacity(REMEMBERED), oldest: 0 }
    }

    pub(super) fn at(&self, vertex: VertexId) -> Place {
        place(self.mesh.points()[vertex as usize])
    }

    /// The third corner of the triangle on the left of the edge from `a` to `b`; none if the hull
    /// has the edge and no triangle lies there.
    pub(super) fn apex(&mut self, a: VertexId, b: VertexId) -> Option<VertexId> {
        // Counter-clockwise about `a` the corner follows `b`; about `b` it precedes `a`.
        let known = |vertex| self.known.iter().any(|&(known, _)| known == vertex);
        let (centre, end, steps) = if known(b) && !known(a) { (b, a, -1) } else { (a, b, 1) };
        let Neighbours { vertices, on_hull } = self.neighbours(centre);
        let count = vertices.len();
        let index = vertices.iter().position(|&vertex| vertex == end)?;
        match (index, steps, *on_hull) {
            (0, -1, true) => None,
            (last, 1, true) if last + 1 == count => None,
            (_, 1, _) => Some(vertices[(index + 1) % count]),
            _ => Some(vertices[(index + count - 1) % count]),
        }
    }

    /// Both triangles of an edge.
    pub(super) fn beside(&mut self, a: VertexId, b: VertexId) -> [Option<[VertexId; 3]>; 2] {
        let left = self.apex(a, b).map(|apex| [a, b, apex]);
        let right = self.apex(b, a).map(|apex| [b, a, apex]);
        [left, right]
    }

    /// The vertex after one on the hull, counter-clockwise; the vertex itself if there is none.
    pub(super) fn next_on_hull(&mut self, vertex: VertexId) -> VertexId {
        self.neighbours(vertex).vertices.first().copied().unwrap_or(vertex)
    }

    /// The vertex before one on the hull, counter-clockwise; the vertex itself if there is none.
    pub(super) fn previous_on_hull(&mut self, vertex: VertexId) -> VertexId {
        self.neighbours(vertex).vertices.last().copied().unwrap_or(vertex)
    }

    /// The neighbours of a vertex of the mesh.
    pub(super) fn neighbours(&mut self, vertex: VertexId) -> &Neighbours {
        let index =
            self.known.iter().position(|&(known, _)| known == vertex).unwrap_or_else(|| {
                // Only vertices that a query of the mesh gave are asked for; others have none.
                let nothing = || Neighbours { vertices: Vec::new(), on_hull: true };
                let fresh = (vertex, self.mesh.neighbours(vertex).unwrap_or_else(nothing));
                if self.known.len() < REMEMBERED {
                    self.known.push(fresh);
                    self.known.len() - 1
                } else {
                    let index = self.oldest;
                    self.oldest = (index + 1) % REMEMBERED;
                    self.known[index] = fresh;
                    index
                }
            });
        &self.known[index].1
    }
}

/// An edge has two ends, and the next has one of them; the others serve where a path turns back.
const REMEMBERED: usize = 4;

//! The neighbours of a vertex, and its triangles.

use std::collections::BTreeSet;

use asphera_geometry::{VertexId, from_smallest};

use super::Mesh;
use crate::delaunay::About;

/// The neighbours of a vertex: those an edge leads to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Neighbours {
    /// Counter-clockwise seen from +z. Of a vertex on the hull they run through the mesh, from the
    /// next vertex counter-clockwise on the hull to the one before; of another vertex from the
    /// smallest number on. While all vertices lie on one line: the up to two beside it, by x, then
    /// y.
    pub vertices: Vec<VertexId>,
    /// Whether the vertex lies on the boundary of the convex hull, be it inside a straight side.
    /// While all vertices lie on one line: yes.
    pub on_hull: bool,
}

impl Mesh {
    /// The neighbours of a vertex; none if there is no such vertex or it was withdrawn.
    ///
    /// Takes a short walk and time in proportion to the neighbours.
    pub fn neighbours(&self, vertex: VertexId) -> Option<Neighbours> {
        let About { vertices, on_hull, .. } = self.about(vertex)?;
        Some(Neighbours { vertices, on_hull })
    }

    /// The triangles of a vertex, counter-clockwise about it in the order of its neighbours, each
    /// from its smallest corner on as in [`Mesh::triangles`]; none if there is no such vertex or it
    /// was withdrawn.
    ///
    /// Takes a short walk and time in proportion to the triangles.
    pub fn star(&self, vertex: VertexId) -> Option<Vec<[VertexId; 3]>> {
        Some(self.about(vertex)?.triangles(vertex).collect())
    }

    /// The vertices to which at most `rings` edges lead, the vertex itself left out: those of the
    /// first ring in order of their numbers, then those of the second, and so on; none if there is
    /// no such vertex or it was withdrawn.
    ///
    /// Takes k·log k time for k vertices within.
    pub fn within(&self, vertex: VertexId, rings: usize) -> Option<Vec<VertexId>> {
        let mut known = BTreeSet::from([vertex]);
        let mut found = Vec::new();
        let mut ring = vec![(vertex, self.about(vertex)?)];
        for index in 1..=rings {
            let mut next: Vec<(VertexId, &About)> = Vec::new();
            for (_, about) in &ring {
                let fresh = about.vertices.iter().filter(|&&vertex| known.insert(vertex));
                next.extend(fresh.map(|&vertex| (vertex, about)));
            }
            next.sort_unstable_by_key(|&(vertex, _)| vertex);
            found.extend(next.iter().map(|&(vertex, _)| vertex));
            if index == rings || next.is_empty() {
                break;
            }
            let about_next =
                |(vertex, of): (VertexId, &About)| (vertex, self.about_next(vertex, of));
            ring = next.into_iter().map(about_next).collect();
        }
        Some(found)
    }

    /// The neighbours of `vertex`, which is itself a neighbour of the vertex that `of` belongs to. Constant time but for their number.
    pub fn about_next(&self, vertex: VertexId, of: &About) -> About {
        self.delaunay.about_next(&self.points[..], vertex, of)
    }

    /// The neighbours of a vertex; `None` if there is no such vertex.
    pub fn about(&self, vertex: VertexId) -> Option<About> {
        self.is_vertex(vertex).then(|| self.delaunay.about(&self.points[..], vertex))
    }
}

impl About {
    /// The triangles of the vertex these are the neighbours of.
    pub(super) fn triangles(&self, vertex: VertexId) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        let ends = &self.vertices;
        // On a line, two neighbours are no triangle.
        let count = match (self.on_hull, self.on_line()) {
            (_, true) => 0,
            (true, _) => ends.len() - 1,
            (false, _) => ends.len(),
        };
        (0..count).map(move |i| from_smallest([vertex, ends[i], ends[(i + 1) % ends.len()]]))
    }
}

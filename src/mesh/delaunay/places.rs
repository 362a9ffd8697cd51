//! Where vertices lie, wherever that is kept.

use asphera_geometry::predicates::Place;
use asphera_geometry::{PointMm, VertexId, place};

use crate::fetch::fetch;

/// The places of vertices.
pub(crate) trait Places {
    /// Where the vertex lies.
    fn place(&self, vertex: VertexId) -> Place;

    /// Asks for the place, which is read soon, if it may have to be waited for. There may be no such
    /// vertex.
    #[inline(always)]
    fn fetch(&self, _vertex: VertexId) {}

    /// All points, if they lie in memory for any thread to read.
    fn in_memory(&self) -> Option<&[PointMm]> {
        None
    }
}

/// The points of vertices, the last of which can be moved up and taken away.
pub(crate) trait Vertices {
    /// Source of their places.
    type Places: Places + ?Sized;

    fn places(&self) -> &Self::Places;

    /// How many there are.
    fn count(&self) -> usize;

    /// Puts the point of a vertex in the stead of that of another.
    fn copy(&mut self, from: VertexId, to: VertexId);

    /// Takes away all but the first `count`.
    fn shorten(&mut self, count: usize);
}

impl Places for [PointMm] {
    #[inline(always)]
    fn place(&self, vertex: VertexId) -> Place {
        place(self[vertex as usize])
    }

    /// At both ends, as it may lie in two lines of the cache.
    #[inline(always)]
    fn fetch(&self, vertex: VertexId) {
        if let Some([x, y, _]) = self.get(vertex as usize) {
            fetch(x, |x| *x);
            fetch(y, |y| *y);
        }
    }

    fn in_memory(&self) -> Option<&[PointMm]> {
        Some(self)
    }
}

impl Vertices for Vec<PointMm> {
    type Places = [PointMm];

    fn places(&self) -> &[PointMm] {
        self
    }

    fn count(&self) -> usize {
        self.len()
    }

    fn copy(&mut self, from: VertexId, to: VertexId) {
        self[to as usize] = self[from as usize];
    }

    fn shorten(&mut self, count: usize) {
        self.truncate(count);
    }
}

//! Edits of single vertices: one is withdrawn, or gets another height.

use std::collections::BTreeSet;

use asphera_geometry::{PointMm, Rejection, VertexId, admit};
use thiserror::Error;

use super::Mesh;
use super::changes::Heights;

/// Why a vertex was not edited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum EditError {
    /// There is no vertex of this number.
    #[error("there is no vertex {vertex} in a mesh that has taken {vertices}")]
    NoSuchVertex {
        /// The number.
        vertex: VertexId,
        /// How many vertices there were so far, withdrawn ones included.
        vertices: usize,
    },
    /// The vertex was withdrawn before.
    #[error("vertex {vertex} was withdrawn before")]
    Withdrawn {
        /// Its number.
        vertex: VertexId,
    },
    /// The mesh admits no point of this height.
    #[error("vertex {vertex} cannot have this height: {rejection}")]
    Height {
        /// Its number.
        vertex: VertexId,
        /// Fault of the height.
        rejection: Rejection,
    },
}

/// Edits so far.
#[derive(Default)]
pub(super) struct Edits {
    /// In the order they were withdrawn.
    pub(super) withdrawn: Vec<VertexId>,
    vacant: BTreeSet<VertexId>,
    pub(super) heights: Heights,
}

impl Mesh {
    /// Takes a vertex out of the mesh, as an outlier found later; returns its point.
    ///
    /// Afterwards the mesh is that of the other vertices, exactly: the same as if the point had
    /// never been measured, but for the numbers. **No number changes.** That of the vertex becomes
    /// vacant for good: [`Mesh::points`] still has its point at that index, though no triangle has
    /// that corner; [`Mesh::outcome`] says [`crate::Outcome::Withdrawn`], and [`Mesh::is_vertex`]
    /// says no. Whoever goes over all points, as for a fit, goes over [`Mesh::vertices`] instead.
    ///
    /// Further measurements in the place of the vertex do not take over: they stay the duplicates
    /// and conflicts of it that they were, so [`Mesh::projectable`] says what it said, and
    /// [`Mesh::repeats`] still has them. A point that is inserted there afterwards is a vertex with
    /// a number of its own. Points that wait to be inserted are no vertices yet and are left alone.
    ///
    /// Takes k·log k time for k neighbours, and a short walk. If all others lie on one line, all
    /// triangles go, and the others are the neighbours.
    ///
    /// # Errors
    ///
    /// If there is no such vertex, or it was withdrawn before.
    pub fn remove(&mut self, vertex: VertexId) -> Result<PointMm, EditError> {
        self.existing(vertex)?;
        self.delaunay.cells_mut().advance();
        self.delaunay.remove(&self.points[..], vertex);
        self.edits.withdrawn.push(vertex);
        self.edits.vacant.insert(vertex);
        Ok(self.points[vertex as usize])
    }

    /// Gives a vertex the height `z_mm`; returns the one it had. Triangles stay as they are, since
    /// they depend on x and y alone.
    ///
    /// What was judged by the former height stays: conflicts, duplicates and the statistics of
    /// [`Mesh::repeats`], which are of measurements. Points to come are judged by the new one, and
    /// where the first repeat is among them, it counts as the first measurement. Heights below
    /// [`asphera_geometry::TINY_MM`] are taken as zero. Constant time, but for a look at the withdrawn.
    ///
    /// # Errors
    ///
    /// If there is no such vertex, if it was withdrawn, or if the height is not finite or out of
    /// range.
    pub fn set_height(&mut self, vertex: VertexId, z_mm: f64) -> Result<f64, EditError> {
        self.existing(vertex)?;
        let [_, _, z_mm] =
            admit([0.0, 0.0, z_mm]).map_err(|rejection| EditError::Height { vertex, rejection })?;
        self.edits.heights.note(vertex);
        self.delaunay.cells_mut().advance();
        self.delaunay.touch(&self.points[..], vertex);
        Ok(std::mem::replace(&mut self.points[vertex as usize][2], z_mm))
    }

    /// Whether the mesh has a vertex of this number: one that was inserted and not withdrawn.
    /// Logarithmic time in those withdrawn.
    pub fn is_vertex(&self, vertex: VertexId) -> bool {
        (vertex as usize) < self.points.len() && !self.edits.vacant.contains(&vertex)
    }

    /// The vertices there are, in order of arrival: all numbers but the vacant ones.
    pub fn vertices(&self) -> impl Iterator<Item = VertexId> + '_ {
        let mut vacant = self.edits.vacant.iter().copied().peekable();
        (0..self.points.len() as VertexId)
            .filter(move |&vertex| vacant.next_if_eq(&vertex).is_none())
    }

    /// The vertices that were withdrawn, in the order they were.
    pub fn withdrawn(&self) -> &[VertexId] {
        &self.edits.withdrawn
    }

    fn existing(&self, vertex: VertexId) -> Result<(), EditError> {
        if self.is_vertex(vertex) {
            Ok(())
        } else if (vertex as usize) < self.points.len() {
            Err(EditError::Withdrawn { vertex })
        } else {
            Err(EditError::NoSuchVertex { vertex, vertices: self.points.len() })
        }
    }
}

#[cfg(test)]
mod tests;

//! The triangles about a sample, in the order in which they are met.

use super::{EdgeId, TriangleId, Triangulation};
use crate::samples::SampleId;

/// What lies about a sample, counter-clockwise: between each edge and the next lies a sector.
#[derive(Clone, Debug)]
pub(crate) struct Fan {
    /// The edges of the sample.
    pub(crate) edges: Vec<EdgeId>,
    /// The sector after each edge: a triangle, or none for what lies beyond the hull.
    pub(crate) sectors: Vec<Option<TriangleId>>,
}

impl Triangulation {
    /// The fan of a sample; empty if there are no triangles.
    pub(crate) fn fan(&self, sample: SampleId) -> Fan {
        let count = self.spokes(sample).len();
        let mut fan = Fan { edges: Vec::with_capacity(count), sectors: Vec::with_capacity(count) };
        // A sample on the hull has one edge with nothing clockwise of it; its fan begins there.
        let first = self.spokes(sample).iter().find(|spoke| {
            self.beside(sample, spoke.edge)[1].is_none()
                && self.beside(sample, spoke.edge)[0].is_some()
        });
        let Some(first) = first.or(self.spokes(sample).first()) else { return fan };
        let mut edge = first.edge;
        loop {
            let sector = self.beside(sample, edge)[0];
            fan.edges.push(edge);
            fan.sectors.push(sector);
            let Some(triangle) = sector else { return fan };
            edge = self.edge_before(sample, triangle);
            if edge == first.edge {
                return fan;
            }
        }
    }

    /// The triangle counter-clockwise of an edge about one of its ends, and that clockwise.
    fn beside(&self, sample: SampleId, edge: EdgeId) -> [Option<TriangleId>; 2] {
        let edge = self.edges()[edge as usize];
        let [left, right] = edge.triangles();
        if edge.ends[0] == sample { [left, right] } else { [right, left] }
    }

    /// The edge of a triangle that leads to one of its corners from the corner before.
    fn edge_before(&self, sample: SampleId, triangle: TriangleId) -> EdgeId {
        let corners = self.triangles()[triangle as usize];
        let corner = corners.iter().position(|&corner| corner == sample).unwrap_or(0);
        self.sides(triangle)[(corner + 2) % 3]
    }

    /// The triangles on the other sides of a triangle's edges, from each corner to the next; none beyond the hull.
    pub(crate) fn across(&self, triangle: TriangleId) -> [Option<TriangleId>; 3] {
        self.sides(triangle).map(|side| {
            let triangles = self.edges()[side as usize].triangles();
            if triangles[0] == Some(triangle) { triangles[1] } else { triangles[0] }
        })
    }
}

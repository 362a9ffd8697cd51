//! The neighbourhood of a vertex: rings of neighbours of neighbours.

use asphera_geometry::VertexId;

use super::Adjacency;

/// How many samples a neighbourhood should have: fewer make another ring worth its width.
const ENOUGH: usize = 16;
/// How many rings are added at most to reach that.
const MORE_RINGS: usize = 2;

/// On how many sides of a vertex there are samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Surroundings {
    /// All rings close about the vertex.
    Whole,
    /// The border cuts off a part of the neighbourhood, but the vertex is not on it.
    Cut,
    /// The vertex is on the border: all samples lie on one side, and derivatives are extrapolated.
    OnBorder,
}

/// A vertex and the rings about it, in memory that is used again.
#[derive(Default)]
pub(crate) struct Rings {
    /// The vertex first, then ring by ring, each in order of discovery.
    samples: Vec<VertexId>,
}

impl Rings {
    /// Gathers what at most `rings` edges lead to, and up to two rings more where that is less than
    /// 16 vertices. Takes k² time for k vertices, of which there are seldom more than some dozens.
    pub(crate) fn gather(
        &mut self,
        adjacency: &Adjacency,
        vertex: VertexId,
        rings: usize,
    ) -> Surroundings {
        self.samples.clear();
        self.samples.push(vertex);
        let mut surroundings = Surroundings::Whole;
        let mut from = 0;
        for ring in 0..rings + MORE_RINGS {
            let until = self.samples.len();
            if from == until || (ring >= rings && until >= ENOUGH) {
                break;
            }
            for index in from..until {
                let inner = self.samples[index];
                if adjacency.on_border(inner) && surroundings == Surroundings::Whole {
                    surroundings =
                        if index == 0 { Surroundings::OnBorder } else { Surroundings::Cut };
                }
                for &end in adjacency.neighbours(inner) {
                    if !self.samples.contains(&end) {
                        self.samples.push(end);
                    }
                }
            }
            from = until;
        }
        surroundings
    }

    pub(crate) fn samples(&self) -> &[VertexId] {
        &self.samples
    }
}

//! The pieces of a section, and how they are put together.

use asphera_geometry::{PointMm, VertexId};

/// The line in which a mesh is cut.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Section {
    /// What of it is known, in order of the arc position along the path; nothing lies in between.
    pub pieces: Vec<Piece>,
}

/// A part of a section without a break.
#[derive(Clone, Debug, PartialEq)]
pub struct Piece {
    /// Its points in order, two or more; the section runs straight from each to the next but on a
    /// circle. Of a closed piece the last one is the first again.
    pub points: Vec<SectionPoint>,
    /// Why it begins where it does.
    pub begins: Limit,
    /// Why it ends where it does.
    pub ends: Limit,
}

/// Why a piece of a section begins or ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Limit {
    /// The path begins or ends there.
    Path,
    /// The mesh begins or ends there: beyond lies the outside of the convex hull.
    Hull,
    /// The surface in space ends there, at an edge of one facet.
    Border,
    /// Beyond lies a triangle that was not kept: its gap is above the limit.
    Gap,
    /// A vertex lies in the cutting plane there, and more pieces than one meet at it, or no other.
    Junction,
    /// Nowhere: the piece is closed, and its end is its beginning.
    Closed,
}

/// A point of a section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SectionPoint {
    /// Arc position in mm: along a path the distance from its start in the plane of projection;
    /// along a piece cut by a plane the length in space from its first point. It never decreases.
    pub s_mm: f64,
    /// x, y and z in mm.
    pub at_mm: PointMm,
    /// What in the mesh it is interpolated from.
    pub source: Source,
}

/// Where in a mesh a point of a section lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// At a vertex.
    Vertex {
        /// The vertex.
        vertex: VertexId,
    },
    /// On an edge.
    Edge {
        /// Its ends, the smaller first.
        edge: [VertexId; 2],
        /// How far from the first to the second: 0 to 1.
        share: f64,
    },
    /// In a triangle: a start or an end of the path, or a point between crossings of a circle.
    Triangle {
        /// Its corners.
        corners: [VertexId; 3],
        /// Their weights, from 0 up, with the sum 1.
        weights: [f64; 3],
    },
}

impl Section {
    /// All points, piece after piece.
    pub fn points(&self) -> impl Iterator<Item = &SectionPoint> {
        self.pieces.iter().flat_map(|piece| &piece.points)
    }

    /// How much of the arc position the pieces cover, in mm.
    pub fn length_mm(&self) -> f64 {
        self.pieces.iter().map(Piece::length_mm).sum()
    }
}

impl Piece {
    /// The difference of the arc positions of its ends in mm.
    pub fn length_mm(&self) -> f64 {
        let ends = self.points.first().zip(self.points.last());
        ends.map_or(0.0, |(first, last)| last.s_mm - first.s_mm)
    }

    /// Whether its end is its beginning.
    pub fn is_closed(&self) -> bool {
        self.begins == Limit::Closed
    }
}

impl SectionPoint {
    /// A value given at the vertices, in the unit of `value`, interpolated as the heights are: it
    /// is asked for at up to three vertices. A NaN among them is passed on.
    pub fn interpolate(&self, value: impl FnMut(VertexId) -> f64) -> f64 {
        self.source.interpolate(value)
    }
}

impl Source {
    /// The vertices with their weights, from 0 up, with the sum 1.
    pub fn weights(&self) -> impl Iterator<Item = (VertexId, f64)> {
        let (vertices, weights, count) = match *self {
            Source::Vertex { vertex } => ([vertex; 3], [1.0, 0.0, 0.0], 1),
            Source::Edge { edge: [from, to], share } => {
                ([from, to, to], [1.0 - share, share, 0.0], 2)
            }
            Source::Triangle { corners, weights } => (corners, weights, 3),
        };
        vertices.into_iter().zip(weights).take(count)
    }

    fn interpolate(&self, mut value: impl FnMut(VertexId) -> f64) -> f64 {
        let mut weights = self.weights();
        // What all have in common is not rounded again.
        let first = weights.next().map_or(f64::NAN, |(vertex, _)| value(vertex));
        first + weights.map(|(vertex, weight)| weight * (value(vertex) - first)).sum::<f64>()
    }

    /// From what [`asphera_mesh::Mesh::linear_coordinates`] gives; none without a vertex.
    pub(super) fn of_weights(weights: &[(VertexId, f64)]) -> Option<Source> {
        match *weights {
            [(vertex, _)] => Some(Source::Vertex { vertex }),
            [(p, _), (q, share)] if p < q => Some(Source::Edge { edge: [p, q], share }),
            [(p, share), (q, _)] => Some(Source::Edge { edge: [q, p], share }),
            [(p, u), (q, v), (r, w)] => {
                Some(Source::Triangle { corners: [p, q, r], weights: [u, v, w] })
            }
            _ => None,
        }
    }

    /// Where it lies, x, y and z in mm.
    pub(super) fn at_mm(&self, points: &[PointMm]) -> PointMm {
        [0, 1, 2].map(|axis| self.interpolate(|vertex| points[vertex as usize][axis]))
    }
}

/// Puts a section together, chord by chord.
pub(super) struct Builder<'a, K> {
    points: &'a [PointMm],
    keep: K,
    pieces: Vec<Piece>,
    /// The piece to which the next chord may belong.
    open: Option<Piece>,
    /// Why a piece that begins with the next chord begins there.
    begins: Limit,
    /// The largest arc position so far.
    reached_mm: f64,
}

impl<'a, K: FnMut([VertexId; 3]) -> bool> Builder<'a, K> {
    pub(super) fn new(points: &'a [PointMm], keep: K) -> Self {
        Builder {
            points,
            keep,
            pieces: Vec::new(),
            open: None,
            begins: Limit::Path,
            reached_mm: 0.0,
        }
    }

    /// The chord that follows begins a run, for this reason.
    pub(super) fn begin(&mut self, why: Limit) {
        self.begins = why;
    }

    /// The chord before was the last one of a run, for this reason.
    pub(super) fn end(&mut self, why: Limit) {
        self.close(why);
    }

    /// Whether one of the triangles beside a chord is kept; their corners begin anywhere.
    pub(super) fn keeps(&mut self, beside: [Option<[VertexId; 3]>; 2]) -> bool {
        let keep = &mut self.keep;
        beside.into_iter().flatten().any(|corners| keep(asphera_geometry::from_smallest(corners)))
    }

    /// Adds a chord that begins where the one before ended, from one point to the next ones; if it
    /// is not kept, the section is broken there.
    pub(super) fn chord(&mut self, from: SectionPoint, to: &[SectionPoint], kept: bool) {
        if !kept {
            self.close(Limit::Gap);
            self.begins = Limit::Gap;
            return;
        }
        // Rounding must not turn the order that is known exactly.
        let mut in_order = |mut point: SectionPoint| {
            self.reached_mm = self.reached_mm.max(point.s_mm);
            point.s_mm = self.reached_mm;
            point
        };
        let begins = self.begins;
        let piece = self.open.get_or_insert_with(|| Piece {
            points: vec![in_order(from)],
            begins,
            ends: begins,
        });
        piece.points.extend(to.iter().copied().map(in_order));
    }

    /// The point of a source at an arc position.
    pub(super) fn point(&self, s_mm: f64, source: Source) -> SectionPoint {
        SectionPoint { s_mm, at_mm: source.at_mm(self.points), source }
    }

    /// Makes the only piece a closed one, if it runs from the start of the path to its end.
    pub(super) fn join_ends(&mut self) {
        if let [piece] = &mut self.pieces[..]
            && [piece.begins, piece.ends] == [Limit::Path; 2]
        {
            [piece.begins, piece.ends] = [Limit::Closed; 2];
        }
    }

    pub(super) fn finish(mut self) -> Section {
        self.close(Limit::Path);
        Section { pieces: self.pieces }
    }

    fn close(&mut self, why: Limit) {
        // Where a corner of the mesh pokes into the path by less than rounding tells, it touches it.
        if let Some(mut piece) = self.open.take().filter(|piece| piece.length_mm() > 0.0) {
            piece.ends = why;
            self.pieces.push(piece);
        }
    }
}

//! The straight way over a mesh.
//!
//! The way is known by the sides on which vertices lie of its line, which is decided exactly. It
//! either crosses the inside of an edge, whose ends then lie on different sides, or passes through
//! a vertex, which then lies on the line, and goes on through a triangle or along an edge.
//!
//! ```text
//!        q                      the edge crossed has one end on the left and one on the right; the
//!        │                      side of the apex beyond says by which of the two other edges the
//!  left ─┼──── right            way leaves the triangle, or that it passes through the apex
//!     \  │   /
//!      \ │ /
//!       apex                    (p lies below)
//! ```

use std::cmp::Ordering;

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, orientation};
use asphera_mesh::{Location, Mesh};

use super::pieces::{Builder, Limit, SectionPoint, Source};
use super::walk::Walk;

/// A straight way from `p` through `q`.
pub(super) struct Way {
    p: Place,
    q: Place,
    /// Whether it ends at `q`.
    ends: bool,
    /// Its direction, of length 1.
    along: [f64; 2],
}

impl Way {
    /// From a place to another one.
    pub(super) fn segment(p: Place, q: Place) -> Way {
        // Halves do not overflow, and differ where the places do.
        let half = [q[0] / 2.0 - p[0] / 2.0, q[1] / 2.0 - p[1] / 2.0];
        let length = half[0].hypot(half[1]);
        Way { p, q, ends: true, along: half.map(|component| component / length) }
    }

    /// From a place on, without an end.
    pub(super) fn ray(p: Place, along: [f64; 2]) -> Way {
        // Far enough for the direction not to be rounded more than it is.
        let far = 4.0 * p[0].abs().max(p[1].abs()).max(1.0);
        Way { p, q: [p[0] + far * along[0], p[1] + far * along[1]], ends: false, along }
    }

    /// On which side of the line a place lies: `Greater` is left.
    fn side(&self, place: Place) -> Ordering {
        orientation(self.p, self.q, place)
    }

    /// Whether of two places on the line the way comes to `to` after `from`.
    fn leads(&self, from: Place, to: Place) -> bool {
        let axis = usize::from(self.p[0] == self.q[0]);
        if self.p[axis] < self.q[axis] { from[axis] < to[axis] } else { to[axis] < from[axis] }
    }

    fn s_mm(&self, place: Place) -> f64 {
        let s_mm = (place[0] - self.p[0]) * self.along[0] + (place[1] - self.p[1]) * self.along[1];
        s_mm.max(0.0)
    }

    /// Where the line crosses an edge whose ends lie on different sides of it.
    fn crossing(&self, walk: &Walk<'_>, a: VertexId, b: VertexId) -> Source {
        let edge = [a.min(b), a.max(b)];
        let [from, to] = edge.map(|end| {
            let [x, y] = walk.at(end);
            self.along[0] * (y - self.p[1]) - self.along[1] * (x - self.p[0])
        });
        let share = from / (from - to);
        // Where doubles do not tell the ends apart, they are as good as one.
        let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
        Source::Edge { edge, share }
    }
}

/// Where the way is.
#[derive(Clone, Copy)]
enum Stand {
    /// It crosses an edge; the triangle beyond lies on the left of the edge from `left` to `right`.
    Edge { left: VertexId, right: VertexId },
    /// It passes through a vertex.
    Vertex(VertexId),
}

/// What it comes to next.
enum Next {
    Stand(Stand),
    /// Its end, before it leaves the triangle or the edge.
    End,
}

/// Adds the section along the way.
pub(super) fn trace<K: FnMut([VertexId; 3]) -> bool>(
    mesh: &Mesh,
    way: &Way,
    builder: &mut Builder<'_, K>,
) {
    if mesh.counts().triangles == 0 {
        return;
    }
    Tracer { mesh, way, walk: Walk::new(mesh), builder }.trace();
}

struct Tracer<'a, 'b, 'c, K> {
    mesh: &'a Mesh,
    way: &'b Way,
    walk: Walk<'a>,
    builder: &'b mut Builder<'c, K>,
}

impl<K: FnMut([VertexId; 3]) -> bool> Tracer<'_, '_, '_, K> {
    fn trace(mut self) {
        let p = self.way.p;
        let (mut from, next) = match self.mesh.locate(p[0], p[1]) {
            Location::Inside { triangle } => {
                let Some(next) = self.leave_inside(triangle) else { return };
                (self.given(p), self.come_to(next, [Some(triangle), None]))
            }
            Location::OnEdge { edge: [a, b] } => (self.given(p), self.leave_edge(a, b)),
            Location::At { vertex } => {
                (self.stand_point(Stand::Vertex(vertex)), Some(Reached::at(Stand::Vertex(vertex))))
            }
            Location::Outside { edge } => {
                self.builder.begin(Limit::Hull);
                match self.enter(edge) {
                    Some(stand) => (self.stand_point(stand), Some(Reached::at(stand))),
                    None => return,
                }
            }
            Location::OffLine | Location::Empty | Location::Rejected(_) => return,
        };
        let Some(mut reached) = next else { return self.builder.end(Limit::Hull) };
        loop {
            if let Some(beside) = reached.through {
                let to = match reached.next {
                    Next::Stand(stand) => self.stand_point(stand),
                    Next::End => self.given(self.way.q),
                };
                let kept = self.builder.keeps(beside);
                self.builder.chord(from, &[to], kept);
                from = to;
            }
            let Next::Stand(stand) = reached.next else { return self.builder.end(Limit::Path) };
            if let Stand::Vertex(vertex) = stand
                && self.way.ends
                && !self.way.leads(self.walk.at(vertex), self.way.q)
            {
                return self.builder.end(Limit::Path);
            }
            let beyond = match stand {
                Stand::Edge { left, right } => self.cross(left, right),
                Stand::Vertex(vertex) => self.pass(vertex),
            };
            let Some(next) = beyond else { return self.builder.end(Limit::Hull) };
            reached = next;
        }
    }

    /// The triangle beyond an edge.
    fn cross(&mut self, left: VertexId, right: VertexId) -> Option<Reached> {
        let apex = self.walk.apex(left, right)?;
        let stand = match self.way.side(self.walk.at(apex)) {
            Ordering::Equal => Stand::Vertex(apex),
            Ordering::Greater => Stand::Edge { left: apex, right },
            Ordering::Less => Stand::Edge { left, right: apex },
        };
        self.come_to(stand, [Some([left, right, apex]), None])
    }

    /// The edge along which the way goes on from a vertex, or else the triangle.
    fn pass(&mut self, vertex: VertexId) -> Option<Reached> {
        let at = self.walk.at(vertex);
        let about = self.walk.neighbours(vertex).clone();
        let sides: Vec<Ordering> =
            about.vertices.iter().map(|&end| self.way.side(self.walk.at(end))).collect();
        let ahead =
            |&i: &usize| sides[i].is_eq() && self.way.leads(at, self.walk.at(about.vertices[i]));
        let count = sides.len();
        if let Some(i) = (0..count).find(ahead) {
            let end = about.vertices[i];
            let beside = self.walk.beside(vertex, end);
            return self.come_to(Stand::Vertex(end), beside);
        }
        // No triangle lies between the last neighbour of a vertex on the hull and the first.
        let triangles = if about.on_hull { count - 1 } else { count };
        let i = (0..triangles).find(|&i| sides[i].is_lt() && sides[(i + 1) % count].is_gt())?;
        let (right, left) = (about.vertices[i], about.vertices[(i + 1) % count]);
        self.come_to(Stand::Edge { left, right }, [Some([vertex, right, left]), None])
    }

    /// The way out of a triangle inside which it starts.
    fn leave_inside(&mut self, triangle: [VertexId; 3]) -> Option<Stand> {
        let at = triangle.map(|corner| self.walk.at(corner));
        let sides = at.map(|place| self.way.side(place));
        let ahead = |&i: &usize| sides[i].is_eq() && self.way.leads(self.way.p, at[i]);
        if let Some(i) = (0..3).find(ahead) {
            return Some(Stand::Vertex(triangle[i]));
        }
        // Counter-clockwise about the triangle, the edge by which the way leaves leads from right
        // to left.
        let i = (0..3).find(|&i| sides[i].is_lt() && sides[(i + 1) % 3].is_gt())?;
        Some(Stand::Edge { left: triangle[(i + 1) % 3], right: triangle[i] })
    }

    /// The way from a place on an edge.
    fn leave_edge(&mut self, a: VertexId, b: VertexId) -> Option<Reached> {
        match self.way.side(self.walk.at(a)) {
            Ordering::Greater => Some(Reached::at(Stand::Edge { left: a, right: b })),
            Ordering::Less => Some(Reached::at(Stand::Edge { left: b, right: a })),
            Ordering::Equal => {
                let ahead = if self.way.leads(self.way.p, self.walk.at(a)) { a } else { b };
                let beside = self.walk.beside(a, b);
                self.come_to(Stand::Vertex(ahead), beside)
            }
        }
    }

    /// Where the way comes to the hull from outside, which it sees at an edge; none if it misses
    /// it, or ends before or on it.
    ///
    /// Seen from a place outside, the edges of the hull that turn their outer side to it follow one
    /// another from left to right, and the way enters by the one whose ends lie on both its sides.
    fn enter(&mut self, [mut start, mut end]: [VertexId; 2]) -> Option<Stand> {
        loop {
            let [from, to] = [start, end].map(|vertex| self.walk.at(vertex));
            if !orientation(from, to, self.way.p).is_lt() {
                return None;
            }
            for (vertex, at) in [(start, from), (end, to)] {
                if self.way.side(at).is_eq() {
                    let passed = self.way.leads(self.way.p, at)
                        && (!self.way.ends || self.way.leads(at, self.way.q));
                    return passed.then_some(Stand::Vertex(vertex));
                }
            }
            match (self.way.side(from).is_gt(), self.way.side(to).is_gt()) {
                (true, true) => (start, end) = (end, self.walk.next_on_hull(end)),
                (false, false) => (start, end) = (self.walk.previous_on_hull(start), start),
                // The hull lies behind.
                (false, true) => return None,
                (true, false) => {
                    let inside = !self.way.ends || orientation(from, to, self.way.q).is_gt();
                    return inside.then_some(Stand::Edge { left: start, right: end });
                }
            }
        }
    }

    /// The chord that ends where the way comes to next, or before, if the way does.
    fn come_to(&mut self, stand: Stand, beside: [Option<[VertexId; 3]>; 2]) -> Option<Reached> {
        let before = self.way.ends
            && match stand {
                Stand::Vertex(vertex) => self.way.leads(self.way.q, self.walk.at(vertex)),
                Stand::Edge { left, right } => {
                    let [left, right] = [left, right].map(|end| self.walk.at(end));
                    orientation(left, right, self.way.q).is_le()
                }
            };
        let next = if before { Next::End } else { Next::Stand(stand) };
        Some(Reached { next, through: Some(beside) })
    }

    /// The point where the way crosses an edge or passes through a vertex.
    fn stand_point(&self, stand: Stand) -> SectionPoint {
        let source = match stand {
            Stand::Vertex(vertex) => Source::Vertex { vertex },
            Stand::Edge { left, right } => self.way.crossing(&self.walk, left, right),
        };
        let mut point = self.builder.point(0.0, source);
        point.s_mm = self.way.s_mm([point.at_mm[0], point.at_mm[1]]);
        point
    }

    /// The point at a place inside the mesh: the start of the way or its end.
    fn given(&self, at: Place) -> SectionPoint {
        let weights = self.mesh.linear_coordinates(at[0], at[1]);
        let source = Source::of_weights(&weights).expect("it lies in a triangle or on an edge");
        let mut point = self.builder.point(self.way.s_mm(at), source);
        [point.at_mm[0], point.at_mm[1]] = at;
        point
    }
}

/// What the way comes to, and what lies beside the chord that leads there, if there is one.
struct Reached {
    next: Next,
    through: Option<[Option<[VertexId; 3]>; 2]>,
}

impl Reached {
    /// The way is there already.
    fn at(stand: Stand) -> Reached {
        Reached { next: Next::Stand(stand), through: None }
    }
}

//! The way around a circle, from triangle to triangle.
//!
//! A triangle and the disc are convex, so their intersection is, and its border is made of arcs of
//! the circle and pieces of the triangle's sides in turn. Counter-clockwise, an arc begins where the
//! border of the triangle leaves the disc, and ends where it comes back into it: **the next crossing
//! along the sides**. So it takes no more to follow the circle than to know which corners lie
//! inside, and whether a side with both ends outside is crossed twice. The same holds for the hull:
//! where the circle leaves the mesh, it comes back at the next crossing along the hull.
//!
//! ```text
//!       c                  sides:  a ▶ b leaves the disc at 1, b ▶ c comes into it at 2
//!      / \                 arc:    from 1 to 2, in this triangle
//!     /   2 -.
//!    /     \  \            A vertex on the circle counts as inside, and a side that only touches
//!   a --1-- b  |           the circle as not crossed: the circle might have been a little different
//!                          there. Arcs that vanish between crossings at one vertex are left out.
//! ```

use std::collections::{BTreeSet, VecDeque};

use asphera_geometry::predicates::{Place, left_of};
use asphera_geometry::{VertexId, from_smallest};
use asphera_mesh::{Location, Mesh};

use super::disc::Disc;
use super::pieces::Source;
use super::walk::Walk;

/// What the circle meets.
pub(super) enum Circuit {
    /// No triangle.
    Nothing,
    /// One triangle, in which it lies as a whole.
    Within([VertexId; 3]),
    /// The arcs into which the edges of the mesh cut it, counter-clockwise, from any one on.
    Arcs(Vec<Arc>),
}

/// A part of the circle inside a triangle.
pub(super) struct Arc {
    pub(super) from: Source,
    pub(super) to: Source,
    pub(super) corners: [VertexId; 3],
    /// Whether it begins where the one before ends, not where the circle comes into the mesh.
    pub(super) follows: bool,
    /// Whether it may be longer than half the circle. If not, and it looks as if, it is so short
    /// that rounding turned it around.
    pub(super) may_be_long: bool,
}

/// A crossing of the circle with an edge.
#[derive(Clone, Copy, PartialEq)]
struct Crossing {
    /// The edge, the smaller end first.
    edge: [VertexId; 2],
    /// Whether it is the one farther from that end, of two that its line has.
    far: bool,
    source: Source,
}

/// A crossing of the circle with the side of a triangle, as one sees it who goes along the side.
#[derive(Clone, Copy)]
struct Passage {
    /// Which side: it leads from the corner of this index to the next.
    side: usize,
    /// Whether one leaves the disc there.
    leaves: bool,
    crossing: Crossing,
}

/// Follows the circle around. `start` is a place on it, but for rounding.
pub(super) fn follow(mesh: &Mesh, disc: &Disc, start: Place) -> Circuit {
    if mesh.counts().triangles == 0 {
        return Circuit::Nothing;
    }
    Follower { mesh, disc, walk: Walk::new(mesh) }.follow(start)
}

struct Follower<'a, 'b> {
    mesh: &'a Mesh,
    disc: &'b Disc,
    walk: Walk<'a>,
}

impl Follower<'_, '_> {
    fn follow(mut self, start: Place) -> Circuit {
        let near = match self.mesh.locate(start[0], start[1]) {
            Location::Inside { triangle } => Some(triangle),
            Location::OnEdge { edge: [a, b] } => {
                self.walk.beside(a, b).into_iter().flatten().next()
            }
            Location::At { vertex } => {
                self.mesh.star(vertex).and_then(|star| star.first().copied())
            }
            Location::Outside { edge } => match self.next_along_hull(edge, edge) {
                Some((corners, passage)) => return self.around(corners, passage),
                None => self.hull_around_disc(edge),
            },
            Location::OffLine | Location::Empty | Location::Rejected(_) => None,
        };
        let Some(near) = near else { return Circuit::Nothing };
        self.search(near)
    }

    /// The first triangle that the circle meets, from one near it on, ring by ring. As a rule it is
    /// that one, and where the start was rounded across an edge, the one beyond.
    fn search(mut self, near: [VertexId; 3]) -> Circuit {
        let mut seen = BTreeSet::from([from_smallest(near)]);
        let mut open = VecDeque::from([near]);
        while let Some(corners) = open.pop_front() {
            let passages = self.passages(corners);
            if let Some(&passage) = passages.iter().find(|passage| passage.leaves) {
                return self.around(corners, passage);
            }
            if self.holds_disc(corners) {
                return Circuit::Within(corners);
            }
            let [a, b, c] = corners;
            for (from, to) in [(b, a), (c, b), (a, c)] {
                if let Some(apex) = self.walk.apex(from, to)
                    && seen.insert(from_smallest([from, to, apex]))
                {
                    open.push_back([from, to, apex]);
                }
            }
        }
        Circuit::Nothing
    }

    /// Follows the circle from a crossing by which it comes into a triangle until it is there again.
    fn around(mut self, mut corners: [VertexId; 3], first: Passage) -> Circuit {
        let mut arcs = Vec::new();
        let mut follows = false;
        let mut from = first.crossing;
        loop {
            let passages = self.passages(corners);
            let begin = passages.iter().position(|passage| passage.crossing.same_as(&from));
            let begin = begin.expect("both triangles of an edge see it crossed");
            let (enters, leaves) = (passages[begin], passages[(begin + 1) % passages.len()]);
            let to = leaves.crossing;
            if from.source != to.source || !matches!(to.source, Source::Vertex { .. }) {
                let passed = if enters.side == leaves.side {
                    3
                } else {
                    (leaves.side + 3 - enters.side) % 3
                };
                // From outside a disc one sees less than half of its circle: so it is from the only
                // corner between. And a long arc has the centre in the hull of its points.
                let may_be_long = passed > 1 && self.holds(corners, self.disc.centre);
                arcs.push(Arc { from: from.source, to: to.source, corners, follows, may_be_long });
                follows = true;
            }
            let (a, b) = (corners[leaves.side], corners[(leaves.side + 1) % 3]);
            if let Some(apex) = self.walk.apex(b, a) {
                (corners, from) = ([b, a, apex], to);
            } else {
                let again =
                    passages.iter().find(|passage| passage.side == leaves.side && passage.leaves);
                from = if let Some(passage) = again {
                    passage.crossing
                } else {
                    let next = [b, self.walk.next_on_hull(b)];
                    let (beyond, passage) = self
                        .next_along_hull(next, [a, b])
                        .expect("the hull leaves the disc as often as it comes into it");
                    corners = beyond;
                    passage.crossing
                };
                follows = false;
            }
            if from.same_as(&first.crossing) {
                if let Some(arc) = arcs.first_mut() {
                    arc.follows = follows;
                }
                return Circuit::Arcs(arcs);
            }
        }
    }

    /// The next crossing where the hull leaves the disc, from an edge of the hull on to before
    /// another one, and the triangle there.
    fn next_along_hull(
        &mut self,
        [mut a, mut b]: [VertexId; 2],
        until: [VertexId; 2],
    ) -> Option<([VertexId; 3], Passage)> {
        loop {
            let found = self.passages_of_side(0, a, b).into_iter().flatten();
            if let Some(passage) = found.into_iter().find(|passage| passage.leaves) {
                let apex = self.walk.apex(a, b)?;
                return Some(([a, b, apex], passage));
            }
            (a, b) = (b, self.walk.next_on_hull(b));
            if [a, b] == until {
                return None;
            }
        }
    }

    /// The triangle at an edge of the hull, if the disc lies inside the hull, which is known not to
    /// cross the circle.
    fn hull_around_disc(&mut self, [a, b]: [VertexId; 2]) -> Option<[VertexId; 3]> {
        let [x, y] = self.disc.centre;
        let outside = matches!(self.mesh.locate(x, y), Location::Outside { .. });
        if outside || self.holds_vertex(a) {
            return None;
        }
        self.walk.apex(a, b).map(|apex| [a, b, apex])
    }

    /// Where one who goes around a triangle counter-clockwise passes the circle: leaving the disc
    /// and coming into it in turn.
    fn passages(&self, corners: [VertexId; 3]) -> Vec<Passage> {
        (0..3)
            .flat_map(|side| self.passages_of_side(side, corners[side], corners[(side + 1) % 3]))
            .flatten()
            .collect()
    }

    fn passages_of_side(&self, side: usize, a: VertexId, b: VertexId) -> [Option<Passage>; 2] {
        let passage = |leaves, source| {
            let far = leaves == (a < b);
            let edge = [a.min(b), a.max(b)];
            Some(Passage { side, leaves, crossing: Crossing { edge, far, source } })
        };
        match (self.holds_vertex(a), self.holds_vertex(b)) {
            (true, true) => [None, None],
            (true, false) => [passage(true, self.crossing(a, b)), None],
            (false, true) => [passage(false, self.crossing(b, a)), None],
            (false, false) => {
                let [p, q] = [a, b].map(|end| self.walk.at(end));
                // The line comes nearest between the ends, and near enough.
                let between =
                    asphera_geometry::predicates::compare_with_right_angle(p, q, self.disc.centre)
                        .is_gt()
                        && asphera_geometry::predicates::compare_with_right_angle(
                            q,
                            p,
                            self.disc.centre,
                        )
                        .is_gt();
                if !between || !self.disc.meets_line(p, q) {
                    return [None, None];
                }
                [passage(false, self.secant(b, a)), passage(true, self.secant(a, b))]
            }
        }
    }

    /// Where the circle crosses an edge with only one end inside or on it.
    fn crossing(&self, inside: VertexId, outside: VertexId) -> Source {
        let [p, q] = [inside, outside].map(|end| self.walk.at(end));
        let away = || {
            !asphera_geometry::predicates::compare_with_right_angle(p, q, self.disc.centre).is_gt()
        };
        if self.disc.side(p).is_eq() && away() {
            return Source::Vertex { vertex: inside };
        }
        self.secant(inside, outside)
    }

    /// The second crossing of two that the line from `a` to `b` has with the circle.
    fn secant(&self, a: VertexId, b: VertexId) -> Source {
        // Always computed along the edge, so that both triangles see the same.
        let edge = [a.min(b), a.max(b)];
        let [p, q] = edge.map(|end| self.walk.at(end));
        Source::Edge { edge, share: self.disc.share(p, q, a < b) }
    }

    fn holds_vertex(&self, vertex: VertexId) -> bool {
        self.disc.side(self.walk.at(vertex)).is_le()
    }

    /// Whether a triangle that the circle does not cross has the whole disc inside.
    fn holds_disc(&self, corners: [VertexId; 3]) -> bool {
        !self.holds_vertex(corners[0]) && self.holds(corners, self.disc.centre)
    }

    fn holds(&self, corners: [VertexId; 3], place: Place) -> bool {
        let at = corners.map(|corner| self.walk.at(corner));
        (0..3).all(|i| !left_of(at[(i + 1) % 3], at[i], place))
    }
}

impl Crossing {
    fn same_as(&self, other: &Crossing) -> bool {
        self.edge == other.edge && self.far == other.far
    }
}

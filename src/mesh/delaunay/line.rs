//! What is kept while all places lie on one line and there is nothing to triangulate.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::ops::Bound::{Excluded, Unbounded};

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, orientation};

use super::cells::{Cells, GHOST, Side, Slot};
use super::places::Places;
use super::star::nearer;
use crate::Location;

/// Places on one line, in the order along it.
#[derive(Default)]
pub(super) struct Line {
    /// Two different places: they define the line. The first ones or, once a vertex was removed,
    /// the outermost.
    ends: Vec<Place>,
    /// The vertex at each place, in lexicographic order of the places.
    vertices: BTreeMap<[OrderedBits; 2], VertexId>,
}

impl Line {
    /// The line of vertices of which no three span a triangle.
    pub(super) fn of(
        points: &(impl Places + ?Sized),
        vertices: impl Iterator<Item = VertexId>,
    ) -> Line {
        let mut line = Line::default();
        for vertex in vertices.filter(|&vertex| vertex != GHOST) {
            line.insert(points.place(vertex), vertex);
        }
        line
    }

    /// Whether all places would still lie on one line.
    pub(super) fn contains(&self, place: Place) -> bool {
        match self.ends[..] {
            [from, to] => orientation(from, to, place) == Ordering::Equal,
            _ => true,
        }
    }

    /// Adds a place on the line; the vertex that stands there.
    pub(super) fn insert(&mut self, place: Place, vertex: VertexId) -> VertexId {
        let there = *self.vertices.entry(key(place)).or_insert(vertex);
        if there == vertex && self.ends.len() < 2 {
            self.ends.push(place);
        }
        there
    }

    /// Removes the vertex at a place.
    pub(super) fn remove(&mut self, points: &(impl Places + ?Sized), place: Place) {
        self.vertices.remove(&key(place));
        let outermost = self.outermost().map(|ends| ends.map(|vertex| points.place(vertex)));
        // A single vertex is both.
        self.ends = outermost.into_iter().flatten().collect();
        self.ends.dedup();
    }

    /// The first and the last vertex, by x, then y.
    pub(super) fn outermost(&self) -> Option<[VertexId; 2]> {
        let (_, &first) = self.vertices.first_key_value()?;
        let (_, &last) = self.vertices.last_key_value()?;
        Some([first, last])
    }

    /// Where a place lies.
    pub(super) fn locate(&self, place: Place) -> Location {
        if self.vertices.is_empty() {
            return Location::Empty;
        }
        if let Some(&vertex) = self.vertices.get(&key(place)) {
            return Location::At { vertex };
        }
        match self.about(place) {
            [Some(before), Some(after)] if self.contains(place) => {
                Location::OnEdge { edge: [before.min(after), before.max(after)] }
            }
            _ => Location::OffLine,
        }
    }

    /// The vertices before and after a place by x, then y; not the one that stands there.
    pub(super) fn about(&self, place: Place) -> [Option<VertexId>; 2] {
        let key = key(place);
        let before = self.vertices.range(..key).next_back();
        let after = self.vertices.range((Excluded(key), Unbounded)).next();
        [before, after].map(|found| found.map(|(_, &vertex)| vertex))
    }

    /// The nearest vertex to a place, the one with the smaller x, then y, of two.
    pub(super) fn nearest(
        &self,
        points: &(impl Places + ?Sized),
        place: Place,
    ) -> Option<VertexId> {
        let foot = self.foot(place);
        let start = match (self.vertices.get(&key(foot)), self.about(foot)) {
            (Some(&there), _) => there,
            (None, [before, after]) => before.or(after)?,
        };
        // Along a line the distance has one minimum: whichever neighbour is better leads to it.
        let mut nearest = start;
        loop {
            let about = self.about(points.place(nearest)).into_iter().flatten();
            let better =
                |&vertex: &VertexId| nearer(place, points.place(vertex), points.place(nearest));
            let Some(vertex) = about.into_iter().find(better) else { return Some(nearest) };
            nearest = vertex;
        }
    }

    /// The foot of the perpendicular from a place, rounded.
    fn foot(&self, place: Place) -> Place {
        let [from, to] = self.ends[..] else { return place };
        let along = [to[0] - from[0], to[1] - from[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        let [x, y] = [0, 1].map(|axis| (place[axis] - from[axis]) * along[axis]);
        [0, 1].map(|axis| from[axis] + (x + y) / squared * along[axis])
    }

    pub(super) fn len(&self) -> usize {
        self.vertices.len()
    }

    /// Gives the vertex at a place another number.
    pub(super) fn relabel(&mut self, place: Place, to: VertexId) {
        if let Some(vertex) = self.vertices.get_mut(&key(place)) {
            *vertex = to;
        }
    }

    /// Triangulates the line, of at least two places, with a vertex off it: a fan about that
    /// vertex. Takes cells from `spare`; returns one of the triangles.
    pub(super) fn span(
        &self,
        points: &(impl Places + ?Sized),
        apex: VertexId,
        cells: &impl Cells,
        spare: &mut Vec<Slot>,
    ) -> Slot {
        let mut along: Vec<VertexId> = self.vertices.values().copied().collect();
        let at = |vertex: VertexId| points.place(vertex);
        if orientation(at(along[0]), at(along[1]), at(apex)) == Ordering::Less {
            along.reverse();
        }
        // Seen from the apex the line runs counter-clockwise now.
        let count = along.len() - 1;
        let mut take = || spare.pop().expect("two cells are kept for each point to come");
        let triangles: Vec<Slot> = (0..count).map(|_| take()).collect();
        let below: Vec<Slot> = (0..count).map(|_| take()).collect();
        // The ghosts before the sides from the apex to the line's first and from its last to the
        // apex.
        let (left, right) = (take(), take());
        for i in 0..count {
            let (t, g) = (triangles[i], below[i]);
            let (from, to) = (along[i], along[i + 1]);
            let before = if i == 0 { Side::new(left, 2) } else { Side::new(triangles[i - 1], 1) };
            let after =
                if i + 1 == count { Side::new(right, 2) } else { Side::new(triangles[i + 1], 2) };
            // Side 0 lies on the line, side 1 leads from `to` to the apex, side 2 from it to
            // `from`.
            cells.write(t, [apex, from, to], [Side::new(g, 2), after, before]);
            let ghost_before = if i == 0 { left } else { below[i - 1] };
            let ghost_after = if i + 1 == count { right } else { below[i + 1] };
            let across = [Side::new(ghost_before, 1), Side::new(ghost_after, 0), Side::new(t, 0)];
            cells.write(g, [to, from, GHOST], across);
        }
        let (first, last) = (along[0], along[count]);
        let across = [Side::new(right, 1), Side::new(below[0], 0), Side::new(triangles[0], 2)];
        cells.write(left, [first, apex, GHOST], across);
        let across = [
            Side::new(below[count - 1], 1),
            Side::new(left, 0),
            Side::new(triangles[count - 1], 1),
        ];
        cells.write(right, [apex, last, GHOST], across);
        triangles[0]
    }
}

fn key(place: Place) -> [OrderedBits; 2] {
    place.map(OrderedBits::new)
}

/// A finite double other than negative zero, ordered by value.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct OrderedBits(u64);

impl OrderedBits {
    fn new(value: f64) -> OrderedBits {
        let bits = value.to_bits();
        // Negative numbers sort backwards by their bits, and above the positive ones.
        OrderedBits(if bits >> 63 == 1 { !bits } else { bits | 1 << 63 })
    }
}

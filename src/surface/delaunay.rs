//! Incremental Delaunay triangulation of places in the plane; the only file that knows spade.
//!
//! While all places lie on one line there is nothing to triangulate, and spade would search that
//! line from end to end at each insertion. They are therefore held back, ordered along the line,
//! and handed over when the first place off the line arrives: a profile of 100,000 points costs
//! what a map of 100,000 points costs.

use std::cmp::Ordering;
use std::collections::BTreeMap;

use spade::handles::FixedVertexHandle;
use spade::{DelaunayTriangulation, InsertionError, Point2, Triangulation};

use crate::exact::{Place, orientation};

/// Number of a place, in the order in which different places were inserted, from 0.
pub(crate) type Slot = u32;

/// A growing Delaunay triangulation.
pub(crate) struct Delaunay {
    state: State,
}

enum State {
    /// No three places off one line yet.
    Line(Line),
    /// There is at least one triangle.
    Plane(Plane),
}

#[derive(Default)]
struct Line {
    /// The first two different places: they define the line.
    ends: Vec<Place>,
    /// The slot of each place in lexicographic order, which is the order along the line.
    slots: BTreeMap<[OrderedBits; 2], (Place, Slot)>,
}

struct Plane {
    mesh: DelaunayTriangulation<Point2<f64>>,
    /// The slot of each of spade's first vertices: those of the line in line order, and the first
    /// place off it. All later vertices have the number of their slot.
    first_slots: Vec<Slot>,
    /// The inverse: spade's number of each of the first slots.
    first_vertices: Vec<usize>,
}

impl Delaunay {
    pub(crate) fn new() -> Delaunay {
        Delaunay { state: State::Line(Line::default()) }
    }

    /// Inserts an admitted place (see [`crate::point::admit`]) and returns its slot: the next one, or
    /// that of exactly the same place where it was inserted before.
    ///
    /// Costs a walk from the slot `near`, or else from the place inserted before, and the edge
    /// flips.
    pub(crate) fn insert(&mut self, place: Place, near: Option<Slot>) -> Slot {
        match &mut self.state {
            State::Plane(plane) => plane.insert(place, near),
            State::Line(line) => {
                if line.contains(place) {
                    line.insert(place)
                } else {
                    let slot = next_slot(line.slots.len());
                    self.state = State::Plane(Plane::span(std::mem::take(line), place, slot));
                    slot
                }
            }
        }
    }

    /// How many different places there are.
    pub(crate) fn len(&self) -> usize {
        match &self.state {
            State::Line(line) => line.slots.len(),
            State::Plane(plane) => plane.mesh.num_vertices(),
        }
    }

    /// How many triangles there are.
    pub(crate) fn triangle_count(&self) -> usize {
        match &self.state {
            State::Line(_) => 0,
            State::Plane(plane) => plane.mesh.num_inner_faces(),
        }
    }

    /// The triangles counter-clockwise, in an order that depends on the insertions alone.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [Slot; 3]> + '_ {
        let plane = match &self.state {
            State::Line(_) => None,
            State::Plane(plane) => Some(plane),
        };
        plane.into_iter().flat_map(|plane| {
            plane
                .mesh
                .inner_faces()
                .map(|face| face.vertices().map(|vertex| plane.slot(vertex.fix().index())))
        })
    }
}

impl Line {
    /// Whether all places would still lie on one line.
    fn contains(&self, place: Place) -> bool {
        match self.ends[..] {
            [from, to] => orientation(from, to, place) == Ordering::Equal,
            _ => true,
        }
    }

    fn insert(&mut self, place: Place) -> Slot {
        let slot = next_slot(self.slots.len());
        let (_, there) = *self.slots.entry(place.map(OrderedBits::new)).or_insert((place, slot));
        if there == slot && self.ends.len() < 2 {
            self.ends.push(place);
        }
        there
    }
}

impl Plane {
    /// Triangulates the places of `line`, at least two, and `apex`, which is off that line.
    fn span(line: Line, apex: Place, apex_slot: Slot) -> Plane {
        let count = line.slots.len() + 1;
        // The apex comes second: spade never sees three places on a line without a triangle, and
        // each further one only extends the fan about the apex by one triangle.
        let mut along = line.slots.into_values();
        let first = along.next();
        let mut plane = Plane {
            mesh: DelaunayTriangulation::new(),
            first_slots: Vec::with_capacity(count),
            first_vertices: vec![0; count],
        };
        for (place, slot) in first.into_iter().chain([(apex, apex_slot)]).chain(along) {
            let vertex = vertex_index(plane.mesh.insert(to_spade(place)));
            plane.first_slots.push(slot);
            plane.first_vertices[slot as usize] = vertex;
        }
        plane
    }

    fn insert(&mut self, place: Place, near: Option<Slot>) -> Slot {
        let inserted = match near {
            Some(slot) => self.mesh.insert_with_hint(to_spade(place), self.vertex(slot)),
            None => self.mesh.insert(to_spade(place)),
        };
        self.slot(vertex_index(inserted))
    }

    fn slot(&self, vertex: usize) -> Slot {
        self.first_slots.get(vertex).copied().unwrap_or_else(|| next_slot(vertex))
    }

    fn vertex(&self, slot: Slot) -> FixedVertexHandle {
        let slot = slot as usize;
        FixedVertexHandle::from_index(self.first_vertices.get(slot).copied().unwrap_or(slot))
    }
}

fn to_spade([x, y]: Place) -> Point2<f64> {
    Point2::new(x, y)
}

fn vertex_index(inserted: Result<FixedVertexHandle, InsertionError>) -> usize {
    inserted.expect("admitted coordinates lie inside spade's range of 2^-142 to 2^201").index()
}

/// The slot after `len` slots.
fn next_slot(len: usize) -> Slot {
    Slot::try_from(len).expect("the triangulation ends before slots do, at 2^32 directed edges")
}

/// The bits of a finite double other than negative zero, ordered as the double is.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct OrderedBits(u64);

impl OrderedBits {
    fn new(value: f64) -> OrderedBits {
        let bits = value.to_bits();
        OrderedBits(if value < 0.0 { !bits } else { bits | 1 << 63 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_keep_the_order_of_doubles() {
        let ascending = [-1e12, -1.0, -1e-40, 0.0, 1e-40, 1.0_f64.next_down(), 1.0, 1e12];
        assert!(ascending.map(OrderedBits::new).is_sorted());
    }

    #[test]
    fn slots_follow_insertion_across_the_first_triangle() {
        let mut mesh = Delaunay::new();
        let places = [[2.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, -1.0]];
        for (slot, place) in (0..).zip(places) {
            assert_eq!(mesh.insert(place, None), slot);
        }
        for (slot, place) in (0..).zip(places) {
            assert_eq!(mesh.insert(place, Some(slot)), slot);
        }
        let mut triangles: Vec<[Slot; 3]> = mesh.triangles().collect();
        triangles.iter_mut().for_each(|corners| corners.sort_unstable());
        triangles.sort_unstable();
        assert_eq!(triangles, [[0, 2, 3], [0, 2, 4], [1, 2, 3], [1, 2, 4]]);
        assert_eq!((mesh.len(), mesh.triangle_count()), (5, 4));
    }
}

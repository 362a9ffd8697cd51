//! Triangles and points in chunks, as the triangulation asks for them.

use std::ops::Range;
use std::sync::{Arc, Mutex};

use asphera_geometry::predicates::Place;
use asphera_geometry::{PointMm, VertexId};

use super::desk::Desk;
use super::pages::Pages;
use super::shelf::{Part, Shelf};
use crate::delaunay::{Cells, GHOST, Layout, Places, Side, Slot, Vertices, next_slots};

/// Triangles: the corners of each, and what lies across each of its sides.
pub(super) struct PagedCells<S, const BITS: u32> {
    pub(super) pages: Pages<u32, S, 6, BITS>,
    /// Places, and a triangle that was at each when it was inserted.
    landmarks: Vec<(Place, Slot)>,
    /// The first vertex to be a landmark again.
    next_landmark: VertexId,
}

/// Points.
pub(super) struct PagedPoints<S, const BITS: u32> {
    pub(super) pages: Pages<f64, S, 3, BITS>,
}

/// One vertex of so many is a landmark. A prime number, so that those of scan lines do not lie one
/// behind the other.
const LANDMARK_EVERY: VertexId = 1009;

impl<S: Shelf, const BITS: u32> PagedCells<S, BITS> {
    /// No triangles yet, of which `most` chunks are to be in memory.
    pub(super) fn new(desk: Arc<Mutex<Desk<S>>>, most: usize) -> PagedCells<S, BITS> {
        let pages = Pages::new(desk, Part::Triangles, [GHOST, GHOST, GHOST, 0, 0, 0], most);
        PagedCells { pages, landmarks: Vec::new(), next_landmark: 0 }
    }

    pub(super) fn memory_bytes(&self) -> usize {
        self.pages.memory_bytes() + self.landmarks.capacity() * size_of::<(Place, Slot)>()
    }

    /// The corners of all triangles.
    pub(super) fn corners_of(words: &[u32]) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        let corners = words.as_chunks::<6>().0.iter().map(|&[a, b, c, ..]| [a, b, c]);
        corners.filter(|corners| corners[2] != GHOST)
    }
}

impl<S: Shelf, const BITS: u32> Cells for PagedCells<S, BITS> {
    // Landmarks are all there is to fill a new table with. Four of them come to a cell in which there
    // are points, as the slack leaves three cells of four without.
    const HINTS: Layout =
        Layout { points_a_cell: LANDMARK_EVERY as usize, least_cells: 1, slack: Some(2.0) };

    fn len(&self) -> usize {
        self.pages.len()
    }

    fn grow(&mut self, count: usize) -> Range<Slot> {
        let slots = next_slots(self.pages.len(), count);
        self.pages.grow(count);
        slots
    }

    #[inline(always)]
    fn corners(&self, slot: Slot) -> [VertexId; 3] {
        self.pages.read(slot as usize, 0)
    }

    #[inline(always)]
    fn corner(&self, slot: Slot, index: usize) -> VertexId {
        let [corner] = self.pages.read(slot as usize, index);
        corner
    }

    #[inline(always)]
    fn across(&self, side: Side) -> Side {
        let [across] = self.pages.read(side.slot() as usize, 3 + side.index());
        Side::numbered(across)
    }

    #[inline(always)]
    fn write(&self, slot: Slot, [a, b, c]: [VertexId; 3], across: [Side; 3]) {
        let [p, q, r] = across.map(Side::number);
        self.pages.write(slot as usize, 0, [a, b, c, p, q, r]);
    }

    #[inline(always)]
    fn set_corner(&self, slot: Slot, index: usize, vertex: VertexId) {
        self.pages.write(slot as usize, index, [vertex]);
    }

    #[inline(always)]
    fn set_across(&self, side: Side, across: Side) {
        self.pages.write(side.slot() as usize, 3 + side.index(), [across.number()]);
    }

    fn note_landmarks(&mut self, places: &(impl Places + ?Sized), first: VertexId, slots: &[Slot]) {
        let end = first + slots.len() as VertexId;
        while self.next_landmark < end {
            let vertex = self.next_landmark.max(first);
            self.landmarks.push((places.place(vertex), slots[(vertex - first) as usize]));
            self.next_landmark = vertex + LANDMARK_EVERY;
        }
    }

    fn for_each_landmark(&self, _: &(impl Places + ?Sized), note: impl Fn(Place, Slot) + Sync) {
        self.landmarks.iter().for_each(|&(place, slot)| note(place, slot));
    }
}

impl<S: Shelf, const BITS: u32> PagedPoints<S, BITS> {
    /// No points yet, of which `most` chunks are to be in memory.
    pub(super) fn new(desk: Arc<Mutex<Desk<S>>>, most: usize) -> PagedPoints<S, BITS> {
        PagedPoints { pages: Pages::new(desk, Part::Points, [0.0; 3], most) }
    }

    /// Unwinds as [`Pages::read`].
    pub(super) fn point(&self, vertex: VertexId) -> PointMm {
        self.pages.read(vertex as usize, 0)
    }

    /// Adds points.
    pub(super) fn extend(&mut self, points: &[PointMm]) {
        let first = self.pages.len();
        self.pages.grow(points.len());
        for (index, &point) in points.iter().enumerate() {
            self.pages.write(first + index, 0, point);
        }
    }
}

impl<S: Shelf, const BITS: u32> Places for PagedPoints<S, BITS> {
    #[inline(always)]
    fn place(&self, vertex: VertexId) -> Place {
        self.pages.read(vertex as usize, 0)
    }
}

impl<S: Shelf, const BITS: u32> Vertices for PagedPoints<S, BITS> {
    type Places = PagedPoints<S, BITS>;

    fn places(&self) -> &PagedPoints<S, BITS> {
        self
    }

    fn count(&self) -> usize {
        self.pages.len()
    }

    fn copy(&mut self, from: VertexId, to: VertexId) {
        let point = self.point(from);
        self.pages.write(to as usize, 0, point);
    }

    fn shorten(&mut self, count: usize) {
        self.pages.shorten(count);
    }
}

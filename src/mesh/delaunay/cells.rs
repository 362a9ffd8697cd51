//! The triangles: the corners of each, and what lies across each of its sides.
//!
//! Across the hull lie ghosts: triangles with a corner at infinity, one for each side of the hull.
//! With them the triangles close to a sphere, every side has another one across, and n points make
//! exactly 2n - 2 triangles. A point more is two triangles more, whatever else changes.
//!
//! ```text
//!            corner i
//!              / \
//!   prev side /   \ next side         side i lies opposite corner i,
//!            /     \                  the triangle on its left
//!   corner i+1 ──▶ corner i+2
//!            side i
//! ```

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use asphera_geometry::VertexId;
use asphera_geometry::predicates::Place;
use rayon::prelude::*;

use super::hints::Layout;
use super::places::Places;
use crate::fetch::fetch;
use crate::room::make_room;

/// Which triangle: its index among the cells.
pub(crate) type Slot = u32;

/// The corner at infinity. A ghost has it last; a cell that was never used has it three times, and
/// one that is not used any more has it last, too.
pub(crate) const GHOST: VertexId = VertexId::MAX;

/// Cells there can be: a side is numbered with 32 bits, two of which tell which of the three it is.
pub(super) const MOST_CELLS: usize = 1 << 30;

/// One side of one triangle, seen from that triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Side(u32);

impl Side {
    /// Of no triangle; it stands where a side is not known yet.
    pub(super) const NONE: Side = Side(u32::MAX);

    /// As one number.
    pub(crate) fn number(self) -> u32 {
        self.0
    }

    /// The side of which [`Side::number`] is the number.
    pub(crate) fn numbered(number: u32) -> Side {
        Side(number)
    }

    pub(super) fn new(slot: Slot, index: usize) -> Side {
        Side(slot << 2 | index as u32)
    }

    pub(crate) fn slot(self) -> Slot {
        self.0 >> 2
    }

    /// Which corner it lies opposite to.
    pub(crate) fn index(self) -> usize {
        (self.0 & 3) as usize
    }

    /// The side that starts where this one ends.
    pub(super) fn next(self) -> Side {
        Side::new(self.slot(), NEXT[self.index()])
    }

    /// The side that ends where this one starts.
    pub(super) fn prev(self) -> Side {
        Side::new(self.slot(), PREV[self.index()])
    }
}

/// All triangles, wherever they are kept.
///
/// They are written through a shared reference: a triangle is changed while others are read.
pub(crate) trait Cells {
    /// How the table of hints is laid out.
    const HINTS: Layout;

    /// How many cells there are, unused ones included.
    fn len(&self) -> usize;

    /// Adds `count` unused cells and returns their slots.
    ///
    /// # Panics
    ///
    /// When there would be more than [`MOST_CELLS`].
    fn grow(&mut self, count: usize) -> Range<Slot>;

    /// Asks for the cell, which is read soon, if it may have to be waited for.
    #[inline(always)]
    fn fetch(&self, _slot: Slot) {}

    fn corners(&self, slot: Slot) -> [VertexId; 3];

    fn corner(&self, slot: Slot, index: usize) -> VertexId;

    /// Side of the triangle across it that is the same edge.
    fn across(&self, side: Side) -> Side;

    fn write(&self, slot: Slot, corners: [VertexId; 3], across: [Side; 3]);

    fn set_corner(&self, slot: Slot, index: usize, vertex: VertexId);

    /// Says what lies across `side`; the other way round is not touched.
    fn set_across(&self, side: Side, across: Side);

    /// Takes note of triangles at places that were inserted, for
    /// [`Cells::for_each_landmark`].
    fn note_landmarks(&mut self, places: &(impl Places + ?Sized), first: VertexId, slots: &[Slot]);

    /// Some places all over the triangulation, and a triangle at or near each.
    fn for_each_landmark(&self, places: &(impl Places + ?Sized), note: impl Fn(Place, Slot) + Sync);

    /// All triangles, if they lie in memory for any thread to work on.
    fn in_memory(&self) -> Option<&FlatCells> {
        None
    }

    /// Whether the triangle lies outside the hull, or is no triangle at all.
    #[inline(always)]
    fn is_ghost(&self, slot: Slot) -> bool {
        self.corner(slot, 2) == GHOST
    }

    /// Where the side ends, triangle on its left.
    #[inline(always)]
    fn end(&self, side: Side) -> VertexId {
        self.corner(side.slot(), PREV[side.index()])
    }

    /// The corner it lies opposite to.
    #[inline(always)]
    fn apex(&self, side: Side) -> VertexId {
        self.corner(side.slot(), side.index())
    }

    /// Makes two sides the two of one edge.
    #[inline(always)]
    fn join(&self, one: Side, other: Side) {
        self.set_across(one, other);
        self.set_across(other, one);
    }
}

/// The slots of `count` cells more, after `len` there are.
///
/// # Panics
///
/// When there would be more than [`MOST_CELLS`].
pub(crate) fn next_slots(len: usize, count: usize) -> Range<Slot> {
    assert!(len + count <= MOST_CELLS, "a mesh has at most {} vertices", MOST_CELLS / 2);
    len as Slot..(len + count) as Slot
}

/// Triangles in memory, one after the other.
///
/// The words are atomic so that two threads may work on different parts of one triangulation; which
/// parts those are is for the callers to settle. Alone they cost nothing: every access is relaxed.
///
/// Of every [`CHUNK`] of them the last moment is kept at which a corner of one was written, so that
/// what is known of all triangles can be kept current by looking again at those alone.
#[derive(Default)]
pub(crate) struct FlatCells {
    cells: Vec<Cell>,
    /// When each chunk was written last.
    written: Vec<AtomicU32>,
    now: u32,
}

/// Fewer cells are not worth a second thread.
const FOR_TWO: usize = 16_384;

/// How many cells one after the other share the moment of their last change.
const CHUNK: usize = 1024;

/// One triangle.
struct Cell {
    corners: [AtomicU32; 3],
    across: [AtomicU32; 3],
}

impl Cell {
    fn unused() -> Cell {
        Cell { corners: [const { AtomicU32::new(GHOST) }; 3], across: Default::default() }
    }
}

impl FlatCells {
    /// Starts another moment: what is written from now on was not written before.
    pub(crate) fn advance(&mut self) {
        self.now += 1;
    }

    /// The present moment.
    pub(crate) fn now(&self) -> u32 {
        self.now
    }

    /// When each chunk was written last.
    pub(crate) fn written(&self) -> impl ExactSizeIterator<Item = u32> + '_ {
        self.written.iter().map(|moment| moment.load(RELAXED))
    }

    /// The triangles of a chunk.
    pub(crate) fn triangles_of(&self, chunk: usize) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        let end = self.cells.len().min((chunk + 1) * CHUNK);
        let slots = chunk * CHUNK..end;
        slots.map(|slot| self.corners(slot as Slot)).filter(|corners| corners[2] != GHOST)
    }

    #[inline(always)]
    fn note_written(&self, slot: Slot) {
        self.written[slot as usize / CHUNK].store(self.now, RELAXED);
    }
}

impl Cells for FlatCells {
    // A quarter of that when it is refined.
    const HINTS: Layout = Layout { points_a_cell: 4, least_cells: 1024, slack: None };

    fn len(&self) -> usize {
        self.cells.len()
    }

    fn grow(&mut self, count: usize) -> Range<Slot> {
        let first = self.cells.len();
        let slots = next_slots(first, count);
        make_room(&mut self.cells, count);
        if count < FOR_TWO {
            self.cells.resize_with(first + count, Cell::unused);
        } else {
            // Much of the time goes into the system's handing out of the memory.
            let unused = (0..count).into_par_iter().with_min_len(FOR_TWO / 2);
            self.cells.par_extend(unused.map(|_| Cell::unused()));
        }
        self.written.resize_with((first + count).div_ceil(CHUNK), || AtomicU32::new(self.now));
        slots
    }

    /// At both ends, as it may lie in two lines of the cache.
    #[inline(always)]
    fn fetch(&self, slot: Slot) {
        if let Some(Cell { corners, across }) = self.cells.get(slot as usize) {
            fetch(&corners[0], |word| word.load(RELAXED));
            fetch(&across[2], |word| word.load(RELAXED));
        }
    }

    #[inline(always)]
    fn corners(&self, slot: Slot) -> [VertexId; 3] {
        let [a, b, c] = &self.cells[slot as usize].corners;
        [a.load(RELAXED), b.load(RELAXED), c.load(RELAXED)]
    }

    #[inline(always)]
    fn corner(&self, slot: Slot, index: usize) -> VertexId {
        self.cells[slot as usize].corners[index].load(RELAXED)
    }

    #[inline(always)]
    fn across(&self, side: Side) -> Side {
        Side(self.cells[side.slot() as usize].across[side.index()].load(RELAXED))
    }

    #[inline(always)]
    fn write(&self, slot: Slot, corners: [VertexId; 3], across: [Side; 3]) {
        self.note_written(slot);
        let cell = &self.cells[slot as usize];
        for i in 0..3 {
            cell.corners[i].store(corners[i], RELAXED);
            cell.across[i].store(across[i].0, RELAXED);
        }
    }

    #[inline(always)]
    fn set_corner(&self, slot: Slot, index: usize, vertex: VertexId) {
        self.note_written(slot);
        self.cells[slot as usize].corners[index].store(vertex, RELAXED);
    }

    #[inline(always)]
    fn set_across(&self, side: Side, across: Side) {
        self.cells[side.slot() as usize].across[side.index()].store(across.0, RELAXED);
    }

    fn in_memory(&self) -> Option<&FlatCells> {
        Some(self)
    }

    /// All are at hand.
    fn note_landmarks(&mut self, _: &(impl Places + ?Sized), _: VertexId, _: &[Slot]) {}

    fn for_each_landmark(
        &self,
        places: &(impl Places + ?Sized),
        note: impl Fn(Place, Slot) + Sync,
    ) {
        // Two triangles to a point: every fourth makes for one in a cell of the table, or two.
        let fourths = 0..self.len() as Slot / 4;
        let triangle = |fourth: Slot| {
            let [corner, _, last] = self.corners(4 * fourth);
            (last != GHOST).then_some((corner, 4 * fourth))
        };
        match places.in_memory() {
            Some(points) => fourths
                .into_par_iter()
                .with_min_len(FOR_TWO / 4)
                .filter_map(triangle)
                .for_each(|(corner, slot)| note(points.place(corner), slot)),
            None => fourths
                .filter_map(triangle)
                .for_each(|(corner, slot)| note(places.place(corner), slot)),
        }
    }
}

/// 0, 1, 2 in turn, and back.
pub(super) const NEXT: [usize; 3] = [1, 2, 0];
pub(super) const PREV: [usize; 3] = [2, 0, 1];

const RELAXED: Ordering = Ordering::Relaxed;

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

use std::sync::atomic::{AtomicU32, Ordering};

use crate::VertexId;

/// Which triangle: its index among the cells.
pub(super) type Slot = u32;

/// The corner at infinity. A ghost has it last; a cell that was never used has it three times, and
/// one that is not used any more has it last, too.
pub(super) const GHOST: VertexId = VertexId::MAX;

/// Cells there can be: a side is numbered with 32 bits, two of which tell which of the three it is.
pub(super) const MOST_CELLS: usize = 1 << 30;

/// One side of one triangle, seen from that triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side(u32);

impl Side {
    /// Of no triangle; it stands where a side is not known yet.
    pub(super) const NONE: Side = Side(u32::MAX);

    pub(super) fn new(slot: Slot, index: usize) -> Side {
        Side(slot << 2 | index as u32)
    }

    pub(super) fn slot(self) -> Slot {
        self.0 >> 2
    }

    /// Which corner it lies opposite to.
    pub(super) fn index(self) -> usize {
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

/// All triangles.
///
/// The words are atomic so that two threads may work on different parts of one triangulation; which
/// parts those are is for the callers to settle. Alone they cost nothing: every access is relaxed.
#[derive(Default)]
pub(super) struct Cells(Vec<Cell>);

/// One triangle.
#[derive(Default)]
struct Cell {
    corners: [AtomicU32; 3],
    across: [AtomicU32; 3],
}

impl Cells {
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// Adds `count` unused cells and returns their slots.
    ///
    /// # Panics
    ///
    /// When there would be more than [`MOST_CELLS`].
    pub(super) fn grow(&mut self, count: usize) -> std::ops::Range<Slot> {
        let first = self.0.len();
        assert!(first + count <= MOST_CELLS, "a mesh has at most {} vertices", MOST_CELLS / 2);
        if self.0.capacity() < first + count {
            // By half, not twice: what is kept for points to come is lost to others.
            self.0.reserve_exact(count.max(first / 2));
        }
        self.0.resize_with(first + count, || Cell {
            corners: [const { AtomicU32::new(GHOST) }; 3],
            across: Default::default(),
        });
        first as Slot..(first + count) as Slot
    }

    #[inline(always)]
    pub(super) fn corners(&self, slot: Slot) -> [VertexId; 3] {
        let [a, b, c] = &self.0[slot as usize].corners;
        [a.load(RELAXED), b.load(RELAXED), c.load(RELAXED)]
    }

    #[inline(always)]
    pub(super) fn corner(&self, slot: Slot, index: usize) -> VertexId {
        self.0[slot as usize].corners[index].load(RELAXED)
    }

    /// Whether the triangle lies outside the hull, or is no triangle at all.
    #[inline(always)]
    pub(super) fn is_ghost(&self, slot: Slot) -> bool {
        self.corner(slot, 2) == GHOST
    }

    /// The same side, seen from the triangle across it.
    #[inline(always)]
    pub(super) fn across(&self, side: Side) -> Side {
        Side(self.0[side.slot() as usize].across[side.index()].load(RELAXED))
    }

    /// Where the side ends, triangle on its left.
    pub(super) fn end(&self, side: Side) -> VertexId {
        self.corner(side.slot(), PREV[side.index()])
    }

    /// The corner it lies opposite to.
    pub(super) fn apex(&self, side: Side) -> VertexId {
        self.corner(side.slot(), side.index())
    }

    #[inline(always)]
    pub(super) fn write(&self, slot: Slot, corners: [VertexId; 3], across: [Side; 3]) {
        let cell = &self.0[slot as usize];
        for i in 0..3 {
            cell.corners[i].store(corners[i], RELAXED);
            cell.across[i].store(across[i].0, RELAXED);
        }
    }

    #[inline(always)]
    pub(super) fn set_corner(&self, slot: Slot, index: usize, vertex: VertexId) {
        self.0[slot as usize].corners[index].store(vertex, RELAXED);
    }

    /// Says what lies across `side`; the other way round is not touched.
    #[inline(always)]
    pub(super) fn set_across(&self, side: Side, across: Side) {
        self.0[side.slot() as usize].across[side.index()].store(across.0, RELAXED);
    }

    /// Makes two sides the two of one edge.
    #[inline(always)]
    pub(super) fn join(&self, one: Side, other: Side) {
        self.set_across(one, other);
        self.set_across(other, one);
    }
}

/// 0, 1, 2 in turn, and back.
pub(super) const NEXT: [usize; 3] = [1, 2, 0];
pub(super) const PREV: [usize; 3] = [2, 0, 1];

const RELAXED: Ordering = Ordering::Relaxed;

//! Two blocks of a batch, meshed at the same time and joined along a seam that both have.
//!
//! The seam is a line of points of the batch ([`seam`](super::seam)). The first block ends with it and goes
//! on in the triangulation there is; the second begins with it and makes a triangulation of its own, its
//! triangles among the same cells. Then each loses what lies beyond the seam, and what is left of both is
//! joined edge by edge:
//!
//! ```text
//!        first block             second block                both
//!
//!      s0 ─── s1 ─── s2              r0 ─ r1 ─ r2          r0 ─ r1 ─ r2
//!       │  ╱   │  ╱   │               │  ╱ │  ╱ │           │  ╱ │  ╱ │
//!      a0 ─── a1 ─── a2              s0 ─ s1 ─ s2          s0 ─ s1 ─ s2
//!                                                           │  ╱ │  ╱ │
//!                                                          a0 ─ a1 ─ a2
//! ```
//!
//! **Why the result is right.** With the corner at infinity a triangulation closes to a sphere. On it the
//! seam is a closed line: around from its last point to its first or, of an open one, through
//! infinity. If all its edges are edges of both triangulations, and no other vertex of either lies beyond
//! it, then what is left of the two has all vertices, and its triangles do not overlap:
//!
//! - *Closed.* The seam is a simple polygon, as its edges are edges of a triangulation. One part fills it,
//!   the other what is around.
//! - *Open.* The ends of the seam lie on the hulls of both. Beyond the seam the hull of the first block has vertices of
//!   the seam alone, so all of the first block lies on one side of each of those sides; the second block
//!   likewise, on the other side of the seam's own hull. Inside the seam's hull the seam itself parts them, and
//!   outside a place that belongs to one lies beyond a side of the other, or on the line of a straight seam:
//!   so that line may be led on by one of the two only. The outline can turn right
//!   only at the two ends of the seam, between two convex lines: there the hull is closed as beside a strip
//!   (`hull.rs`).
//!
//! From any triangulation of a convex region flips lead to that of Delaunay; they start at the seam, as all
//! else is Delaunay already.
//!
//! Where a condition does not hold (lines that cross, a point of one block in the place of one of the other), the second
//! triangulation is thrown away and its points are inserted after the others. That costs no more time than one
//! thread would have taken.
//!
//! A second block all around its seam would first fill the seam: of points on one circle, as a ring has them, that
//! is one near tie after the other. So a closed seam has a hub there, any point of the first block: with it the
//! ring makes a star, which goes with all else beyond the seam.

#[cfg(test)]
mod tests;

use std::collections::HashSet;
use std::hash::{BuildHasherDefault, Hasher};
use std::ops::Range;

use asphera_geometry::predicates::{by_x_then_y, orientation};
use asphera_geometry::{PointMm, VertexId, place};

use super::cells::{Cells, FlatCells, GHOST, Side, Slot};
use super::editor::Editor;
use super::places::Places;
use super::sheet::Sheet;

/// Where two blocks of a batch meet.
pub(super) struct Blocks {
    /// The whole batch.
    pub(super) batch: Range<VertexId>,
    /// The seam: the last points of the first block and the first of the second.
    pub(super) seam: Range<VertexId>,
    /// Whether the seam leads around.
    pub(super) closed: bool,
}

impl Blocks {
    /// Points left when only the first block is inserted.
    pub(super) fn rest(&self) -> Range<VertexId> {
        self.seam.end..self.batch.end
    }

    /// How many cells the second block may take.
    pub(super) fn second_cells(&self) -> usize {
        2 * (self.second().len() + 1)
    }

    /// The first block, with the seam.
    pub(super) fn first(&self) -> Range<VertexId> {
        self.batch.start..self.seam.end
    }

    fn second(&self) -> Range<VertexId> {
        self.seam.start..self.batch.end
    }

    fn hub(&self) -> Option<VertexId> {
        self.closed.then_some(self.batch.start)
    }

    /// The vertices of the seam, and through which it leads on from the last to the first.
    fn around(&self) -> impl Iterator<Item = VertexId> + '_ {
        self.seam.clone().chain((!self.closed).then_some(GHOST))
    }

    /// Whether an edge between two vertices of the seam belongs to it.
    fn has_edge(&self, one: VertexId, other: VertexId) -> bool {
        let (low, high) = (one.min(other), one.max(other));
        let (first, last) = (self.seam.start, self.seam.end - 1);
        match high {
            GHOST => !self.closed && (low == first || low == last),
            _ => high - low == 1 || self.closed && (low, high) == (first, last),
        }
    }
}

/// One of the two triangulations, seen from the seam.
struct Flank {
    /// Whether what goes lies on the left of the seam.
    goes_left: bool,
    /// Triangles and ghosts that go.
    goes: Vec<Slot>,
    /// The sides along the seam that stay.
    stays: Vec<Side>,
}

impl Sheet {
    /// Inserts a batch as two blocks, by two threads if there are two; `fresh` are cells no one knows of, for
    /// the second. False if the blocks could not be joined: then only the first is inserted, and the cells
    /// are spare.
    pub(super) fn insert_blocks(
        &mut self,
        points: &[PointMm],
        cells: &FlatCells,
        blocks: &Blocks,
        fresh: Range<Slot>,
    ) -> bool {
        let mut other = self.beside();
        let had_hints = self.plane.as_ref().is_some_and(|plane| plane.hints.get().is_some());
        self.shares_cells = true;
        let (one, two) = rayon::join(
            || {
                self.insert(points, cells, blocks.first());
                self.flank(points, cells, blocks, blocks.first(), None)
            },
            || {
                other.work.spare.extend(fresh.clone());
                if let Some(hub) = blocks.hub() {
                    other.insert(points, cells, hub..hub + 1);
                }
                other.insert(points, cells, blocks.second());
                other.flank(points, cells, blocks, blocks.second(), blocks.hub())
            },
        );
        self.shares_cells = false;
        if let Some(plane) = &mut self.plane
            && !had_hints
        {
            // If there are any now, they name none of the older triangles.
            plane.hints.take();
        }
        let editor = Editor { points, cells, work: &mut self.work };
        if let (Some(one), Some(two)) = (one, two)
            && one.goes_left != two.goes_left
            && (blocks.closed || editor.are_apart(&one, &two))
        {
            self.absorb(points, cells, blocks, other, [one, two]);
            return true;
        }
        for slot in fresh {
            cells.write(slot, [GHOST; 3], [Side::NONE; 3]);
            self.work.spare.push(slot);
        }
        false
    }

    /// What goes and what stays of this triangulation, if nothing stands against it.
    fn flank(
        &mut self,
        points: &[PointMm],
        cells: &FlatCells,
        blocks: &Blocks,
        block: Range<VertexId>,
        hub: Option<VertexId>,
    ) -> Option<Flank> {
        // A point in the place of the hub would be told to stand where a point of the other block does.
        if hub.is_some_and(|hub| self.duplicates.iter().any(|duplicate| duplicate.of == hub)) {
            return None;
        }
        let recent = self.plane.as_ref()?.recent;
        // There is none at those that were inserted while all lay on one line.
        let from_end = (block.end - 1 - blocks.seam.start) as usize;
        let from = self.slots.iter().rev().nth(from_end).copied().unwrap_or(recent);
        let editor = Editor { points, cells, work: &mut self.work };
        let left = editor.along(blocks, from)?;
        let right: Vec<Side> = left.iter().map(|&side| cells.across(side)).collect();
        let beyond = |sides: &[Side]| editor.beyond(blocks, sides, hub);
        match beyond(&left) {
            Some(goes) => Some(Flank { goes_left: true, goes, stays: right }),
            None => Some(Flank { goes_left: false, goes: beyond(&right)?, stays: left }),
        }
    }

    /// Takes over the triangulation of the second block.
    fn absorb(
        &mut self,
        points: &[PointMm],
        cells: &FlatCells,
        blocks: &Blocks,
        other: Sheet,
        flanks: [Flank; 2],
    ) {
        let (Some(plane), Some(second)) = (&mut self.plane, other.plane) else { return };
        let duplicates = other.duplicates.len();
        self.vertices += (blocks.batch.end - blocks.seam.end) as usize - duplicates;
        self.duplicates.extend(other.duplicates);
        (plane.recent, plane.run_start) = (second.recent, second.run_start);
        if let Some(hints) = plane.hints.get_mut() {
            hints.expect((blocks.batch.end - blocks.seam.end) as usize, other.extent);
            let first = blocks.batch.end - other.slots.len() as VertexId;
            for (vertex, &slot) in (first..).zip(&other.slots) {
                if vertex >= blocks.seam.end {
                    hints.note(place(points[vertex as usize]), slot);
                }
            }
        }
        self.extent.join(&other.extent);
        self.slots = other.slots;
        self.work.ghosts += other.work.ghosts;
        self.work.spare.extend(other.work.spare);
        self.work.strip = other.work.strip;
        Editor { points, cells, work: &mut self.work }.join_flanks(blocks, flanks);
    }
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// The sides along the seam, all around, that lie on its left; `None` if it lacks an edge.
    fn along(&self, blocks: &Blocks, from: Slot) -> Option<Vec<Side>> {
        let start = blocks.seam.start;
        let home = self.locate(self.at(start), from);
        let index = self.cells.corners(home).iter().position(|&corner| corner == start)?;
        let first = Side::new(home, index).prev();
        let to = |spoke: Side, vertex: VertexId| {
            self.spokes(spoke).find(|&side| self.cells.end(side) == vertex)
        };
        let mut spoke = first;
        let mut left = Vec::with_capacity(blocks.seam.len() + 1);
        for vertex in blocks.around().skip(1) {
            let side = to(spoke, vertex)?;
            left.push(side);
            spoke = self.cells.across(side);
        }
        // Infinity has no spokes to look through: the last edge is found from the first vertex.
        let last = blocks.around().last()?;
        left.push(self.cells.across(to(first, last)?));
        Some(left)
    }

    /// All triangles and ghosts beyond the seam, given the sides along it over there; `None` if one
    /// has a corner that is neither infinity, the hub nor of the seam.
    fn beyond(&self, blocks: &Blocks, sides: &[Side], hub: Option<VertexId>) -> Option<Vec<Slot>> {
        let mut goes = Vec::with_capacity(2 * sides.len());
        let mut seen = HashSet::with_capacity_and_hasher(2 * sides.len(), BySlot::default());
        let mut open: Vec<Slot> = sides.iter().map(|side| side.slot()).collect();
        while let Some(slot) = open.pop() {
            if !seen.insert(slot) {
                continue;
            }
            let corners = self.cells.corners(slot);
            let may_go = |&corner: &VertexId| {
                corner == GHOST || Some(corner) == hub || blocks.seam.contains(&corner)
            };
            if !corners.iter().all(may_go) {
                return None;
            }
            goes.push(slot);
            for side in [0, 1, 2].map(|index| Side::new(slot, index)) {
                let across = self.cells.across(side);
                if !blocks.has_edge(self.cells.end(side), self.cells.end(across)) {
                    open.push(across.slot());
                }
            }
        }
        Some(goes)
    }

    /// Whether the hulls of two triangulations lead apart from both ends of an open seam.
    fn are_apart(&self, one: &Flank, two: &Flank) -> bool {
        // The last two edges of the seam lead to infinity: there lie ghosts.
        let ends = one.stays.iter().zip(&two.stays).rev().take(2);
        ends.map(|(&side, &other)| [side, other]).all(|sides| {
            let vertices = sides.map(|side| {
                let [end, start, _] = self.cells.corners(side.slot());
                // Of the side after the hull's that is the end, of the one before it the start.
                if side.index() == 1 { [end, start] } else { [start, end] }
            });
            let [[end, along_one], [_, along_two]] =
                vertices.map(|pair| pair.map(|at| self.at(at)));
            orientation(along_one, end, along_two).is_ne()
                || by_x_then_y(along_one, end) != by_x_then_y(along_two, end)
        })
    }

    /// Joins what stays of two triangulations, and makes the whole Delaunay.
    fn join_flanks(&mut self, blocks: &Blocks, [one, two]: [Flank; 2]) {
        let kept = one.stays[0].slot();
        for slot in one.goes.into_iter().chain(two.goes) {
            self.work.ghosts -= usize::from(self.cells.is_ghost(slot));
            // Hints may name it still: as a ghost of no length it leads on. The first vertex has a
            // place whatever becomes of the duplicates of the batch.
            self.cells.write(slot, [0, 0, GHOST], [Side::new(kept, 0); 3]);
            self.work.spare.push(slot);
        }
        for (&side, &other) in one.stays.iter().zip(&two.stays) {
            self.cells.join(side, other);
            self.work.suspects.push(side);
        }
        if !blocks.closed {
            // The last two edges lead to infinity. The ghost that has its side of the hull before that
            // corner has infinity after it.
            let edges = one.stays.iter().zip(&two.stays).rev().take(2);
            let ghosts: Vec<Slot> = edges
                .map(|(&side, &other)| if side.index() == 1 { side.slot() } else { other.slot() })
                .collect();
            for ghost in ghosts {
                self.close_corner(ghost);
            }
        }
        self.legalize();
    }
}

/// Slots are numbers nobody chooses to do harm: a product tells them apart.
type BySlot = BuildHasherDefault<SlotHasher>;

#[derive(Default)]
struct SlotHasher(u64);

impl Hasher for SlotHasher {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u32(self.0 as u32 ^ u32::from(byte));
        }
    }

    fn write_u32(&mut self, slot: u32) {
        // An odd number: as many different products as slots, the upper bits as well mixed.
        self.0 = u64::from(slot).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

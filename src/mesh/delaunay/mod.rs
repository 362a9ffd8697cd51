//! Incremental Delaunay triangulation of places in the plane.
//!
//! After each batch the triangulation is that of all places so far, convex hull included. Where more
//! than three lie on one circle with none inside, [`encloses`](asphera_geometry::predicates::encloses) decides by
//! their coordinates, so the triangulation is the same in whatever order and batches they came.
//!
//! Scans are what it is made for: a batch is cut into runs along lines, also of lines that arrive by turns ([`runs`]); a run that lies outside
//! the hull, as the next line of a growing scan does, is sewn to it as a whole ([`strip`]); all
//! else is inserted point by point ([`insert`]), runs ends first and then by bisection, and points in no
//! order in rounds, each four times as long as those before it, by the places they belong to (`scattered.rs`). Where runs
//! tear down too much, as along an outline that is traced, the rest of the batch goes in in rounds, too. A large batch of lines
//! is meshed as two [`blocks`] at the same time. Vertices go one by one ([`remove`]).

mod ahead;
mod blocks;
mod cells;
mod editor;
mod fan;
mod halves;
mod hints;
mod hull;
mod insert;
mod line;
mod natural;
mod numbering;
mod places;
mod queries;
mod remove;
mod runs;
mod scattered;
mod seam;
mod sheet;
#[cfg(test)]
mod soundness;
mod star;
mod strip;
mod wide;

use std::ops::Range;

use asphera_geometry::VertexId;

use self::blocks::Blocks;
pub(crate) use self::cells::{Cells, FlatCells, GHOST, Side, Slot, next_slots};
use self::hints::Hints;
pub(crate) use self::hints::Layout;
pub(crate) use self::places::{Places, Vertices};
pub use self::queries::About;
pub(crate) use self::queries::Conflict;
use self::seam::{Seam, seam};
#[cfg(any(test, feature = "fuzzing"))]
use self::sheet::ForTwo;
use self::sheet::Sheet;

/// A growing Delaunay triangulation.
#[derive(Default)]
pub(crate) struct Delaunay<C = FlatCells> {
    cells: C,
    sheet: Sheet,
}

/// A point that stands where another does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Duplicate {
    pub(crate) point: VertexId,
    pub(crate) of: VertexId,
}

impl<C: Cells> Delaunay<C> {
    /// Inserts the points `batch`, the last ones of `points`, all admitted (see
    /// [`asphera_geometry::admit`]).
    ///
    /// Returns whether some stand where another does: they are no vertices, and the caller takes them
    /// out of `points` by [`Delaunay::close_gaps`] before anything else.
    pub(crate) fn insert(
        &mut self,
        points: &(impl Places + ?Sized),
        batch: Range<VertexId>,
    ) -> bool {
        let sheet = &mut self.sheet;
        sheet.duplicates.clear();
        let blocks = self.blocks(points, &batch);
        let sheet = &mut self.sheet;
        let first = blocks.as_ref().map_or(batch.clone(), Blocks::first);
        // What duplicates and removed vertices left is taken first. It may be named still: the second
        // of two blocks gets cells that are new.
        let wanted = 2 * (sheet.vertices + first.len());
        let missing = wanted.saturating_sub(self.cells.len());
        let mut new = self.cells.grow(missing + blocks.as_ref().map_or(0, Blocks::second_cells));
        sheet.work.spare.extend(new.by_ref().take(missing));
        match (blocks, points.in_memory(), self.cells.in_memory()) {
            (Some(blocks), Some(points), Some(cells)) => {
                if !sheet.insert_blocks(points, cells, &blocks, new) {
                    sheet.insert(points, cells, blocks.rest());
                }
            }
            _ => sheet.insert(points, &self.cells, batch.clone()),
        }
        if !sheet.slots.is_empty() {
            let first = batch.end - sheet.slots.len() as VertexId;
            self.cells.note_landmarks(points, first, &sheet.slots);
        }
        !sheet.duplicates.is_empty()
    }

    /// The blocks to insert a batch as, if two threads can share it.
    fn blocks(&self, points: &(impl Places + ?Sized), batch: &Range<VertexId>) -> Option<Blocks> {
        let in_memory = points.in_memory().is_some() && self.cells.in_memory().is_some();
        if batch.len() < self.sheet.for_two.lines || !in_memory || rayon::current_num_threads() < 2
        {
            return None;
        }
        let place = |index: usize| points.place(batch.start + index as VertexId);
        let Seam { points: seam, closed } = seam(batch.len(), place)?;
        let [start, end] = [seam.start, seam.end].map(|index| batch.start + index as VertexId);
        Some(Blocks { batch: batch.clone(), seam: start..end, closed })
    }

    /// No triangles yet, to be kept in `cells`, which has none.
    pub(crate) fn kept_in(cells: C) -> Delaunay<C> {
        Delaunay { cells, sheet: Sheet::default() }
    }

    /// Lets two threads share batches of so many points, however little that pays.
    #[cfg(any(test, feature = "fuzzing"))]
    pub(crate) fn share_from(&mut self, points: usize) {
        self.sheet.for_two = ForTwo { lines: points, scattered: points };
    }

    /// Where its triangles are kept.
    pub(crate) fn cells(&self) -> &C {
        &self.cells
    }

    /// Counterpart to be put in order between batches.
    pub(crate) fn cells_mut(&mut self) -> &mut C {
        &mut self.cells
    }

    /// Bytes of memory it takes besides that of the cells, as long as there are triangles.
    pub(crate) fn other_bytes(&self) -> usize {
        let hints = self.sheet.plane.as_ref().and_then(|plane| plane.hints.get());
        hints.map_or(0, Hints::bytes)
            + size_of_val(&self.sheet.slots[..])
            + size_of_val(&self.sheet.work.spare[..])
            + self.sheet.work.wide.bytes()
    }

    /// Work of all insertions so far: triangles torn down, sides flipped, and steps gone on long walks.
    #[cfg(test)]
    pub(crate) fn effort(&self) -> usize {
        self.sheet.work.effort
    }

    /// How many triangles there are.
    pub(crate) fn triangle_count(&self) -> usize {
        if self.sheet.plane.is_some() {
            2 * self.sheet.vertices - 2 - self.sheet.work.ghosts
        } else {
            0
        }
    }

    /// The triangles counter-clockwise, in an order that means nothing.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        (0..self.cells.len() as Slot)
            .map(|slot| self.cells.corners(slot))
            .filter(|corners| corners[2] != GHOST)
    }

    /// Takes the triangles about a vertex for written.
    pub(crate) fn touch(&mut self, points: &(impl Places + ?Sized), vertex: VertexId) {
        self.rename(points, [vertex; 2], None);
    }
}

//! One triangulation that grows, its triangles among cells that another may share.

use std::ops::Range;

use super::Duplicate;
use super::cells::{Cells, Slot};
use super::editor::{Editor, Work};
use super::hints::Hints;
use super::insert::Placed;
use super::line::Line;
use super::places::Places;
use super::runs::{Run, runs};
use crate::VertexId;
use crate::exact::Place;
use crate::order::by_bisection;

/// A growing triangulation, but for its cells.
#[derive(Default)]
pub(super) struct Sheet {
    pub(super) work: Work,
    /// The places, while all lie on one line.
    pub(super) line: Line,
    /// Once there are triangles.
    pub(super) plane: Option<Plane>,
    /// How many different places there are.
    pub(super) vertices: usize,
    runs: Vec<Run>,
    /// A triangle at each of the last points of the batch, those before it had any left out.
    pub(super) slots: Vec<Slot>,
    pub(super) duplicates: Vec<Duplicate>,
}

/// Where insertions start from.
pub(super) struct Plane {
    /// A triangle at the place inserted last.
    pub(super) recent: Slot,
    /// A triangle at the start of the last run: the next line of a scan in one direction starts there.
    pub(super) run_start: Slot,
    pub(super) hints: Hints,
}

impl Sheet {
    /// Inserts the points `batch`. There must be two spare cells for each, and for each vertex there is
    /// as long as all lie on one line.
    pub(super) fn insert(
        &mut self,
        points: &(impl Places + ?Sized),
        cells: &impl Cells,
        batch: Range<VertexId>,
    ) {
        let duplicates = self.duplicates.len();
        let mut rest = batch.clone();
        while self.plane.is_none()
            && let Some(vertex) = rest.next()
        {
            self.insert_on_line(points, cells, vertex);
        }
        self.slots.clear();
        if !rest.is_empty() {
            self.insert_in_plane(points, cells, rest);
        }
        self.vertices += batch.len() - (self.duplicates.len() - duplicates);
    }

    fn insert_on_line<C: Cells>(
        &mut self,
        points: &(impl Places + ?Sized),
        cells: &C,
        vertex: VertexId,
    ) {
        let place = points.place(vertex);
        if self.line.contains(place) {
            let there = self.line.insert(place, vertex);
            if there != vertex {
                self.duplicates.push(Duplicate { point: vertex, of: there });
            }
            return;
        }
        let slot = self.line.span(points, vertex, cells, &mut self.work.spare);
        // A ghost at each place of the line, but for its two ends and with the vertex off it.
        self.work.ghosts = self.line.len() + 1;
        let mut hints = Hints::new(0, place, place, C::HINTS);
        hints.note(place, slot);
        self.plane = Some(Plane { recent: slot, run_start: slot, hints });
        self.line = Line::default();
    }

    fn insert_in_plane(
        &mut self,
        points: &(impl Places + ?Sized),
        cells: &impl Cells,
        batch: Range<VertexId>,
    ) {
        let Some(plane) = &mut self.plane else { return };
        runs(batch.clone().map(|vertex| points.place(vertex)), &mut self.runs);
        self.slots.resize(batch.len(), plane.recent);
        let mut inserter = Inserter {
            editor: Editor { points, cells, work: &mut self.work },
            plane,
            first: batch.start,
            slots: &mut self.slots,
            duplicates: &mut self.duplicates,
        };
        if self.runs.len() > batch.len() / SCATTERED {
            inserter.insert_scattered();
        } else {
            for run in &self.runs {
                inserter.insert_run(run);
            }
        }
    }
}

/// Inserts one batch.
pub(super) struct Inserter<'a, P: ?Sized, C> {
    pub(super) editor: Editor<'a, P, C>,
    pub(super) plane: &'a mut Plane,
    /// The first point of the batch.
    pub(super) first: VertexId,
    /// A triangle at each point of the batch, once inserted.
    pub(super) slots: &'a mut [Slot],
    pub(super) duplicates: &'a mut Vec<Duplicate>,
}

impl<P: Places + ?Sized, C: Cells> Inserter<'_, P, C> {
    fn insert_run(&mut self, run: &Run) {
        let Range { start, end } = run.points;
        let mut from = self.nearest(start);
        let mut done = 0;
        if let Some(axis) = run.axis {
            // Where the first points lie inside the hull, the rest may still lie outside.
            while done < SKIPPED && start + done + 1 < end {
                let [first, last] = [start + done, end].map(|index| self.first + index as VertexId);
                if self.editor.insert_strip(first..last, axis, from) {
                    self.slots[start + done..end].copy_from_slice(self.editor.strip_slots());
                    done = end - start;
                } else {
                    from = self.insert(start + done, from);
                    done += 1;
                }
            }
        }
        for step in by_bisection(end - start - done) {
            let from = step.near.map_or(from, |near| self.slots[start + done + near]);
            self.insert(start + done + step.index, from);
        }
        self.plane.run_start = self.slots[start];
        self.plane.recent = self.slots[end - 1];
        for index in start..end {
            self.plane.hints.note(self.place(index), self.slots[index]);
        }
    }

    /// Inserts a point of the batch from a triangle; returns one at the point.
    pub(super) fn insert(&mut self, index: usize, from: Slot) -> Slot {
        let point = self.first + index as VertexId;
        let slot = match self.editor.insert(point, from) {
            Placed::New(slot) => slot,
            Placed::Occupied(of, slot) => {
                self.duplicates.push(Duplicate { point, of });
                slot
            }
        };
        self.slots[index] = slot;
        slot
    }

    /// The nearest known triangle to a point of the batch.
    fn nearest(&self, index: usize) -> Slot {
        let place = self.place(index);
        let distance = |slot: &Slot| {
            let [x, y] = self.editor.at(self.editor.cells.corner(*slot, 0));
            (x - place[0]).hypot(y - place[1])
        };
        let known =
            [Some(self.plane.recent), Some(self.plane.run_start), self.plane.hints.near(place)];
        let nearest =
            known.into_iter().flatten().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.unwrap_or(self.plane.recent)
    }

    pub(super) fn place(&self, index: usize) -> Place {
        self.editor.at(self.first + index as VertexId)
    }
}

/// Batches of which more than one point in so many starts a run follow no line.
pub(super) const SCATTERED: usize = 8;

/// How many points of a run are inserted alone before it is not tried as a strip any more.
const SKIPPED: usize = 3;

//! One triangulation that grows, its triangles among cells that another may share.

use std::ops::Range;
use std::sync::OnceLock;

use asphera_geometry::predicates::Place;
use asphera_geometry::{BoundsMm, VertexId};

use super::Duplicate;
use super::cells::{Cells, Slot};
use super::editor::{Editor, Work};
use super::hints::Hints;
use super::insert::Placed;
use super::line::Line;
use super::places::Places;
use super::runs::{Run, SCATTERED, Track, runs, runs_by_turns};
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
    /// The box around all places there have been.
    pub(super) extent: BoundsMm,
    /// Whether another triangulation grows among the cells.
    pub(super) shares_cells: bool,
    pub(super) for_two: ForTwo,
    pub(super) setback: Setback,
    runs: Vec<Run>,
    /// A triangle at each of the last points of the batch, those before it had any left out.
    pub(super) slots: Vec<Slot>,
    pub(super) duplicates: Vec<Duplicate>,
}

/// How many points a batch must have to be worth a second thread.
#[derive(Clone, Copy)]
pub(super) struct ForTwo {
    pub(super) lines: usize,
    pub(super) scattered: usize,
}

impl Default for ForTwo {
    fn default() -> ForTwo {
        ForTwo { lines: 8192, scattered: 256 }
    }
}

/// How many batches are spared the trial of runs, as those of the last ones took too much.
#[derive(Default)]
pub(super) struct Setback {
    last: u32,
    left: u32,
}

impl Setback {
    /// Whether one more batch is spared it.
    fn is_on(&mut self) -> bool {
        let is_on = self.left > 0;
        self.left = self.left.saturating_sub(1);
        is_on
    }

    /// Takes note of whether runs were worth it. More and more batches are spared the trial as long as they are not.
    fn note(&mut self, worth_it: bool) {
        self.last = if worth_it { 0 } else { (2 * self.last + 1).min(LONGEST_SETBACK) };
        self.left = self.last;
    }
}

/// How many batches are spared the trial of runs at most before one is tried again.
const LONGEST_SETBACK: u32 = 31;

/// Where insertions start from.
pub(super) struct Plane {
    /// A triangle at the place inserted last.
    pub(super) recent: Slot,
    /// A triangle at the start of the last run: the next line of a scan in one direction starts there.
    pub(super) run_start: Slot,
    /// None as long as nothing has asked for them.
    pub(super) hints: OnceLock<Hints>,
    /// How much wider than the box about all places the next table is made.
    pub(super) room: f64,
}

impl Sheet {
    /// An empty one, among the same cells.
    pub(super) fn beside(&self) -> Sheet {
        Sheet { shares_cells: true, for_two: self.for_two, ..Sheet::default() }
    }

    /// Inserts the points `batch`. There must be two spare cells for each, and for each vertex there is
    /// as long as all lie on one line.
    pub(super) fn insert(
        &mut self,
        points: &(impl Places + ?Sized),
        cells: &impl Cells,
        batch: Range<VertexId>,
    ) {
        let duplicates = self.duplicates.len();
        let mut extent = BoundsMm::EMPTY;
        batch.clone().for_each(|vertex| extent.add(points.place(vertex)));
        self.extent.join(&extent);
        let mut rest = batch.clone();
        while self.plane.is_none()
            && let Some(vertex) = rest.next()
        {
            self.insert_on_line(points, cells, vertex);
        }
        self.slots.clear();
        if !rest.is_empty() {
            self.insert_in_plane(points, cells, rest, extent);
        }
        self.vertices += batch.len() - (self.duplicates.len() - duplicates);
    }

    /// A triangle from which it should not be far to a place, once there are triangles.
    pub(super) fn near(
        &self,
        points: &(impl Places + ?Sized),
        cells: &impl Cells,
        place: Place,
    ) -> Option<Slot> {
        let plane = self.plane.as_ref()?;
        let make = || Hints::of(points, cells, (self.extent, plane.room), self.vertices);
        Some(plane.hints.get_or_init(make).near(place).unwrap_or(plane.recent))
    }

    fn insert_on_line(
        &mut self,
        points: &(impl Places + ?Sized),
        cells: &impl Cells,
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
        self.plane =
            Some(Plane { recent: slot, run_start: slot, hints: OnceLock::new(), room: 1.0 });
        self.line = Line::default();
    }

    fn insert_in_plane(
        &mut self,
        points: &(impl Places + ?Sized),
        cells: &impl Cells,
        batch: Range<VertexId>,
        extent: BoundsMm,
    ) {
        let Some(plane) = &mut self.plane else { return };
        let place = |index: usize| points.place(batch.start + index as VertexId);
        runs((0..batch.len()).map(place), &mut self.runs);
        self.slots.resize(batch.len(), plane.recent);
        let is_spared = self.setback.is_on();
        let follow_lines = self.runs.len() <= batch.len() / SCATTERED
            || runs_by_turns(batch.len(), place, &mut self.runs);
        let lines = if follow_lines { by_turns(&self.runs) } else { None };
        if let Some(hints) = plane.hints.get_mut() {
            hints.expect(batch.len(), extent);
        }
        let mut inserter = Inserter {
            editor: Editor { points, cells, work: &mut self.work },
            plane,
            first: batch.start,
            slots: &mut self.slots,
            duplicates: &mut self.duplicates,
            extent: self.extent,
            vertices: self.vertices + batch.len(),
            shares_cells: self.shares_cells,
            for_two: self.for_two.scattered,
        };
        if is_spared || lines.is_none() {
            inserter.insert_scattered(&(0..batch.len()).collect::<Vec<_>>(), lines);
        } else {
            let worth_it = inserter.insert_runs(&self.runs);
            self.setback.note(worth_it);
        }
        // The next one to ask gets a finer one.
        if plane.hints.get().is_some_and(Hints::are_outgrown) {
            plane.hints.take();
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
    /// The box around all places, those of the batch among them, and about how many there are.
    pub(super) extent: BoundsMm,
    pub(super) vertices: usize,
    pub(super) shares_cells: bool,
    /// How many points must be left to be worth a second thread, if they are scattered.
    pub(super) for_two: usize,
}

impl<'a, P: Places + ?Sized, C: Cells> Inserter<'a, P, C> {
    /// Inserts runs one after the other as long as that is worth it, and all that is left as points in no order.
    ///
    /// Returns whether it was for all.
    fn insert_runs(&mut self, runs: &[Run]) -> bool {
        let before = self.editor.work.effort;
        let (mut left, mut inserted) = (Vec::new(), 0);
        for run in runs {
            if left.is_empty() {
                self.insert_run(run, (before, inserted), &mut left);
            } else {
                left.extend(run.points.numbers());
            }
            inserted += run.points.count;
        }
        if !left.is_empty() {
            // Some of them are in order of bisection.
            left.sort_unstable();
            self.insert_scattered(&left, by_turns(runs));
        }
        left.is_empty()
    }

    /// Inserts a run after others of so much effort and so many points, but for points that are `left` as it takes too much.
    fn insert_run(&mut self, run: &Run, (before, others): (usize, usize), left: &mut Vec<usize>) {
        let Run { points, axis } = *run;
        let mut from = self.nearest(points);
        let mut done = 0;
        let more = LEAST_POINTS.max(self.slots.len() / LARGE_SHARE);
        let is_worth_it = |inserter: &Self, points: usize| {
            inserter.editor.work.effort - before <= MOST_EFFORT * (points + more)
        };
        if points.stride > 1 {
            self.editor.start_line(points.count);
        }
        if let Some(axis) = axis {
            // Where the first points lie inside the hull, the rest may still lie outside.
            let mut skipped = 0;
            while skipped < SKIPPED && done + 1 < points.count && is_worth_it(self, others + done) {
                let piece = self.editor.next_strip(points.count - done);
                if piece < 2 {
                    break;
                }
                let here = points.part(done..done + piece);
                if self.editor.insert_strip(here.from(self.first as usize), axis, from) {
                    for (index, &slot) in here.numbers().zip(self.editor.strip_slots()) {
                        self.slots[index] = slot;
                    }
                    done += piece;
                    from = self.slots[points.at(done - 1)];
                } else {
                    from = self.insert(points.at(done), from);
                    done += 1;
                    skipped += 1;
                }
            }
        }
        for (count, step) in by_bisection(points.count - done).enumerate() {
            let index = points.at(done + step.index);
            if left.is_empty() && is_worth_it(self, others + done + count) {
                let from = step.near.map_or(from, |near| self.slots[points.at(done + near)]);
                self.insert(index, from);
            } else {
                left.push(index);
            }
        }
        self.plane.run_start = self.slots[points.at(0)];
        let known = if left.is_empty() { points.count } else { done };
        self.plane.recent = self.slots[points.at(known.max(1) - 1)];
        if let Some(hints) = self.plane.hints.get() {
            for index in points.part(0..known).numbers() {
                hints.note(self.place(index), self.slots[index]);
            }
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

    /// The nearest known triangle to the start of a run.
    ///
    /// Next to the start or the end of the last run, no farther than this one is long, no other is
    /// looked for: the walk costs less than the run.
    fn nearest(&self, run: Track) -> Slot {
        let [start, end] = [0, run.count - 1].map(|index| self.place(run.at(index)));
        let distance = |place: Place| (place[0] - start[0]).hypot(place[1] - start[1]);
        let to = |slot: Slot| distance(self.editor.at(self.editor.cells.corner(slot, 0)));
        let Plane { recent, run_start, .. } = *self.plane;
        let nearest = if to(run_start) < to(recent) { run_start } else { recent };
        if to(nearest) <= distance(end) {
            return nearest;
        }
        match self.hints().near(start) {
            Some(slot) if to(slot) < to(nearest) => slot,
            _ => nearest,
        }
    }

    /// A table of hints for all places, those of the batch among them.
    pub(super) fn hints(&self) -> &Hints {
        self.plane.hints.get_or_init(self.make_hints())
    }

    /// Makes such a table.
    pub(super) fn make_hints(&self) -> impl FnOnce() -> Hints + use<'a, P, C> {
        let Editor { points, cells, .. } = self.editor;
        let (shares_cells, vertices) = (self.shares_cells, self.vertices);
        let extent = (self.extent, self.plane.room);
        move || {
            if shares_cells {
                // A triangle of the other triangulation would lead astray.
                Hints::none(vertices, extent, C::HINTS)
            } else {
                Hints::of(points, cells, extent, vertices)
            }
        }
    }

    pub(super) fn place(&self, index: usize) -> Place {
        self.editor.at(self.first + index as VertexId)
    }
}

/// Number of lines that arrive by turns, of which runs are; `None` if there is no run.
fn by_turns(runs: &[Run]) -> Option<usize> {
    runs.first().map(|run| run.points.stride)
}

/// More triangles torn down and sides flipped a point than this are too many. Points in no order take 4 in
/// rounds. Lines inside a raster take 6 to 8: they are somewhat slower in rounds, rings of 35 to 60 points inwards much faster.
const MOST_EFFORT: usize = 6;

/// So many points more may take as much, or of a large batch one in so many. The first turn of a spiral about what another
/// thread inserts is a closed curve, but all turns after it are lines.
const LEAST_POINTS: usize = 256;
const LARGE_SHARE: usize = 16;

/// How many points of a run are inserted alone before it is not tried as a strip any more.
const SKIPPED: usize = 3;

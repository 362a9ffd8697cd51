//! Incremental Delaunay triangulation of places in the plane.
//!
//! After each batch the triangulation is that of all places so far, convex hull included. Where more
//! than three lie on one circle with none inside, [`encloses`](crate::exact::encloses) decides by
//! their coordinates, so the triangulation is the same in whatever order and batches they came.
//!
//! Scans are what it is made for: a batch is cut into runs along lines ([`runs`]); a run that lies outside
//! the hull, as the next line of a growing scan does, is sewn to it as a whole ([`strip`]); all
//! else is inserted point by point ([`insert`]), runs ends first and then by bisection, and points in no
//! order by the place they belong to. Vertices go one by one ([`remove`]).

mod cells;
mod editor;
mod halves;
mod hints;
mod hull;
mod insert;
mod line;
mod natural;
mod places;
mod queries;
mod remove;
mod runs;
mod scattered;
#[cfg(test)]
mod soundness;
mod star;
mod strip;

use std::collections::BTreeMap;
use std::ops::Range;

pub(crate) use self::cells::{Cells, FlatCells, GHOST, Side, Slot, next_slots};
use self::editor::{Editor, Work};
use self::hints::Hints;
pub(crate) use self::hints::Layout;
use self::insert::Placed;
use self::line::Line;
pub(crate) use self::places::{Places, Vertices};
pub(crate) use self::queries::{About, Conflict};
use self::runs::{Run, runs};
use crate::VertexId;
use crate::exact::Place;
use crate::order::by_bisection;

/// A growing Delaunay triangulation.
#[derive(Default)]
pub(crate) struct Delaunay<C = FlatCells> {
    cells: C,
    work: Work,
    /// The places, while all lie on one line.
    line: Line,
    /// Once there are triangles.
    plane: Option<Plane>,
    /// How many different places there are.
    vertices: usize,
    runs: Vec<Run>,
    /// A triangle at each point of the batch.
    slots: Vec<Slot>,
    duplicates: Vec<Duplicate>,
}

/// Where insertions start from.
struct Plane {
    /// A triangle at the place inserted last.
    recent: Slot,
    /// A triangle at the start of the last run: the next line of a scan in one direction starts there.
    run_start: Slot,
    hints: Hints,
}

/// A point that stands where another does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Duplicate {
    pub(crate) point: VertexId,
    pub(crate) of: VertexId,
}

impl<C: Cells> Delaunay<C> {
    /// Inserts the points `batch`, the last ones of `points`, all admitted (see
    /// [`crate::point::admit`]).
    ///
    /// Returns whether some stand where another does: they are no vertices, and the caller takes them
    /// out of `points` by [`Delaunay::close_gaps`] before anything else.
    pub(crate) fn insert(
        &mut self,
        points: &(impl Places + ?Sized),
        batch: Range<VertexId>,
    ) -> bool {
        self.duplicates.clear();
        // What duplicates and removed vertices left is taken first.
        let wanted = 2 * (self.vertices + batch.len());
        self.work.spare.extend(self.cells.grow(wanted.saturating_sub(self.cells.len())));
        let mut rest = batch.clone();
        while self.plane.is_none()
            && let Some(vertex) = rest.next()
        {
            self.insert_on_line(points, vertex);
        }
        if !rest.is_empty() {
            self.insert_in_plane(points, rest);
        }
        self.vertices += batch.len() - self.duplicates.len();
        !self.duplicates.is_empty()
    }

    fn insert_on_line(&mut self, points: &(impl Places + ?Sized), vertex: VertexId) {
        let place = points.place(vertex);
        if self.line.contains(place) {
            let there = self.line.insert(place, vertex);
            if there != vertex {
                self.duplicates.push(Duplicate { point: vertex, of: there });
            }
            return;
        }
        let slot = self.line.span(points, vertex, &self.cells, &mut self.work.spare);
        // A ghost at each place of the line, but for its two ends and with the vertex off it.
        self.work.ghosts = self.line.len() + 1;
        let mut hints = Hints::new(0, place, place, C::HINTS);
        hints.note(place, slot);
        self.plane = Some(Plane { recent: slot, run_start: slot, hints });
        self.line = Line::default();
    }

    fn insert_in_plane(&mut self, points: &(impl Places + ?Sized), batch: Range<VertexId>) {
        let Some(plane) = &mut self.plane else { return };
        runs(batch.clone().map(|vertex| points.place(vertex)), &mut self.runs);
        self.slots.clear();
        self.slots.resize(batch.len(), plane.recent);
        let mut inserter = Inserter {
            editor: Editor { points, cells: &self.cells, work: &mut self.work },
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
        self.cells.note_landmarks(points, batch.start, &self.slots);
        if let Some(mut hints) = plane.hints.outgrown() {
            self.cells.for_each_landmark(points, |place, slot| hints.note_again(place, slot));
            plane.hints = hints;
        }
    }

    /// No triangles yet, to be kept in `cells`, which has none.
    pub(crate) fn kept_in(cells: C) -> Delaunay<C> {
        Delaunay {
            cells,
            work: Work::default(),
            line: Line::default(),
            plane: None,
            vertices: 0,
            runs: Vec::new(),
            slots: Vec::new(),
            duplicates: Vec::new(),
        }
    }

    /// Where its triangles are kept.
    pub(crate) fn cells(&self) -> &C {
        &self.cells
    }

    /// The same, to be put in order between batches.
    pub(crate) fn cells_mut(&mut self) -> &mut C {
        &mut self.cells
    }

    /// Bytes of memory it takes besides that of the cells, as long as there are triangles.
    pub(crate) fn other_bytes(&self) -> usize {
        let hints = self.plane.as_ref().map_or(0, |plane| plane.hints.bytes());
        hints + size_of_val(&self.slots[..]) + size_of_val(&self.work.spare[..])
    }

    /// How many triangles there are.
    pub(crate) fn triangle_count(&self) -> usize {
        if self.plane.is_some() { 2 * self.vertices - 2 - self.work.ghosts } else { 0 }
    }

    /// The triangles counter-clockwise, in an order that means nothing.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [VertexId; 3]> + '_ {
        (0..self.cells.len() as Slot)
            .map(|slot| self.cells.corners(slot))
            .filter(|corners| corners[2] != GHOST)
    }

    /// Takes the duplicates of the last batch out of `points`, and numbers the batch's vertices in
    /// order of arrival. Returns the duplicates in order, each of the first to arrive in its place.
    pub(crate) fn close_gaps(
        &mut self,
        points: &mut impl Vertices,
        first: VertexId,
    ) -> Vec<Duplicate> {
        let mut duplicates = std::mem::take(&mut self.duplicates);
        let mut firsts: BTreeMap<VertexId, VertexId> = BTreeMap::new();
        for &Duplicate { point, of } in &duplicates {
            let first = firsts.entry(of).or_insert(of);
            *first = point.min(*first);
        }
        // Who was inserted first bears the number of who arrived first.
        for duplicate in &mut duplicates {
            let (inserted, arrived) = (duplicate.of, firsts[&duplicate.of]);
            if duplicate.point == arrived {
                duplicate.point = inserted;
                self.relabel(points.places(), inserted, arrived);
            }
            duplicate.of = arrived;
        }
        duplicates.sort_unstable_by_key(|duplicate| duplicate.point);
        let mut gaps = duplicates.iter().map(|duplicate| duplicate.point).peekable();
        let first_gap = gaps.peek().copied().unwrap_or(first);
        let mut filled = first_gap;
        for vertex in first_gap..points.count() as VertexId {
            if gaps.next_if_eq(&vertex).is_none() {
                self.relabel(points.places(), vertex, filled);
                points.copy(vertex, filled);
                filled += 1;
            }
        }
        points.shorten(points.count() - duplicates.len());
        for index in 0..duplicates.len() {
            // An earlier duplicate of the batch moved what comes after it.
            let of = duplicates[index].of;
            let before = duplicates.partition_point(|duplicate| duplicate.point < of);
            duplicates[index].of -= before as VertexId;
        }
        duplicates
    }

    /// Takes the triangles about a vertex for written.
    pub(crate) fn touch(&mut self, points: &(impl Places + ?Sized), vertex: VertexId) {
        self.relabel(points, vertex, vertex);
    }

    /// Gives a vertex another number. Its point is still, or also, to be found at the old one.
    fn relabel(&mut self, points: &(impl Places + ?Sized), from: VertexId, to: VertexId) {
        let place = points.place(from);
        match &mut self.plane {
            None => self.line.relabel(place, to),
            Some(plane) => {
                let editor = Editor { points, cells: &self.cells, work: &mut self.work };
                plane.recent = editor.relabel(place, from, to, plane.recent);
            }
        }
    }
}

/// Inserts one batch.
struct Inserter<'a, P: ?Sized, C> {
    editor: Editor<'a, P, C>,
    plane: &'a mut Plane,
    /// The first point of the batch.
    first: VertexId,
    /// A triangle at each point of the batch, once inserted.
    slots: &'a mut [Slot],
    duplicates: &'a mut Vec<Duplicate>,
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
    fn insert(&mut self, index: usize, from: Slot) -> Slot {
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

    fn place(&self, index: usize) -> Place {
        self.editor.at(self.first + index as VertexId)
    }
}

/// Batches of which more than one point in so many starts a run follow no line.
const SCATTERED: usize = 8;

/// How many points of a run are inserted alone before it is not tried as a strip any more.
const SKIPPED: usize = 3;

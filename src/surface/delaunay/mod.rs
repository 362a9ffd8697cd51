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
mod hints;
mod hull;
mod insert;
mod line;
mod natural;
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

use self::cells::{Cells, GHOST, Slot};
use self::editor::{Editor, Work};
use self::hints::Hints;
use self::insert::Placed;
use self::line::Line;
pub(crate) use self::queries::{About, Conflict};
use self::runs::{Run, runs};
use crate::exact::Place;
use crate::order::by_bisection;
use crate::point::place;
use crate::{PointMm, VertexId};

/// A growing Delaunay triangulation.
#[derive(Default)]
pub(crate) struct Delaunay {
    cells: Cells,
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

impl Delaunay {
    /// Inserts the points `batch`, the last ones of `points`, all admitted (see
    /// [`crate::point::admit`]).
    ///
    /// Returns whether some stand where another does: they are no vertices, and the caller takes them
    /// out of `points` by [`Delaunay::close_gaps`] before anything else.
    pub(crate) fn insert(&mut self, points: &[PointMm], batch: Range<VertexId>) -> bool {
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

    fn insert_on_line(&mut self, points: &[PointMm], vertex: VertexId) {
        let place = place(points[vertex as usize]);
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
        let mut hints = Hints::new(0, place, place);
        hints.note(place, slot);
        self.plane = Some(Plane { recent: slot, run_start: slot, hints });
        self.line = Line::default();
    }

    fn insert_in_plane(&mut self, points: &[PointMm], batch: Range<VertexId>) {
        let Some(plane) = &mut self.plane else { return };
        let places = &points[batch.start as usize..batch.end as usize];
        runs(places.iter().map(|&point| place(point)), &mut self.runs);
        self.slots.clear();
        self.slots.resize(places.len(), plane.recent);
        let mut inserter = Inserter {
            editor: Editor { points, cells: &self.cells, work: &mut self.work },
            plane,
            first: batch.start,
            slots: &mut self.slots,
            duplicates: &mut self.duplicates,
        };
        if self.runs.len() > places.len() / SCATTERED {
            inserter.insert_scattered();
        } else {
            for run in &self.runs {
                inserter.insert_run(run);
            }
        }
        if let Some(mut hints) = plane.hints.outgrown() {
            // Two triangles to a point: every fourth makes for two in a cell.
            for slot in (0..self.cells.len() as Slot).step_by(4) {
                let [corner, _, last] = self.cells.corners(slot);
                if last != GHOST {
                    hints.note_again(place(points[corner as usize]), slot);
                }
            }
            plane.hints = hints;
        }
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
        points: &mut Vec<PointMm>,
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
                self.relabel(points, inserted, arrived);
            }
            duplicate.of = arrived;
        }
        duplicates.sort_unstable_by_key(|duplicate| duplicate.point);
        let mut gaps = duplicates.iter().map(|duplicate| duplicate.point).peekable();
        let first_gap = gaps.peek().copied().unwrap_or(first);
        let mut filled = first_gap;
        for vertex in first_gap..points.len() as VertexId {
            if gaps.next_if_eq(&vertex).is_none() {
                self.relabel(points, vertex, filled);
                points[filled as usize] = points[vertex as usize];
                filled += 1;
            }
        }
        points.truncate(points.len() - duplicates.len());
        for index in 0..duplicates.len() {
            // An earlier duplicate of the batch moved what comes after it.
            let of = duplicates[index].of;
            let before = duplicates.partition_point(|duplicate| duplicate.point < of);
            duplicates[index].of -= before as VertexId;
        }
        duplicates
    }

    /// Gives a vertex another number. Its point is still, or also, to be found at the old one.
    fn relabel(&mut self, points: &[PointMm], from: VertexId, to: VertexId) {
        let place = place(points[from as usize]);
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
struct Inserter<'a> {
    editor: Editor<'a>,
    plane: &'a mut Plane,
    /// The first point of the batch.
    first: VertexId,
    /// A triangle at each point of the batch, once inserted.
    slots: &'a mut [Slot],
    duplicates: &'a mut Vec<Duplicate>,
}

impl Inserter<'_> {
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

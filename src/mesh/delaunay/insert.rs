//! Insertion of one point: the triangles that cannot stay go, and a fan about the point fills
//! their place.
//!
//! A. Bowyer, Computing Dirichlet tessellations, Comput. J. 24 (1981) 162-166,
//! doi:10.1093/comjnl/24.2.162; D. F. Watson, same volume 167-172. The triangles that go are
//! connected and have no vertex inside, so they are found by a search from the one in which the point
//! lies that never meets a triangle twice, and the search meets the sides around them in order.

use std::cell::Cell;

use asphera_geometry::VertexId;
use asphera_geometry::predicates::Place;

use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::places::Places;

/// Fate of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Placed {
    /// It is a corner of this triangle now.
    New(Slot),
    /// Another vertex stands exactly there; nothing was changed.
    Occupied(VertexId, Slot),
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// Inserts a point, walking to it from a triangle.
    pub(super) fn insert(&mut self, vertex: VertexId, from: Slot) -> Placed {
        let place = self.at(vertex);
        let found = if self.cells.is_ghost(from) && self.is_before(from, place) {
            Some(from)
        } else {
            self.find(place, self.inside(from), |_, _| true)
        };
        let home = found.expect("every triangle is one of all");
        if let Some(other) = self.corner_at(home, place) {
            return Placed::Occupied(other, home);
        }
        self.carve(place, home);
        Placed::New(self.fill(vertex))
    }

    /// Whether a ghost is in use, and a place lies before its side of the hull.
    #[cold]
    #[inline(never)]
    fn is_before(&self, slot: Slot, place: Place) -> bool {
        // Behind a ghost lies a triangle. What lies across a triangle's sides is in use.
        let side = Side::new(slot, 2);
        let behind = self.cells.across(side);
        !self.cells.is_ghost(behind.slot())
            && self.cells.across(behind) == side
            && self.in_conflict(slot, place)
    }

    /// As [`Editor::locate_among`], for a place that is as a rule not far or near the point inserted last.
    ///
    /// Where points have thousands of neighbours, as along a curve, a walk from any triangle at the point before would lead
    /// through a good part of those about it. So after some steps it starts anew from one of such points, in the right sense.
    #[inline(always)]
    pub(super) fn find(
        &mut self,
        place: Place,
        from: Slot,
        among: impl Fn(&Self, [VertexId; 3]) -> bool,
    ) -> Option<Slot> {
        let (steps, last) = (Cell::new(0), Cell::new(from));
        let is_near = |slot, corners| {
            steps.set(steps.get() + 1);
            last.set(slot);
            steps.get() < FAR_STEPS && among(self, corners)
        };
        match self.locate_among(place, from, is_near) {
            None if steps.get() == FAR_STEPS => self.find_far(place, last.get(), among),
            found => found,
        }
    }

    /// The same, from the nearest of the wide stars if that is nearer than the triangle.
    #[cold]
    #[inline(never)]
    fn find_far(
        &mut self,
        place: Place,
        from: Slot,
        among: impl Fn(&Self, [VertexId; 3]) -> bool,
    ) -> Option<Slot> {
        let facing = self.facing(place, from);
        let start = facing.filter(|&slot| among(self, self.cells.corners(slot))).unwrap_or(from);
        let start = self.inside(start);
        let steps = Cell::new(0);
        let home = self.locate_among(place, start, |_, corners| {
            steps.set(steps.get() + 1);
            among(self, corners)
        });
        self.work.effort += steps.get();
        home
    }

    /// Finds the triangles in conflict with `place`, of which `home` is one, and the sides around.
    pub(super) fn carve(&mut self, place: Place, home: Slot) {
        self.carve_among(place, home, |_, _| true);
    }

    /// The same, as long as they are some of the triangles and ghosts, as `home` is; whether all are.
    #[inline(always)]
    pub(super) fn carve_among(
        &mut self,
        place: Place,
        home: Slot,
        among: impl Fn(&Self, Slot) -> bool,
    ) -> bool {
        let work = &mut *self.work;
        let mut open = std::mem::take(&mut work.open);
        let mut doomed = std::mem::take(&mut work.doomed);
        let mut border = std::mem::take(&mut work.border);
        doomed.clear();
        border.clear();
        doomed.push(home);
        open.extend([1, 0, 2].map(|i| Side::new(home, i)));
        let mut all = true;
        while let Some(side) = open.pop() {
            let across = self.cells.across(side);
            if self.in_conflict(across.slot(), place) {
                if !among(self, across.slot()) {
                    all = false;
                    open.clear();
                    break;
                }
                doomed.push(across.slot());
                open.push(across.prev());
                open.push(across.next());
            } else {
                border.push((across, self.cells.end(across)));
            }
        }
        let work = &mut *self.work;
        (work.open, work.doomed, work.border) = (open, doomed, border);
        all
    }

    /// Joins the vertex with every side around the hole; returns one of the new triangles.
    ///
    /// ```text
    ///      end ◀─── start         into: from the end to the vertex
    ///         \   /               out:  from the vertex to the start
    ///         vertex              the next triangle starts where this one ends
    /// ```
    pub(super) fn fill(&mut self, vertex: VertexId) -> Slot {
        let work = &mut *self.work;
        work.effort += work.doomed.len();
        if work.border.iter().any(|&(_, start)| start == GHOST) {
            let ghosts = work.doomed.iter().filter(|&&slot| self.cells.is_ghost(slot)).count();
            work.ghosts = work.ghosts + 2 - ghosts;
        }
        // n sides lie around n - 2 triangles without a vertex inside.
        while work.doomed.len() < work.border.len() {
            let spare = work.spare.pop().expect("two cells are kept for each point to come");
            work.doomed.push(spare);
        }
        let (slots, border) = (&work.doomed, &work.border);
        let into = |i: usize| Side::new(slots[i], if border[i].1 == GHOST { 2 } else { 1 });
        let out = |i: usize| Side::new(slots[i], if border[i].1 == GHOST { 0 } else { 2 });
        let last = border.len() - 1;
        for i in 0..=last {
            let (before, after) =
                (if i == 0 { last } else { i - 1 }, if i == last { 0 } else { i + 1 });
            let ((beyond, start), end) = (border[i], border[after].1);
            let (slot, out_after, into_before) = (slots[i], out(after), into(before));
            if start == GHOST {
                self.cells.write(slot, [end, vertex, GHOST], [into_before, beyond, out_after]);
                self.cells.set_across(beyond, Side::new(slot, 1));
            } else {
                self.cells.write(slot, [vertex, start, end], [beyond, out_after, into_before]);
                self.cells.set_across(beyond, Side::new(slot, 0));
            }
        }
        work.wide.note(self.points.place(vertex), slots, self.cells.len());
        slots[0]
    }
}

/// A place is far after so many steps of a walk; three are the rule.
const FAR_STEPS: u32 = 24;

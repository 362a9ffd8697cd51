//! Insertion of scattered points by two threads, each on its side of a line.
//!
//! A triangle is a side's if all its corners lie there, and nobody else's; one with corners on both
//! sides is changed by nobody as long as the two are at work. So two threads never meet:
//!
//! - Across an edge of a side's triangle lies a triangle of the same side, or one that is nobody's,
//!   whose corners stand still: both have the edge's ends as corners.
//! - A point is inserted only if all triangles in conflict with it are its side's. The new ones are
//!   its side's then, too, and of the others around the hole only the word is written that tells
//!   what lies across its side.
//! - What lies across the other sides of a triangle that is nobody's is not asked for.
//!
//! Points that would need more are left, as a rule a few in a thousand. A walk may start from a
//! triangle the other thread is just writing: whatever three corners are read there, they are not all
//! of this side, and the walk starts elsewhere. So it does where both note hints in one table. The
//! triangulation does not depend on any of this, as there is only one.

use asphera_geometry::predicates::Place;
use asphera_geometry::{PointMm, VertexId, place};

use super::Duplicate;
use super::ahead::{Insert, insert_all};
use super::cells::{Cells, FlatCells, GHOST, Slot};
use super::editor::{Editor, Work};
use super::hints::Hints;
use super::insert::Placed;
use crate::order::in_two;

/// Two halves of a batch, inserted at the same time.
pub(super) struct Halves<'a> {
    pub(super) points: &'a [PointMm],
    pub(super) cells: &'a FlatCells,
    pub(super) hints: &'a Hints,
    /// The first point of the batch.
    pub(super) first: VertexId,
}

/// Fate of the points of a batch.
pub(super) struct Inserted {
    /// A triangle at each point that was inserted, or found to stand where another does.
    pub(super) slots: Vec<(usize, Slot)>,
    pub(super) duplicates: Vec<Duplicate>,
    /// The points that are still to be inserted.
    pub(super) left: Vec<usize>,
}

/// One side of the line, the line itself on the upper one.
#[derive(Clone, Copy)]
enum Half {
    Below(f64),
    From(f64),
}

impl Half {
    fn has(self, place: Place) -> bool {
        match self {
            Half::Below(y) => place[1] < y,
            Half::From(y) => place[1] >= y,
        }
    }
}

impl Halves<'_> {
    /// Inserts what two threads can of the points of a batch, given in an order by place.
    pub(super) fn insert(&self, order: &[usize], work: &mut Work) -> Inserted {
        let (y, [lower, upper]) = in_two(order, |index| self.place(index));
        let ghosts = work.ghosts;
        let mut other = Work { ghosts, ..Work::default() };
        other.spare = work.spare.split_off(work.spare.len() - 2 * upper.len());
        let (mut below, from) = rayon::join(
            || self.insert_half(Half::Below(y), &lower, work),
            || self.insert_half(Half::From(y), &upper, &mut other),
        );
        work.spare.append(&mut other.spare);
        work.ghosts = work.ghosts + other.ghosts - ghosts;
        below.slots.extend(from.slots);
        below.duplicates.extend(from.duplicates);
        below.left.extend(from.left);
        below
    }

    fn insert_half(&self, half: Half, order: &[usize], work: &mut Work) -> Inserted {
        let editor = Editor { points: self.points, cells: self.cells, work };
        let inserted =
            Inserted { slots: Vec::with_capacity(order.len()), duplicates: vec![], left: vec![] };
        let mut inserter = HalfInserter { halves: self, half, editor, recent: None, inserted };
        insert_all(&mut inserter, order);
        inserter.inserted
    }

    fn place(&self, index: usize) -> Place {
        place(self.points[self.first as usize + index])
    }
}

/// Inserts one half.
struct HalfInserter<'a> {
    halves: &'a Halves<'a>,
    half: Half,
    editor: Editor<'a, [PointMm], FlatCells>,
    /// A triangle at the place inserted last.
    recent: Option<Slot>,
    inserted: Inserted,
}

impl Insert for HalfInserter<'_> {
    type Places = [PointMm];
    type Cells = FlatCells;

    fn place(&self, index: usize) -> Place {
        self.halves.place(index)
    }

    fn fetch_near(&self, place: Place) {
        self.halves.hints.fetch(place);
    }

    fn near(&self, place: Place) -> Slot {
        self.halves.hints.near(place).or(self.recent).unwrap_or(0)
    }

    fn editor(&self) -> &Editor<'_, [PointMm], FlatCells> {
        &self.editor
    }

    fn insert(&mut self, index: usize, near: Slot) {
        let HalfInserter { halves, half, ref mut editor, recent, ref mut inserted } = *self;
        let point = halves.first + index as VertexId;
        // What was a triangle when it was noted may be a ghost by now.
        let mut known = [Some(near), recent].into_iter().flatten();
        let start = known.find(|&slot| editor.is_triangle_of(half, slot));
        let placed = start.and_then(|start| editor.insert_in(half, point, start));
        let slot = match placed {
            None => return inserted.left.push(index),
            Some(Placed::New(slot)) => slot,
            Some(Placed::Occupied(of, slot)) => {
                inserted.duplicates.push(Duplicate { point, of });
                slot
            }
        };
        self.recent = Some(slot);
        halves.hints.note(halves.place(index), slot);
        inserted.slots.push((index, slot));
    }
}

impl Editor<'_, [PointMm], FlatCells> {
    /// Whether all corners lie in the half, infinity in both.
    fn are_in(&self, half: Half, corners: [VertexId; 3]) -> bool {
        corners.into_iter().all(|corner| corner == GHOST || half.has(self.at(corner)))
    }

    fn is_triangle_of(&self, half: Half, slot: Slot) -> bool {
        let corners = self.cells.corners(slot);
        corners[2] != GHOST && self.are_in(half, corners)
    }

    /// Inserts a point as [`Editor::insert`] does, walking to it from a triangle of its half, if none
    /// takes part that is not.
    fn insert_in(&mut self, half: Half, vertex: VertexId, from: Slot) -> Option<Placed> {
        let place = self.at(vertex);
        let home = self.find(place, from, |editor, corners| editor.are_in(half, corners))?;
        if let Some(other) = self.corner_at(home, place) {
            return Some(Placed::Occupied(other, home));
        }
        let is_of = |editor: &Self, slot| editor.are_in(half, editor.cells.corners(slot));
        self.carve_among(place, home, is_of).then(|| Placed::New(self.fill(vertex)))
    }
}

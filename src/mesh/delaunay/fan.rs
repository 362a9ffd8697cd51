//! The fan beside an unfinished line.
//!
//! The mesh is convex after every batch. Where a batch ends within a line, its last point is joined with
//! the whole rest of the line before: a fan of as many triangles, though the next batch will take
//! most of them down again. A ghost is a triangle, too, with a corner at infinity, so the ghosts before
//! a line are such a fan already. One corner of each is written, and nothing else changes but at the ends:
//!
//! ```text
//!      c0 ──── c1 ──── c2 ──── c3            c0 ──── c1 ──── c2 ──── c3
//!     /    ∞       ∞       ∞       fold ▶    │    /    ___/   ____/
//!    /                             ◀ unfold  │  / __/  ____/
//!    p                                       p ── c3
//!      the edge: from p to c0                the edge: from p to c3
//! ```
//!
//! **Why no flip is needed.** Let the line run along an axis, exactly, and let the apex p lie before it and not
//! beyond the near corner of a base along the axis. Then the triangles are Delaunay where they meet:
//!
//! - *On the base.* Where the angle opposite to the base in the triangle behind it is not obtuse, the
//!   part of that triangle's circle before the base is at most half a disc, and lies above the base: p is not
//!   inside it, nor on it.
//! - *Between two of the fan.* The circle through p and a base meets the line in the ends of the base alone, so
//!   the far corner of the next base is outside.
//!
//! What remains is suspect as ever: the side by which the fan begins. Lines that are not straight are
//! closed as any other corner of the hull (`hull.rs`); there a line hides most of itself from p.

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, left_of};

use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::places::Places;
use super::runs::{Axis, Track};

/// In which sense around the hull a fan's bases follow one another from its `edge`, the side of the hull
/// that ends at the apex.
///
/// As the index of a ghost's corner and side it tells the corner of the edge that is the apex, the near
/// corner of a base, and the side by which a ghost meets the next one; the other index tells the
/// opposite of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Out {
    /// Clockwise.
    Back = 0,
    /// Counter-clockwise.
    Ahead = 1,
}

impl Out {
    fn indices(self) -> [usize; 2] {
        [self as usize, 1 - self as usize]
    }
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// Makes a fan about the apex of `edge` of the ghosts next to it, as far as they lie before a straight
    /// line. The apex must lie before the first of them. False if there is none; else `edge` leads from the
    /// apex to the end of the last.
    pub(super) fn fold(&mut self, edge: Slot, out: Out) -> bool {
        let [out_index, back] = out.indices();
        let apex = self.cells.corner(edge, out_index);
        let first = self.cells.across(Side::new(edge, out_index)).slot();
        let mut near = self.at(self.cells.corner(first, out_index));
        let mut far = self.at(self.cells.corner(first, back));
        let axis = Axis::of([far[0] - near[0], far[1] - near[1]]);
        if axis.along(self.at(apex)) > axis.along(near) {
            return false;
        }
        let (mut last, mut next, mut ghosts) = (edge, first, 0);
        while self.is_base(next, axis, near, far) {
            self.cells.set_corner(next, 2, apex);
            ghosts += 1;
            last = next;
            next = self.cells.across(Side::new(next, out_index)).slot();
            (near, far) = (far, self.at(self.cells.corner(next, back)));
        }
        if last == edge {
            return false;
        }
        self.work.ghosts -= ghosts;
        let start = Side::new(first, back);
        self.cells.join(start, self.cells.across(Side::new(edge, 2)));
        self.work.suspects.push(start);
        self.cells.set_corner(edge, back, self.cells.corner(last, back));
        self.cells.join(Side::new(edge, 2), Side::new(last, out_index));
        self.cells.join(Side::new(edge, out_index), Side::new(next, back));
        true
    }

    /// Makes ghosts of the fan about the apex of `edge` again, if a run goes on from the apex before the
    /// fan's line, which leads along `axis` away from the apex. False if there is none; else `edge` leads to
    /// the end of what is left of it, and the line of the hull still advances along the axis.
    ///
    /// The run must not come between the fan and what is left of it: its first point lies before
    /// `edge`, and all of them before the line. Nor may it start on the other side of the apex: it would hide
    /// the side between apex and line, which then meets the line in a corner that is not convex.
    pub(super) fn unfold(&mut self, edge: Slot, axis: Axis, out: Out, run: Track) -> bool {
        let [out_index, back] = out.indices();
        let apex = self.cells.corner(edge, out_index);
        let first = self.cells.across(Side::new(edge, 2));
        if first.index() != out_index || self.cells.corner(first.slot(), 2) != apex {
            return false;
        }
        let [place, mut far] = [apex, self.cells.corner(edge, back)].map(|corner| self.at(corner));
        let level = axis.across(far);
        let (mut last, mut inner, mut ghosts) = (edge, first, 0);
        loop {
            let slot = inner.slot();
            let near = self.at(self.cells.corner(slot, out_index));
            let next = self.cells.across(Side::new(slot, back));
            let next_apex = self.cells.corner(next.slot(), 2);
            if axis.across(near) != level
                || !axis.is_between(place, near, far)
                || self.cells.is_ghost(self.cells.across(Side::new(slot, 2)).slot())
                || next_apex == GHOST
                || last == edge && !self.goes_on(run, place, edge, axis, slot)
            {
                break;
            }
            self.cells.set_corner(slot, 2, GHOST);
            ghosts += 1;
            (last, inner, far) = (slot, next, near);
            if inner.index() != out_index || next_apex != apex {
                break;
            }
        }
        if last == edge {
            return false;
        }
        self.work.ghosts += ghosts;
        let next = self.cells.across(Side::new(edge, out_index));
        self.cells.join(Side::new(first.slot(), out_index), next);
        self.cells.join(Side::new(last, back), Side::new(edge, out_index));
        self.cells.set_corner(edge, back, self.cells.corner(last, out_index));
        self.cells.join(Side::new(edge, 2), inner);
        true
    }

    /// Whether a fan about a place can begin before a ghost, counter-clockwise along the axis.
    pub(super) fn begins_fan(&self, ghost: Slot, axis: Axis, place: Place) -> bool {
        let [end, start] = self.base(ghost);
        axis.along(place) <= axis.along(start)
            && self.is_base(ghost, axis, start, end)
            && left_of(end, start, place)
    }

    /// Whether a ghost's side leads exactly along the axis, and the triangle behind it has no obtuse
    /// angle opposite.
    #[inline(always)]
    fn is_base(&self, ghost: Slot, axis: Axis, near: Place, far: Place) -> bool {
        let behind = self.cells.across(Side::new(ghost, 2));
        if axis.across(near) != axis.across(far)
            || axis.along(near) >= axis.along(far)
            || self.cells.is_ghost(behind.slot())
        {
            return false;
        }
        let opposite = self.at(self.cells.apex(behind));
        let height = axis.across(opposite) - axis.across(near);
        let along = axis.along(opposite);
        // By Thales: the foot of the height cuts the base in two, whose product is at most the square
        // of the height. Its sign is exact, and the factor makes up for what is rounded.
        let product = (along - axis.along(near)) * (axis.along(far) - along);
        product <= 0.0 || height * height >= product * (1.0 + 8.0 * f64::EPSILON)
    }

    /// Whether a run goes on from an apex along the axis, its first point lies before a side of the hull, and all
    /// on the outer side of the line of a base.
    fn goes_on(&self, run: Track, apex: Place, edge: Slot, axis: Axis, base: Slot) -> bool {
        let first = self.at(run.first as VertexId);
        if axis.along(first) < axis.along(apex) {
            return false;
        }
        let level = axis.across(self.at(self.cells.corner(base, 0)));
        let is_less = axis.across(first) < level;
        let mut run = run.numbers().map(|number| axis.across(self.at(number as VertexId)));
        [edge, base].into_iter().all(|slot| {
            let [end, start] = self.base(slot);
            left_of(end, start, first)
        }) && run.all(|across| if is_less { across < level } else { across > level })
    }

    /// End and start of the side of the hull, or of a base, in the sense of the hull.
    #[inline(always)]
    fn base(&self, slot: Slot) -> [Place; 2] {
        [self.at(self.cells.corner(slot, 0)), self.at(self.cells.corner(slot, 1))]
    }
}

#[cfg(test)]
mod tests;

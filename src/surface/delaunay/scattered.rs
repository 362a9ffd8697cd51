//! Insertion of points that follow no line.
//!
//! Each such point meets triangles that no cache holds, and the time goes into waiting for memory. So the
//! points are taken some dozens at a time, and what they will meet is fetched for all of them before
//! any is inserted: the waits of many overlap.

use std::hint::black_box;

use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::halves::{Halves, Inserted};
use super::places::Places;
use super::sheet::Inserter;
use crate::exact::{Place, estimated_in_circle};
use crate::order::by_place;

impl<P: Places + ?Sized, C: Cells> Inserter<'_, P, C> {
    /// Inserts all points of the batch, those near one another together; by two threads where there
    /// are two and it pays.
    pub(super) fn insert_scattered(&mut self) {
        let order = by_place((0..self.slots.len()).map(|index| self.place(index)));
        match (self.editor.points.in_memory(), self.editor.cells.in_memory()) {
            (Some(points), Some(cells))
                if order.len() >= self.for_two && rayon::current_num_threads() > 1 =>
            {
                let order = self.insert_some_first(order);
                let make_hints = self.make_hints();
                let hints = self.plane.hints.get_or_init(make_hints);
                let halves = Halves { points, cells, hints, first: self.first };
                let Inserted { slots, duplicates, left } = halves.insert(&order, self.editor.work);
                for (index, slot) in slots {
                    self.slots[index] = slot;
                }
                self.duplicates.extend(duplicates);
                self.insert_in_order(&left);
            }
            _ => self.insert_in_order(&order),
        }
    }

    /// Where there are next to no triangles, two threads would meet at most of them: so some points all
    /// over are inserted first. The others.
    fn insert_some_first(&mut self, order: Vec<usize>) -> Vec<usize> {
        let there = self.vertices - self.slots.len();
        if there > order.len() / FIRST {
            return order;
        }
        let first: Vec<usize> = order.iter().copied().step_by(FIRST).collect();
        self.insert_in_order(&first);
        let others = order.chunks(FIRST).flat_map(|points| &points[1..]);
        others.copied().collect()
    }

    fn insert_in_order(&mut self, order: &[usize]) {
        let mut from = [0; WINDOW];
        for window in order.chunks(WINDOW) {
            let from = &mut from[..window.len()];
            for (slot, &index) in from.iter_mut().zip(window) {
                *slot = self.hints().near(self.place(index)).unwrap_or(self.plane.recent);
            }
            self.editor.look_ahead(from, |at| self.place(window[at]));
            for (&slot, &index) in from.iter().zip(window) {
                let slot = self.insert(index, slot);
                self.note(index, slot);
            }
        }
    }

    fn note(&mut self, index: usize, slot: Slot) {
        self.slots[index] = slot;
        self.hints().note(self.place(index), slot);
        self.plane.recent = slot;
    }
}

impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// Leads some walks on, each to a place of its own, and reads what will be met at their ends.
    pub(super) fn look_ahead(&self, from: &mut [Slot], place: impl Fn(usize) -> Place) {
        let mut walking: [usize; WINDOW] = std::array::from_fn(|at| at);
        let mut count = from.len();
        for _ in 0..STEPS {
            let mut left = 0;
            self.fetch(from, &walking[..count]);
            for index in 0..count {
                let at = walking[index];
                let next = self.step(place(at), from[at]);
                if next != from[at] {
                    from[at] = next;
                    walking[left] = at;
                    left += 1;
                }
            }
            count = left;
        }
        self.fetch_around(from, place);
    }

    /// Reads the triangles in which some walks are, and their corners, and nothing that depends on what is
    /// read.
    fn fetch(&self, slots: &[Slot], walking: &[usize]) {
        let mut read = 0;
        for &at in walking {
            read ^= self.cells.corner(slots[at], 0);
        }
        black_box(read);
        let mut read = 0.0;
        for &at in walking {
            for corner in self.cells.corners(slots[at]) {
                // The corner at infinity has no place: any other will do.
                read += self.at(if corner == GHOST { 0 } else { corner })[0];
            }
        }
        black_box(read);
    }

    /// Reads the triangles about some that will have to make way for a place each, and those that lie
    /// around them, each with the one corner by which it is told. In passes, each of which reads
    /// nothing that depends on what it reads.
    fn fetch_around(&self, slots: &[Slot], place: impl Fn(usize) -> Place) {
        let mut ring: [(u8, Side); MOST * WINDOW] = [(0, Side::NONE); MOST * WINDOW];
        let mut count = 0;
        for (at, &slot) in slots.iter().enumerate() {
            for index in 0..3 {
                ring[count] = (at as u8, self.cells.across(Side::new(slot, index)));
                count += 1;
            }
        }
        for _ in 0..RINGS {
            self.fetch_beyond(&ring[..count]);
            let mut next = [(0, Side::NONE); MOST * WINDOW];
            let mut found = 0;
            for &(at, side) in &ring[..count] {
                if found + 2 <= next.len() && self.is_doomed(side.slot(), place(at as usize)) {
                    for side in [side.next(), side.prev()] {
                        next[found] = (at, self.cells.across(side));
                        found += 1;
                    }
                }
            }
            (ring, count) = (next, found);
        }
        self.fetch_beyond(&ring[..count]);
    }

    /// Whether a triangle will, in all likelihood, have to make way for a place.
    fn is_doomed(&self, slot: Slot, place: Place) -> bool {
        let corners = self.cells.corners(slot);
        if corners[2] == GHOST {
            return false;
        }
        let [a, b, c] = corners.map(|corner| self.at(corner));
        estimated_in_circle(a, b, c, place).0 > 0.0
    }

    /// Reads triangles seen across a side, and the corners opposite to it.
    fn fetch_beyond(&self, sides: &[(u8, Side)]) {
        black_box(sides.iter().fold(0, |read, &(_, side)| read ^ self.cells.apex(side)));
        black_box(sides.iter().fold(0.0, |read, &(_, side)| {
            let apex = self.cells.apex(side);
            // The corner at infinity has no place: any other will do.
            read + self.at(if apex == GHOST { 0 } else { apex })[0]
        }));
    }

    /// One step of the walk from a triangle to a place.
    fn step(&self, place: Place, slot: Slot) -> Slot {
        let corners = self.cells.corners(slot);
        if corners[2] == GHOST {
            return self.cells.across(Side::new(slot, 2)).slot();
        }
        let at = corners.map(|corner| self.at(corner));
        match self.side_before(at, place, 3) {
            Some(index) => self.cells.across(Side::new(slot, index)).slot(),
            None => slot,
        }
    }
}

/// How many points are looked ahead for.
pub(super) const WINDOW: usize = 48;

/// How many steps of their walks at most; three are the rule.
const STEPS: usize = 8;

/// How many triangles away from the one in which a point lies others are looked at.
const RINGS: usize = 3;

/// How many sides a point has room for among those of a ring.
const MOST: usize = 6;

/// One point of so many is inserted before two threads start, if there are no more vertices than that.
const FIRST: usize = 16;

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
use crate::exact::Place;
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
        for _ in 0..STEPS {
            self.fetch(from);
            for (at, slot) in from.iter_mut().enumerate() {
                *slot = self.step(place(at), *slot);
            }
        }
        self.fetch_around(from);
    }

    /// Reads triangles and their corners, and nothing that depends on what is read.
    fn fetch(&self, slots: &[Slot]) {
        let mut read = 0;
        for &slot in slots {
            read ^= self.cells.corner(slot, 0);
        }
        black_box(read);
        let mut read = 0.0;
        for &slot in slots {
            for corner in self.cells.corners(slot) {
                // The corner at infinity has no place: any other will do.
                read += self.at(if corner == GHOST { 0 } else { corner })[0];
            }
        }
        black_box(read);
    }

    /// Reads the triangles across the sides of some, and those across theirs, each with the one corner
    /// that is not theirs. In passes, each of which reads nothing that depends on what it reads.
    fn fetch_around(&self, slots: &[Slot]) {
        let mut around = [Side::NONE; 3 * WINDOW];
        let around = &mut around[..3 * slots.len()];
        for (sides, &slot) in around.chunks_exact_mut(3).zip(slots) {
            sides
                .copy_from_slice(&[0, 1, 2].map(|index| self.cells.across(Side::new(slot, index))));
        }
        self.fetch_beyond(around);
        let mut beyond = [Side::NONE; 6 * WINDOW];
        let beyond = &mut beyond[..6 * slots.len()];
        for (sides, &side) in beyond.chunks_exact_mut(2).zip(&*around) {
            sides.copy_from_slice(&[side.next(), side.prev()].map(|side| self.cells.across(side)));
        }
        self.fetch_beyond(beyond);
    }

    /// Reads triangles seen across a side, and the corners opposite to it.
    fn fetch_beyond(&self, sides: &[Side]) {
        black_box(sides.iter().fold(0, |read, &side| read ^ self.cells.apex(side)));
        black_box(sides.iter().fold(0.0, |read, &side| {
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

/// How many steps of their walks.
const STEPS: usize = 4;

/// One point of so many is inserted before two threads start, if there are no more vertices than that.
const FIRST: usize = 16;

//! Insertion of points that follow no line.

use super::ahead::{Insert, insert_all};
use super::cells::{Cells, Slot};
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
                insert_all(self, &left);
            }
            _ => insert_all(self, &order),
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
        insert_all(self, &first);
        let others = order.chunks(FIRST).flat_map(|points| &points[1..]);
        others.copied().collect()
    }
}

impl<P: Places + ?Sized, C: Cells> Insert for Inserter<'_, P, C> {
    type Places = P;
    type Cells = C;

    fn place(&self, index: usize) -> Place {
        Inserter::place(self, index)
    }

    fn fetch_near(&self, place: Place) {
        self.hints().fetch(place);
    }

    fn near(&self, place: Place) -> Slot {
        self.hints().near(place).unwrap_or(self.plane.recent)
    }

    fn editor(&self) -> &Editor<'_, P, C> {
        &self.editor
    }

    fn insert(&mut self, index: usize, near: Slot) {
        let slot = Inserter::insert(self, index, near);
        self.hints().note(self.place(index), slot);
        self.plane.recent = slot;
    }
}

/// One point of so many is inserted before two threads start, if there are no more vertices than that.
const FIRST: usize = 16;

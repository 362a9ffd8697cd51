//! Insertion of points that follow no line, or several by turns.
//!
//! Points near one another follow in the order they are inserted in, so what one met is at hand for the next. Along a
//! curve that alone would tear down with each point what the one before it built. So the batch is taken in rounds, each
//! of several times as many points as the one before and spread over all of it (N. Amenta, S. Choi, G. Rote,
//! Incremental constructions con BRIO, Proc. 19th Symp. Comput. Geom. (2003) 211-219, doi:10.1145/777792.777824; here
//! by every fourth point, without drawing any). Near one another are those that follow along a line, where there are lines:
//! by place the two sides of a closed one come by turns.
//!
//! Where the batch traces a curve about an empty region, the end of the curve belongs to most triangles that span the
//! region. Each round would tear those down once more. So the ends go in before all rounds, the last point first.

use asphera_geometry::predicates::Place;

use super::ahead::{Insert, insert_all};
use super::cells::{Cells, Slot};
use super::editor::Editor;
use super::halves::{Halves, Inserted};
use super::places::Places;
use super::sheet::Inserter;
use crate::order::{along_lines, by_place, ends_and_others, in_rounds, middles_and_others};

impl<P: Places + ?Sized, C: Cells> Inserter<'_, P, C> {
    /// Inserts points of the batch, given in order of arrival: the ends of what they trace, and the others in rounds, in
    /// each those near one another together; by two threads where there are two and it pays.
    ///
    /// Points that trace so many `lines` by turns go in along these, unless the way by place is shorter
    /// or their steps are long.
    pub(super) fn insert_scattered(&mut self, indices: &[usize], lines: Option<usize>) {
        self.adapt_hints();
        let (ends, others) = ends_and_others(indices, |index| self.place(index));
        insert_all(self, &ends);
        let [width, height] = self.extent.size_mm();
        let longest = FAR_STEP * (width * height / self.vertices as f64).sqrt();
        let place = |index| self.place(index);
        let along = lines.and_then(|lines| along_lines(&others, lines, longest, place));
        let are_far = along.is_none();
        let order = along.unwrap_or_else(|| {
            let order = by_place(others.iter().map(|&index| self.place(index)));
            order.into_iter().map(|at| others[at]).collect()
        });
        let mut takes_much = false;
        for round in in_rounds(&order) {
            let before = self.editor.work.effort;
            if takes_much {
                let [middles, others] = middles_and_others(&round);
                self.insert_round(&middles, are_far);
                self.insert_round(&others, are_far);
            } else {
                self.insert_round(&round, are_far);
            }
            takes_much = self.editor.work.effort - before > MUCH_EFFORT * round.len();
        }
    }

    /// Runs are as well off with an old table, which goes afterwards. Scattered points beyond it would be led to those on
    /// its other side.
    fn adapt_hints(&mut self) {
        let Some(hints) = self.plane.hints.get_mut() else { return };
        if hints.is_narrow() {
            self.plane.room = ROOM;
            self.plane.hints.take();
        } else if hints.are_outgrown() && !hints.refine() {
            self.plane.hints.take();
        }
    }

    /// Where two threads have a triangulation each among the same cells, both are at work already.
    ///
    /// Along a line the next point meets what the one before it met. So nothing is searched for ahead there, unless points
    /// `are_far` from one another.
    fn insert_round(&mut self, order: &[usize], are_far: bool) {
        match (self.editor.points.in_memory(), self.editor.cells.in_memory()) {
            (Some(points), Some(cells))
                if order.len() >= self.for_two
                    && !self.shares_cells
                    && rayon::current_num_threads() > 1 =>
            {
                let make_hints = self.make_hints();
                let hints = self.plane.hints.get_or_init(make_hints);
                let halves = Halves { points, cells, hints, first: self.first };
                let Inserted { slots, duplicates, left } = halves.insert(order, self.editor.work);
                for (index, slot) in slots {
                    self.slots[index] = slot;
                }
                self.duplicates.extend(duplicates);
                insert_all(self, &left);
            }
            _ if are_far => insert_all(self, order),
            _ => {
                for &index in order {
                    let near = self.near(self.place(index));
                    Insert::insert(self, index, near);
                }
            }
        }
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

/// Where a round took more a point, the next one is cut in two. In the middle of others points take 4.
const MUCH_EFFORT: usize = 5;

/// Along lines of longer steps, in distances between the points of the mesh, the next point meets little that the one
/// before it met.
const FAR_STEP: f64 = 2.0;

/// How much wider than its points a table is made once they outgrew one.
const ROOM: f64 = 1.5;

#[cfg(test)]
mod tests;

//! Where to start the walk to a place of which nothing is known.
//!
//! A table over a grid that repeats itself over the whole plane: each cell names a triangle at the point
//! that was inserted last in it. Triangles change and far places share a cell, so what is found is near
//! as a rule, not right. A hint only ever costs time.

use super::cells::Slot;
use crate::exact::Place;

pub(super) struct Hints {
    /// Cells per mm.
    scale: f64,
    /// Cells along x and y, less one: powers of two, less one.
    masks: [i64; 2],
    cells: Vec<Slot>,
    /// The box around all points noted.
    low: Place,
    high: Place,
    noted: usize,
    /// How many points may be noted before the table is too coarse.
    enough: usize,
}

impl Hints {
    /// No hints yet, for about `points` to come, within the box.
    pub(super) fn new(points: usize, low: Place, high: Place) -> Hints {
        let size = [high[0] - low[0], high[1] - low[1]];
        let longest = size[0].max(size[1]);
        let wanted = (points / POINTS_A_CELL).max(LEAST_CELLS) as f64;
        // Along a box that is all but a line there are not more cells than wanted, either.
        let cell = (size[0] / wanted * size[1]).sqrt().max(longest / wanted);
        let cell = if cell > 0.0 { cell } else { 1.0 };
        let sides = size.map(|size| ((size / cell).ceil() as usize).max(1).next_power_of_two());
        Hints {
            scale: cell.recip(),
            masks: sides.map(|side| side as i64 - 1),
            cells: vec![NONE; sides[0] * sides[1]],
            low,
            high,
            noted: 0,
            enough: 2 * points.max(LEAST_CELLS),
        }
    }

    /// Notes a triangle at a point that has been inserted.
    #[inline]
    pub(super) fn note(&mut self, place: Place, slot: Slot) {
        let cell = self.cell(place, [0, 0]);
        self.cells[cell] = slot;
        self.low = [self.low[0].min(place[0]), self.low[1].min(place[1])];
        self.high = [self.high[0].max(place[0]), self.high[1].max(place[1])];
        self.noted += 1;
    }

    /// A triangle near `place`: that of its cell, or of one of the cells around.
    #[inline]
    pub(super) fn near(&self, place: Place) -> Option<Slot> {
        let slots = AROUND.into_iter().map(|offset| self.cells[self.cell(place, offset)]);
        slots.into_iter().find(|&slot| slot != NONE)
    }

    /// Once there are twice as many points as the table is made for: a finer one for all of them,
    /// still empty.
    pub(super) fn outgrown(&self) -> Option<Hints> {
        (self.noted > self.enough)
            .then(|| Hints { noted: self.noted, ..Hints::new(self.noted, self.low, self.high) })
    }

    /// Notes a triangle again, in a table that replaces an outgrown one.
    #[inline]
    pub(super) fn note_again(&mut self, place: Place, slot: Slot) {
        let cell = self.cell(place, [0, 0]);
        self.cells[cell] = slot;
    }

    #[inline]
    fn cell(&self, place: Place, offset: [i64; 2]) -> usize {
        // A cast saturates: places out of range share a cell.
        let [x, y] = [0, 1].map(|axis| {
            ((place[axis] * self.scale) as i64).wrapping_add(offset[axis]) & self.masks[axis]
        });
        (y * (self.masks[0] + 1) + x) as usize
    }
}

/// The cell itself, then those around it.
const AROUND: [[i64; 2]; 9] =
    [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, -1], [1, -1], [-1, 1]];

/// How many points a cell has when a table is made; up to twice as many when it is replaced.
const POINTS_A_CELL: usize = 4;
const LEAST_CELLS: usize = 1024;
const NONE: Slot = Slot::MAX;

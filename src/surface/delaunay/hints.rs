//! Where to start the walk to a place of which nothing is known.
//!
//! A table over a grid that repeats itself over the whole plane: each cell names a triangle at the point
//! that was inserted last in it. Triangles change and far places share a cell, so what is found is near
//! as a rule, not right. A hint only ever costs time.

use super::cells::Slot;
use crate::exact::Place;

/// How a table is laid out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// How many points a cell has when a table is made.
    pub(crate) points_a_cell: usize,
    /// How many cells there are however few points.
    pub(crate) least_cells: usize,
    /// How much wider than the points the table is made, so that the next ones share no cell with
    /// those there are; it is replaced when they do. `None`: they may share cells.
    pub(crate) slack: Option<f64>,
}

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
    layout: Layout,
    /// How many points may be noted before the table is too coarse.
    enough: usize,
}

impl Hints {
    /// No hints yet, for about `points` to come, within the box.
    pub(super) fn new(points: usize, low: Place, high: Place, layout: Layout) -> Hints {
        let slack = layout.slack.unwrap_or(1.0);
        let size = [high[0] - low[0], high[1] - low[1]].map(|size| size * slack);
        let longest = size[0].max(size[1]);
        let wanted = (points / layout.points_a_cell).max(layout.least_cells) as f64;
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
            layout,
            enough: 2 * points.max(LEAST_POINTS),
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
    ///
    /// What lies outside the box shares its cell with far places inside; the border is nearer.
    #[inline]
    pub(super) fn near(&self, place: Place) -> Option<Slot> {
        let place = [0, 1].map(|axis| place[axis].max(self.low[axis]).min(self.high[axis]));
        let slots = AROUND.into_iter().map(|offset| self.cells[self.cell(place, offset)]);
        slots.into_iter().find(|&slot| slot != NONE)
    }

    /// Once there are twice as many points as the table is made for, or they lie farther apart than
    /// the slack was for: a finer or wider one for all of them, still empty.
    pub(super) fn outgrown(&self) -> Option<Hints> {
        let is_wider = |axis: usize| {
            (self.high[axis] - self.low[axis]) * self.scale > (self.masks[axis] + 1) as f64
        };
        let outgrown = self.noted > self.enough
            || self.layout.slack.is_some() && [0, 1].iter().any(|&axis| is_wider(axis));
        outgrown.then(|| Hints {
            noted: self.noted,
            ..Hints::new(self.noted, self.low, self.high, self.layout)
        })
    }

    /// Bytes of the table.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.cells[..])
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

/// No table is replaced before so many points were noted twice over.
const LEAST_POINTS: usize = 1024;
const NONE: Slot = Slot::MAX;

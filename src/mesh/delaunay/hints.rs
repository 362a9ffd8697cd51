//! Where to start the walk to a place of which nothing is known.
//!
//! A table over a grid that repeats itself over the whole plane: each cell names a triangle at the point
//! that was inserted last in it. Triangles change and far places share a cell, so what is found is near
//! as a rule, not right. A hint only ever costs time.
//!
//! Lines of a scan start where others did: they need no table, and none is made before something asks
//! for one.

use asphera_geometry::BoundsMm;
use std::sync::atomic::{AtomicU32, Ordering};

use asphera_geometry::predicates::Place;

use super::cells::{Cells, Slot};
use super::places::Places;
use crate::fetch::fetch;

/// How a table is laid out.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    /// How many points a cell has at most when a table is made.
    pub(crate) points_a_cell: usize,
    /// How many cells there are however few points.
    pub(crate) least_cells: usize,
    /// How much wider than the points the table is made, so that the next ones share no cell with
    /// those there are; it is replaced when they do. `None`: they may share cells, and the table is
    /// refined as they become more.
    pub(crate) slack: Option<f64>,
}

/// The table. Triangles are noted through a shared reference, so that two threads may.
pub(super) struct Hints {
    /// Cells per mm.
    scale: f64,
    /// Cells along x and y, less one: powers of two, less one.
    masks: [i64; 2],
    cells: Vec<AtomicU32>,
    /// The box around all points noted.
    extent: BoundsMm,
    noted: usize,
    layout: Layout,
    /// How many points may be noted before the table is too coarse.
    enough: usize,
}

impl Hints {
    /// A table for about `points` within the box, in which there is a triangle at some of the places
    /// there are.
    pub(super) fn of<C: Cells>(
        points: &(impl Places + ?Sized),
        cells: &C,
        (extent, room): (BoundsMm, f64),
        count: usize,
    ) -> Hints {
        let hints = Hints::none(count, (extent, room), C::HINTS);
        cells.for_each_landmark(points, |place, slot| hints.note(place, slot));
        hints
    }

    /// No hints yet. Where the layout has no slack of its own the table is `room` times as wide as the box.
    pub(super) fn none(points: usize, (extent, room): (BoundsMm, f64), layout: Layout) -> Hints {
        let slack = layout.slack.unwrap_or(room);
        let size = extent.size_mm().map(|size| size * slack);
        let longest = size[0].max(size[1]);
        let wanted = (points / layout.points_a_cell).max(layout.least_cells) as f64;
        // Along a box that is all but a line there are not more cells than wanted, either.
        let cell = (size[0] / wanted * size[1]).sqrt().max(longest / wanted);
        let cell = if cell > 0.0 { cell } else { 1.0 };
        let sides = size.map(|size| ((size / cell).ceil() as usize).max(1).next_power_of_two());
        let mut scale = cell.recip();
        let mut enough = 2 * points.max(LEAST_POINTS);
        if layout.slack.is_none() {
            // As fine as there are cells, and not quite as wide: two sides of the box share none.
            let fill = |axis: usize| (sides[axis] - 2) as f64 / size[axis];
            let fills = [0, 1].into_iter().filter(|&axis| sides[axis] > 2).map(fill);
            scale = fills.reduce(f64::min).unwrap_or(scale);
            enough = layout.points_a_cell * sides[0] * sides[1];
        }
        Hints {
            scale,
            masks: sides.map(|side| side as i64 - 1),
            cells: (0..sides[0] * sides[1]).map(|_| AtomicU32::new(NONE)).collect(),
            extent,
            noted: points,
            layout,
            enough,
        }
    }

    /// Makes four cells of each, in which there is then what was in that one; false if that is not enough, as
    /// the points lie farther apart than the table is wide.
    ///
    /// Looks at no point and no triangle: a new table would have to, all over the memory.
    pub(super) fn refine(&mut self) -> bool {
        if self.layout.slack.is_some() || self.is_narrow() {
            return false;
        }
        let [columns, rows] = self.masks.map(|mask| mask as usize + 1);
        let mut finer = Vec::with_capacity(4 * self.cells.len());
        for row in 0..2 * rows {
            let coarse = &self.cells[row / 2 * columns..][..columns];
            finer.extend(coarse.iter().flat_map(|cell| {
                let slot = cell.load(Ordering::Relaxed);
                [AtomicU32::new(slot), AtomicU32::new(slot)]
            }));
        }
        self.cells = finer;
        self.masks = self.masks.map(|mask| 2 * mask + 1);
        self.scale *= 2.0;
        self.enough *= 4;
        true
    }

    /// Notes a triangle at a point that has been inserted.
    #[inline]
    pub(super) fn note(&self, place: Place, slot: Slot) {
        self.cells[self.cell(place, [0, 0])].store(slot, Ordering::Relaxed);
    }

    /// Says that so many more points, within the box, have been noted or are about to be.
    pub(super) fn expect(&mut self, points: usize, extent: BoundsMm) {
        self.extent.join(&extent);
        self.noted += points;
    }

    /// Asks for what [`Hints::near`] reads, as a rule.
    #[inline]
    pub(super) fn fetch(&self, place: Place) {
        let place = self.extent.nearest(place);
        fetch(&self.cells[self.cell(place, [0, 0])], |cell| cell.load(Ordering::Relaxed));
    }

    /// A triangle near `place`: that of its cell, or of one of the cells around.
    ///
    /// What lies outside the box shares its cell with far places inside; the border is nearer.
    #[inline]
    pub(super) fn near(&self, place: Place) -> Option<Slot> {
        let place = self.extent.nearest(place);
        self.near_by(place, 1).or_else(|| self.not_far(place))
    }

    /// The same, so many cells away.
    #[inline]
    fn near_by(&self, place: Place, cells: i64) -> Option<Slot> {
        let read = |offset: [i64; 2]| {
            let offset = offset.map(|on| on * cells);
            self.cells[self.cell(place, offset)].load(Ordering::Relaxed)
        };
        AROUND.into_iter().map(read).find(|&slot| slot != NONE)
    }

    /// The same, from farther and farther away: before the hull of a mesh that grows there are some empty cells.
    #[cold]
    #[inline(never)]
    fn not_far(&self, place: Place) -> Option<Slot> {
        [2, 4, 8, 16].into_iter().find_map(|cells| self.near_by(place, cells))
    }

    /// Whether there are too many points for the table, or they lie farther apart than the slack was for: it
    /// is time for another.
    pub(super) fn are_outgrown(&self) -> bool {
        self.noted > self.enough || self.layout.slack.is_some() && self.is_narrow()
    }

    /// Whether the box around the points is wider than the table.
    pub(super) fn is_narrow(&self) -> bool {
        let size = self.extent.size_mm();
        let is_wider = |axis: usize| size[axis] * self.scale > (self.masks[axis] + 1) as f64;
        is_wider(0) || is_wider(1)
    }

    /// Bytes of the table.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.cells[..])
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

#[cfg(test)]
mod tests {
    use super::*;

    const LAYOUT: Layout = Layout { points_a_cell: 4, least_cells: 16, slack: None };

    fn square(side: f64) -> BoundsMm {
        BoundsMm { low: [-side; 2], high: [side; 2] }
    }

    #[test]
    fn refined_hints_tell_what_they_told() {
        let mut hints = Hints::none(64, (square(1.0), 1.0), LAYOUT);
        let places: Vec<Place> = (0..8)
            .flat_map(|i| (0..8).map(move |j| [i, j].map(|k| k as f64 / 4.0 - 0.9)))
            .collect();
        for (slot, &place) in places.iter().enumerate() {
            hints.note(place, slot as Slot);
        }
        // Places right of the origin and above it are in the same cells of either table.
        let told: Vec<_> = places.iter().map(|&place| hints.near(place)).collect();
        assert!(told.iter().all(Option::is_some));
        let bytes = hints.bytes();
        assert!(hints.refine());
        assert_eq!(hints.bytes(), 4 * bytes);
        for (place, told) in places.into_iter().zip(told) {
            if place.iter().all(|&coordinate| coordinate >= 0.0) {
                assert_eq!(hints.near(place), told, "{place:?}");
            } else {
                assert!(hints.near(place).is_some(), "{place:?}");
            }
        }
    }

    #[test]
    fn it_is_refined_when_each_cell_has_its_points_and_not_before() {
        let mut hints = Hints::none(64, (square(1.0), 1.0), LAYOUT);
        let enough = LAYOUT.points_a_cell * hints.bytes() / size_of::<Slot>();
        hints.expect(enough - 64, square(1.0));
        assert!(!hints.are_outgrown());
        hints.expect(1, square(1.0));
        assert!(hints.are_outgrown() && hints.refine() && !hints.are_outgrown());
    }

    #[test]
    fn a_table_that_is_too_narrow_is_not_refined() {
        let mut hints = Hints::none(64, (square(1.0), 1.0), LAYOUT);
        hints.expect(64, square(1.1));
        assert!(hints.refine(), "there is some room beside the box");
        hints.expect(64, square(3.0));
        assert!(!hints.refine());
    }

    #[test]
    fn beyond_empty_cells_it_tells_of_one_that_is_not() {
        let hints = Hints::none(4096, (square(2.0), 1.0), LAYOUT);
        assert_eq!(hints.near([0.0; 2]), None);
        // The cells are an eighth of a mm wide; all of a square have a triangle.
        let steps = (0..16).flat_map(|i| (0..16).map(move |j| [i, j]));
        let places: Vec<Place> =
            steps.map(|step| step.map(|on| f64::from(on) / 16.0 - 1.0)).collect();
        for (slot, &place) in places.iter().enumerate() {
            hints.note(place, slot as Slot);
        }
        for away in [0.0_f64, 0.2, 0.4, 0.8, 1.2] {
            let place = [away, -0.5];
            let slot = hints.near(place).expect("there is one within sixteen cells");
            let [x, y] = places[slot as usize];
            assert!((place[0] - x).hypot(place[1] - y) < 2.0 * away + 0.4, "{away}: {x}, {y}");
        }
    }

    #[test]
    fn room_is_for_points_beyond_the_box() {
        let mut hints = Hints::none(64, (square(1.0), 1.5), LAYOUT);
        hints.expect(64, square(1.45));
        assert!(!hints.is_narrow());
        hints.expect(64, square(3.5));
        assert!(hints.is_narrow());
    }
}

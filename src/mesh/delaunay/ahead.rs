//! Insertion of points in no order, with what each will meet asked for before.
//!
//! Such a point meets some thirty lines of memory that no cache holds, and knows of one only when it has read
//! the one before. So points are taken some dozens at a time, and where all of them are to go is found in passes:
//! a pass reads what the one before asked for, and asks for what the next one will read. Between two
//! passes one of the dozens before is inserted, for which all is at hand by then: the triangles
//! are changed while the memory is waited for. So do chains of pointers that are followed by turns
//! (O. Kocberber, B. Falsafi, B. Grot, Asynchronous memory access chaining, Proc. VLDB Endow. 9 (2015)
//! 252-263, doi:10.14778/2856318.2856321).
//!
//! What is found is a hint: until a point is inserted, others have changed the triangles.

use std::hint::select_unpredictable;

use asphera_geometry::VertexId;
use asphera_geometry::predicates::{Place, estimated_in_circle, estimated_orientation};

use super::cells::{Cells, GHOST, Side, Slot};
use super::editor::Editor;
use super::places::Places;

/// Inserts points of a batch.
pub(super) trait Insert {
    type Places: Places + ?Sized;
    type Cells: Cells;

    /// Where a point of the batch lies.
    fn place(&self, index: usize) -> Place;

    /// Asks for what [`Insert::near`] reads.
    fn fetch_near(&self, place: Place);

    /// A triangle near a place.
    fn near(&self, place: Place) -> Slot;

    fn editor(&self) -> &Editor<'_, Self::Places, Self::Cells>;

    /// Inserts a point, probably near a triangle.
    fn insert(&mut self, index: usize, near: Slot);
}

/// Inserts points in their order, in which those near one another follow.
pub(super) fn insert_all(insert: &mut impl Insert, order: &[usize]) {
    let (mut here, mut ahead) = (Ahead::default(), Ahead::default());
    for window in order.chunks(WINDOW) {
        ahead.start(window);
        while ahead.pass(insert) {
            here.insert_next(insert);
        }
        while here.insert_next(insert) {}
        std::mem::swap(&mut here, &mut ahead);
    }
    while here.insert_next(insert) {}
}

/// How far the search for what some points will meet has come.
struct Ahead<'a> {
    /// The points.
    window: &'a [usize],
    /// How many of them have been inserted.
    inserted: usize,
    pass: Pass,
    /// The triangle to which the walk to each has come.
    slots: [Slot; WINDOW],
    /// The walks not at their end, the first `left`.
    walking: [u8; WINDOW],
    /// Sides of triangles that will make way, each seen from across and with its point, the first `left`.
    ring: [(u8, Side); RING],
    left: usize,
}

/// Memory that the next pass reads.
#[derive(Clone, Copy)]
enum Pass {
    /// Nothing yet.
    Start,
    /// The table of hints.
    Hints,
    /// The triangles to which walks have come; how many more steps they may go.
    Triangles(usize),
    /// The corners of those.
    Corners(usize),
    /// The triangles across the sides of the ring; how many more rings there may be.
    Ring(usize),
    /// The corners of those opposite to the sides.
    Apexes(usize),
    /// There is none.
    End,
}

impl Default for Ahead<'_> {
    fn default() -> Self {
        Ahead {
            window: &[],
            inserted: 0,
            pass: Pass::End,
            slots: [0; WINDOW],
            walking: [0; WINDOW],
            ring: [(0, Side::NONE); RING],
            left: 0,
        }
    }
}

impl<'a> Ahead<'a> {
    /// Starts anew with other points.
    fn start(&mut self, window: &'a [usize]) {
        (self.window, self.inserted, self.pass) = (window, 0, Pass::Start);
    }

    /// Does the next pass; false if there is none.
    fn pass(&mut self, insert: &impl Insert) -> bool {
        let (editor, window) = (insert.editor(), self.window);
        let place = |at: usize| insert.place(window[at]);
        self.pass = match self.pass {
            Pass::Start => {
                (0..window.len()).for_each(|at| insert.fetch_near(place(at)));
                Pass::Hints
            }
            Pass::Hints => {
                for at in 0..window.len() {
                    self.slots[at] = insert.near(place(at));
                    self.walking[at] = at as u8;
                    editor.cells.fetch(self.slots[at]);
                }
                self.left = window.len();
                Pass::Triangles(STEPS)
            }
            Pass::Triangles(steps) => {
                for &at in &self.walking[..self.left] {
                    let corners = editor.cells.corners(self.slots[at as usize]);
                    corners.into_iter().for_each(|corner| editor.points.fetch(corner));
                }
                Pass::Corners(steps)
            }
            Pass::Corners(steps) => {
                self.step(editor, place);
                if self.left > 0 && steps > 1 {
                    Pass::Triangles(steps - 1)
                } else {
                    self.first_ring(editor);
                    Pass::Ring(RINGS)
                }
            }
            Pass::Ring(rings) => {
                for &(_, side) in &self.ring[..self.left] {
                    editor.points.fetch(editor.cells.apex(side));
                }
                if rings > 0 { Pass::Apexes(rings) } else { Pass::End }
            }
            Pass::Apexes(rings) => {
                self.next_ring(editor, place);
                Pass::Ring(rings - 1)
            }
            Pass::End => return false,
        };
        true
    }

    /// Inserts the next point; false if there is none.
    fn insert_next(&mut self, insert: &mut impl Insert) -> bool {
        let Some(&index) = self.window.get(self.inserted) else { return false };
        insert.insert(index, self.slots[self.inserted]);
        self.inserted += 1;
        true
    }

    /// Leads each walk on by a step.
    fn step<P: Places + ?Sized, C: Cells>(
        &mut self,
        editor: &Editor<'_, P, C>,
        place: impl Fn(usize) -> Place,
    ) {
        let mut left = 0;
        for index in 0..self.left {
            let at = self.walking[index];
            let slot = self.slots[at as usize];
            let next = editor.step(place(at as usize), slot);
            editor.cells.fetch(next);
            self.slots[at as usize] = next;
            // Without a branch, as nobody could tell which way it goes.
            self.walking[left] = at;
            left += usize::from(next != slot);
        }
        self.left = left;
    }

    /// Looks across the sides of the triangles in which the points lie.
    fn first_ring<P: Places + ?Sized, C: Cells>(&mut self, editor: &Editor<'_, P, C>) {
        for at in 0..self.window.len() {
            for index in 0..3 {
                let side = editor.cells.across(Side::new(self.slots[at], index));
                editor.cells.fetch(side.slot());
                self.ring[3 * at + index] = (at as u8, side);
            }
        }
        self.left = 3 * self.window.len();
    }

    /// Looks across the far sides of those triangles that will make way.
    fn next_ring<P: Places + ?Sized, C: Cells>(
        &mut self,
        editor: &Editor<'_, P, C>,
        place: impl Fn(usize) -> Place,
    ) {
        let mut next = [(0, Side::NONE); RING];
        let mut found = 0;
        for &(at, side) in &self.ring[..self.left] {
            let is_doomed = editor.is_doomed(side.slot(), place(at as usize));
            // Without a branch, as nobody could tell which way it goes.
            next[found] = (at, editor.cells.across(side.next()));
            next[found + 1] = (at, editor.cells.across(side.prev()));
            found = (found + 2 * usize::from(is_doomed)).min(RING - 2);
        }
        for &(_, side) in &next[..found] {
            editor.cells.fetch(side.slot());
        }
        (self.ring, self.left) = (next, found);
    }
}

// Another thread may be writing what is read here, so that any corner may be the one at infinity.
impl<P: Places + ?Sized, C: Cells> Editor<'_, P, C> {
    /// One step of the walk from a triangle to a place, in all likelihood.
    fn step(&self, place: Place, slot: Slot) -> Slot {
        let corners = self.cells.corners(slot);
        if corners.contains(&GHOST) {
            return self.step_at_hull(place, slot, corners);
        }
        let [a, b, c] = corners.map(|corner| self.at(corner));
        let beyond = [(c, b), (a, c), (b, a)].map(|(p, q)| estimated_orientation(p, q, place).0);
        // Without branches, as nobody could tell which way they go.
        let last = select_unpredictable(beyond[2] > beyond[1], 2, 1);
        let index = select_unpredictable(beyond[last] > beyond[0], last, 0);
        let across = self.cells.across(Side::new(slot, index)).slot();
        select_unpredictable(beyond[index] > 0.0, across, slot)
    }

    /// The same from a ghost, or what was a triangle once: it stays where the place lies before it.
    #[cold]
    #[inline(never)]
    fn step_at_hull(&self, place: Place, slot: Slot, [a, b, c]: [VertexId; 3]) -> Slot {
        let is_before = || estimated_orientation(self.at(a), self.at(b), place).0 > 0.0;
        if c == GHOST && a != GHOST && b != GHOST && is_before() {
            return slot;
        }
        self.cells.across(Side::new(slot, 2)).slot()
    }

    /// Whether a triangle will, in all likelihood, have to make way for a place.
    fn is_doomed(&self, slot: Slot, place: Place) -> bool {
        let corners = self.cells.corners(slot);
        if corners.contains(&GHOST) {
            return false;
        }
        let [a, b, c] = corners.map(|corner| self.at(corner));
        estimated_in_circle(a, b, c, place).0 > 0.0
    }
}

/// How many points are looked ahead for at a time: about as many as there are passes, so that each pass has an
/// insertion to go with it.
const WINDOW: usize = 24;

/// How many steps of a walk are looked ahead for at most; three are the rule.
const STEPS: usize = 8;

/// How many triangles away from the one in which a point lies others are looked at.
const RINGS: usize = 3;

/// How many sides there is room for in a ring: six for each point, where three to four are the rule.
const RING: usize = 6 * WINDOW;

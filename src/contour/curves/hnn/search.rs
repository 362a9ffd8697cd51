//! The search for the nearest sample and the half neighbour of every sample of a run.

use asphera_geometry::BoundsMm;
use asphera_geometry::predicates::{certain_distances, compare_distances, squared_distance};

use crate::PlaceMm;
use crate::cells::{Cells, LEAF, Node, Position};

/// No sample.
pub(super) const NONE: Position = Position::MAX;

/// The two samples that one chooses: its nearest, and its half neighbour or [`NONE`].
pub(super) type Chosen = [Position; 2];

/// Memory of one thread that searches.
pub(super) struct Search<'a> {
    cells: &'a Cells,
    /// Samples about a run.
    near: Vec<Position>,
    /// Their x and y in mm.
    places: [Vec<f64>; 2],
    /// Squares of their distances in mm² from one of the run, and those of them that are within reach.
    squares_mm2: Vec<f64>,
    within: Vec<(f64, u32)>,
}

/// A sample at a distance from another.
#[derive(Clone, Copy)]
struct Candidate {
    squared_mm2: f64,
    position: Position,
    at_mm: PlaceMm,
}

impl<'a> Search<'a> {
    pub(super) fn new(cells: &'a Cells) -> Search<'a> {
        Search {
            cells,
            near: Vec::new(),
            places: Default::default(),
            squares_mm2: Vec::new(),
            within: Vec::new(),
        }
    }

    /// Adds the choices of the samples of a run, in order.
    ///
    /// Most find both within a few spacings of the run: what lies there is gathered once for all. The others search alone.
    pub(super) fn run(&mut self, leaf: &Node, chosen: &mut Vec<Chosen>) {
        let reach_mm2 = self.reach_mm2(leaf);
        let Search { cells, near, places: [x, y], .. } = self;
        let mut own = 0;
        near.clear();
        x.clear();
        y.clear();
        // Squares rounded down belong to samples a trifle beyond.
        cells.visit_near(leaf.bounds(), reach_mm2 * (1.0 + 2.0 * ROUNDING), |other| {
            if other.positions().start == leaf.positions().start {
                own = near.len();
            }
            for position in other.positions() {
                let [at_x, at_y] = cells.places()[position];
                near.push(position as Position);
                x.push(at_x);
                y.push(at_y);
            }
            near.len() <= MANY
        });
        let is_shared = self.near.len() <= MANY && reach_mm2.is_finite();
        self.squares_mm2.resize(self.near.len(), 0.0);
        self.within.resize(self.near.len(), (0.0, 0));
        for (index, position) in leaf.positions().enumerate() {
            chosen.push(if is_shared {
                self.choice(own + index, reach_mm2)
            } else {
                self.lone(position as Position)
            });
        }
    }

    /// Square in mm² of the distance from a run within which most of its samples have both.
    fn reach_mm2(&self, leaf: &Node) -> f64 {
        let (own, all) = (leaf.positions(), self.cells.places());
        let mut least = [f64::INFINITY; LEAF];
        let count = own.len();
        for (least, at) in least.iter_mut().zip(own) {
            // Those next to it on the curve through the cells are near as a rule.
            for other in at.saturating_sub(2)..(at + 3).min(all.len()) {
                let square = squared_distance(all[at], all[other]);
                *least = if square < *least && other != at { square } else { *least };
            }
        }
        let least = &mut least[..count];
        least.sort_unstable_by(f64::total_cmp);
        SPACINGS * SPACINGS * least[count / 2]
    }

    /// The choice of a gathered sample; those no farther than the root of `reach_mm2` were gathered.
    fn choice(&mut self, own: usize, reach_mm2: f64) -> Chosen {
        let Search { near, places: [x, y], squares_mm2, within, .. } = self;
        let (sample, at) = (near[own], [x[own], y[own]]);
        for ((square, x), y) in squares_mm2.iter_mut().zip(&*x).zip(&*y) {
            *square = squared_distance(at, [*x, *y]);
        }
        // Rounding may hide which of two is nearer, so those a trifle beyond count, too, but none of them is chosen.
        let most_mm2 = reach_mm2 * (1.0 + ROUNDING);
        let mut count = 0;
        for (index, &square) in (0..).zip(&*squares_mm2) {
            // Every one is written, and stays if it is near: that spares a branch that nobody can foresee.
            within[count] = (square, index);
            count += usize::from(square <= most_mm2 && index as usize != own);
        }
        let within = &self.within[..count];
        let is_certain = |it: &Candidate| it.squared_mm2 <= reach_mm2;
        let nearest = self.least(at, within, |_| true);
        let Some(nearest) = nearest.filter(is_certain) else { return self.lone(sample) };
        let behind = self.least(at, within, |place| is_nearer(place, at, nearest.at_mm));
        let behind = behind.filter(is_certain).map(|behind| behind.position);
        [nearest.position, behind.unwrap_or_else(|| self.behind(sample, nearest.at_mm))]
    }

    /// The nearest of some gathered samples that is wanted, of equally near ones that of the smallest number.
    fn least(
        &self,
        from: PlaceMm,
        of: &[(f64, u32)],
        is_wanted: impl Fn(PlaceMm) -> bool,
    ) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        let mut most_mm2 = f64::INFINITY;
        for &(squared_mm2, index) in of {
            if squared_mm2 > most_mm2 {
                continue;
            }
            let index = index as usize;
            let at_mm = [self.places[0][index], self.places[1][index]];
            let found = Candidate { squared_mm2, position: self.near[index], at_mm };
            if best.is_none_or(|best| self.precedes(from, &found, &best)) && is_wanted(at_mm) {
                most_mm2 = squared_mm2 * (1.0 + ROUNDING);
                best = Some(found);
            }
        }
        best
    }

    /// Whether a sample is nearer than another, or as near and of a smaller number.
    fn precedes(&self, from: PlaceMm, a: &Candidate, b: &Candidate) -> bool {
        let order = certain_distances(a.squared_mm2, b.squared_mm2)
            .unwrap_or_else(|| compare_distances(from, a.at_mm, from, b.at_mm));
        let number = |it: &Candidate| self.cells.samples()[it.position as usize];
        order.then_with(|| number(a).cmp(&number(b))).is_lt()
    }

    /// The choice of a sample far from its run.
    fn lone(&self, sample: Position) -> Chosen {
        let nearest = self.nearest(sample, |_| true, |_| true);
        if nearest == NONE {
            return [NONE; 2];
        }
        [nearest, self.behind(sample, self.cells.places()[nearest as usize])]
    }

    /// The nearest sample that is nearer to a sample than to its nearest one. Boxes beyond the bisector of both are left out, so an end of
    /// a curve does not ask about the curve.
    fn behind(&self, sample: Position, nearest_mm: PlaceMm) -> Position {
        let at = self.cells.places()[sample as usize];
        let reaches_behind = |bounds: &BoundsMm| reaches_behind(bounds, at, nearest_mm);
        self.nearest(sample, reaches_behind, |place| is_nearer(place, at, nearest_mm))
    }

    /// The nearest other sample that is wanted, and lies in a box that is; of equally near ones that of the smallest number.
    fn nearest(
        &self,
        sample: Position,
        is_box_wanted: impl Fn(&BoundsMm) -> bool,
        is_wanted: impl Fn(PlaceMm) -> bool,
    ) -> Position {
        let places = self.cells.places();
        let at = places[sample as usize];
        let mut best = Candidate { squared_mm2: f64::INFINITY, position: NONE, at_mm: at };
        self.cells.search(at, is_box_wanted, |leaf| {
            for other in leaf.positions().filter(|&other| other != sample as usize) {
                let at_mm = places[other];
                let squared_mm2 = squared_distance(at, at_mm);
                let found = Candidate { squared_mm2, position: other as Position, at_mm };
                let is_near = squared_mm2 <= best.squared_mm2 * (1.0 + ROUNDING);
                if is_near
                    && (best.position == NONE || self.precedes(at, &found, &best))
                    && is_wanted(at_mm)
                {
                    best = found;
                }
            }
            best.squared_mm2 * (1.0 + ROUNDING)
        });
        best.position
    }
}

/// Whether a place is nearer to `a` than to `b`.
#[inline]
fn is_nearer(place: PlaceMm, a: PlaceMm, b: PlaceMm) -> bool {
    compare_distances(a, place, b, place).is_lt()
}

/// Whether a box may hold a place that is nearer to `a` than to `b`; by rounding it may say so of a box just beyond the bisector.
fn reaches_behind(bounds: &BoundsMm, a: PlaceMm, b: PlaceMm) -> bool {
    // A place x is where (x - a)·(b - a) is below half of |b - a|². Each term is least at one side of the box.
    let (mut least, mut size) = (0.0, 0.0);
    for axis in 0..2 {
        let way = b[axis] - a[axis];
        let side = if way > 0.0 { bounds.low[axis] } else { bounds.high[axis] };
        let term = (side - a[axis]) * way;
        least += term;
        size += term.abs();
    }
    let half = 0.5 * squared_distance(a, b);
    least - half <= ROUNDING * (size + half)
}

/// Within so many spacings of a run most of its samples have both: of a curve they follow one another.
const SPACINGS: f64 = 2.0;

/// Where more lie about a run, each of its samples searches alone.
const MANY: usize = 128;

/// Above what squares of distances are rounded by.
const ROUNDING: f64 = 1e-12;

//! The search for the nearest sample and the half neighbour of every sample of a run.

use asphera_geometry::BoundsMm;
use asphera_geometry::predicates::{certain_distances, compare_distances, squared_distance};

use crate::PlaceMm;
use crate::cells::{Cells, Node, Position};

/// No sample.
pub(super) const NONE: Position = Position::MAX;

/// The two samples that one chooses: its nearest, and its half neighbour or [`NONE`].
pub(super) type Chosen = [Position; 2];

/// Memory of one thread that searches.
pub(super) struct Search<'a> {
    cells: &'a Cells,
    /// Samples about a run, with their places.
    near: Vec<Position>,
    places: Vec<PlaceMm>,
    squares_mm2: Vec<f64>,
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
        let (near, places, squares_mm2) = Default::default();
        Search { cells, near, places, squares_mm2 }
    }

    /// Adds the choices of the samples of a run, in order.
    ///
    /// Most find both within a few spacings of the run: what lies there is gathered once for all. The others search alone.
    pub(super) fn run(&mut self, leaf: &Node, chosen: &mut Vec<Chosen>) {
        let reach_mm2 = self.reach_mm2(leaf);
        let Search { cells, near, places, .. } = self;
        near.clear();
        places.clear();
        // Squares rounded down belong to samples a trifle beyond.
        cells.visit_near(leaf.bounds(), reach_mm2 * (1.0 + 2.0 * ROUNDING), |other| {
            near.extend(other.positions().map(|position| position as Position));
            places.extend_from_slice(&cells.places()[other.positions()]);
            near.len() <= MANY
        });
        let is_shared = self.near.len() <= MANY && reach_mm2.is_finite();
        self.squares_mm2.resize(self.near.len(), 0.0);
        for position in leaf.positions() {
            let sample = position as Position;
            let found = if is_shared { self.choice(sample, reach_mm2) } else { self.lone(sample) };
            chosen.push(found);
        }
    }

    /// Square in mm² of the distance from a run within which most of its samples have both.
    fn reach_mm2(&self, leaf: &Node) -> f64 {
        let (own, all) = (leaf.positions(), self.cells.places());
        // Those before and after it on the curve belong to its neighbours as a rule.
        let about = own.start.saturating_sub(2)..(own.end + 2).min(all.len());
        let mut least = [f64::INFINITY; 16];
        let count = own.len();
        for (least, at) in least.iter_mut().zip(own) {
            for other in about.clone().filter(|&other| other != at) {
                let square = squared_distance(all[at], all[other]);
                *least = if square < *least { square } else { *least };
            }
        }
        let least = &mut least[..count];
        least.sort_unstable_by(f64::total_cmp);
        SPACINGS * SPACINGS * least[count / 2]
    }

    /// The choice of a sample; those no farther than the root of `reach_mm2` were gathered.
    fn choice(&mut self, sample: Position, reach_mm2: f64) -> Chosen {
        let at = self.cells.places()[sample as usize];
        let mut least = f64::INFINITY;
        let others = self.near.iter().zip(&self.places);
        for (square, (&position, &place)) in self.squares_mm2.iter_mut().zip(others) {
            let squared = squared_distance(at, place);
            *square = if position == sample { f64::INFINITY } else { squared };
            least = if *square < least { *square } else { least };
        }
        if least > reach_mm2 {
            return self.lone(sample);
        }
        let Some(nearest) = self.least(at, least, |_| true) else { return self.lone(sample) };
        let mut best_mm2 = reach_mm2;
        let is_behind = |place: PlaceMm| is_nearer(place, at, nearest.at_mm);
        for (&square, &place) in self.squares_mm2.iter().zip(&self.places) {
            if square < best_mm2 && is_behind(place) {
                best_mm2 = square;
            }
        }
        match self.least(at, best_mm2, is_behind) {
            Some(behind) => [nearest.position, behind.position],
            None => [nearest.position, self.behind(sample, nearest.at_mm)],
        }
    }

    /// The nearest gathered sample that is wanted, where `squared_mm2` is the least square of those in doubles; none where none is that near.
    fn least(
        &self,
        at: PlaceMm,
        squared_mm2: f64,
        is_wanted: impl Fn(PlaceMm) -> bool,
    ) -> Option<Candidate> {
        let mut best: Option<Candidate> = None;
        // Rounding may hide which of two is nearer.
        let most_mm2 = squared_mm2 * (1.0 + ROUNDING);
        for (index, &squared_mm2) in self.squares_mm2.iter().enumerate() {
            if squared_mm2 <= most_mm2 {
                let (position, at_mm) = (self.near[index], self.places[index]);
                let found = Candidate { squared_mm2, position, at_mm };
                if is_wanted(at_mm) && best.is_none_or(|best| self.precedes(at, &found, &best)) {
                    best = Some(found);
                }
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

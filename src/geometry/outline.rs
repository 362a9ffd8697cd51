//! Closed regions of the plane with straight sides.

mod simple;
mod strips;

use std::cmp::Ordering;

use thiserror::Error;

use self::strips::Strips;
use crate::predicates::{Place, orientation};
use crate::{BoundsMm, RANGE_MM, Sum, side};

/// A region of the x-y plane: an outline of straight sides and its holes, in mm. Its border belongs to it.
///
/// Every outline is sound: places are finite, its area is positive, and no side meets another but at a shared corner.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// The outline counter-clockwise, then the holes clockwise.
    rings: Vec<Vec<Place>>,
    strips: Strips,
}

/// Why closed lines are no region.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum OutlineError {
    /// A place that is not finite, or where no mesh can be.
    #[error("place ({}, {}) mm, expected finite numbers up to 1e12", .at_mm[0], .at_mm[1])]
    Place {
        /// The place in mm.
        at_mm: Place,
    },
    /// A closed line of fewer than three places.
    #[error("closed line {line} has {places} different places, expected 3 or more")]
    Places {
        /// Which line: 0 is the outline, 1 the first hole.
        line: usize,
        /// How many places it has, repeated ones left out.
        places: usize,
    },
    /// A closed line without area.
    #[error("closed line {line} encloses nothing")]
    Empty {
        /// Which line: 0 is the outline, 1 the first hole.
        line: usize,
    },
    /// Two sides that meet elsewhere than at the corner they share.
    #[error("closed lines {} and {} meet near ({}, {}) mm", .lines[0], .lines[1], .near_mm[0], .near_mm[1])]
    Meet {
        /// The lines of the two sides, which may be one: 0 is the outline, 1 the first hole.
        lines: [usize; 2],
        /// The beginning of the first side in mm.
        near_mm: Place,
    },
    /// A hole that is not inside the outline, or inside another hole.
    #[error("hole {hole} does not lie inside the outline")]
    Hole {
        /// Which hole, from 1 on.
        hole: usize,
    },
}

impl Outline {
    /// The region that closed lines enclose. Each line may run either way, and may or may not repeat its first place at
    /// its end.
    ///
    /// Whether lines meet is decided exactly. Takes time in proportion to the pairs of sides whose ranges of x overlap,
    /// and of holes.
    ///
    /// # Errors
    ///
    /// When a place is not finite; when a line has fewer than three places, or no area, or meets itself or another one,
    /// be it at a corner; when a hole is not inside.
    pub fn new(outline_mm: &[Place], holes_mm: &[Vec<Place>]) -> Result<Outline, OutlineError> {
        let lines = std::iter::once(outline_mm).chain(holes_mm.iter().map(Vec::as_slice));
        let mut rings = Vec::with_capacity(1 + holes_mm.len());
        for (line, places) in lines.enumerate() {
            rings.push(ring(line, places)?);
        }
        if let Some((lines, near_mm)) = simple::meeting(&rings) {
            return Err(OutlineError::Meet { lines, near_mm });
        }
        for hole in 1..rings.len() {
            let at = rings[hole][0];
            let elsewhere = |&other: &usize| other != hole && ring_contains(&rings[other], at);
            if !ring_contains(&rings[0], at) || (1..rings.len()).any(|other| elsewhere(&other)) {
                return Err(OutlineError::Hole { hole });
            }
        }
        let strips = Strips::of(&rings);
        Ok(Outline { rings, strips })
    }

    /// The outline counter-clockwise, then the holes clockwise, mm.
    pub fn rings(&self) -> &[Vec<Place>] {
        &self.rings
    }

    /// Every side, from its beginning to its end.
    pub fn sides(&self) -> impl Iterator<Item = [Place; 2]> + '_ {
        self.rings.iter().flat_map(|ring| ring_sides(ring)).map(|(p, q)| [p, q])
    }

    /// The region without its holes.
    #[must_use]
    pub fn filled(&self) -> Outline {
        let rings = vec![self.rings[0].clone()];
        let strips = Strips::of(&rings);
        Outline { rings, strips }
    }

    /// Its area in mm².
    pub fn area_mm2(&self) -> f64 {
        let mut sum = Sum::default();
        self.rings.iter().for_each(|ring| sum.add(ring_area_mm2(ring)));
        sum.total()
    }

    /// The length of its border in mm, holes included.
    pub fn perimeter_mm(&self) -> f64 {
        self.sides().map(|[p, q]| (q[0] - p[0]).hypot(q[1] - p[1])).sum()
    }

    /// The smallest and the largest x and y in mm.
    pub fn bounds_mm(&self) -> [Place; 2] {
        let BoundsMm { low, high } = BoundsMm::about(self.rings[0].iter().copied());
        [low, high]
    }

    /// Whether a place, in mm, belongs to it, exactly. NaN belongs to none. Takes time in proportion to the sides at
    /// the height of the place.
    pub fn contains(&self, at_mm: Place) -> bool {
        let sides = || self.strips.sides(at_mm[1], 0.0);
        at_mm.iter().all(|mm| mm.is_finite())
            && (sides().any(|&[p, q]| side_meets(p, q, at_mm))
                || sides().filter(|[p, q]| side_right_of(*p, *q, at_mm)).count() % 2 == 1)
    }

    /// Whether a side passes no farther from a place than `reach_mm`.
    pub fn passes_within(&self, at_mm: Place, reach_mm: f64) -> bool {
        let mut sides = self.strips.sides(at_mm[1], reach_mm);
        sides.any(|&side| side::distance_mm(side, at_mm) <= reach_mm)
    }

    /// The place of its border that is nearest to another.
    pub fn nearest_mm(&self, at_mm: Place) -> Place {
        let start = (f64::INFINITY, at_mm);
        let nearest = self.sides().fold(start, |best, side| {
            let apart_mm = side::distance_mm(side, at_mm);
            if apart_mm < best.0 { (apart_mm, side::nearest_mm(side, at_mm)) } else { best }
        });
        nearest.1
    }

    /// Where `from + s·step` lies in it: pieces of s, ascending, to rounding.
    pub fn pieces(&self, from: Place, step: Place) -> Vec<[f64; 2]> {
        // A side has its lower end and not its upper, as in `side_right_of`: every crossing counts once.
        let beside = |at: Place| step[0] * (at[1] - from[1]) - step[1] * (at[0] - from[0]);
        let length2 = step[0] * step[0] + step[1] * step[1];
        let mut cuts: Vec<f64> = self
            .sides()
            .filter_map(|[p, q]| {
                let (to_p, to_q) = (beside(p), beside(q));
                let crosses = (to_p > 0.0) != (to_q > 0.0);
                crosses.then(|| {
                    let share = to_p / (to_p - to_q);
                    let at = [0, 1].map(|axis| p[axis] + share * (q[axis] - p[axis]) - from[axis]);
                    (at[0] * step[0] + at[1] * step[1]) / length2
                })
            })
            .collect();
        cuts.sort_by(f64::total_cmp);
        cuts.chunks_exact(2).map(|pair| [pair[0], pair[1]]).filter(|[a, b]| a < b).collect()
    }
}

/// A closed line, counter-clockwise for the outline and clockwise for a hole.
fn ring(line: usize, places: &[Place]) -> Result<Vec<Place>, OutlineError> {
    let mut ring: Vec<Place> = Vec::with_capacity(places.len());
    for &at_mm in places {
        if !at_mm.iter().all(|mm| mm.abs() <= RANGE_MM) {
            return Err(OutlineError::Place { at_mm });
        }
        // Adding zero makes negative zero positive.
        let place = at_mm.map(|mm| mm + 0.0);
        if ring.last() != Some(&place) {
            ring.push(place);
        }
    }
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    if ring.len() < 3 {
        return Err(OutlineError::Places { line, places: ring.len() });
    }
    let area_mm2 = ring_area_mm2(&ring);
    if area_mm2 == 0.0 {
        return Err(OutlineError::Empty { line });
    }
    if (area_mm2 > 0.0) != (line == 0) {
        ring.reverse();
    }
    Ok(ring)
}

/// The area a closed line encloses, positive if it runs counter-clockwise.
pub fn ring_area_mm2(ring: &[Place]) -> f64 {
    let Some(&[x0, y0]) = ring.first() else { return 0.0 };
    let mut twice = Sum::default();
    for (p, q) in ring_sides(ring) {
        twice.add((p[0] - x0) * (q[1] - y0));
        twice.add(-(p[1] - y0) * (q[0] - x0));
    }
    0.5 * twice.total()
}

/// The sides of a closed line, each with its beginning and its end.
fn ring_sides(ring: &[Place]) -> impl Iterator<Item = (Place, Place)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Whether a closed line runs about a place an odd number of times; of a place on it, whichever. Decided exactly.
pub fn ring_contains(ring: &[Place], at: Place) -> bool {
    ring_sides(ring).filter(|&(p, q)| side_right_of(p, q, at)).count() % 2 == 1
}

/// Whether a ray from `at` along +x crosses the side, exactly; a side has its lower end and not its upper.
pub fn side_right_of(p: Place, q: Place, at: Place) -> bool {
    if (p[1] > at[1]) == (q[1] > at[1]) {
        return false;
    }
    let turn = orientation(p, q, at);
    if q[1] > p[1] { turn == Ordering::Greater } else { turn == Ordering::Less }
}

/// Whether a place lies on a side, exactly.
fn side_meets(p: Place, q: Place, at: Place) -> bool {
    let between =
        (0..2).all(|axis| p[axis].min(q[axis]) <= at[axis] && at[axis] <= p[axis].max(q[axis]));
    between && orientation(p, q, at) == Ordering::Equal
}

#[cfg(test)]
mod tests;

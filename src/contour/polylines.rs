//! The distance of a place, or of a side, to lines.

mod tree;

use std::cell::Cell;

use asphera_geometry::side;

use self::tree::SideTree;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The sides of lines, found by their middles.
pub(crate) struct Polylines {
    sides: Vec<[PlaceMm; 2]>,
    tree: SideTree,
    /// Share of a distance by which what is found may be too long.
    slack: f64,
}

impl Polylines {
    /// The sides of lines: corners, and whether the last is joined to the first. A corner alone is a side without length.
    pub(crate) fn new(lines: &[(Vec<PlaceMm>, bool)]) -> Polylines {
        let mut sides = Vec::new();
        for (places, closed) in lines {
            sides.extend(places.windows(2).map(|pair| [pair[0], pair[1]]));
            match (&places[..], closed) {
                ([only], _) => sides.push([*only, *only]),
                ([first, .., last], true) => sides.push([*last, *first]),
                _ => {}
            }
        }
        Polylines::of_sides(sides)
    }

    /// Sides by their ends in mm, in any order.
    pub(crate) fn of_sides(sides: Vec<[PlaceMm; 2]>) -> Polylines {
        Polylines { tree: SideTree::new(&sides), sides, slack: 0.0 }
    }

    /// The same with distances that may be too long by a share of 10⁻⁶.
    ///
    /// So sides that lie nearly in one place, as the centres of a circle's samples, are not all looked at.
    pub(crate) fn nearly(self) -> Polylines {
        Polylines { slack: 1e-6, ..self }
    }

    /// The distance of a place to the nearest place on a side in mm; none without sides.
    pub(crate) fn distance_mm(&self, place: PlaceMm) -> Option<f64> {
        self.nearest(place).map(|(_, distance_mm)| distance_mm)
    }

    /// The nearest side to a place and its distance in mm; none without sides.
    pub(crate) fn nearest(&self, place: PlaceMm) -> Option<(u32, f64)> {
        self.least([place; 2], |side, most_mm| distance_within_mm(side, place, most_mm))
    }

    /// The distance of the nearest side to a side in mm, 0 where they cross; none without sides.
    pub(crate) fn distance_to_side_mm(&self, [p, q]: [PlaceMm; 2]) -> Option<f64> {
        let of = |side, most_mm| between_sides_mm([p, q], side, most_mm);
        self.least([p, q], of).map(|(_, distance_mm)| distance_mm)
    }

    /// The side nearest to one, and the distance, as `of` finds it; it may find none where that is above a length.
    fn least(
        &self,
        [p, q]: [PlaceMm; 2],
        of: impl Fn([PlaceMm; 2], f64) -> Option<f64>,
    ) -> Option<(u32, f64)> {
        let (place, reach_mm) = (middle(p, q), 0.5 * distance_mm(p, q));
        let first = self.tree.nearest(place)?;
        let best = Cell::new((of(self.sides[first as usize], f64::INFINITY)?, first));
        self.tree.visit(
            |node, is_leaf| {
                let least_mm = best.get().0;
                let is_near = node.floor_mm(place) - reach_mm <= least_mm * (1.0 - self.slack);
                (is_leaf || is_near) && node.gap_mm([p, q]) <= least_mm
            },
            |side| {
                let (least_mm, first) = best.get();
                if let Some(found_mm) = of(self.sides[side as usize], least_mm)
                    && (found_mm < least_mm || (found_mm == least_mm && side < first))
                {
                    best.set((found_mm, side));
                }
            },
        );
        let (distance_mm, side) = best.get();
        Some((side, distance_mm))
    }
}

/// The place half way between two.
pub(crate) fn middle(p: PlaceMm, q: PlaceMm) -> PlaceMm {
    [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
}

/// The distance of a place from a side in mm; none where it is above `most_mm`.
fn distance_within_mm(side: [PlaceMm; 2], place: PlaceMm, most_mm: f64) -> Option<f64> {
    let way_mm = way_mm(side, place);
    (!is_longer(way_mm, most_mm)).then(|| way_mm[0].hypot(way_mm[1]))
}

/// The way to a place from the nearest one of a side, mm.
fn way_mm(side: [PlaceMm; 2], place: PlaceMm) -> [f64; 2] {
    let nearest = side::nearest_mm(side, place);
    [place[0] - nearest[0], place[1] - nearest[1]]
}

/// Whether a way is certainly longer than a length in mm. That needs no root, which takes longer than all else.
fn is_longer([x, y]: [f64; 2], length_mm: f64) -> bool {
    x * x + y * y > length_mm * length_mm * (1.0 + 8.0 * f64::EPSILON)
}

/// The distance of two sides in mm, 0 where they cross; none where it is above `most_mm`.
fn between_sides_mm([a, b]: [PlaceMm; 2], [p, q]: [PlaceMm; 2], most_mm: f64) -> Option<f64> {
    // No place of a side is farther from its middle than half its length; coordinates are rounded.
    let (at, half_mm) = (middle(a, b), 0.5 * distance_mm(a, b));
    let half_mm = half_mm + ROUNDING * (at[0].abs() + at[1].abs() + half_mm);
    let to_middle_mm = way_mm([p, q], at);
    if is_longer(to_middle_mm, (most_mm + half_mm) * (1.0 + ROUNDING)) {
        return None;
    }
    let turn = |o: PlaceMm, u: PlaceMm, v: PlaceMm| {
        (u[0] - o[0]) * (v[1] - o[1]) - (u[1] - o[1]) * (v[0] - o[0])
    };
    let apart = |first: f64, second: f64| (first > 0.0) != (second > 0.0);
    // Of a side so short that it is rounding alone any place may seem to lie on both sides.
    if !is_longer(to_middle_mm, half_mm)
        && apart(turn(a, b, p), turn(a, b, q))
        && apart(turn(p, q, a), turn(p, q, b))
    {
        return Some(0.0);
    }
    let ends = [([p, q], a), ([p, q], b), ([a, b], p), ([a, b], q)];
    ends.into_iter().fold(None, |least_mm, (side, end)| {
        let found_mm = distance_within_mm(side, end, least_mm.unwrap_or(most_mm));
        found_mm.map_or(least_mm, |found_mm| Some(least_mm.map_or(found_mm, |it| it.min(found_mm))))
    })
}

/// Of lengths that are differences of coordinates.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(index: u32) -> f64 {
        f64::from(index.wrapping_mul(0x9E37_79B9)) * 2.0_f64.powi(-32)
    }

    #[test]
    fn a_side_that_is_rounding_alone_crosses_nothing_far_off() {
        let along = |share: f64| [1.0 + 0.6 * share, 2.0 - 0.8 * share];
        for index in 0..2_000 {
            let at = along(30.0 + 10.0 * spread(index));
            // A few bits along the same line.
            let bit = f64::EPSILON * 16.0;
            let beside = [at[0] + 3.0 * bit, at[1] - 4.0 * bit];
            let short = Polylines::of_sides(vec![[at, beside]]);
            let found = short.distance_to_side_mm([along(0.0), along(1.0 + spread(7 * index))]);
            assert!(found.is_some_and(|it| it > 28.0), "{index}: {found:?}");
        }
    }

    #[test]
    fn the_nearest_side_is_that_of_looking_at_all() {
        // A line that slants and bends, some sides of it far longer than others.
        let place = |index: u32| {
            let share = f64::from(index) + 0.8 * spread(index);
            [3.0 + 0.01 * share, 0.02 * share + (0.005 * share).sin()]
        };
        let places: Vec<PlaceMm> = (0..1_000).map(place).collect();
        let mut sides: Vec<[PlaceMm; 2]> = places.windows(2).map(|it| [it[0], it[1]]).collect();
        sides.extend((0..30).map(|index| [place(31 * index), place(31 * index + 9)]));
        let lines = Polylines::of_sides(sides.clone());
        for index in 0..300 {
            let from = [14.0 * spread(3 * index), 22.0 * spread(5 * index + 1)];
            let to = [from[0] + spread(index) - 0.5, from[1] + spread(index + 9) - 0.5];
            let least =
                |of: &dyn Fn([PlaceMm; 2]) -> f64| sides.iter().map(|&it| of(it)).reduce(f64::min);
            let expected = least(&|side| side::distance_mm(side, from));
            assert_eq!(lines.distance_mm(from), expected);
            let between = |side| between_sides_mm([from, to], side, f64::INFINITY);
            let expected = least(&|side| between(side).unwrap_or(f64::INFINITY));
            assert_eq!(lines.distance_to_side_mm([from, to]), expected);
        }
    }
}

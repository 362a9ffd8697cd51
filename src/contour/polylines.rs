//! The distance of a place, or of a side, to lines.

use std::cell::Cell;

use asphera_geometry::{WeightedTree, side};

use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The sides of lines, found by their middles.
pub(crate) struct Polylines {
    sides: Vec<[PlaceMm; 2]>,
    /// Their middles; half their lengths are negative weights, so that weight + distance bounds the distance to a side.
    tree: WeightedTree,
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
        let middles = sides.iter().map(|&[p, q]| {
            let [x, y] = middle(p, q);
            ([x, y, 0.0], -0.5 * distance_mm(p, q))
        });
        let tree = WeightedTree::new(middles);
        Polylines { sides, tree, slack: 0.0 }
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
        self.least(place, 0.0, |side| side::distance_mm(side, place))
    }

    /// The distance of the nearest side to a side in mm, 0 where they cross; none without sides.
    pub(crate) fn distance_to_side_mm(&self, [p, q]: [PlaceMm; 2]) -> Option<f64> {
        let reach_mm = 0.5 * distance_mm(p, q);
        self.least(middle(p, q), reach_mm, |side| between_sides_mm([p, q], side))
            .map(|(_, distance_mm)| distance_mm)
    }

    /// The side of the least distance as `of` tells it, and that; `of` is at least that to `place` less `reach_mm`.
    fn least(
        &self,
        place: PlaceMm,
        reach_mm: f64,
        of: impl Fn([PlaceMm; 2]) -> f64,
    ) -> Option<(u32, f64)> {
        let at = [place[0], place[1], 0.0];
        let (first, _) = self.tree.nearest(at, |_| true)?;
        let best = Cell::new((of(self.sides[first as usize]), first));
        self.tree.visit(
            |bounds, weight_mm| {
                let floor_mm = bounds.squared_distance_mm2(at).sqrt() + weight_mm - reach_mm;
                floor_mm <= best.get().0 * (1.0 - self.slack)
            },
            |side| {
                let found = (of(self.sides[side as usize]), side);
                if found.0 < best.get().0 || (found.0 == best.get().0 && found.1 < best.get().1) {
                    best.set(found);
                }
                false
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

/// The distance of two sides in mm; 0 where they cross.
fn between_sides_mm([a, b]: [PlaceMm; 2], [p, q]: [PlaceMm; 2]) -> f64 {
    let turn = |o: PlaceMm, u: PlaceMm, v: PlaceMm| {
        (u[0] - o[0]) * (v[1] - o[1]) - (u[1] - o[1]) * (v[0] - o[0])
    };
    let apart = |first: f64, second: f64| (first > 0.0) != (second > 0.0);
    if apart(turn(a, b, p), turn(a, b, q)) && apart(turn(p, q, a), turn(p, q, b)) {
        return 0.0;
    }
    let ends = [
        side::distance_mm([p, q], a),
        side::distance_mm([p, q], b),
        side::distance_mm([a, b], p),
        side::distance_mm([a, b], q),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

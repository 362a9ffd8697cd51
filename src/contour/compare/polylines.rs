//! The distance of a place to lines.

use std::cell::Cell;

use asphera_geometry::WeightedTree;

use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// The sides of lines, found by their middles.
pub(super) struct Polylines {
    sides: Vec<[PlaceMm; 2]>,
    /// Their middles; half their lengths are negative weights, so that weight + distance bounds the distance to a side.
    tree: WeightedTree,
}

impl Polylines {
    /// The sides of lines: corners, and whether the last is joined to the first. A corner alone is a side without length.
    pub(super) fn new(lines: &[(Vec<PlaceMm>, bool)]) -> Polylines {
        let mut sides = Vec::new();
        for (places, closed) in lines {
            sides.extend(places.windows(2).map(|pair| [pair[0], pair[1]]));
            match (&places[..], closed) {
                ([only], _) => sides.push([*only, *only]),
                ([first, .., last], true) => sides.push([*last, *first]),
                _ => {}
            }
        }
        let middles = sides.iter().map(|&[p, q]| {
            ([0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0.0], -0.5 * distance_mm(p, q))
        });
        let tree = WeightedTree::new(middles);
        Polylines { sides, tree }
    }

    /// The distance of a place to the nearest place on a side in mm; none without sides.
    pub(super) fn distance_mm(&self, place: PlaceMm) -> Option<f64> {
        let at = [place[0], place[1], 0.0];
        let (first, _) = self.tree.nearest(at, |_| true)?;
        let best = Cell::new(self.to_side_mm(first, place));
        self.tree.visit(
            |bounds, weight_mm| bounds.squared_distance_mm2(at).sqrt() + weight_mm <= best.get(),
            |side| {
                best.set(best.get().min(self.to_side_mm(side, place)));
                false
            },
        );
        Some(best.get())
    }

    fn to_side_mm(&self, side: u32, [x, y]: PlaceMm) -> f64 {
        let [p, q] = self.sides[side as usize];
        let [along_x, along_y] = [q[0] - p[0], q[1] - p[1]];
        let squared = along_x * along_x + along_y * along_y;
        let share = match squared > 0.0 {
            true => (((x - p[0]) * along_x + (y - p[1]) * along_y) / squared).clamp(0.0, 1.0),
            false => 0.0,
        };
        distance_mm([x, y], [p[0] + share * along_x, p[1] + share * along_y])
    }
}

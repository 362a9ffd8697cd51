//! Sides: straight lines between two places of the plane, in mm.

use crate::predicates::Place;

/// Share of a side, from 0 at its beginning to 1, where it comes nearest to a place; 0 of a side without length.
pub fn share_along([p, q]: [Place; 2], at_mm: Place) -> f64 {
    let way = [q[0] - p[0], q[1] - p[1]];
    let from = [at_mm[0] - p[0], at_mm[1] - p[1]];
    let squared = way[0] * way[0] + way[1] * way[1];
    let along = from[0] * way[0] + from[1] * way[1];
    if squared > 0.0 { (along / squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// Place of a side that is nearest to another.
pub fn nearest_mm(side: [Place; 2], at_mm: Place) -> Place {
    let share = share_along(side, at_mm);
    let [p, q] = side;
    [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]
}

/// Distance of a place from a side in mm.
pub fn distance_mm(side: [Place; 2], at_mm: Place) -> f64 {
    let [x, y] = nearest_mm(side, at_mm);
    (at_mm[0] - x).hypot(at_mm[1] - y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_place_lies_across_the_side_or_at_an_end() {
        let side = [[1.0, 1.0], [5.0, 1.0]];
        assert_eq!((share_along(side, [2.0, 4.0]), distance_mm(side, [2.0, 4.0])), (0.25, 3.0));
        assert_eq!(
            (nearest_mm(side, [9.0, 4.0]), distance_mm(side, [9.0, 4.0])),
            ([5.0, 1.0], 5.0)
        );
        assert_eq!(nearest_mm([[2.0, 3.0]; 2], [7.0, 7.0]), [2.0, 3.0], "a side without length");
    }
}

//! Distances of places from a triangle mesh.

use asphera_geometry::{BoxMm, PointMm};
use rayon::prelude::*;

use crate::geometry::{dot, minus, scaled};
use crate::prove::boxes::Tree;
use crate::prove::corners;

/// The distance of each place from the nearest place of a triangle mesh, mm; infinite where there is no triangle.
///
/// # Panics
///
/// If a triangle names a point that there is not.
pub fn distances_mm(points_mm: &[PointMm], facets: &[[u32; 3]], places_mm: &[PointMm]) -> Vec<f64> {
    let boxes: Vec<_> =
        facets.iter().map(|&facet| BoxMm::about(corners(points_mm, facet))).collect();
    let tree = Tree::of(&boxes);
    let distance = |&place: &PointMm| {
        let square = |at: u32| {
            let way = minus(place, nearest(corners(points_mm, facets[at as usize]), place));
            dot(way, way)
        };
        tree.least(place, square).sqrt()
    };
    places_mm.par_iter().map(distance).collect()
}

/// The place of a triangle that is nearest to a place (C. Ericson, Real-Time Collision Detection, 2005, section 5.1.5).
pub(crate) fn nearest([a, b, c]: [PointMm; 3], place: PointMm) -> PointMm {
    let [ab, ac] = [minus(b, a), minus(c, a)];
    let along = |shares: [f64; 2]| {
        let [u, v] = shares;
        let way = [scaled(ab, u), scaled(ac, v)];
        [0, 1, 2].map(|axis| a[axis] + way[0][axis] + way[1][axis])
    };
    let [d1, d2] = [ab, ac].map(|side| dot(side, minus(place, a)));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let [d3, d4] = [ab, ac].map(|side| dot(side, minus(place, b)));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let toward_c = d1 * d4 - d3 * d2;
    if toward_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return along([d1 / (d1 - d3), 0.0]);
    }
    let [d5, d6] = [ab, ac].map(|side| dot(side, minus(place, c)));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let toward_b = d5 * d2 - d1 * d6;
    if toward_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return along([0.0, d2 / (d2 - d6)]);
    }
    let toward_a = d3 * d6 - d5 * d4;
    if toward_a <= 0.0 && d4 >= d3 && d5 >= d6 {
        let share = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return along([1.0 - share, share]);
    }
    let whole = toward_a + toward_b + toward_c;
    along([toward_b / whole, toward_c / whole])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against a fine raster of the triangles, and exactly at the seven regions of one.
    #[test]
    fn distances_are_those_of_a_raster() {
        let points = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0], [4.0, 3.0, 2.0]];
        let one = [[0, 1, 2]];
        let exact = [
            ([1.0, 1.0, 2.5], 2.5),
            ([-3.0, -4.0, 0.0], 5.0),
            ([7.0, 0.0, 4.0], 5.0),
            ([0.0, 8.0, 12.0], 13.0),
            ([2.0, -3.0, 4.0], 5.0),
            ([-4.0, 1.5, 3.0], 5.0),
            ([3.5, 3.5, 0.0], 2.5),
        ];
        for (place, expected) in exact {
            let found = distances_mm(&points, &one, &[place])[0];
            assert!((found - expected).abs() < 1e-12, "{place:?}: {found}");
        }
        let both = [[0, 1, 2], [1, 3, 2]];
        let raster: Vec<PointMm> = both
            .iter()
            .flat_map(|facet| {
                let [a, b, c] = corners(&points, *facet);
                (0..=100).flat_map(move |i| {
                    (0..=100 - i).map(move |j| {
                        let [u, v] = [i, j].map(|step| f64::from(step) / 100.0);
                        [0, 1, 2]
                            .map(|axis| a[axis] + u * (b[axis] - a[axis]) + v * (c[axis] - a[axis]))
                    })
                })
            })
            .collect();
        let places: Vec<PointMm> = (0..216)
            .map(|at| [at % 6, at / 6 % 6, at / 36].map(|step| 1.7 * f64::from(step) - 3.1))
            .collect();
        for (place, found) in places.iter().zip(distances_mm(&points, &both, &places)) {
            let least = raster.iter().map(|other| {
                let way = minus(*place, *other);
                dot(way, way).sqrt()
            });
            let least = least.fold(f64::INFINITY, f64::min);
            assert!(found <= least + 1e-12 && least - found < 0.06, "{found} {least}");
        }
        assert_eq!(distances_mm(&points, &[], &places)[0], f64::INFINITY);
    }
}

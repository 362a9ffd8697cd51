//! The deviation of a part as a whole on a flat chart, to be looked at.
//!
//! A sphere is drawn as two discs, its upper half on the left and its lower half on the right, both as seen from outside, y upwards.
//! Equal areas have equal areas there (J. H. Lambert, 1772). A cylinder is unrolled: along its axis to the right, round it upwards.
//! A plane is drawn as it lies.

use std::f64::consts::{FRAC_1_SQRT_2, PI, SQRT_2};

use asphera_form::Grid;
use asphera_geometry::PointMm;
use asphera_geometry::vector::{dot, minus};
use asphera_report::Map;

use super::shape::{Laid, Shape, across};
use crate::figures::map_of;

/// The mean deviation in the cells of the chart; `None` without extent.
pub(super) fn chart(laid: &Laid, points_mm: &[PointMm], deviations_mm: &[f64]) -> Option<Map> {
    let places: Vec<[f64; 2]> = points_mm.iter().map(|&point| place_mm(laid, point)).collect();
    let grid = grid(laid, &places)?;
    let mut sums = vec![(0.0, 0_u32); grid.nx * grid.ny];
    for ([x, y], deviation_mm) in places.iter().zip(deviations_mm) {
        let column = cell([grid.x_min_mm, grid.x_max_mm], *x, grid.nx);
        let row = cell([grid.y_min_mm, grid.y_max_mm], *y, grid.ny);
        let (sum, count) = &mut sums[row * grid.nx + column];
        *sum += 1e6 * deviation_mm;
        *count += 1;
    }
    let mean = |(sum, count): (f64, u32)| if count > 0 { sum / f64::from(count) } else { f64::NAN };
    let means_nm: Vec<f64> = sums.into_iter().map(mean).collect();
    Some(map_of(&grid, &means_nm))
}

/// Where a point is drawn, mm.
fn place_mm(laid: &Laid, point_mm: PointMm) -> [f64; 2] {
    let way = minus(point_mm, laid.centre_mm);
    let [u, v] = across(laid.axis);
    match laid.shape {
        Shape::Plane => [dot(way, u), dot(way, v)],
        Shape::Cylinder { radius_mm, .. } => {
            [dot(way, laid.axis), radius_mm * dot(way, v).atan2(dot(way, u))]
        }
        Shape::Sphere { radius_mm } => {
            let (_, [x, y, z]) = laid.off(point_mm);
            // At the pole 1, at the rim √2 in units of the length across.
            let stretch = SQRT_2 * radius_mm / (1.0 + z.abs()).sqrt();
            let aside_mm = MIDDLE * radius_mm;
            match z >= 0.0 {
                true => [stretch * x - aside_mm, stretch * y],
                // From below, x runs to the left.
                false => [aside_mm - stretch * x, stretch * y],
            }
        }
    }
}

fn grid(laid: &Laid, places: &[[f64; 2]]) -> Option<Grid> {
    if let Shape::Sphere { radius_mm } = laid.shape {
        let half_mm = HALF * radius_mm;
        let [wide, high] = [MIDDLE * radius_mm + half_mm, half_mm];
        let cells = cells_across(places.len() / 2);
        return Some(Grid {
            nx: 2 * cells,
            ny: cells,
            x_min_mm: -wide,
            x_max_mm: wide,
            y_min_mm: -high,
            y_max_mm: high,
        });
    }
    let side = |axis: usize| {
        places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| {
            [low.min(place[axis]), high.max(place[axis])]
        })
    };
    let [x_min_mm, x_max_mm] = side(0);
    let [y_min_mm, y_max_mm] = match laid.shape {
        Shape::Cylinder { radius_mm, .. } => [-PI * radius_mm, PI * radius_mm],
        _ => side(1),
    };
    let cells = cells_across(places.len());
    let is_wide = x_max_mm > x_min_mm && y_max_mm > y_min_mm;
    is_wide.then_some(Grid { nx: cells, ny: cells, x_min_mm, x_max_mm, y_min_mm, y_max_mm })
}

/// As many cells that most hold two points.
fn cells_across(points: usize) -> usize {
    ((points as f64).sqrt() * FRAC_1_SQRT_2).clamp(1.0, MOST_CELLS) as usize
}

fn cell([low, high]: [f64; 2], value: f64, count: usize) -> usize {
    // A cast saturates.
    (((value - low) / (high - low) * count as f64) as usize).min(count - 1)
}

/// How far the middle of a disc lies from that of the chart, in radii; its own radius is √2.
const MIDDLE: f64 = 1.5;
/// Half the side of the square about a disc, in radii.
const HALF: f64 = 1.5;
const MOST_CELLS: f64 = 96.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_halves_are_drawn_as_seen_and_by_area() {
        let laid = Laid {
            shape: Shape::Sphere { radius_mm: 2.0 },
            centre_mm: [1.0, 1.0, 1.0],
            axis: [0.0, 0.0, 1.0],
        };
        let place = |x: f64, y: f64, z: f64| place_mm(&laid, [1.0 + x, 1.0 + y, 1.0 + z]);
        assert_eq!(place(0.0, 0.0, 2.0), [-3.0, 0.0]);
        assert_eq!(place(0.0, 0.0, -2.0), [3.0, 0.0]);
        // The rim of either half, in the middle of the chart.
        let rim = 2.0 * SQRT_2;
        assert!((place(2.0, 0.0, 0.0)[0] - (rim - 3.0)).abs() < 1e-12);
        assert!((place(2.0, 0.0, -1e-12)[0] - (3.0 - rim)).abs() < 1e-9);
        // The cap above z has the area 2πR²(1 − z/R), and so has its disc.
        let z: f64 = 1.2;
        let r = (4.0 - z * z).sqrt();
        let [x, _] = place(r, 0.0, z);
        assert!(((x + 3.0).powi(2) - 2.0 * 4.0 * (1.0 - z / 2.0)).abs() < 1e-12);
    }

    #[test]
    fn means_stand_in_their_cells_and_gaps_stay_gaps() {
        let laid = Laid { shape: Shape::Plane, centre_mm: [0.0; 3], axis: [0.0, 0.0, 1.0] };
        let points: Vec<PointMm> =
            (0..32).map(|at| [f64::from(at % 2), f64::from(at / 16), 0.0]).collect();
        let deviations: Vec<f64> = points.iter().map(|[x, y, _]| 1e-6 * (x + 10.0 * y)).collect();
        let map = chart(&laid, &points, &deviations).unwrap();
        let known: Vec<f64> = map.values_nm.iter().copied().flatten().collect();
        assert_eq!((map.nx, map.ny, known.len()), (4, 4, 4));
        let mut sorted = known;
        sorted.sort_by(f64::total_cmp);
        assert_eq!(sorted, [0.0, 1.0, 10.0, 11.0]);
    }
}

//! Rasters recognised among places, and what linear interpolation leaves of waves where there is none.

use std::f64::consts::PI;

use asphera_figures::{Interpolation, Lattice};

use crate::common::Noise;

const COLUMNS: usize = 40;
const ROWS: usize = 30;

/// Places, triangles by them, and the column and row of each place.
type Raster = (Vec<[f64; 2]>, Vec<[u32; 3]>, Vec<[usize; 2]>);

/// Nodes of a raster, moved by `place`, without those that `is_gap` names; and the halves of its cells.
fn raster(place: impl Fn(f64, f64) -> [f64; 2], is_gap: impl Fn(usize, usize) -> bool) -> Raster {
    let (mut places, mut nodes) = (Vec::new(), Vec::new());
    let mut index = vec![None; COLUMNS * ROWS];
    for row in 0..ROWS {
        for column in 0..COLUMNS {
            if !is_gap(column, row) {
                index[row * COLUMNS + column] = Some(places.len() as u32);
                places.push(place(column as f64, row as f64));
                nodes.push([column, row]);
            }
        }
    }
    let mut triangles = Vec::new();
    for row in 0..ROWS - 1 {
        for column in 0..COLUMNS - 1 {
            let at = |c: usize, r: usize| index[(row + r) * COLUMNS + column + c];
            for half in [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]] {
                if let [Some(a), Some(b), Some(c)] = half {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    (places, triangles, nodes)
}

/// Where a node lies.
type Placing<'a> = &'a dyn Fn(f64, f64) -> [f64; 2];

fn turned(angle: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [1e3 + cos * x - sin * y, -500.0 + sin * x + cos * y]
}

#[test]
fn rasters_are_found_whatever_their_turn_steps_and_gaps() {
    let holes = |column: usize, row: usize| {
        let off = [column as f64 - 12.0, row as f64 - 9.0];
        off[0].hypot(off[1]) < 4.0 || (column * 7 + row * 11).is_multiple_of(53) || column + row < 6
    };
    for degrees in [0.0, 1e-3, 17.0, 44.9, -44.0, 90.0, 200.0] {
        for steps in [[0.1, 0.1], [0.02, 0.3], [0.3, 0.05]] {
            for tilt in [0.0, 0.005] {
                let angle: f64 = degrees * PI / 180.0;
                let place = |i: f64, j: f64| {
                    turned(angle, [steps[0] * i + tilt * steps[1] * j, steps[1] * j])
                };
                let (places, triangles, nodes) = raster(place, holes);
                let found = Lattice::find(&places, &triangles).unwrap();
                let is_across = (degrees as i32).rem_euclid(180) == 90;
                let size = if is_across { [ROWS, COLUMNS] } else { [COLUMNS, ROWS] };
                assert_eq!([found.columns(), found.rows()], size, "{degrees}°");
                let expected = if is_across { [steps[1], steps[0]] } else { steps };
                for (found, expected) in found.spacing_mm().iter().zip(expected) {
                    let share = found / expected;
                    assert!((share - 1.0).abs() < 1e-3 + tilt, "{share}");
                }
                assert_eq!(found.places().flatten().count(), nodes.len());
                if tilt == 0.0 {
                    // Each place lies where its node says.
                    let [x0, y0] = found.origin_mm();
                    let (sin, cos) = found.turn_rad().sin_cos();
                    for (node, place) in found.places().enumerate() {
                        let Some(place) = place else { continue };
                        let at = [node % found.columns(), node / found.columns()];
                        let [u, v] = [0, 1].map(|axis| at[axis] as f64 * found.spacing_mm()[axis]);
                        let off = [
                            x0 + cos * u - sin * v - places[place][0],
                            y0 + sin * u + cos * v - places[place][1],
                        ];
                        assert!(
                            off[0].hypot(off[1]) < 1e-3 * steps[0].min(steps[1]),
                            "{degrees}°: {off:?}"
                        );
                    }
                }
            }
        }
    }
    let (places, triangles, _) = raster(|i, j| [0.1 * i, 0.1 * j], |_, _| false);
    let upright = Lattice::find(&places, &triangles).unwrap();
    assert_eq!(upright.turn_rad(), 0.0);
    assert!(upright.places().map(|place| place.unwrap()).eq(0..COLUMNS * ROWS));
}

#[test]
fn what_is_no_raster_is_none() {
    let mut noise = Noise::new(7);
    let mut off = || 0.1 * noise.next();
    let shaken: Vec<[f64; 2]> = (0..COLUMNS * ROWS).map(|_| [off(), off()]).collect();
    let at = |i: f64, j: f64| shaken[j as usize * COLUMNS + i as usize];
    let odd = |j: f64| (j as usize % 2) as f64;
    let kinds: [(&str, Placing<'_>); 5] = [
        ("jitter of a tenth", &|i, j| [i + at(i, j)[0], j + at(i, j)[1]]),
        ("every second line shifted by a tenth", &|i, j| [i + 0.1 * odd(j), j]),
        ("hexagonal", &|i, j| [i + 0.5 * odd(j), 0.75_f64.sqrt() * j]),
        ("lines ever farther apart", &|i, j| [i, j + 0.002 * j * j]),
        ("polar", &|i, j| [(5.0 + j) * (0.1 * i).cos(), (5.0 + j) * (0.1 * i).sin()]),
    ];
    for (name, place) in kinds {
        let (places, triangles, _) = raster(place, |_, _| false);
        assert_eq!(Lattice::find(&places, &triangles), None, "{name}");
    }
    assert_eq!(Lattice::find(&[], &[]), None);
}

/// One point beside its node took the raster away, and with it all power above a fifth of the highest frequency.
#[test]
fn a_few_strays_leave_a_raster_what_it_is() {
    let (mut places, triangles, _) = raster(|i, j| [i, j], |_, _| false);
    let whole = Lattice::find(&places, &triangles).unwrap();
    assert_eq!(whole.strays(), 0);
    let nodes = places.len();
    // Between nodes, beside one that is occupied, far outside; and one that has left its node.
    places.extend([[3.4, 5.0], [3.01, 5.0], [-40.3, 70.4]]);
    places[7][0] += 0.3;
    let found = Lattice::find(&places, &triangles).unwrap();
    assert_eq!(found.strays(), 4);
    assert_eq!((found.columns(), found.rows()), (whole.columns(), whole.rows()));
    let expected = whole.places().map(|place| place.filter(|place| *place != 7));
    assert!(found.places().eq(expected));
    // The nearer of two has the node, in whichever order they come.
    places.swap(nodes + 1, 5 * COLUMNS + 3);
    let swapped = Lattice::find(&places, &triangles).unwrap();
    assert_eq!(swapped.places().nth(5 * COLUMNS + 3), Some(Some(nodes + 1)));
    // One in a hundred is the most.
    places.extend((0..nodes / 90).map(|i| [i as f64 + 0.4, 2.5]));
    assert_eq!(Lattice::find(&places, &triangles), None);
}

/// Along the rows of a raster linear interpolation is convolution with a hat of two steps, whose transform is sinc².
#[test]
fn a_raster_interpolated_leaves_a_sinc_to_the_fourth() {
    let (places, triangles, _) = raster(|i, j| [0.2 * i, 0.1 * j], |_, _| false);
    let found = Interpolation::over(&places, &triangles, 2.5);
    for frequency in [0.2, 0.625, 1.0, 1.25, 2.0, 2.5] {
        for (step, at) in [(0.2, [frequency, 0.0]), (0.1, [0.0, -frequency])] {
            let x = PI * frequency * step;
            let (left, expected) = (found.power(at), (x.sin() / x).powi(4));
            assert!((left - expected).abs() < 0.012, "{at:?}: {left}, not {expected}");
        }
    }
    // sinc⁴ is a half at x = 1.0019; a little askew to the rows, towards the diagonals of the cells, it is so earlier.
    let half = found.half_power_per_mm() / (1.0019 / (PI * 0.2));
    assert!((0.93..1.01).contains(&half), "{half}");
    let none = Interpolation::over(&[], &[], 1.0);
    assert_eq!((none.power([0.5, 0.0]), none.half_power_per_mm()), (1.0, 1.0));
}

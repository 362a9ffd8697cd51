//! Figures that compare two outcomes, against what is known of simple shapes.

use asphera_contour::{Deviation, Graph, IouError, PlaceMm, agreement, intersection_over_union};

use crate::places::circle;

fn square(x: f64, y: f64, side: f64) -> Vec<PlaceMm> {
    vec![[x, y], [x + side, y], [x + side, y + side], [x, y + side]]
}

#[test]
fn distances_of_two_sets() {
    let found = Deviation::between(&[[0.0, 0.0], [1.0, 0.0]], &[[0.0, 3.0], [1.0, 0.0]]).unwrap();
    // 1 and 0 forth, 10 of the way from (0, 3) to (1, 0)'s nearest: (0, 0) at 3; 0 back.
    assert_eq!(found.hausdorff_mm, 3.0);
    assert!((found.rms_mm - (10.0_f64 / 4.0).sqrt()).abs() < 1e-15);
    assert_eq!(Deviation::between(&[], &[[0.0, 0.0]]), None);
    assert_eq!(Deviation::between(&[], &[]), None);
}

#[test]
fn distances_of_lines() {
    // A square of 2 mm within one of 4 mm: corners of the inner are 1 mm off, those of the outer √2.
    let lines = |x: f64, side: f64| vec![(square(x, x, side), true)];
    let found = Deviation::between_lines(&lines(-1.0, 2.0), &lines(-2.0, 4.0)).unwrap();
    assert!((found.hausdorff_mm - 2.0_f64.sqrt()).abs() < 1e-15);
    assert!((found.rms_mm - 1.5_f64.sqrt()).abs() < 1e-15);
    // Open, the side that closes the outer square is not there: two corners of the inner still lie 1 mm off.
    let open = vec![(square(-2.0, -2.0, 4.0), false)];
    assert_eq!(Deviation::between_lines(&lines(-1.0, 2.0), &open), Some(found));
    let single = vec![(vec![[0.0, 0.0]], false)];
    let found = Deviation::between_lines(&single, &lines(-2.0, 4.0)).unwrap();
    assert_eq!(found.hausdorff_mm, 8.0_f64.sqrt());
    assert_eq!(Deviation::between_lines(&[], &single), None);
    // Many sides, against all of them.
    let wave: Vec<PlaceMm> =
        (0..500).map(|step| [0.02 * f64::from(step), f64::from(step % 7)]).collect();
    let places = crate::places::scattered(50, 3);
    for &place in &places {
        let found =
            Deviation::between_lines(&[(vec![place], false)], &[(wave.clone(), false)]).unwrap();
        let far: Vec<f64> =
            wave.iter().map(|&corner| crate::places::distance(corner, place)).collect();
        let expected = far.iter().copied().fold(0.0, f64::max);
        assert!((found.hausdorff_mm - expected).abs() < 1e-12);
        // What is left of the sum of squares is that of the place to the line.
        let squares = found.rms_mm.powi(2) * 501.0 - far.iter().map(|way| way * way).sum::<f64>();
        let on_sides = wave.windows(2).flat_map(|pair| {
            (0..=200).map(|step| {
                let share = f64::from(step) / 200.0;
                [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]))
            })
        });
        let nearest =
            on_sides.map(|at| crate::places::distance(at, place)).fold(f64::INFINITY, f64::min);
        assert!((squares.max(0.0).sqrt() - nearest).abs() < 0.02, "{squares} {nearest}");
    }
}

#[test]
fn overlaps_of_squares_rings_and_circles() {
    let iou = |a: &[Vec<PlaceMm>], b: &[Vec<PlaceMm>]| intersection_over_union(a, b).unwrap();
    let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found}");
    near(iou(&[square(0.0, 0.0, 2.0)], &[square(0.0, 0.0, 2.0)]), 1.0);
    near(iou(&[square(0.0, 0.0, 2.0)], &[square(1.0, 1.0, 2.0)]), 1.0 / 7.0);
    near(iou(&[square(0.0, 0.0, 2.0)], &[square(5.0, 0.0, 2.0)]), 0.0);
    // A hole, given as a line within.
    let ring = [square(0.0, 0.0, 3.0), square(1.0, 1.0, 1.0)];
    near(iou(&ring, &[square(0.0, 0.0, 3.0)]), 8.0 / 9.0);
    // Turned by 45° the sides cross: a square of diagonal 2·√2 over one of side 2 leaves a regular octagon.
    let diamond: Vec<PlaceMm> = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]
        .map(|place: PlaceMm| place.map(|value| value * 2_f64.sqrt()))
        .to_vec();
    let octagon = 8.0 * (2_f64.sqrt() - 1.0);
    near(iou(&[square(-1.0, -1.0, 2.0)], &[diamond]), octagon / (8.0 - octagon));
    let coarse = circle(100_000 / 50);
    let smaller: Vec<PlaceMm> = coarse.iter().map(|place| place.map(|value| 0.9 * value)).collect();
    near(iou(&[coarse], &[smaller]), 0.81);
    assert_eq!(intersection_over_union(&[], &[]), Err(IouError::NoArea));
    assert_eq!(intersection_over_union(&[vec![[f64::NAN, 0.0]]], &[]), Err(IouError::NotFinite));
}

/// Two combs across each other: of teeth and gaps alike a quarter is in common. There are 4·n² crossings.
#[test]
fn outlines_that_cross_often_have_their_area() {
    let comb = |teeth: u32, flipped: bool| -> Vec<PlaceMm> {
        let place = |x: f64, y: f64| if flipped { [y, x] } else { [x, y] };
        let wide = 1.0 / f64::from(teeth);
        let tooth = (0..teeth).flat_map(|tooth| {
            let x = f64::from(tooth) * wide;
            [place(x, 0.0), place(x, 1.0), place(x + 0.5 * wide, 1.0), place(x + 0.5 * wide, 0.0)]
        });
        // Turned a little, so that no side is upright.
        let (sin, cos) = 0.3_f64.sin_cos();
        tooth.map(|[x, y]| [x * cos - y * sin, x * sin + y * cos]).collect()
    };
    for teeth in [4, 50, 1000] {
        // Half of the square is in each, and a quarter in both; the sides that join the teeth lie on one line and enclose nothing.
        let found = intersection_over_union(&[comb(teeth, false)], &[comb(teeth, true)]).unwrap();
        assert!((found - 1.0 / 3.0).abs() < 1e-9, "{teeth} teeth: {found}");
    }
    let wave = |count: u32, waves: f64| -> Vec<PlaceMm> {
        let at = |index: u32| {
            let angle = std::f64::consts::TAU * f64::from(index) / f64::from(count);
            let radius = 10.0 + 3.0 * (waves * angle).sin();
            [radius * angle.cos(), radius * angle.sin()]
        };
        (0..count).map(at).collect()
    };
    // The faces that Shapely 2.2 (GEOS) cuts the lines into, by parity.
    let found = intersection_over_union(&[wave(300, 7.0)], &[wave(400, 9.0)]).unwrap();
    assert!((found - 0.623_614_252_306_813_7).abs() < 1e-12, "{found}");
    // A star of 401 tips crosses itself 89 times a side, in order.
    let star: Vec<PlaceMm> = (0..401)
        .map(|tip| f64::from(tip) * 90.0 * std::f64::consts::TAU / 401.0)
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    let stars = [star];
    assert_eq!(intersection_over_union(&stars, &stars), Ok(1.0));
    let scattered = crate::places::scattered(2_000, 3);
    let square = square(0.0, 0.0, 1.0);
    assert_eq!(intersection_over_union(&[square], &[scattered]), Err(IouError::NoOrder { of: 1 }));
}

#[test]
fn edges_in_common() {
    let truth = Graph::new([[0, 1], [1, 2], [2, 3], [3, 0]]);
    let found = agreement(&Graph::new([[1, 0], [2, 1], [0, 2]]), &truth);
    assert!((found.precision - 2.0 / 3.0).abs() < 1e-15);
    assert_eq!(found.recall, 0.5);
}

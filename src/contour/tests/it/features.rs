//! Circles and deviations against analytic truths, brute force and thousands of draws.

use std::f64::consts::TAU;

use asphera_contour::PlaceMm;
use asphera_contour::features::{Circle, NominalOutline, minimum_zone, noise_range};
use asphera_contour::sampler::BezierLine;
use asphera_geometry::Numbers;

use crate::places::{Random, distance};

/// Points round a circle of 20 mm with normal noise and a wave of three lobes.
fn round(count: usize, sigma: f64, lobes: f64, draw: u32) -> Vec<PlaceMm> {
    let numbers = Numbers::new(40, draw, 0);
    (0..count)
        .map(|index| {
            let angle = TAU * index as f64 / count as f64;
            let radius = 10.0 + sigma * numbers.normal(index) + lobes * (3.0 * angle).cos();
            [3.0 + radius * angle.cos(), -7.0 + radius * angle.sin()]
        })
        .collect()
}

#[test]
fn exact_circles_are_found_exactly() {
    for count in [4, 5, 100] {
        let found = Circle::fit(&round(count, 0.0, 0.0, 0)).unwrap();
        assert!((found.diameter_mm - 20.0).abs() < 1e-13 && found.roundness_mm < 1e-13);
        assert!(distance(found.centre_mm, [3.0, -7.0]) < 1e-13);
        assert!((found.span_deg - 360.0 * (1.0 - 1.0 / count as f64)).abs() < 1e-9);
    }
    // Lobes are orthogonal to the terms of a circle.
    let lobes = Circle::fit(&round(360, 0.0, 0.01, 0)).unwrap();
    assert!((lobes.roundness_mm - 0.02).abs() < 1e-6 && (lobes.diameter_mm - 20.0).abs() < 1e-5);
    assert!((lobes.deviation_rms_mm - 0.01 / 2.0_f64.sqrt()).abs() < 1e-6);
}

#[test]
fn what_is_no_circle_has_none() {
    let line: Vec<PlaceMm> = (0..20).map(|x| [f64::from(x), 2.0 * f64::from(x)]).collect();
    assert!(Circle::fit(&line).is_none() && Circle::fit(&line[..3]).is_none());
    assert!(Circle::fit(&[[1.0, 1.0]; 9]).is_none());
}

#[test]
fn uncertainties_hold_the_truth_of_two_thousand_draws() {
    // 20 mm, 10,000 points, 1 µm.
    let draws = 2000;
    let (mut diameter, mut centre, mut roundness) = (0, 0, 0);
    for draw in 0..draws {
        let found = Circle::fit(&round(10_000, 1e-3, 0.0, draw)).unwrap();
        diameter += u32::from((found.diameter_mm - 20.0).abs() <= 1.96 * found.u_diameter_mm);
        centre += u32::from((found.centre_mm[0] - 3.0).abs() <= 1.96 * found.u_centre_mm[0]);
        // The true roundness is zero.
        roundness += u32::from(found.roundness_mm <= 2.0 * found.u_roundness_mm);
        assert!((found.noise_sigma_mm - 1e-3).abs() < 1e-4);
    }
    let percent =
        [diameter, centre, roundness].map(|held| 100.0 * f64::from(held) / f64::from(draws));
    println!("diameter, centre, roundness held: {percent:?} %");
    assert!(percent.iter().all(|percent| (percent - 95.0).abs() <= 2.0), "{percent:?}");
}

#[test]
fn ranges_of_normal_numbers() {
    // Tables of the studentized range with infinitely many degrees of freedom (E. S. Pearson, H. O. Hartley 1966).
    for (count, share, expected) in [
        (2, 0.95, 2.772),
        (3, 0.95, 3.314),
        (10, 0.95, 4.474),
        (10, 0.99, 5.157),
        (100, 0.95, 6.085),
    ] {
        let found = noise_range(count, share);
        assert!((found - expected).abs() < 2e-3, "{count} {share}: {found}");
    }
    assert_eq!(noise_range(1, 0.95), 0.0);
}

#[test]
fn minimum_zones_are_the_best_of_all_candidates() {
    let mut random = Random::new(41);
    for trial in 0..40 {
        let count = 5 + trial % 8;
        let points: Vec<PlaceMm> = (0..count)
            .map(|index| {
                let angle = TAU * (index as f64 + random.between(0.0, 0.9)) / count as f64;
                let radius = 10.0 + random.between(-0.3, 0.3);
                [radius * angle.cos(), radius * angle.sin()]
            })
            .collect();
        let start = Circle::fit(&points).unwrap();
        let found = minimum_zone(&points, start.centre_mm, 0.5 * start.diameter_mm).unwrap();
        assert!(found.width_mm <= start.roundness_mm * (1.0 + 1e-12));
        // The centre is equally far from two points, and from two: all such places.
        let width = |at: PlaceMm| {
            let ways: Vec<f64> = points.iter().map(|&point| distance(point, at)).collect();
            ways.iter().copied().fold(0.0, f64::max)
                - ways.iter().copied().fold(f64::INFINITY, f64::min)
        };
        let pairs: Vec<[PlaceMm; 2]> = (0..count)
            .flat_map(|i| (0..i).map(move |j| (i, j)))
            .map(|(i, j)| [points[i], points[j]])
            .collect();
        let mut best = f64::INFINITY;
        for (i, &first) in pairs.iter().enumerate() {
            for &second in &pairs[..i] {
                // x·(q - p) = (q² - p²)/2 for both.
                let row = |[p, q]: [PlaceMm; 2]| {
                    let square = |a: PlaceMm| a[0] * a[0] + a[1] * a[1];
                    [q[0] - p[0], q[1] - p[1], 0.5 * (square(q) - square(p))]
                };
                let ([a, b, e], [c, d, f]) = (row(first), row(second));
                let det = a * d - b * c;
                let at = [(e * d - b * f) / det, (a * f - e * c) / det];
                if at[0].hypot(at[1]) < 2.0 {
                    best = best.min(width(at));
                }
            }
        }
        assert!((found.width_mm - best).abs() < 1e-9, "{} {best}", found.width_mm);
    }
}

#[test]
fn a_minimum_zone_of_alternating_rings_is_their_distance() {
    let points: Vec<PlaceMm> = (0..200)
        .map(|index| {
            let (sin, cos) = (TAU * f64::from(index) / 200.0).sin_cos();
            let radius = if index % 2 == 0 { 10.0 } else { 10.02 };
            [1.0 + radius * cos, radius * sin]
        })
        .collect();
    let found = minimum_zone(&points, [1.001, 0.002], 10.0).unwrap();
    assert!((found.width_mm - 0.02).abs() < 1e-12 && (found.radius_mm - 10.01).abs() < 1e-12);
}

fn polygon(corners: &[PlaceMm]) -> BezierLine {
    let count = corners.len();
    let pieces = (0..count).map(|index| {
        let [p, q] = [corners[index], corners[(index + 1) % count]];
        let at = |share: f64| [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])];
        [p, at(1.0 / 3.0), at(2.0 / 3.0), q]
    });
    BezierLine { pieces: pieces.collect(), closed: true }
}

#[test]
fn deviations_from_polygons_with_holes() {
    let square = |half: f64| [[-half, -half], [half, -half], [half, half], [-half, half]];
    let mut hole = square(1.0);
    for reverse in [false, true] {
        if reverse {
            hole.reverse();
        }
        let outline = NominalOutline::new(&[polygon(&square(5.0)), polygon(&hole)]).unwrap();
        let points =
            [[6.0, 0.0], [4.5, 1.0], [8.0, 9.0], [0.0, 0.5], [1.25, 0.0], [4.0, 4.5], [5.0, 2.0]];
        let found = outline.deviations(&points);
        let expected = [1.0, -0.5, 5.0, 0.5, -0.25, -0.5, 0.0];
        for (found, expected) in found.deviations_mm.iter().zip(expected) {
            let found = found.unwrap();
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
        assert!(distance(found.feet_mm[2], [5.0, 5.0]) < 1e-12);
        let [high, low, rms] = found.extremes_mm().unwrap();
        assert!((high - 5.0).abs() < 1e-12 && (low + 0.5).abs() < 1e-12 && rms > 1.9);
    }
    assert!(NominalOutline::new(&[]).is_none());
}

#[test]
fn deviations_from_curves_are_those_of_the_curves() {
    // A circle of 16 pieces: no Bézier curve is a circle, but these are to 4e-8 of the radius.
    let step = TAU / 16.0;
    let handle = 4.0 / 3.0 * (step / 4.0).tan();
    let pieces = (0..16).map(|index| {
        let (s0, c0) = (step * f64::from(index)).sin_cos();
        let (s1, c1) = (step * f64::from((index + 1) % 16)).sin_cos();
        [
            [c0, s0],
            [c0 - handle * s0, s0 + handle * c0],
            [c1 + handle * s1, s1 - handle * c1],
            [c1, s1],
        ]
        .map(|[x, y]| [10.0 * x, 10.0 * y])
    });
    let line = BezierLine { pieces: pieces.collect(), closed: true };
    let open = BezierLine { closed: false, pieces: line.pieces[..4].to_vec() };
    let outline = NominalOutline::new(&[line]).unwrap();
    let mut random = Random::new(42);
    for _ in 0..500 {
        let (sin, cos) = random.between(0.0, TAU).sin_cos();
        let off = random.between(-1.0, 1.0) * 10_f64.powf(random.between(-6.0, 0.5));
        let found = outline.deviations(&[[(10.0 + off) * cos, (10.0 + off) * sin]]).deviations_mm
            [0]
        .unwrap();
        assert!((found - off).abs() < 1e-6, "{found} {off}");
    }
    // Left of the open quarter lies its middle.
    let outline = NominalOutline::new(&[open]).unwrap();
    let found = outline.deviations(&[[6.0, 6.0], [8.0, 8.0]]).deviations_mm;
    assert!(found[0].unwrap() > 1.0 && found[1].unwrap() < -1.0, "{found:?}");
}

/// The line through corners that is not closed.
fn open(corners: &[PlaceMm]) -> NominalOutline {
    let mut line = polygon(corners);
    line.pieces.pop();
    line.closed = false;
    NominalOutline::new(&[line]).unwrap()
}

fn deviation_of(outline: &NominalOutline, place: PlaceMm) -> Option<f64> {
    outline.deviations(&[place]).deviations_mm[0]
}

#[test]
fn points_beyond_the_ends_of_an_open_line_have_no_deviation() {
    // An arc of 10 mm from 10° to 350°, counter-clockwise, and points 0.05 mm outside it: its right.
    let place = |degrees: f64, radius: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [radius * cos, radius * sin]
    };
    let handle = 4.0 / 3.0 * (5_f64.to_radians() / 4.0).tan();
    let pieces = (0..68).map(|index| {
        let [from, to] =
            [f64::from(index), f64::from(index + 1)].map(|it| place(10.0 + 5.0 * it, 10.0));
        let by = |[x, y]: PlaceMm, way: f64| [x - way * handle * y, y + way * handle * x];
        [from, by(from, 1.0), by(to, -1.0), to]
    });
    let arc =
        NominalOutline::new(&[BezierLine { pieces: pieces.collect(), closed: false }]).unwrap();
    let points: Vec<PlaceMm> =
        (0..1440).map(|index| place(0.25 * f64::from(index), 10.05)).collect();
    let found = arc.deviations(&points);
    for (index, deviation) in found.deviations_mm.iter().enumerate() {
        let degrees = 0.25 * index as f64;
        match (10.0..=350.0).contains(&degrees) {
            true => assert!((deviation.unwrap() + 0.05).abs() < 1e-6, "{degrees}: {deviation:?}"),
            false => assert_eq!(*deviation, None, "{degrees}"),
        }
    }
    let [high, low, rms] = found.extremes_mm().unwrap();
    assert!([high, low, -rms].iter().all(|it| (it + 0.05).abs() < 1e-6), "{high} {low} {rms}");
    let beyond = arc.deviations(&[place(0.0, 10.0), place(3.0, 9.0)]);
    assert_eq!((beyond.extremes_mm(), beyond.deviations_mm), (None, vec![None, None]));
}

#[test]
fn signs_at_corners_and_ends_of_open_lines() {
    // Three sides of a square, counter-clockwise: left is within.
    let sides = open(&[[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]);
    for (place, expected) in [
        ([5.0, 0.1], Some(0.1)),
        ([5.0, -0.1], Some(-0.1)),
        ([0.0, -0.1], Some(-0.1)),
        ([0.0, 10.1], Some(-0.1)),
        ([0.0, 0.0], Some(0.0)),
        ([-0.001, -0.1], None),
        ([-0.1, 5.0], None),
        ([-0.1, 10.0], None),
        ([13.0, -4.0], Some(-5.0)),
        ([13.0, 14.0], Some(-5.0)),
        ([9.9, 0.2], Some(0.1)),
    ] {
        let found = deviation_of(&sides, place);
        let is_right = match (found, expected) {
            (Some(found), Some(expected)) => (found - expected).abs() < 1e-12,
            (found, expected) => found == expected,
        };
        assert!(is_right, "{place:?}: {found:?}, not {expected:?}");
    }
    // A tip of nearly 6°, turned about all round: all places whose foot is the tip lie right of the way to it and from it.
    for turn in 0..360 {
        let turned = |[x, y]: PlaceMm| {
            let (sin, cos) = f64::from(turn).to_radians().sin_cos();
            [cos * x - sin * y, sin * x + cos * y]
        };
        let tip = open(&[[-10.0, -0.5], [0.0, 0.0], [-10.0, 0.5]].map(turned));
        for degrees in -87..=87 {
            let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
            let found = deviation_of(&tip, turned([cos, sin])).unwrap();
            assert!((found + 1.0).abs() < 1e-9, "{turn} {degrees}: {found}");
        }
        assert!(deviation_of(&tip, turned([-5.0, 0.0])).unwrap() > 0.2);
    }
    // A line that ends where it begins has no end there.
    let back = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 1e-12]];
    let found = deviation_of(&open(&back), [-3.0, -4.0]).unwrap();
    assert!((found + 5.0).abs() < 1e-9, "{found}");
}

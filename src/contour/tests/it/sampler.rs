//! Samples of known curves against analytic truths and against the conditions they were made for.

use std::f64::consts::{PI, TAU};

use asphera_contour::curves::{hnn_crust, nn_crust};
use asphera_contour::sampler::{BezierLine, Disturbance, Spacing, TrueCurve, borders};
use asphera_contour::{CurveSampling, PlaceMm};

use crate::places::{Random, by_row, closed, distance, triangulation};

/// An ellipse of 64 pieces: a Bézier curve leaves its arc by less than 1e-9.
fn ellipse(half_axes: [f64; 2]) -> BezierLine {
    let count = 64;
    let step = TAU / f64::from(count);
    let handle = 4.0 / 3.0 * (step / 4.0).tan();
    let pieces = (0..count).map(|index| {
        let (s0, c0) = (step * f64::from(index)).sin_cos();
        let (s1, c1) = (step * f64::from((index + 1) % count)).sin_cos();
        [
            [c0, s0],
            [c0 - handle * s0, s0 + handle * c0],
            [c1 + handle * s1, s1 - handle * c1],
            [c1, s1],
        ]
        .map(|[x, y]| [half_axes[0] * x, half_axes[1] * y])
    });
    BezierLine { pieces: pieces.collect(), closed: true }
}

/// A smooth closed curve through corners at random about a circle (cardinal spline).
pub(crate) fn random_curve(random: &mut Random) -> BezierLine {
    let count = 9;
    let corners: Vec<PlaceMm> = (0..count)
        .map(|index| {
            let (sin, cos) = (TAU * f64::from(index) / f64::from(count)).sin_cos();
            let radius = random.between(5.0, 10.0);
            [radius * cos, radius * sin]
        })
        .collect();
    let corner = |index: usize| corners[index % corners.len()];
    let slope = |index: usize| {
        let [before, after] = [corner(index + corners.len() - 1), corner(index + 1)];
        [(after[0] - before[0]) / 6.0, (after[1] - before[1]) / 6.0]
    };
    let piece = |index: usize| {
        let ([p, q], [s, t]) =
            ([corner(index), corner(index + 1)], [slope(index), slope(index + 1)]);
        [p, [p[0] + s[0], p[1] + s[1]], [q[0] - t[0], q[1] - t[1]], q]
    };
    BezierLine { pieces: (0..corners.len()).map(piece).collect(), closed: true }
}

fn polygon(corners: &[PlaceMm], closed: bool) -> BezierLine {
    let count = corners.len();
    let sides = if closed { count } else { count - 1 };
    let pieces = (0..sides).map(|index| {
        let [p, q] = [corners[index], corners[(index + 1) % count]];
        let at = |share: f64| [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])];
        [p, at(1.0 / 3.0), at(2.0 / 3.0), q]
    });
    BezierLine { pieces: pieces.collect(), closed }
}

const EPSILON_THIRD: Spacing = Spacing { epsilon: Some(1.0 / 3.0), rho: None, chord_mm: None };
const RHO_09: Spacing = Spacing { epsilon: None, rho: Some(0.9), chord_mm: None };

#[test]
fn circles_get_as_few_samples_as_the_condition_lets_them() {
    for bound in [0.05, 0.2, 1.0 / 3.0, 0.47, 0.9] {
        for spacing in [
            Spacing { epsilon: Some(bound), ..Spacing::default() },
            Spacing { rho: Some(bound), ..Spacing::default() },
        ] {
            let curve = TrueCurve::of_beziers(&[ellipse([5.0, 5.0])], &spacing);
            let samples = &curve.sampled(&spacing)[0];
            // The middle of an arc of angle a is 2·R·sin(a/4) from its ends.
            let expected = (TAU / (4.0 * (bound / 2.0).asin())).ceil();
            assert_eq!(samples.places_mm.len() as f64, expected, "{spacing:?}");
            assert!(
                samples.lfs_mm.iter().all(|lfs| (lfs - 5.0).abs() < 5e-3),
                "{:?}",
                samples.lfs_mm
            );
        }
    }
}

#[test]
fn ellipses_have_the_feature_size_of_their_axis() {
    let curve = TrueCurve::of_beziers(&[ellipse([2.0, 1.0])], &EPSILON_THIRD);
    assert!((curve.least_lfs_mm() - 0.5).abs() < 1e-3, "{}", curve.least_lfs_mm());
    let samples = &curve.sampled(&EPSILON_THIRD)[0];
    // The medial axis lies between (-1.5, 0) and (1.5, 0).
    let lfs = |place: PlaceMm| distance(place, [place[0].clamp(-1.5, 1.5), 0.0]);
    for (place, found) in samples.places_mm.iter().zip(&samples.lfs_mm) {
        assert!((found - lfs(*place)).abs() < 2e-3, "{place:?} {found}");
    }
    // Every place has a sample near enough, and most gaps use what the bound allows.
    let fine = &curve.lines_mm()[0].0;
    let worst = |place: &PlaceMm| {
        let nearest = samples.places_mm.iter().map(|&sample| distance(sample, *place));
        nearest.fold(f64::INFINITY, f64::min) / lfs(*place)
    };
    let largest = fine.iter().map(worst).fold(0.0, f64::max);
    assert!((0.32..1.0 / 3.0 + 2e-3).contains(&largest), "{largest}");
}

#[test]
fn samples_for_a_proven_condition_are_joined_rightly() {
    let mut random = Random::new(90);
    for _ in 0..25 {
        let line = random_curve(&mut random);
        let of = |spacing: Spacing| {
            let curve = TrueCurve::of_beziers(std::slice::from_ref(&line), &spacing);
            curve.sampled(&spacing)[0].places_mm.clone()
        };
        let points = of(RHO_09);
        let set = triangulation(&points);
        let found = hnn_crust(set.samples());
        assert_eq!(by_row(&found, &set), closed(points.len()));
        // What is judged by the samples alone agrees with what they were made for.
        let rho = CurveSampling::new(&set, &found).rho().unwrap().rho;
        assert!((0.6..1.3).contains(&rho), "{rho}");
        let points = of(EPSILON_THIRD);
        let set = triangulation(&points);
        assert_eq!(by_row(&nn_crust(&set), &set), closed(points.len()));
    }
}

#[test]
fn edges_meet_at_no_less_than_the_published_angle() {
    // π - 4·asin(ρ/2): 73.03° for ρ < 0.9 (Ohrhallinger, Mitchell, Wimmer 2016).
    assert!(((PI - 4.0 * 0.45_f64.asin()).to_degrees() - 73.03).abs() < 0.005);
    let mut random = Random::new(91);
    for rho in [0.25, 0.5, 0.9] {
        let spacing = Spacing { rho: Some(rho), ..Spacing::default() };
        let mut least: f64 = 180.0;
        for _ in 0..12 {
            let curve = TrueCurve::of_beziers(&[random_curve(&mut random)], &spacing);
            let points = &curve.sampled(&spacing)[0].places_mm;
            let count = points.len();
            for index in 0..count {
                let [a, b, c] = [0, 1, 2].map(|step| points[(index + step) % count]);
                let ([px, py], [qx, qy]) = ([a[0] - b[0], a[1] - b[1]], [c[0] - b[0], c[1] - b[1]]);
                let angle = (px * qy - py * qx).atan2(px * qx + py * qy).abs().to_degrees();
                least = least.min(angle);
            }
        }
        let bound = (PI - 4.0 * (rho / 2.0).asin()).to_degrees();
        println!("ρ < {rho}: least angle {least:.2}°, published {bound:.2}°");
        assert!(least >= bound - 0.1);
    }
}

#[test]
fn chords_corners_and_ends() {
    let spacing = Spacing { chord_mm: Some(0.01), ..Spacing::default() };
    let curve = TrueCurve::of_beziers(&[ellipse([5.0, 5.0])], &spacing);
    let count = curve.sampled(&spacing)[0].places_mm.len();
    // Sagitta R·(1 - cos(a/2)).
    assert_eq!(count as f64, (PI / (1.0 - 0.01_f64 / 5.0).acos()).ceil());
    let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    for closed in [true, false] {
        let curve = TrueCurve::of_beziers(&[polygon(&corners, closed)], &EPSILON_THIRD);
        let samples = &curve.sampled(&EPSILON_THIRD)[0];
        assert_eq!(samples.closed, closed);
        assert!(corners.iter().all(|corner| samples.places_mm.contains(corner)));
        assert!(samples.places_mm.len() > 40 && samples.places_mm.len() < 200);
        if !closed {
            assert_eq!(
                (samples.places_mm[0], *samples.places_mm.last().unwrap()),
                (corners[0], corners[3])
            );
        }
    }
    assert!(TrueCurve::of_beziers(&[], &EPSILON_THIRD).sampled(&EPSILON_THIRD).is_empty());
    let still = BezierLine { pieces: vec![[[1.0, 1.0]; 4]], closed: false };
    let curve = TrueCurve::of_beziers(&[still], &EPSILON_THIRD);
    assert!(
        curve.lines_mm().iter().all(|(places, _)| places.iter().flatten().all(|v| v.is_finite()))
    );
}

#[test]
fn disturbances_stay_within_their_bounds() {
    let lines = [ellipse([5.0, 3.0])];
    let curve = TrueCurve::of_beziers(&lines, &EPSILON_THIRD);
    let samples = curve.sampled(&EPSILON_THIRD);
    let count = samples[0].places_mm.len();
    let none = Disturbance::default().apply(&curve, &samples);
    assert_eq!((&none.points_mm, none.outliers), (&samples[0].places_mm, 0));
    assert_eq!(none.edges, closed(count));
    let noise = Disturbance { of_box: 0.01, seed: 3, ..Disturbance::default() };
    let moved = noise.apply(&curve, &samples);
    assert_eq!(moved, noise.apply(&curve, &samples));
    assert_ne!(moved, Disturbance { seed: 4, ..noise }.apply(&curve, &samples));
    let ways: Vec<f64> =
        moved.points_mm.iter().zip(&samples[0].places_mm).map(|(&p, &q)| distance(p, q)).collect();
    let most = 0.01 * curve.diagonal_mm();
    assert!(ways.iter().all(|&way| way <= most) && ways.iter().any(|&way| way > 0.8 * most));
    let noise =
        Disturbance { of_lfs: 0.2, outliers_percent: 50.0, seed: 3, ..Disturbance::default() };
    let moved = noise.apply(&curve, &samples);
    assert_eq!(moved.outliers, (0.5 * count as f64).round() as usize);
    for (index, &place) in samples[0].places_mm.iter().enumerate() {
        let [x, y] = [moved.points_mm[index][0] - place[0], moved.points_mm[index][1] - place[1]];
        let [nx, ny] = samples[0].normals[index];
        assert!((x * ny - y * nx).abs() < 1e-12);
        assert!(x.hypot(y) <= 0.2 * samples[0].lfs_mm[index]);
    }
    assert!(moved.points_mm[count..].iter().all(|[x, y]| x.abs() <= 5.0001 && y.abs() <= 3.0001));
}

#[test]
fn borders_go_once_along_every_side() {
    let mut random = Random::new(92);
    for (columns, rows, share) in
        [(1, 1, 1.1), (7, 5, 0.5), (30, 20, 0.4), (25, 25, 0.7), (9, 9, 1.1)]
    {
        let set: Vec<bool> = (0..columns * rows).map(|_| random.share() < share).collect();
        let at = |column: i64, row: i64| {
            let inside = (0..columns as i64).contains(&column) && (0..rows as i64).contains(&row);
            inside && set[row as usize * columns + column as usize]
        };
        let mut sides = 0;
        for row in -1..=rows as i64 {
            for column in -1..=columns as i64 {
                sides += usize::from(at(column, row) != at(column + 1, row));
                sides += usize::from(at(column, row) != at(column, row + 1));
            }
        }
        let lines = borders(&set, columns, rows, 1.0);
        assert_eq!(lines.iter().map(Vec::len).sum::<usize>(), sides);
        let mut all: Vec<PlaceMm> = lines.concat();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
        all.dedup();
        assert_eq!(all.len(), sides);
        for line in &lines {
            let next = line.iter().cycle().skip(1);
            assert!(line.iter().zip(next).all(|(&p, &q)| distance(p, q) <= 1.0));
        }
    }
}

#[test]
fn borders_of_known_shapes() {
    let area = |line: &[PlaceMm]| {
        let next = line.iter().cycle().skip(1);
        0.5 * line.iter().zip(next).map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>()
    };
    // A ring of 8 pixels round an unset one, the lower left pixel of the image at the origin.
    let ring = [true, true, true, true, false, true, true, true, true];
    let lines = borders(&ring, 3, 3, 2.0);
    assert_eq!(lines.iter().map(Vec::len).collect::<Vec<_>>(), [12, 4]);
    assert_eq!(lines[0][0], [1.0, 0.0]);
    // Middles cut the four corners: eight triangles of half a pixel's half each.
    assert_eq!((area(&lines[0]), area(&lines[1])), (4.0 * (9.0 - 0.5), -4.0 * 0.5));
    // Two pixels that touch at a corner are two shapes.
    assert_eq!(borders(&[true, false, false, true], 2, 2, 1.0).len(), 2);
    assert!(borders(&[false; 4], 2, 2, 1.0).is_empty() && borders(&[], 0, 0, 1.0).is_empty());
}

#[test]
fn images_can_be_sampled_too() {
    // A disc of 40 pixels radius, its border smooth enough for samples by ε.
    let size = 100;
    let set: Vec<bool> = (0..size * size)
        .map(|index| {
            let [x, y] = [index % size, index / size].map(|value| value as f64 + 0.5 - 50.0);
            x.hypot(y) < 40.0
        })
        .collect();
    let lines: Vec<(Vec<PlaceMm>, bool)> =
        borders(&set, size, size, 0.1).into_iter().map(|line| (line, true)).collect();
    let curve = TrueCurve::of_places(&lines).smoothed(3);
    let samples = &curve.sampled(&EPSILON_THIRD)[0];
    // A circle takes ten; steps of pixels leave waves.
    assert!((10..40).contains(&samples.places_mm.len()), "{}", samples.places_mm.len());
    assert!(
        samples.places_mm.iter().all(|&place| (distance(place, [5.0, 5.0]) - 4.0).abs() < 0.06)
    );
}

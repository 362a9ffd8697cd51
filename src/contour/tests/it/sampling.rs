//! ε, ρ and u of found curves against what analytic curves say of the same samples.

use std::f64::consts::TAU;

use asphera_contour::curves::{hnn_crust, nn_crust};
use asphera_contour::{CurveSampling, Graph, Method, PlaceMm, Quantity, medial_axis_mm};

use crate::places::{Random, circle, distance, triangulation};
use crate::smooth::{Condition as Asked, Curve};

/// The sampling of the closed polygon through points in order.
fn sampling_of(points: &[PlaceMm]) -> CurveSampling {
    let set = triangulation(points);
    let samples = set.samples();
    let count = points.len();
    let ring =
        Graph::new((0..count).map(|row| [samples.of_row(row), samples.of_row((row + 1) % count)]));
    CurveSampling::new(&set, &ring)
}

fn near(found: f64, expected: f64, share: f64) {
    assert!((found - expected).abs() <= share * expected, "found {found}, expected {expected}");
}

#[test]
fn circles_have_the_epsilon_of_their_arcs() {
    for count in [3, 4, 5, 7, 24, 1000] {
        let found = sampling_of(&circle(count));
        // The middle of an arc lies a quarter of the angle from a sample; the medial axis is the centre.
        let expected = 2.0 * (TAU / (4.0 * count as f64)).sin();
        let [epsilon, rho] = [found.epsilon().unwrap().epsilon, found.rho().unwrap().rho];
        near(epsilon, expected, 2e-6);
        // The reach is that of the chords of the halves of the arc, a bit nearer to the centre.
        assert!(
            rho >= epsilon * (1.0 - 2e-6)
                && rho < epsilon / (TAU / (4.0 * count as f64)).cos() * 1.000_1
        );
        near(found.uniformity().unwrap().ratio, 1.0, 1e-9);
        assert!(found.ends_mm().is_empty());
    }
    // Three samples of a circle have ε = 1, and four meet the condition of HNN-Crust.
    let condition = Method::HnnCrust.condition().unwrap();
    assert!(!sampling_of(&circle(3)).against(&condition).holds());
    assert!(sampling_of(&circle(4)).against(&condition).holds());
}

/// Samples of an ellipse of half axes 2 and 1, and its ε, found from 2,000 places between each two; its medial axis is the line between
/// (-1.5, 0) and (1.5, 0).
fn ellipse(angles: &[f64]) -> (Vec<PlaceMm>, f64) {
    let at = |angle: f64| [2.0 * angle.cos(), angle.sin()];
    let places: Vec<PlaceMm> = angles.iter().map(|&angle| at(angle)).collect();
    let mut epsilon: f64 = 0.0;
    for index in 0..angles.len() {
        let from = angles[index];
        let to = if index + 1 < angles.len() { angles[index + 1] } else { angles[0] + TAU };
        for step in 0..=2000 {
            let place = at(from + (to - from) * f64::from(step) / 2000.0);
            let lfs = distance(place, [place[0].clamp(-1.5, 1.5), 0.0]);
            let nearest = distance(place, at(from)).min(distance(place, at(to)));
            epsilon = epsilon.max(nearest / lfs);
        }
    }
    (places, epsilon)
}

#[test]
fn ellipses_have_the_epsilon_that_their_axis_gives() {
    for (count, share) in [(24, 0.10), (60, 0.03), (200, 0.01), (1000, 0.002)] {
        let step = TAU / f64::from(count);
        // Neither symmetric nor even.
        let angle =
            |index: i32| step * (f64::from(index) + 0.2 * (f64::from(index) * 2.7).sin() + 0.13);
        let angles: Vec<f64> = (0..count).map(angle).collect();
        let (places, expected) = ellipse(&angles);
        let found = sampling_of(&places);
        near(found.epsilon().unwrap().epsilon, expected, share);
        assert!(found.rho().unwrap().rho >= found.epsilon().unwrap().epsilon);
        // The worst place lies at one end of the long axis or between: somewhere on the ellipse.
        let [x, y] = found.epsilon().unwrap().at_mm;
        near(x * x / 4.0 + y * y, 1.0, 0.02);
        near(found.least_lfs_mm(), 0.5, share);
    }
}

#[test]
fn a_condition_that_is_not_met_is_told_with_its_place() {
    // One gap in an otherwise dense ellipse, about the end of its short axis.
    let angles: Vec<f64> = (0..100)
        .map(|index| TAU * f64::from(index) / 100.0)
        .filter(|angle| (angle - TAU / 4.0).abs() > 0.22)
        .collect();
    let (places, expected) = ellipse(&angles);
    let found = sampling_of(&places);
    near(found.epsilon().unwrap().epsilon, expected, 0.05);
    assert!(expected > 1.0 / 3.0 && expected < 0.8);
    let verdict = found.against(&Method::NnCrust.condition().unwrap());
    assert_eq!(verdict.failures.len(), 1);
    let failure = verdict.failures[0];
    assert_eq!((failure.quantity, failure.bound), (Quantity::Epsilon, 1.0 / 3.0));
    assert!(distance(failure.at_mm, [0.0, 1.0]) < 0.05, "{failure:?}");
    assert_eq!(verdict.worst, Some(failure));
    let verdict = found.against(&Method::SigConnect2d.condition().unwrap());
    let of_uniformity = verdict.failures.iter().filter(|it| it.quantity == Quantity::Uniformity);
    assert_eq!(of_uniformity.count(), 2);
}

#[test]
fn corners_and_ends_fail_every_condition() {
    let side = |from: PlaceMm, to: PlaceMm| {
        (0..10).map(move |step| {
            let share = f64::from(step) / 10.0;
            [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
        })
    };
    let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    let square: Vec<PlaceMm> =
        (0..4).flat_map(|corner| side(corners[corner], corners[(corner + 1) % 4])).collect();
    let found = sampling_of(&square);
    let verdict = found.against(&Method::HnnCrust.condition().unwrap());
    assert_eq!(verdict.failures.len(), 8);
    assert!(
        verdict.failures.iter().all(|failure| {
            corners.iter().any(|&corner| distance(corner, failure.at_mm) < 0.51)
        })
    );
    // Half a circle ends twice, and is dense.
    let half = &circle(200)[..100];
    let set = triangulation(half);
    let curve = hnn_crust(set.samples());
    let found = CurveSampling::new(&set, &curve);
    let verdict = found.against(&Method::HnnCrust.condition().unwrap());
    assert!(!verdict.holds() && verdict.failures.len() == 2);
    assert!(verdict.failures.iter().all(|failure| failure.quantity == Quantity::End));
}

#[test]
fn a_point_apart_does_not_belong_to_the_curve() {
    let mut points = circle(100);
    let whole = sampling_of(&points);
    points.push([5.3, 0.1]);
    let set = triangulation(&points);
    let ring = Graph::new(
        (0..100).map(|row| [set.samples().of_row(row), set.samples().of_row((row + 1) % 100)]),
    );
    let found = CurveSampling::new(&set, &ring);
    near(found.epsilon().unwrap().epsilon, whole.epsilon().unwrap().epsilon, 2e-6);
}

#[test]
fn samples_made_for_a_condition_are_found_to_meet_it() {
    // The samples know the true curve; what is found knows them alone.
    let mut random = Random::new(31);
    let (mut worst, mut least): (f64, f64) = (0.0, 9.0);
    for epsilon in [0.1, 0.2, 0.3] {
        let mut tried = 0;
        while tried < 20 {
            let curve = Curve::random(&mut random, 900);
            let Some(points) = curve.samples(Asked::Epsilon(epsilon), &mut random) else {
                continue;
            };
            let found = sampling_of(&points).epsilon().unwrap().epsilon / epsilon;
            (worst, least) = (worst.max(found), least.min(found));
            tried += 1;
        }
    }
    println!("ε found over ε asked for: {least:.3} to {worst:.3}");
    assert!(worst < 1.25 && least > 0.75, "{least} to {worst}");
}

#[test]
fn lengths_and_turns_change_nothing() {
    let points: Vec<PlaceMm> =
        circle(60).iter().map(|&[x, y]| [2.0 * x + 0.1 * y * y, y]).collect();
    let found = sampling_of(&points);
    let other = |change: &dyn Fn(PlaceMm) -> PlaceMm| {
        let moved: Vec<PlaceMm> = points.iter().map(|&place| change(place)).collect();
        let other = sampling_of(&moved);
        near(other.epsilon().unwrap().epsilon, found.epsilon().unwrap().epsilon, 2e-6);
        near(other.rho().unwrap().rho, found.rho().unwrap().rho, 2e-6);
        near(other.uniformity().unwrap().ratio, found.uniformity().unwrap().ratio, 1e-9);
    };
    other(&|[x, y]| [-y, x]);
    other(&|[x, y]| [1024.0 * x, 1024.0 * y]);
    let mut turned = points.clone();
    turned.reverse();
    assert_eq!(sampling_of(&turned).edges(), found.edges());
}

#[test]
fn degenerate_curves_have_no_figures() {
    let set = triangulation(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [5.0, 0.0]]);
    let found = CurveSampling::new(&set, &nn_crust(&set));
    assert_eq!(found.epsilon().unwrap().epsilon, 0.0);
    assert!(found.least_lfs_mm().is_infinite());
    assert_eq!(found.uniformity().unwrap().ratio, 3.0);
    let none = CurveSampling::new(&set, &Graph::default());
    assert!(none.epsilon().is_none() && none.uniformity().is_none() && none.edges().is_empty());
    assert!(
        medial_axis_mm(&set, &Graph::default()).iter().flatten().flatten().all(|v| v.is_finite())
    );
}

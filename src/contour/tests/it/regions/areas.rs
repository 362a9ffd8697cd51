//! Areas of a disc, a ring and a D from 8,000 points at random.

use std::f64::consts::PI;

use asphera_contour::regions::alpha_shape;
use asphera_contour::{Method, PlaceMm};

use super::{check, region};
use crate::places::{Random, triangulation};

/// Points at random where `is_in` is true, within ±1 mm.
fn within(is_in: impl Fn(PlaceMm) -> bool, seed: u64) -> Vec<PlaceMm> {
    let mut random = Random::new(seed);
    let mut points = Vec::new();
    while points.len() < 8_000 {
        let place = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        if is_in(place) {
            points.push(place);
        }
    }
    points
}

fn radius([x, y]: PlaceMm) -> f64 {
    x.hypot(y)
}

#[test]
fn a_disc_a_ring_and_a_d() {
    let disc = (within(|place| radius(place) < 1.0, 1), PI, 0);
    let ring = (within(|place| (0.5..1.0).contains(&radius(place)), 2), 0.75 * PI, 1);
    let half = (within(|place| radius(place) < 1.0 && place[0] > 0.0, 3), 0.5 * PI, 0);
    for (name, (points, truth, holes)) in [("disc", disc), ("ring", ring), ("D", half)] {
        let set = triangulation(&points);
        // Discs as wide as two edges find the ring's hole and no other.
        let edges = set.by_length();
        let median_mm = set.length_mm(edges[edges.len() / 2]);
        let found = alpha_shape(&set, 2.0 * median_mm);
        let area = found.area_mm2(set.samples()) / truth - 1.0;
        println!("{name:<5} alpha at twice the median edge: area {:+.2} %", 100.0 * area);
        assert_eq!((found.parts().len(), found.parts()[0].holes.len()), (1, holes), "{name}");
        // The border lies within by a third of an edge or so, all round.
        let perimeter_mm = found.parts()[0].perimeter_mm(set.samples());
        let within_mm = -area * truth / perimeter_mm;
        assert!((0.2..0.5).contains(&(within_mm / median_mm)), "{name} {within_mm} {median_mm}");
        for method in super::methods() {
            let found = region(method, &set, "");
            check(&set, &found, method.name());
            let area = found.area_mm2(set.samples()) / truth - 1.0;
            let found_holes: usize = found.parts().iter().map(|part| part.holes.len()).sum();
            println!(
                "{name:<5} {:<13} area {:+6.2} %, {} parts, {found_holes} holes, {} points left out",
                method.name(),
                100.0 * area,
                found.parts().len(),
                found.left_out().len()
            );
            let is_one = matches!(method, Method::Chi | Method::Rgg | Method::SimpleShape);
            if holes == 0 {
                // A disc and a D are convex: no triangle of their points reaches beyond them.
                assert!(area < 0.0, "{name} {} {area}", method.name());
                assert!(!is_one || area > -0.05, "{name} {} {area}", method.name());
            }
            assert!(!is_one || (found.parts().len(), found_holes) == (1, 0), "{name}");
        }
    }
}

/// Samples of a disc as the methods ask for them: at most `2 r` apart on its border, at least `2 r` within.
fn r_samples(r_mm: f64, seed: u64) -> Vec<PlaceMm> {
    let sides = (PI / (0.95 * r_mm).asin()).ceil() as u32;
    let on_border = |step: u32| {
        let (sin, cos) = (2.0 * PI * f64::from(step) / f64::from(sides)).sin_cos();
        [cos, sin]
    };
    let mut points: Vec<PlaceMm> = (0..sides).map(on_border).collect();
    let mut random = Random::new(seed);
    for _ in 0..40_000 {
        let place = [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
        let is_apart =
            |other: &PlaceMm| radius([place[0] - other[0], place[1] - other[1]]) >= 2.0 * r_mm;
        if radius(place) < 1.0 && points.iter().all(is_apart) {
            points.push(place);
        }
    }
    points
}

#[test]
fn what_is_proven_of_r_samples_holds() {
    for seed in 0..3 {
        let points = r_samples(0.02, seed);
        let sides =
            points.iter().take_while(|place| (radius(**place) - 1.0).abs() < 1e-12).count() as f64;
        let polygon_mm2 = 0.5 * sides * (2.0 * PI / sides).sin();
        let set = triangulation(&points);
        for method in
            [Method::Ec, Method::Chi, Method::Rgg, Method::SimpleShape, Method::Ct, Method::Discern]
        {
            let found = region(method, &set, "");
            check(&set, &found, method.name());
            let share = found.area_mm2(set.samples()) / polygon_mm2;
            println!("r-samples {seed} {:<13} {share:.4} of the area", method.name());
            // These two ask for samples within that are no farther apart than they must be; ours leave some gaps.
            let least =
                if matches!(method, Method::Ct | Method::Discern) { 0.99 } else { 1.0 - 1e-9 };
            assert!((least..1.0 + 1e-9).contains(&share), "{} {share}", method.name());
            assert_eq!(found.parts().len(), 1, "{}", method.name());
            // Those two may take such a gap for a hole.
            assert!(least < 0.999 || found.parts()[0].holes.is_empty(), "{}", method.name());
        }
    }
}

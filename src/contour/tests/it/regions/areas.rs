//! Areas of a disc, a ring and a D from 8,000 points, at random and on rasters.

use std::f64::consts::PI;

use asphera_contour::{Method, PlaceMm, Region};

use super::{check, region};
use crate::places::{Random, triangulation};

/// A shape within ±1 mm: whether it holds a place, its area in mm², its holes.
type Shape = (&'static str, fn(PlaceMm) -> bool, f64, usize);

const SHAPES: [Shape; 3] = [
    ("disc", |place| radius(place) < 1.0, PI, 0),
    ("ring", |place| (0.5..1.0).contains(&radius(place)), 0.75 * PI, 1),
    ("D", |place| radius(place) < 1.0 && place[0] > 0.0, 0.5 * PI, 0),
];

const COUNT: usize = 8_000;

fn radius([x, y]: PlaceMm) -> f64 {
    x.hypot(y)
}

/// Points at random.
fn at_random(is_in: fn(PlaceMm) -> bool, seed: u64) -> Vec<PlaceMm> {
    let mut random = Random::new(seed);
    let place = || [random.between(-1.0, 1.0), random.between(-1.0, 1.0)];
    std::iter::repeat_with(place).filter(|&place| is_in(place)).take(COUNT).collect()
}

/// A raster of about as many points, shifted and turned at random: no border runs along its rows.
fn on_a_raster(is_in: fn(PlaceMm) -> bool, area_mm2: f64, seed: u64) -> Vec<PlaceMm> {
    let mut random = Random::new(seed);
    let step = (area_mm2 / COUNT as f64).sqrt();
    let (shift, turn) = ([random.share(), random.share()], random.between(0.2, 0.6));
    let (sin, cos) = turn.sin_cos();
    let rows = (1.5 / step) as i32;
    let places = (-rows..=rows).flat_map(|x| (-rows..=rows).map(move |y| [x, y]));
    let places = places.map(|[x, y]| {
        let [x, y] = [step * (f64::from(x) + shift[0]), step * (f64::from(y) + shift[1])];
        [cos * x - sin * y, sin * x + cos * y]
    });
    places.filter(|&place| is_in(place)).collect()
}

/// How far the area of a region is off, in % of the truth.
fn error(points: &[PlaceMm], method: Method, truth: f64) -> (f64, Region) {
    let set = triangulation(points);
    let found = region(method, &set, "");
    check(&set, &found, method.name());
    (100.0 * (found.area_mm2(set.samples()) / truth - 1.0), found)
}

#[test]
fn areas_are_right_within_half_a_percent() {
    for (name, is_in, truth, holes) in SHAPES {
        for seed in 1..=5 {
            let random = at_random(is_in, seed);
            let raster = on_a_raster(is_in, truth, seed);
            for (kind, points) in [("random", random), ("raster", raster)] {
                let (off, found) = error(&points, Method::Auto, truth);
                println!("{name:<5} {kind} {seed}: auto {off:+.2} %");
                assert_eq!((found.parts().len(), found.parts()[0].holes.len()), (1, holes));
                assert!(off.abs() <= 0.5, "{name} {kind} {seed}: {off} %");
            }
        }
    }
}

/// Every region of triangles is too small by about half a spacing all round. The figures of all methods are printed.
#[test]
fn triangles_end_before_the_border() {
    for (name, is_in, truth, holes) in SHAPES {
        let sets = [("random", at_random(is_in, 1)), ("raster", on_a_raster(is_in, truth, 1))];
        for (kind, points) in sets {
            for method in super::methods().filter(|method| *method != Method::Auto) {
                let (off, found) = error(&points, method, truth);
                let found_holes: usize = found.parts().iter().map(|part| part.holes.len()).sum();
                println!(
                    "{name:<5} {kind} {:<13} {off:+7.2} %, {} parts, {found_holes} holes, {} points left out",
                    method.name(),
                    found.parts().len(),
                    found.left_out().len()
                );
                // A disc and a D are convex: no triangle of their points reaches beyond them.
                assert!(holes > 0 || off < 0.0, "{name} {} {off}", method.name());
                if matches!(method, Method::Chi | Method::Rgg | Method::SimpleShape) {
                    assert_eq!((found.parts().len(), found_holes), (1, 0), "{name}");
                }
            }
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

//! Outlines of lines and arcs beside true free forms: which of them come in pieces.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use asphera_contour::PlaceMm;
use asphera_contour::features::{Course, Feature, Profile};
use asphera_geometry::Numbers;

use crate::profiles::{Drawn, drawn};

/// A rectangle of 12 x 8 mm with rounded corners.
fn rounded(radius: f64) -> Vec<Drawn> {
    let [x, y] = [6.0 - radius, 4.0 - radius];
    let arc = |at: PlaceMm, from: f64| Drawn::Arc(at, radius, from, FRAC_PI_2);
    vec![
        Drawn::Line([-x, -4.0], [x, -4.0]),
        arc([x, -y], -FRAC_PI_2),
        Drawn::Line([6.0, -y], [6.0, y]),
        arc([x, y], 0.0),
        Drawn::Line([x, 4.0], [-x, 4.0]),
        arc([-x, y], FRAC_PI_2),
        Drawn::Line([-6.0, y], [-6.0, -y]),
        arc([-x, -y], PI),
    ]
}

/// How many lines, arcs, free pieces and corners.
fn counts(points: Vec<PlaceMm>) -> [usize; 4] {
    let mut counts = [0; 4];
    for feature in Profile::new(&Course::new(points, true), 0.0).features {
        let kind = match feature {
            Feature::Line { .. } => 0,
            Feature::Arc { .. } => 1,
            Feature::Free { .. } => 2,
            Feature::Corner { .. } => 3,
            Feature::Chamfer { .. } | Feature::Edge { .. } => continue,
        };
        counts[kind] += 1;
    }
    counts
}

#[test]
fn rounded_rectangles_are_lines_and_arcs() {
    for (radius, count, sigma) in
        [(1.0, 300, 1e-3), (2.0, 300, 1e-3), (2.0, 200, 1e-3), (1.0, 300, 3e-3), (1.0, 600, 3e-3)]
    {
        for draw in 0..24 {
            let found = counts(drawn(&rounded(radius), count, sigma, draw));
            assert_eq!(found, [4, 4, 0, 0], "{radius} mm, {count} points, {sigma} mm, draw {draw}");
        }
    }
}

#[test]
fn free_forms_stay_free() {
    let ellipse = |a: f64, b: f64| move |t: f64| [a * t.cos(), b * t.sin()];
    let flower = |leaves: f64, high: f64| {
        move |t: f64| {
            let radius = 5.0 + high * (leaves * t).cos();
            [radius * t.cos(), radius * t.sin()]
        }
    };
    let forms: [(&str, &dyn Fn(f64) -> PlaceMm); 4] = [
        ("wide ellipse", &ellipse(20.0, 8.0)),
        ("ellipse", &ellipse(6.0, 4.0)),
        ("flower of five", &flower(5.0, 0.5)),
        ("flower of three", &flower(3.0, 0.1)),
    ];
    for (name, form) in forms {
        for (count, sigma) in [(200, 1e-3), (400, 1e-3), (800, 1e-3)] {
            for draw in 0..6 {
                let noise = Numbers::new(9, draw, 0);
                let points = (0..count).map(|index| {
                    let at = TAU * (index as f64 + 0.3) / count as f64;
                    let ([x, y], [to_x, to_y]) = (form(at), form(at + 1e-6));
                    let off = sigma * noise.normal(index) / (to_x - x).hypot(to_y - y);
                    [x + off * (to_y - y), y - off * (to_x - x)]
                });
                let found = counts(points.collect());
                assert_eq!(found, [0, 0, 1, 0], "{name}, {count} points, draw {draw}");
            }
        }
    }
}

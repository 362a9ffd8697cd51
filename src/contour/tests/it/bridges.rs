//! Gaps that a method closes: what is said of the curve, of its pieces and of what it encloses.

use std::f64::consts::PI;

use asphera_contour::features::{Course, Feature, Profile};
use asphera_contour::{Choice, Method, Parameters, PlaceMm};
use asphera_geometry::Numbers;

use crate::places::triangulation;
use crate::profiles::{Drawn, drawn};

/// Points over an arc of 5 mm, 1 µm of noise.
fn arc(degrees: f64, count: usize) -> Vec<PlaceMm> {
    drawn(&[Drawn::Arc([0.0, 0.0], 5.0, 0.0, degrees.to_radians())], count, 1e-3, 0)
}

fn profiles(points: &[PlaceMm], method: Method) -> Vec<Profile> {
    let set = triangulation(points);
    let curve = method.curve(&set, &Parameters::new()).unwrap();
    let courses = Course::of_curve(set.samples(), &curve, &[]);
    courses.iter().map(|course| Profile::new(course, 0.0)).collect()
}

#[test]
fn the_gap_of_an_arc_stays_open_where_the_points_choose() {
    for degrees in [200.0, 270.0, 300.0, 340.0] {
        for count in [60, 200] {
            let set = triangulation(&arc(degrees, count));
            let curve = Choice::new(&set).curve(&set).unwrap();
            let chains = curve.graph.chains(set.len());
            assert!(chains.len() == 1 && !chains[0].closed, "{degrees}, {count}");
        }
    }
}

#[test]
fn a_closed_gap_ends_the_arc_and_encloses_nothing() {
    for degrees in [200.0, 270.0, 300.0, 340.0] {
        let found = profiles(&arc(degrees, 200), Method::HnnCrust);
        let [Profile { features, area_mm2, perimeter_mm, bridges, unknown, .. }] = &found[..]
        else {
            panic!("{found:#?}")
        };
        assert!(area_mm2.is_none() && perimeter_mm.is_none(), "{found:#?}");
        let [Feature::Arc { sweep_deg, radius_mm, .. }] = &features[..] else {
            panic!("{features:#?}")
        };
        // The first and the last point lie up to a spacing and a half from the ends.
        assert!((degrees - sweep_deg.abs() - 1.3).abs() < 3.0, "{sweep_deg} of {degrees}");
        assert!((radius_mm.value - 5.0).abs() <= 4.0 * radius_mm.u, "{radius_mm:?}");
        let wide_mm = 10.0 * (PI - degrees.to_radians() / 2.0).sin();
        assert!((bridges[0].length_mm - wide_mm).abs() < 0.3, "{bridges:?}");
        assert!(unknown[0].starts_with("gap: ") && unknown[1].starts_with("area, perimeter: "));
    }
}

#[test]
fn sides_without_points_are_gaps() {
    // A slot of which the straight sides were not measured.
    let ends =
        |turn: f64, shift: f64| drawn(&[Drawn::Arc([shift, 0.0], 2.0, turn, PI)], 60, 1e-3, 1);
    let points = [ends(-PI / 2.0, 4.0), ends(PI / 2.0, -4.0)].concat();
    let profile = Profile::new(&Course::new(points, true), 0.0);
    assert!(profile.area_mm2.is_none() && profile.bridges.len() == 2, "{profile:#?}");
    let arcs = profile.features.iter().filter(|it| matches!(it, Feature::Arc { .. })).count();
    assert!(arcs == 2 && profile.features.len() == 2, "{profile:#?}");
}

#[test]
fn points_at_random_round_a_circle_have_no_gap() {
    let mut closed = 0;
    for draw in 0..40 {
        let numbers = Numbers::new(3, draw, 0);
        let mut angles: Vec<f64> =
            (0..240).map(|index| 2.0 * PI * numbers.uniform(index)).collect();
        angles.sort_by(f64::total_cmp);
        let places = angles.iter().map(|angle| [5.0 * angle.cos(), 5.0 * angle.sin()]);
        let profile = Profile::new(&Course::new(places.collect(), true), 0.0);
        closed += usize::from(profile.area_mm2.is_some());
    }
    assert!(closed >= 39, "{closed} of 40");
}

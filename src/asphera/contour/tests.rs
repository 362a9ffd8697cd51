//! A curve found without a mesh has the report of one found with it.

use std::f64::consts::TAU;

use asphera_contour::{Method, Parameters, PlaceMm, Samples, Triangulation};

use super::ContourSettings;

/// A curve with a gap, and two points off it.
fn points() -> Vec<PlaceMm> {
    let at = |index: u32| {
        let angle = TAU * f64::from(index * index % 911) / 911.0;
        [7.0 * angle.cos() + 0.3 * (5.0 * angle).sin(), 4.0 * angle.sin()]
    };
    (0..400).filter(|index| index % 7 > 0).map(at).chain([[20.0, 3.0], [21.0, 3.5]]).collect()
}

#[test]
fn a_mesh_changes_nothing_but_what_is_checked() {
    for words in ["one_sided=false", "one_sided=true"] {
        let settings = ContourSettings {
            method: Method::HnnCrust,
            parameters: Parameters::parse(words).unwrap(),
            tolerance_mm: 0.0,
            is_airfoil: false,
            gap_mm: Some(0.5),
            nominal: None,
            hints: Vec::new(),
        };
        let samples = Samples::new(&points()).unwrap();
        assert!(!settings.is_without_mesh(&samples));
        let mut found = settings.found_without_mesh(&samples).unwrap();
        let mut meshed = settings.found(&Triangulation::new(samples)).unwrap();
        assert!(meshed.0.sampling.take().is_some() && found.0.sampling.is_none());
        assert!(found.0.unknown[0].starts_with("sampling: not checked of 344 points"));
        for report in [&mut found.0, &mut meshed.0] {
            report.unknown.retain(|why| !why.starts_with("sampling: "));
        }
        assert_eq!(found, meshed, "{words}");
    }
}

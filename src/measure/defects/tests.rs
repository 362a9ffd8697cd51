//! Defects put on parts whose noise is known, found by what the report says.

use std::f64::consts::PI;

use asphera_geometry::PointMm;

use super::*;
use crate::nominal::parse;
use crate::random::Random;
use crate::{Measurement, Pipeline, Wanted, sampling_of_points};

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 20\n\
    [aperture]\nshape = \"rectangle\"\nwidth_mm = 3.5\nheight_mm = 3.5\n";
const PITCH_MM: f64 = 0.02;
const SIGMA_MM: f64 = 1e-5;

/// 200 × 200 points of a sphere, seen from its hollow side, with noise of 10 nm and what else stands on it.
fn points(more_mm: impl Fn(f64, f64) -> f64) -> Vec<PointMm> {
    let mut random = Random(11);
    let mut unit = || random.next();
    (0..200 * 200)
        .map(|index| {
            let [x, y] = [index % 200, index / 200].map(|i| PITCH_MM * (f64::from(i) - 99.5));
            let noise = (0..12).map(|_| unit()).sum::<f64>() - 6.0;
            [x, y, 20.0 - (400.0 - x * x - y * y).sqrt() + SIGMA_MM * noise + more_mm(x, y)]
        })
        .collect()
}

fn measured(part: &str, points: &[PointMm]) -> Measurement {
    let mut pipeline = Pipeline::new(parse("part.toml", part).unwrap());
    points.iter().for_each(|&point| pipeline.take_position(point));
    pipeline.finish()
}

/// A pit of 200 nm at (0.5, -0.7), 0.1 mm wide at half of that, and a scratch of 150 nm.
fn damage(x: f64, y: f64) -> f64 {
    let pit = -2e-4 * (-4.0 * 2.0_f64.ln() * ((x - 0.5).powi(2) + (y + 0.7).powi(2)) / 0.01).exp();
    let scratch = if (y - x - 0.6).abs() < 0.03 * 2.0_f64.sqrt() && (x + 0.6).abs() < 0.5 {
        -1.5e-4
    } else {
        0.0
    };
    pit + scratch
}

fn assert_damage(features: &FeatureFigures) {
    let defects = features.defects.as_ref().unwrap();
    assert_eq!((defects.len(), features.defects_more), (2, 0), "{defects:#?}");
    let of = |kind: &str| defects.iter().find(|defect| defect.kind == kind).unwrap();
    let pit = of("pit");
    assert!((pit.at_mm[0] - 0.5).hypot(pit.at_mm[1] + 0.7) < PITCH_MM, "{pit:?}");
    assert!((pit.height_nm / -200.0 - 1.0).abs() < 0.12, "{pit:?}");
    assert!((pit.area_mm2.unwrap() / (PI * 0.05 * 0.05) - 1.0).abs() < 0.12, "{pit:?}");
    assert_eq!(pit.shape, "round");
    // The volume under a Gaussian is height times area at half of it over ln 2.
    let um3 = -0.2 * PI * 50.0 * 50.0 / 2.0_f64.ln();
    assert!((pit.volume_um3.unwrap() / um3 - 1.0).abs() < 0.15, "{pit:?} {um3}");
    let scratch = of("scratch");
    assert_eq!(scratch.shape, "straight");
    assert!((scratch.orientation_deg.unwrap() - 45.0).abs() < 1.0, "{scratch:?}");
    assert!((scratch.length_mm.unwrap() / 2.0_f64.sqrt() - 1.0).abs() < 0.05, "{scratch:?}");
    assert!((scratch.width_mm.unwrap() / 0.06 - 1.0).abs() < 0.2, "{scratch:?}");
    assert!((scratch.height_nm / -150.0 - 1.0).abs() < 0.08, "{scratch:?}");
    assert!((scratch.at_mm[0] + 0.6).hypot(scratch.at_mm[1]) < 0.05, "{scratch:?}");
    assert!(defects.is_sorted_by(|p, q| p.significance >= q.significance));
    let by = features.defects_search.as_ref().unwrap();
    assert!((by.sigma_nm / 10.0 - 1.0).abs() < 0.12, "{by:?}");
    assert!((4.5..5.5).contains(&by.threshold_sigmas) && by.points_unknown == 0, "{by:?}");
}

#[test]
fn a_report_names_what_stands_off_the_nominal() {
    let features = measured(SPHERE, &points(damage)).report.features;
    assert_damage(&features);
    assert_eq!(features.defects_search.unwrap().reference, "nominal");
    // A hollow bends towards the viewer everywhere.
    let partition = features.partition.unwrap();
    assert!(partition.shares["concave"] > 0.98, "{partition:?}");
    assert_eq!(partition.flat_below_per_mm, 1e-6);
}

#[test]
fn points_without_a_nominal_have_defects_too() {
    let wanted = Wanted::default();
    let found = sampling_of_points(points(damage), crate::Along::Z, wanted);
    assert_damage(&found.features);
    assert_eq!(found.features.defects_search.unwrap().reference, "points");
}

#[test]
fn none_found_is_not_the_same_as_not_looked_for() {
    let clean = points(|_, _| 0.0);
    let features = measured(SPHERE, &clean).report.features;
    assert_eq!((features.defects, features.defects_unknown), (Some(Vec::new()), None));
    let unwanted = measured(&format!("defects = false\n{SPHERE}"), &clean).report;
    assert_eq!(unwanted.features.defects, None);
    assert!(unwanted.features.defects_unknown.as_ref().unwrap().contains("defects = false"));
    let json = serde_json::to_value(&unwanted).unwrap();
    assert!(json.get("defects").is_none() && json.get("defects_unknown").is_some());
    // Two points have neither a fit nor squares.
    let nothing = measured(SPHERE, &clean[..2]).report.features;
    assert!(nothing.defects_unknown.unwrap().contains("no fit"));
    assert!(nothing.partition_unknown.is_some());
}

#[test]
fn limits_of_the_nominal_shorten_the_list() {
    let damaged = points(damage);
    let one = format!("{SPHERE}[defects]\nlisted = 1\n");
    let features = measured(&one, &damaged).report.features;
    assert_eq!((features.defects.unwrap().len(), features.defects_more), (1, 1));
    let deep = format!("{SPHERE}[defects]\nmin_height_nm = 170\n");
    let features = measured(&deep, &damaged).report.features;
    let defects = features.defects.unwrap();
    assert_eq!((defects.len(), &defects[0].kind[..], features.defects_more), (1, "pit", 0));
    assert_eq!(features.defects_search.unwrap().lower, 1);
}

#[test]
fn a_report_with_features_can_be_read_again() {
    let report = measured(SPHERE, &points(damage)).report;
    let text = serde_json::to_string(&report).unwrap();
    let again: asphera_report::Report = serde_json::from_str(&text).unwrap();
    let [found, read] = [report, again].map(|report| report.features);
    let kinds = |features: &FeatureFigures| {
        let defects = features.defects.iter().flatten();
        defects.map(|defect| (defect.kind.clone(), defect.points)).collect::<Vec<_>>()
    };
    assert_eq!(kinds(&read), kinds(&found));
    assert_eq!(kinds(&found).len(), 2);
    let classes = |features: FeatureFigures| features.partition.unwrap().regions;
    assert_eq!(classes(read), classes(found));
}

/// z = x²/80 - y²/40, z = x³/300, and a plane: saddle; half concave, half convex along x; flat.
#[test]
fn surfaces_are_parted_by_how_they_bend() {
    let shares = |height: fn(f64, f64) -> f64| {
        let level = points(|x, y| -(20.0 - (400.0 - x * x - y * y).sqrt()) + height(x, y));
        let wanted = Wanted::default();
        let found = sampling_of_points(level, crate::Along::Z, wanted);
        found.features.partition.unwrap().shares
    };
    let saddle = shares(|x, y| x * x / 80.0 - y * y / 40.0);
    assert!(saddle["saddle"] > 0.97, "{saddle:?}");
    let bent = shares(|x, _| x * x * x / 300.0);
    let of = |class: &str| bent.get(class).copied().unwrap_or(0.0);
    assert!((of("trough") - 0.5).abs() < 0.1 && (of("ridge") - 0.5).abs() < 0.1, "{bent:?}");
    let flat = shares(|_, _| 0.0);
    assert!(flat["flat"] > 0.95, "{flat:?}");
}

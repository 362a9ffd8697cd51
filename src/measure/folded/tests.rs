//! Bodies that close on themselves get no figure of a mesh, steep surfaces that do project get all of them.

use asphera_geometry::PointMm;
use asphera_report::{MeshFigures, Status};

use crate::nominal::parse;
use crate::{Along, Measurement, Pipeline, Wanted, sampling_of_points};

const BALL: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 10\n[tolerance]\npv_nm = 1e9\n";

/// Directions evenly over a sphere: R. Swinbank, R. J. Purser, Q. J. R. Meteorol. Soc. 132 (2006) 1769-1793.
fn directions(count: u32) -> impl Iterator<Item = PointMm> {
    (0..count).map(move |index| {
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
        let (sin, cos) = (f64::from(index) * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    })
}

/// Multiples of the roots of two and three, modulo 1.
fn shares(index: u32) -> [f64; 2] {
    [2.0_f64, 3.0].map(|root| (f64::from(index) * root.sqrt()).fract())
}

fn cube() -> impl Iterator<Item = PointMm> {
    (0..12_000_u32).map(|index| {
        let [u, v] = shares(index).map(|share| 10.0 * share - 5.0);
        let face = if index % 2 == 0 { 5.0 } else { -5.0 };
        match index / 2 % 3 {
            0 => [u, v, face],
            1 => [u, face, v],
            _ => [face, u, v],
        }
    })
}

/// Two sheets 3 mm apart, places in no order.
fn scattered_sheets() -> impl Iterator<Item = PointMm> {
    (0..8000_u32).map(|index| {
        let [u, v] = shares(index);
        [10.0 * u, 10.0 * v, if index % 2 == 0 { 0.0 } else { 3.0 }]
    })
}

/// Two rasters, point above point.
fn stacked_rasters() -> impl Iterator<Item = PointMm> {
    (0..3200_u32).map(|index| {
        let (sheet, index) = (index / 1600, index % 1600);
        [f64::from(index % 40), f64::from(index / 40), 3.0 * f64::from(sheet)]
    })
}

fn bodies() -> [(&'static str, Vec<PointMm>); 5] {
    [
        ("ball", directions(10_000).map(|way| way.map(|it| 10.0 * it)).collect()),
        ("ellipsoid", directions(10_000).map(|[x, y, z]| [12.0 * x, 9.0 * y, 5.0 * z]).collect()),
        ("cube", cube().collect()),
        ("sheets", scattered_sheets().collect()),
        ("rasters", stacked_rasters().collect()),
    ]
}

fn measured(points: &[PointMm]) -> Measurement {
    let part = parse("part.toml", BALL).unwrap();
    let mut pipeline = Pipeline::new(part);
    pipeline.take_positions(points.iter().copied());
    pipeline.finish()
}

#[test]
fn sampling_of_a_body_says_first_that_it_does_not_project_and_lists_nothing() {
    for (name, points) in bodies() {
        let found = sampling_of_points(points.iter().copied(), Along::Z, Wanted::default());
        let figures = &found.figures;
        let first = figures.unknown.first().map(String::as_str).unwrap_or_default();
        assert!(first.starts_with("the surface does not project: "), "{name}: {figures:?}");
        assert!(figures.unknown[1].contains(&format!("{} points, x ", points_of(name, &points))));
        assert!(figures.unknown[2].contains("--along"), "{name}: {figures:?}");
        assert_eq!((figures.coverage, figures.gap_max_mm, figures.epsilon_max), (None, None, None));
        assert!(figures.next.is_empty() && found.waypoints.is_none(), "{name}");
        let features = &found.features;
        assert_eq!((&features.defects, &features.partition), (&None, &None), "{name}");
        assert_eq!(features.defects_unknown.as_deref(), Some(first), "{name}");
    }
}

/// How many points are told of: of rasters point above point, those of one.
fn points_of(name: &str, points: &[PointMm]) -> usize {
    if name == "rasters" { points.len() / 2 } else { points.len() }
}

#[test]
fn measure_of_a_body_gives_no_figure_of_its_mesh_and_no_verdict_but_why() {
    for (name, points) in bodies() {
        let Measurement { report, next, map, .. } = measured(&points);
        let MeshFigures { area_mm2, projectable, .. } = report.mesh;
        assert_eq!((area_mm2, projectable), (None, false), "{name}");
        assert!(report.form.is_none() && map.is_none() && next.is_none(), "{name}");
        assert!(report.sampling.gap_max_mm.is_none() && report.features.defects.is_none());
        assert_eq!(report.verdict.status, Status::Undecided);
        let reasons = &report.verdict.reasons;
        let why = reasons.iter().find(|why| why.contains("does not project"));
        assert!(why.is_some_and(|why| why.contains("--along")), "{name}: {reasons:?}");
    }
}

#[test]
fn a_steep_dome_projects() {
    for steep_deg in [60.0_f64, 70.0, 80.0] {
        // As seen from above: places even over the plane up to the slope.
        let radius = 10.0 * steep_deg.to_radians().sin();
        let dome = (0..40_000_u32).map(|index| {
            let r = radius * (f64::from(index) / 40_000.0).sqrt();
            let (sin, cos) = (f64::from(index) * 2.399_963_229_728_653).sin_cos();
            [r * cos, r * sin, 10.0 - (100.0 - r * r).sqrt()]
        });
        let points: Vec<PointMm> = dome.collect();
        let report = measured(&points).report;
        assert!(report.mesh.projectable && report.mesh.relief.folds.is_empty(), "{steep_deg}");
        assert!(report.mesh.area_mm2.is_some() && report.sampling.gap_max_mm.is_some());
        let pv_nm = report.form.unwrap().deviation.pv_nm;
        assert!(pv_nm < 1.0, "{steep_deg}: {pv_nm}");
        let found = sampling_of_points(points, Along::Z, Wanted::default());
        assert!(found.figures.coverage.is_some(), "{steep_deg}: {:?}", found.figures.unknown);
    }
}

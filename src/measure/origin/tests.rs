//! Every number of a whole report of a part, and of the same part elsewhere: places move along, all else stays.

use std::path::{Path, PathBuf};

use asphera_formats::Topography;
use asphera_report::Status;
use serde_json::Value;

use super::*;
use crate::Pipeline;
use crate::nominal::parse;

const SHIFT_MM: [f64; 2] = [37.3, -112.9];
const COUNT: usize = 2500;

/// Places of a jittered lattice over 8 by 6 mm, about (2, −1) mm: no four of them lie on a circle.
fn places() -> impl Iterator<Item = [f64; 2]> {
    (0..COUNT).map(|index| {
        let [i, j] = [index % 50, index / 50].map(|at| at as f64);
        let jitter = |k: f64| 0.06 * (k * (index as f64 + 1.0)).sin();
        [-2.0 + 8.0 * i / 49.0 + jitter(12.9), -4.0 + 6.0 * j / 49.0 + jitter(78.2)]
    })
}

/// A height with form of many orders and a little that differs from point to point, mm.
fn form_mm(index: usize, x: f64, y: f64) -> f64 {
    let noise = ((index as f64 * 91.7).sin() * 43_758.5).fract();
    1e-6 * (40.0 * (0.4 * x).sin() * (0.7 * y).cos() + 6.0 * x * y + 9.0 * (x - y) + 3.0 * noise)
}

/// The report of a part whose height is `sag_mm`, moved; also the running figures halfway.
fn reports(part: &str, sag_mm: impl Fn(f64, f64) -> f64, shift_mm: [f64; 2]) -> [Value; 2] {
    let mut pipeline = Pipeline::new(parse("part.toml", part).unwrap());
    let point = |(index, [x, y]): (usize, [f64; 2])| {
        [x + shift_mm[0], y + shift_mm[1], sag_mm(x, y) + form_mm(index, x, y)]
    };
    let points: Vec<PointMm> = places().enumerate().map(point).collect();
    points[..2200].iter().for_each(|&point| pipeline.take_position(point));
    let running = pipeline.figures();
    points[2200..].iter().for_each(|&point| pipeline.take_position(point));
    let running = [
        serde_json::to_value(&running.form).unwrap(),
        serde_json::to_value(&running.sampling).unwrap(),
        serde_json::to_value(&running.outlook).unwrap(),
    ];
    let report = serde_json::to_value(pipeline.finish().report).unwrap();
    [report, Value::Array(running.into())]
}

/// What a number of a report is moved by: places of the measured frame, but none of the part frame.
fn moved_by(path: &str) -> f64 {
    let is_place = ["/origin/at_mm", "/sampling/at_max_mm", "/next/", "running/1/at_max_mm"];
    let is_place = is_place.iter().any(|name| path.contains(name));
    let axis = |name: &str, axis: &str| {
        let ends = [format!("/t{name}_mm"), format!("/parameters/t{name}/value")];
        ends.iter().any(|end| path.ends_with(end)) || is_place && path.ends_with(axis)
    };
    match path {
        // The last of a list of places, or of one place, is its y.
        _ if axis("x", "/0") => SHIFT_MM[0],
        _ if axis("y", "/1") => SHIFT_MM[1],
        _ => 0.0,
    }
}

/// How many steps a fit took, and what hangs on ties: the defects a search finds at its threshold, and how far the autocorrelation is known where Str is not.
fn hangs_on_rounding(path: &str, value: &Value) -> bool {
    let steps = ["/form/fit/iterations", "/form/fit/evaluations"];
    path.starts_with("/defects")
        || steps.contains(&path)
        || value.as_str().is_some_and(|text| text.starts_with("Str:"))
}

fn differences(path: &str, here: &Value, there: &Value, found: &mut Vec<String>) {
    match (here, there) {
        _ if hangs_on_rounding(path, here) => {}
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            a.iter().for_each(|(key, a)| differences(&format!("{path}/{key}"), a, &b[key], found));
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let pairs = a.iter().zip(b).enumerate();
            pairs.for_each(|(index, (a, b))| differences(&format!("{path}/{index}"), a, b, found));
        }
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap(), b.as_f64().unwrap());
            let apart = (b - a - moved_by(path)).abs();
            if apart > RELATIVE * a.abs().max(b.abs()) + ABSOLUTE {
                found.push(format!("{path}: {a} here, {b} there"));
            }
        }
        _ if here == there => {}
        _ => found.push(format!("{path}: {here} here, {there} there")),
    }
}

fn stays(part: &dyn Fn([f64; 2]) -> String, sag_mm: impl Fn(f64, f64) -> f64) -> Value {
    let [here, running_here] = reports(&part([0.0; 2]), &sag_mm, [0.0; 2]);
    let [there, running_there] = reports(&part(SHIFT_MM), &sag_mm, SHIFT_MM);
    let mut found = Vec::new();
    differences("", &here, &there, &mut found);
    differences("running", &running_here, &running_there, &mut found);
    assert!(found.is_empty(), "{}\n{}", part([0.0; 2]), found.join("\n"));
    assert!(here["form"]["figures"].as_array().unwrap().len() > 20, "{here}");
    here
}

const LIMITS: &str = "[tolerance]\npv_nm = 900\nrms_nm = 200\na_nm = 500\nb_nm = 500\nc_nm = 500\nrmst_nm = 500\nrmsi_nm = 500\n\
    rmsa_nm = 500\npvr_nm = 900\npv99_nm = 900\nrms_about_mean_nm = 500\n[uncertainty]\nnoise_nm = 2\ndraws = 20\n\
    [figures]\nminimum_zone = true\n[figures.texture]\nremove = \"plane\"\n";

#[test]
fn a_plane_without_an_aperture_has_the_same_figures_everywhere() {
    let part = |_: [f64; 2]| format!("[surface]\nkind = \"plane\"\n{LIMITS}");
    let report = stays(&part, |x, y| 1e-3 * x - 2e-3 * y);
    let origin = &report["form"]["origin"];
    assert_eq!(origin["place"], OriginFigures::MIDDLE_OF_POINTS);
    for (axis, middle_mm) in [2.0, -1.0].into_iter().enumerate() {
        assert!((origin["at_mm"][axis].as_f64().unwrap() - middle_mm).abs() < 0.1, "{origin}");
    }
}

#[test]
fn an_aperture_of_a_plane_lies_where_the_nominal_file_says() {
    for shape in [
        "shape = \"circle\"\nradius_mm = 2.5",
        "shape = \"rectangle\"\nwidth_mm = 6\nheight_mm = 4",
        "shape = \"annulus\"\ninner_radius_mm = 0.5\nouter_radius_mm = 2.5",
    ] {
        let part = |[x, y]: [f64; 2]| {
            let centre = format!("centre_mm = [{:?}, {:?}]", 2.0 + x, y - 1.0);
            format!("[surface]\nkind = \"plane\"\n[aperture]\n{shape}\n{centre}\n{LIMITS}")
        };
        let report = stays(&part, |x, y| 1e-3 * x - 2e-3 * y);
        let origin = &report["form"]["origin"];
        assert_eq!(origin["place"], OriginFigures::MIDDLE_OF_APERTURE);
        assert_eq!((&origin["at_mm"][0], &origin["at_mm"][1]), (&2.0.into(), &(-1.0).into()));
    }
}

#[test]
fn surfaces_with_a_vertex_and_cylinders_have_the_same_figures_everywhere() {
    let sphere = |r2: f64| 40.0 - (1600.0 - r2).sqrt();
    let round = |x: f64, y: f64| sphere((x - 1.5).powi(2) + (y + 0.5).powi(2));
    let part = |_: [f64; 2]| format!("[surface]\nkind = \"sphere\"\nradius_mm = 40\n{LIMITS}");
    assert_eq!(stays(&part, round)["form"]["origin"]["place"], OriginFigures::VERTEX);
    let aperture = "[aperture]\nshape = \"circle\"\nradius_mm = 2\ncentre_mm = [0.5, -0.5]\n\
         [fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n";
    let part =
        |_: [f64; 2]| format!("[surface]\nkind = \"sphere\"\nradius_mm = 40\n{aperture}{LIMITS}");
    let report = stays(&part, round);
    let origin = &report["form"]["origin"];
    assert_eq!(origin["place"], OriginFigures::MIDDLE_OF_APERTURE);
    assert!((origin["at_mm"][0].as_f64().unwrap() - 2.0).abs() < 0.05, "{origin}");
    let cylinder = |x: f64, y: f64| sphere((x - 0.1 * y - 2.0).powi(2) / 1.01);
    let part = |_: [f64; 2]| {
        format!("[surface]\nkind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = 40\n{LIMITS}")
    };
    let report = stays(&part, cylinder);
    assert_eq!(report["form"]["origin"]["place"], OriginFigures::MIDDLE_OF_POINTS);
    let part = |_: [f64; 2]| {
        format!("[surface]\nkind = \"unknown\"\n{}", LIMITS.replace("minimum_zone = true", ""))
    };
    stays(&part, round);
}

/// The figures of metropro-1.dat about its middle, its points moved: by NumPy's lstsq over the heights SurfaceTopography reads, as in
/// the end-to-end test of the file itself. About the corner from which the file counts A is 208.95 nm and RMSt 46.25 nm.
#[test]
fn a_measured_map_has_its_figures_about_its_middle() {
    let folder = std::env::var_os("ASPHERA_DATA").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let Ok(bytes) = std::fs::read(folder.join("topography/metropro-1.dat")) else {
        println!("skipped: {} holds no topography/metropro-1.dat", folder.display());
        return;
    };
    let Ok(Topography::Map(map, _)) = asphera_formats::read("metropro-1.dat", &bytes) else {
        panic!("a map")
    };
    let limits =
        "[tolerance]\na_nm = 100\nrmst_nm = 20\n[uncertainty]\nnoise_nm = 0.4\ndraws = 20\n";
    let part =
        format!("[surface]\nkind = \"plane\"\n{limits}[figures]\npsd = false\nq_terms = 0\n");
    let mut pipeline = Pipeline::new(parse("part.toml", &part).unwrap());
    for (index, &z_mm) in map.z_mm.iter().enumerate() {
        let [x, y] = [index % map.nx, index / map.nx].map(|at| at as f64);
        let place = [SHIFT_MM[0] + x * map.dx_mm, SHIFT_MM[1] + y * map.dy_mm];
        pipeline.take_position([place[0], place[1], z_mm]);
    }
    let report = pipeline.finish().report;
    assert_eq!(report.verdict.status, Status::Pass, "{:?}", report.verdict);
    let form = report.form.unwrap();
    for (name, nm) in [("A", 52.237914408279586), ("RMSt", 13.286031190963456)] {
        let found = form.figures.iter().find(|figure| figure.name == name).unwrap().value;
        // Rounding of the places decides which way each square of nodes is parted, and so how much area a node has.
        assert!((found / nm - 1.0).abs() < 0.01, "{name} {found} nm, not {nm} nm");
    }
}

/// A middle is known to 1e-13 of the extent, and heights on a slope by as much.
const RELATIVE: f64 = 1e-5;
/// In nm, mm and what else there is.
const ABSOLUTE: f64 = 1e-6;

//! Outlines as apertures: from numbers, from a drawing, from points that were measured, and in a recording.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use asphera::config::Config;
use asphera::live::Station;
use asphera::replay::replay;
use asphera_link::Command;
use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{count, json, number, run};
use serde_json::Value;
use tokio::time::timeout;

use crate::random::Random;

/// The report of points measured against a plane over an aperture.
fn measured(folder: &Path, points: &Path, aperture: &str) -> Value {
    let nominal = folder.join("nominal.toml");
    let text = format!(
        "[surface]\nkind = \"plane\"\n[aperture]\n{aperture}\n[sampling]\ngap_limit_mm = 1.0\n\
         [tolerance]\nrms_nm = 20\n"
    );
    std::fs::write(&nominal, text).unwrap();
    let (points, nominal) = (points.to_str().unwrap(), nominal.to_str().unwrap());
    let output = run(["measure", points, "--nominal", nominal, "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    json(&output)
}

/// Points with 5 nm of noise in a file.
fn write(path: &Path, places: impl IntoIterator<Item = [f64; 2]>, random: &mut Random) {
    let mut text = "x[mm],y[mm],z[mm]\n".to_owned();
    for [x, y] in places {
        // Writing into a String cannot fail.
        let _ = writeln!(text, "{x},{y},{:e}", 5e-6 * random.normal());
    }
    std::fs::write(path, text).unwrap();
}

#[test]
fn an_outline_counts_as_the_rectangle_it_draws() {
    let folder = tempfile::tempdir().unwrap();
    let points = folder.path().join("points.csv");
    let raster = (0..51)
        .flat_map(|j| (0..61).map(move |i| [0.2 * f64::from(i) - 6.05, 0.2 * f64::from(j) - 5.05]));
    write(&points, raster, &mut Random(7));
    let rectangle = "shape = \"rectangle\"\nwidth_mm = 10\nheight_mm = 8";
    let lines = "shape = \"outline\"\nlines_mm = [[-5, -4, 5, -4, 5, 4, -5, 4]]";
    let [rectangle, outline] =
        [rectangle, lines].map(|keys| measured(folder.path(), &points, keys));
    for figure in ["/form/deviation/pv_nm", "/form/deviation/rms_nm", "/form/fit/pose/tz_mm"] {
        assert_eq!(number(&rectangle, figure), number(&outline, figure), "{figure}");
    }
    let used = |report: &Value| count(report, "/points/used");
    assert_eq!((used(&rectangle), used(&outline)), (2000, 2000));
    let coverage = |report| number(report, "/sampling/coverage");
    assert!((coverage(&rectangle) - coverage(&outline)).abs() < 1e-6);
    assert_eq!(rectangle["verdict"]["status"], outline["verdict"]["status"]);
}

#[test]
fn an_outline_that_was_measured_is_the_aperture() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random(11);
    // A disc of radius 10 about (30, -20), flat on one side, with a bore of radius 3.
    let inside = |[x, y]: [f64; 2]| x.hypot(y) < 10.0 && x < 6.0 && (x + 2.0).hypot(y) > 3.0;
    let places = std::iter::repeat_with(|| [0, 1].map(|_| 20.0 * random.unit() - 10.0));
    let places: Vec<[f64; 2]> = places.filter(|&place| inside(place)).take(8000).collect();
    let points = folder.path().join("points.csv");
    write(&points, places.iter().map(|[x, y]| [x + 30.0, y - 20.0]), &mut random);
    let contour = run(["contour", points.to_str().unwrap(), "--method", "auto", "--json"]);
    assert_eq!(contour.status.code(), Some(0), "{}", String::from_utf8_lossy(&contour.stderr));
    assert_eq!(count(&json(&contour), "/holes"), 1);
    std::fs::write(folder.path().join("outline.json"), &contour.stdout).unwrap();

    let keys = "shape = \"outline\"\nfile = \"outline.json\"";
    let report = measured(folder.path(), &points, keys);
    let coverage = number(&report, "/sampling/coverage");
    assert!(coverage > 0.985, "{coverage}");
    // The segment beyond the flat side, and the bore.
    let angle = 0.6_f64.acos();
    let area_mm2 = std::f64::consts::PI * (100.0 - 9.0) - (100.0 * angle - 6.0 * 8.0);
    let found_mm2 = number(&json(&contour), "/area_mm2");
    assert!((found_mm2 / area_mm2 - 1.0).abs() < 0.005, "{found_mm2}, not {area_mm2}");
    let missing_mm2 = number(&report, "/sampling/uncovered_area_mm2");
    assert!(missing_mm2 < 0.015 * area_mm2, "{missing_mm2}");
    let origin = &report["form"]["origin"];
    assert_eq!(origin["place"], "middle of the aperture");
    assert!((number(origin, "/at_mm/0") - 30.0).abs() < 3.0, "{origin}");
    let rms_nm = number(&report, "/form/deviation/rms_nm");
    assert!((rms_nm - 5.0).abs() < 0.2, "{rms_nm}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_recording_holds_the_outline_it_was_measured_with() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::built_in("sphere").unwrap().with_points(2500).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options =
        StationOptions { recordings: folder.path().to_owned(), listen: ([127, 0, 0, 1], 0).into() };
    let drawing = folder.path().join("square.svg");
    std::fs::write(&drawing, "<svg><path d='M -3 -3 L 3 -3 L 3 3 L -3 3 Z'/></svg>").unwrap();
    let text = rig.station_toml(&options);
    let at = text.find("[nominal.aperture]").unwrap();
    let end = at + 1 + text[at + 1..].find("\n[").unwrap();
    let table =
        format!("[nominal.aperture]\nshape = \"outline\"\nfile = {:?}\n", drawing.display());
    let text = format!("{}{table}{}", &text[..at], &text[end..]);
    let mut station = Station::start(Config::parse("station.toml", &text).unwrap()).unwrap();
    station.handle().session(Command::Start).await.unwrap();
    let finished =
        timeout(Duration::from_secs(120), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    assert_eq!(report.session.as_ref().unwrap().ended, "complete");
    assert!((200..2000).contains(&report.points.used), "{:?}", report.points);

    std::fs::remove_file(drawing).unwrap();
    let mut again = replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
}

//! Contours of sessions: while points arrive, in the report, over HTTP, from the recording and from the exported points.

use std::time::Duration;

use asphera::config::Config;
use asphera::live::{Finished, Station};
use asphera::replay::replay;
use asphera_link::Command;
use asphera_report::contour::ContourReport;
use asphera_report::{LiveStation as _, State, Status};
use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{count, json, number, recording, run};
use serde_json::Value;
use tokio::time::timeout;

use crate::demo::{replayed, timeless};

/// The contour of points without the names of files.
fn contour_of(source: &str, more: &[&str]) -> Value {
    let mut words = vec!["contour", source, "--json"];
    words.extend(more);
    json(&run(words))
}

#[test]
fn the_contour_of_a_blade_is_that_of_its_exported_points() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let arguments =
        ["demo", "--scene", "blade", "--points", "2000", "--speed", "max", "--exit", "--json"];
    let output = run(arguments.into_iter().chain(["--out", folder]));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report = json(&output);
    let contour = &report["contour"];
    assert_eq!((&contour["method"], count(contour, "/input/points")), (&"connect2d".into(), 2000));
    let chains = contour["chains"].as_array().unwrap();
    assert_eq!((chains.len(), &chains[0]["closed"]), (1, &Value::from(true)));

    // The section that the simulator really has: NACA 2412 of 60 mm.
    let features = contour["features"].as_array().unwrap();
    let feature = |kind: &str| features.iter().find(|feature| feature["kind"] == kind).unwrap();
    // Of 20,000 places on it: the largest distance from the trailing edge, and the area of their polygon.
    for (kind, key, truth) in
        [("airfoil", "chord_mm", 60.004_750), ("enclosed", "area_mm2", 294.398_798)]
    {
        let found = number(feature(kind), &format!("/{key}"));
        let u = number(feature(kind), &format!("/u_{key}"));
        assert!(u < 0.005 && (found - truth).abs() < 4.0 * u, "{key}: {found} ± {u}, not {truth}");
    }
    let thickness_mm = number(feature("airfoil"), "/thickness_mm");
    assert!((thickness_mm - 7.2).abs() < 0.002, "{thickness_mm}");

    // The same of the recording, of the replay, and of the points in a file.
    let session = recording(out.path());
    let session = session.to_str().unwrap();
    let settings = ["--method", "connect2d", "--airfoil"];
    assert_eq!(&contour_of(session, &settings), contour);
    // Without options it is that of the recorded configuration; an option replaces its setting.
    assert_eq!(&contour_of(session, &[]), contour);
    let crust = contour_of(session, &["--method", "crust"]);
    assert_eq!((&crust["method"], &crust["parameters"]), (&"crust".into(), &serde_json::json!({})));
    let file = out.path().join("points.xyz");
    let file = file.to_str().unwrap();
    assert_eq!(run(["export", session, "--out", file]).status.code(), Some(0));
    assert_eq!(&contour_of(file, &settings), contour);
    assert_eq!(timeless(replayed(out.path())), timeless(report));
}

/// Measures a simulated part with these tables in its configuration.
async fn measured(
    scene: Scene,
    tables: &str,
) -> (tempfile::TempDir, Station, std::sync::Arc<Finished>) {
    let folder = tempfile::tempdir().unwrap();
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options =
        StationOptions { recordings: folder.path().to_owned(), listen: ([127, 0, 0, 1], 0).into() };
    let text = rig.station_toml(&options);
    // The blade has a table of its own.
    let text = text.replace(
        "[contour]\n# It joins the corner behind.\nmethod = \"connect2d\"\nairfoil = true\n",
        "",
    );
    let config = Config::parse("station.toml", &format!("{text}\n{tables}\n")).unwrap();
    let mut station = Station::start(config).unwrap();
    station.handle().session(Command::Start).await.unwrap();
    let finished =
        timeout(Duration::from_secs(120), station.closed()).await.unwrap().unwrap().finished;
    (folder, station, finished)
}

fn contour(finished: &Finished) -> &ContourReport {
    finished.measurement.report.contour.as_ref().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn too_few_points_leave_the_contour_unknown_and_stop_nothing() {
    let scene = Scene::built_in("blade").unwrap().with_points(2).with_speed(Speed::Max);
    let (_folder, station, finished) =
        measured(scene, "[contour]\n[contour.limits]\nroundness_mm = 1").await;
    let report = &finished.measurement.report;
    let session = report.session.as_ref().unwrap();
    assert_eq!((session.ended.as_str(), report.points.received), ("complete", 2));
    let why = "contour: expected three different places or more, found 2 in 2 points; measure more of the curve";
    assert_eq!(contour(&finished).unknown, [why]);
    assert_eq!(report.verdict.status, Status::Undecided);
    assert!(report.verdict.reasons.iter().any(|reason| reason.ends_with(why)), "{report:?}");
    let shown = station.handle().contour().await.unwrap();
    assert_eq!((shown.as_of_points, shown.contour.unknown.len()), (2, 1));
    let mut again = replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
}

#[tokio::test(flavor = "multi_thread")]
async fn hints_of_the_station_label_the_section_and_a_guard_band_is_replayed() {
    let scene = Scene::built_in("blade").unwrap().with_points(1000).with_speed(Speed::Max);
    let hints =
        "[contour]\nmethod = \"delaunay-painting\"\nhints = \"0.013,0.517=blade;29,8=air\"\n";
    let limits = "[contour.limits]\nroundness_mm = 1\nguard_probability = 0.95\n";
    let (_folder, _station, finished) = measured(scene, &format!("{hints}{limits}")).await;
    let report = &finished.measurement.report;
    let regions = contour(&finished).regions.as_ref().unwrap();
    let blade = regions.iter().find(|it| it.label.as_deref() == Some("blade")).unwrap();
    assert!((blade.area_mm2 - 294.4).abs() < 0.5, "{}", blade.area_mm2);
    // A blade is no circle.
    assert_eq!(report.verdict.status, Status::Undecided);
    let mut again = replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
}

#[tokio::test(flavor = "multi_thread")]
async fn the_border_of_a_raster_shows_while_it_is_scanned() {
    let folder = tempfile::tempdir().unwrap();
    // Four seconds, so that a busy machine sees it too.
    let scene = Scene::built_in("sphere").unwrap().with_points(4000).with_speed(Speed::Times(0.25));
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options =
        StationOptions { recordings: folder.path().to_owned(), listen: ([127, 0, 0, 1], 0).into() };
    std::fs::write(
        folder.path().join("square.svg"),
        "<svg><path d='M -6 -6 L 6 -6 L 6 6 L -6 6 Z'/></svg>",
    )
    .unwrap();
    let outline = folder.path().join("square.svg");
    let tables = format!(
        "[contour]\nmethod = \"alpha\"\noutline = {:?}\n\
         [contour.parameters]\nalpha_mm = 0.3\n[contour.limits]\ndeviation_mm = 0.001\n",
        outline.to_str().unwrap()
    );
    let text = format!("{}\n{tables}", rig.station_toml(&options));
    let mut station = Station::start(Config::parse("station.toml", &text).unwrap()).unwrap();
    let mut snapshots = station.handle().watch();
    station.handle().session(Command::Start).await.unwrap();
    let shown = snapshots.wait_for(|now| now.state == State::Measuring && now.contour.is_some());
    let shown = timeout(Duration::from_secs(60), shown).await.unwrap().unwrap().clone();
    let live = station.handle().contour().await.unwrap();
    assert!(live.in_xy && live.as_of_points >= shown.contour.unwrap().as_of_points);
    assert!((100..4000).contains(&live.as_of_points), "{}", live.as_of_points);
    assert_eq!(live.contour.parts, Some(1));
    let finished =
        timeout(Duration::from_secs(120), station.closed()).await.unwrap().unwrap().finished;
    let report = &finished.measurement.report;
    let found = contour(&finished);
    assert_eq!((found.input.points, found.parts, found.holes), (4000, Some(1), Some(0)));
    // 63 points a line, and 31 on the last.
    let area_mm2 = found.area_mm2.unwrap();
    assert!((area_mm2 - 144.0).abs() < 2.5, "{area_mm2}");
    let check = report.verdict.checks.iter().find(|it| it.figure.id == "contour_deviation");
    // Half of the last line is missing: there the border is the line before, 12/63 mm inside.
    assert!((check.unwrap().value - 12.0 / 63.0).abs() < 1e-5, "{check:?}");
    assert_eq!(report.verdict.status, Status::Fail, "{:?}", report.verdict);
    let finally = station.handle().contour().await.unwrap();
    assert_eq!((finally.as_of_points, &finally.contour), (4000, found));

    // The outline stands in the recording: a replay does without the file.
    std::fs::remove_file(outline).unwrap();
    let mut again = replay(finished.recording.as_ref().unwrap(), |_| {}).unwrap();
    again.report.timing = report.timing.clone();
    assert_eq!(&again.report, report);
}

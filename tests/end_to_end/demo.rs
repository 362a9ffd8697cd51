//! A simulated part over real protocols: the figures agree with what the simulator really had, and the
//! replay of the recording with the live run.

use std::path::Path;

use asphera_tests::{count, json, json_file, number, recording, run};
use serde_json::Value;

fn demo(out: &Path, more: &[&str]) -> Value {
    let out = out.to_str().unwrap();
    let mut arguments = vec!["demo", "--exit", "--json", "--out", out];
    arguments.extend(more);
    let output = run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    json(&output)
}

/// The report without what no two runs share.
pub(crate) fn timeless(mut report: Value) -> Value {
    report.as_object_mut().unwrap().remove("timing");
    report
}

pub(crate) fn replayed(out: &Path) -> Value {
    let session = recording(out);
    let output = run(["replay", session.to_str().unwrap(), "--json"]);
    assert!(
        matches!(output.status.code(), Some(0 | 10 | 11)),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    json(&output)
}

#[test]
fn hundred_thousand_points_agree_with_the_truth_and_replay_alike() {
    let out = tempfile::tempdir().unwrap();
    let report = demo(out.path(), &["--points", "100000", "--speed", "max"]);
    let truth = json_file(&out.path().join("truth.json"));

    assert_eq!(report["format"], "asphera.report/1");
    assert_eq!(count(&report, "/points/received"), 100_000);
    assert_eq!(count(&report, "/points/used"), 100_000, "{:#}", report["points"]);
    for (place, tolerance) in [
        ("/form/deviation/rms_nm", 2.0),
        ("/form/deviation/pv_nm", 2.0),
        ("/form/deviation/max_nm", 2.0),
        ("/form/deviation/min_nm", 2.0),
        ("/form/fit/pose/rx_rad", 1e-6),
        ("/form/fit/pose/ry_rad", 1e-6),
        ("/form/fit/pose/tx_mm", 1e-4),
        ("/form/fit/pose/ty_mm", 1e-4),
        ("/form/fit/pose/tz_mm", 1e-6),
    ] {
        let (found, had) = (number(&report, place), number(&truth, place));
        assert!((found - had).abs() <= tolerance, "{place}: {found}, the simulator had {had}");
    }
    // The uncertainty covers the error, within a factor that form error justifies.
    for name in ["tx", "ty", "tz", "rx", "ry"] {
        let place = format!("/form/fit/parameters/{name}");
        let found = number(&report, &format!("{place}/value"));
        let had = number(&truth, &format!("{place}/value"));
        let u = number(&report, &format!("{place}/u"));
        assert!((found - had).abs() < 6.0 * u, "{name}: {found} ± {u}, the simulator had {had}");
    }
    assert_eq!(report["verdict"]["status"], "pass");
    // Its smooth ring is form.
    assert_eq!(report["defects"], serde_json::json!([]));
    for name in ["report.json", "mesh.ply", "deviation.ply", "deviation.x3p"] {
        assert!(out.path().join(name).metadata().unwrap().len() > 1000, "{name}");
    }
    assert_eq!(timeless(report.clone()), timeless(json_file(&out.path().join("report.json"))));
    assert_eq!(timeless(replayed(out.path())), timeless(report));
}

/// The scan of the README: its ring is seven spacings wide.
#[test]
fn the_smooth_ring_of_a_coarse_scan_is_no_defect() {
    let mut more_without_noise = 0;
    for points in ["5000", "20000"] {
        let out = tempfile::tempdir().unwrap();
        let report = demo(out.path(), &["--points", points, "--speed", "max"]);
        assert_eq!(report["defects"], serde_json::json!([]), "{points}");
        let low = number(&report, "/form/deviation/uncertainty/rms_95_nm/0");
        if low > number(&report, "/form/deviation/rms_nm") {
            more_without_noise += 1;
            // More without noise than with it: true only because one is over the area, the other over the points.
            let summary = run(["replay", recording(out.path()).to_str().unwrap()]);
            let words = String::from_utf8_lossy(&summary.stdout).into_owned();
            assert!(words.contains(", RMS") && words.contains("(over the area without"), "{words}");
        }
    }
    assert!(more_without_noise > 0, "the words about it were not looked at");
}

/// A cartesian bench: two encoders on one bus, a raster, a sphere whose radius is fitted.
#[test]
fn a_raster_of_a_sphere_agrees_with_the_truth_and_replays_alike() {
    let out = tempfile::tempdir().unwrap();
    let report = demo(out.path(), &["--scene", "sphere", "--points", "20000", "--speed", "max"]);
    let truth = json_file(&out.path().join("truth.json"));
    for (place, tolerance) in [
        ("/form/deviation/rms_nm", 2.0),
        ("/form/deviation/pv_nm", 5.0),
        ("/form/fit/pose/tz_mm", 1e-5),
    ] {
        let (found, had) = (number(&report, place), number(&truth, place));
        assert!((found - had).abs() <= tolerance, "{place}: {found}, the simulator had {had}");
    }
    assert_eq!(timeless(replayed(out.path())), timeless(report));
}

#[test]
fn the_same_seed_gives_the_same_part_and_another_seed_another_noise() {
    let truth = |seed: &str| {
        let out = tempfile::tempdir().unwrap();
        demo(out.path(), &["--points", "3000", "--speed", "max", "--seed", seed]);
        json_file(&out.path().join("truth.json"))
    };
    let first = truth("7");
    assert_eq!(first, truth("7"));
    assert_ne!(
        number(&first, "/form/deviation/pv_nm"),
        number(&truth("8"), "/form/deviation/pv_nm")
    );
}

#[test]
fn an_unknown_scene_lists_those_there_are() {
    let output = run(["demo", "--scene", "moon"]);
    assert_eq!(output.status.code(), Some(2));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("asphere") && words.contains("moon"), "{words}");
}

/// Neither the ports of its bench nor the truth of a part that nobody measured.
#[test]
fn a_demo_whose_address_is_taken_leaves_nothing() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let listen = taken.local_addr().unwrap().to_string();
    for scene in [&["demo"][..], &["demo", "--scene", "blade"]] {
        let out = tempfile::tempdir().unwrap();
        let out_text = out.path().to_str().unwrap();
        let options = ["--exit", "--points", "2000", "--listen", &listen, "--out", out_text];
        let output = run(scene.iter().chain(&options));
        assert_ne!(output.status.code(), Some(0));
        assert!(String::from_utf8_lossy(&output.stderr).contains(&listen), "{output:?}");
        let left: Vec<_> = std::fs::read_dir(out.path()).unwrap().flatten().collect();
        assert!(left.is_empty(), "{scene:?}: {left:?}");
    }
}

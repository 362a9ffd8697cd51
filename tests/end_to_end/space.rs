//! Parts that no plane shows: a ball on the bench, and points of files, meshed in space.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_rig::{Plan, Scene};
use asphera_tests::{Running, asphera, count, data, http, json, json_file, now, number, page, run};
use serde_json::Value;

use crate::demo::{replayed, timeless};

#[test]
fn a_ball_on_the_bench_ends_with_its_truth_and_its_verdict_and_replays_alike() {
    let out = tempfile::tempdir().unwrap();
    let folder = out.path().to_str().unwrap();
    let output = run([
        "demo", "--scene", "ball", "--points", "8000", "--speed", "max", "--exit", "--json",
        "--out", folder,
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report = json(&output);
    let truth = json_file(&out.path().join("truth.json"));
    assert_eq!(count(&report, "/points/used"), 8000, "{:#}", report["points"]);
    let mesh = &report["mesh"]["reconstruction"];
    assert_eq!(mesh["closed"], true, "{mesh:#}");
    assert_eq!((&mesh["facets"], &mesh["genus"]), (&(2 * 8000 - 4).into(), &0.into()));
    for (place, tolerance) in [
        ("/form/deviation/rms_nm", 0.5),
        ("/form/deviation/pv_nm", 5.0),
        ("/form/deviation/max_nm", 5.0),
        ("/form/deviation/min_nm", 5.0),
        ("/form/fit/pose/tx_mm", 2e-6),
        ("/form/fit/pose/ty_mm", 2e-6),
        ("/form/fit/pose/tz_mm", 2e-6),
        ("/form/fit/parameters/radius/value", 2e-6),
    ] {
        let (found, had) = (number(&report, place), number(&truth, place));
        assert!((found - had).abs() <= tolerance, "{place}: {found}, the simulator had {had}");
    }
    // Noise, and the rounding of the telegram to some 2 nm.
    let noise = number(&report, "/form/deviation/uncertainty/noise_nm");
    assert!((noise - 20.0).abs() < 1.5, "{noise}");
    assert_eq!(number(&report, "/sampling/coverage"), 1.0);
    assert_eq!(report["verdict"]["status"], "pass", "{:#}", report["verdict"]);
    assert_eq!(timeless(replayed(out.path())), timeless(report));
}

/// What a station says at some moment is what a file of as many points gives.
#[test]
fn a_snapshot_of_a_ball_is_the_measurement_of_the_points_so_far() {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--scene", "ball", "--points", "20000", "--speed", "2"])
            .args(["--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    let by = now() + Duration::from_secs(60);
    let mut moments: Vec<Value> = Vec::new();
    while moments.len() < 3 {
        assert!(now() < by, "{} moments were seen", moments.len());
        let (_, body) = http(&address, "GET", "/api/v1/snapshot", &[]);
        let snapshot: Value = serde_json::from_slice(&body).unwrap();
        let as_of = |of: &Value| of["mesh"]["reconstruction"]["as_of_points"].as_u64();
        let newest = moments.last().and_then(as_of).unwrap_or(1999);
        if as_of(&snapshot).is_some_and(|points| points > newest) && snapshot["form"].is_object() {
            moments.push(snapshot);
        }
        std::thread::park_timeout(Duration::from_millis(50));
    }
    let plan = Plan::new(&Scene::built_in("ball").unwrap().with_points(20_000)).unwrap();
    let nominal = nominal(out.path(), "[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n");
    for snapshot in moments {
        let so_far =
            usize::try_from(count(&snapshot, "/mesh/reconstruction/as_of_points")).unwrap();
        let mut text = String::from("x[mm] y[mm] z[mm]\n");
        for [x, y, z] in &plan.measured_mm()[..so_far] {
            writeln!(text, "{x:?} {y:?} {z:?}").unwrap();
        }
        let file = out.path().join("so-far.xyz");
        std::fs::write(&file, text).unwrap();
        let arguments = ["measure", file.to_str().unwrap(), "--nominal", &nominal];
        let output = run([&arguments[..], &["--along", "none", "--json"]].concat());
        let report = json(&output);
        for place in [
            "/mesh/reconstruction/facets",
            "/mesh/reconstruction/area_mm2",
            "/mesh/reconstruction/border_loops/0/length_mm",
            "/form/deviation/pv_nm",
            "/form/deviation/rms_nm",
            "/sampling/coverage",
            "/sampling/next/0/approach/2",
        ] {
            let (live, later) = (number(&snapshot, place), number(&report, place));
            assert!((live - later).abs() <= 1e-6 * live.abs().max(1.0), "{place}: {live} {later}");
        }
        assert_eq!(snapshot["mesh"]["reconstruction"]["closed"], so_far == 20_000);
        assert_eq!(snapshot["form"]["provisional"], so_far < 20_000);
    }
}

/// Points of a ball R 10 mm; without those whose z is above `top_mm`.
fn ball(folder: &Path, top_mm: f64) -> String {
    let mut text = String::from("x[mm] y[mm] z[mm]\n");
    for index in 0..12_000_u32 {
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / 12_000.0;
        let (sin, cos) = (f64::from(index) * 2.399_963_229_728_653).sin_cos();
        let r = (1.0 - z * z).sqrt();
        if 10.0 * z <= top_mm {
            writeln!(text, "{:.9} {:.9} {:.9}", 10.0 * r * cos, 10.0 * r * sin, 10.0 * z).unwrap();
        }
    }
    let file = folder.join("ball.xyz");
    std::fs::write(&file, text).unwrap();
    file.to_str().unwrap().to_owned()
}

fn nominal(folder: &Path, more: &str) -> String {
    let file = folder.join("sphere.toml");
    let text = "[surface]\nkind = \"sphere\"\nradius_mm = 10.0\n[tolerance]\npv_nm = 100.0\n";
    std::fs::write(&file, format!("{text}{more}")).unwrap();
    file.to_str().unwrap().to_owned()
}

fn measured(arguments: &[&str], code: i32) -> Value {
    let output = run(arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
    json(&output)
}

#[test]
fn a_file_of_a_ball_passes_in_space_in_any_order_and_is_said_to_fold_along_z() {
    let folder = tempfile::tempdir().unwrap();
    let (ball, nominal) = (ball(folder.path(), 10.0), nominal(folder.path(), ""));
    let measure = ["measure", &ball, "--nominal", &nominal, "--json"];
    let with = |more: &[&'static str]| -> Vec<&str> { [&measure[..], more].concat() };
    let found = timeless(measured(&with(&["--along", "none"]), 0));
    assert_eq!(found["verdict"]["status"], "pass");
    let volume = number(&found, "/mesh/reconstruction/volume_mm3");
    assert!((volume / (4000.0 / 3.0 * PI) - 1.0).abs() < 2e-3, "{volume}");
    assert!(number(&found, "/form/deviation/pv_nm") < 0.01);
    let shuffled = with(&["--along", "none", "--shuffle", "7", "--threads", "1"]);
    assert_eq!(timeless(measured(&shuffled, 0)), found);
    let auto = measured(&with(&["--along", "auto"]), 0);
    assert_eq!(auto["form"], found["form"]);
    let decision = auto["mesh"]["decision"].as_str().unwrap();
    assert!(decision.starts_with("in space") && decision.contains("folds"), "{decision}");
    let along_z = measured(&measure, 11);
    let reasons = along_z["verdict"]["reasons"].to_string();
    assert!(reasons.contains("--along none"), "{reasons}");
}

#[test]
fn an_opening_is_told_with_the_way_to_it_and_a_section_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (ball, nominal) = (ball(folder.path(), 9.0), nominal(folder.path(), ""));
    let out = folder.path().join("results");
    let text = run([
        "measure",
        &ball,
        "--nominal",
        &nominal,
        "--along",
        "none",
        "--out",
        out.to_str().unwrap(),
    ]);
    assert_eq!(text.status.code(), Some(0), "{}", String::from_utf8_lossy(&text.stderr));
    let said = String::from_utf8_lossy(&text.stdout);
    assert!(said.contains("in space") && said.contains("measure next"), "{said}");
    let report = json_file(&out.join("report.json"));
    let coverage = number(&report, "/sampling/coverage");
    assert!((coverage - 0.95).abs() < 0.002, "{coverage}");
    assert!(number(&report, "/sampling/next/0/approach/2") > 0.999);
    assert!(out.join("deviation.ply").metadata().unwrap().len() > 100_000);
    assert!(!out.join("deviation.x3p").exists());
    // Without a nominal, and of the ball as it is, from the points alone.
    let sampling = measured(&["sampling", &ball, "--along", "none", "--json"], 0);
    assert_eq!(sampling["lfs_source"], "measured");
    let lfs = number(&sampling, "/lfs_min_mm");
    assert!((lfs - 10.0).abs() < 1.0, "{lfs}");
    for word in ["sideways", "1,2", "NONE"] {
        let refused = run(["measure", &ball, "--nominal", &nominal, "--along", word]);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(said.contains("expected z, fitted, none, auto or three numbers"), "{said}");
    }
}

/// A scanned body: the mesh is that of `reconstruct`, and a design that is no sphere, cylinder or plane gets no form.
#[test]
fn a_scanned_body_has_the_mesh_of_reconstruct_and_no_form() {
    let Some(bunny) = data("solids/bunny.ply") else { return };
    let bunny = bunny.to_str().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("asphere.toml");
    let text =
        "[surface]\nkind = \"asphere\"\nradius_mm = 0.1\nconic = -1.0\n[tolerance]\npv_nm = 1.0\n";
    std::fs::write(&file, text).unwrap();
    let nominal = file.to_str().unwrap();
    let report =
        measured(&["measure", bunny, "--nominal", nominal, "--along", "none", "--json"], 11);
    let made = measured(&["reconstruct", bunny, "--json"], 0);
    let (found, made) = (&report["mesh"]["reconstruction"], &made["mesh"]["reconstruction"]);
    for name in [
        "facets",
        "components",
        "closed",
        "manifold",
        "orientable",
        "genus",
        "betti",
        "nonmanifold_edges",
        "singular_vertices",
        "self_intersections",
    ] {
        assert_eq!(found[name], made[name], "{name}");
    }
    let (area, made_area) = (number(found, "/area_mm2"), number(made, "/area_mm2"));
    assert!((area / made_area - 1.0).abs() < 1e-9, "{area} {made_area}");
    assert!(report["form"].is_null());
    let reasons = report["verdict"]["reasons"].to_string();
    assert!(reasons.contains("sphere, a circular cylinder and a plane"), "{reasons}");
}

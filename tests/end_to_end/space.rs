//! Parts that no plane shows: a ball on the bench, and points of files, meshed in space.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_rig::{Plan, Scene};
use asphera_tests::{
    Running, asphera, count, data, http, json, json_file, number, page, run, until,
};
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
    let mut moments: Vec<Value> = Vec::new();
    until(&address, "three moments with figures", Duration::from_secs(60), |snapshot| {
        let as_of = |of: &Value| of["mesh"]["reconstruction"]["as_of_points"].as_u64();
        let newest = moments.last().and_then(as_of).unwrap_or(1999);
        if as_of(snapshot).is_some_and(|points| points > newest) && snapshot["form"].is_object() {
            moments.push(snapshot.clone());
        }
        moments.len() == 3
    });
    let plan = Plan::new(&Scene::built_in("ball").unwrap().with_points(20_000)).unwrap();
    let nominal = nominal(out.path(), "[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n");
    // Upright through the middle: it cuts what is scanned so far, and ends at its border.
    let plane = format!("plane=1,0,0,{}", number(&moments[0], "/form/origin/at_mm/0"));
    let (status, body) = http(&address, "GET", &format!("/api/v1/section?{plane}"), &[]);
    let section: Value = serde_json::from_slice(&body).unwrap();
    assert_eq!(status, 200, "{section:#}");
    let length_mm = number(&section, "/length_mm");
    assert!(length_mm > 1.0 && length_mm < 2.0 * PI * 10.0, "{length_mm}");
    assert_eq!(
        (&section["pieces"][0]["ends"], &section["height"]),
        (&"border".into(), &Value::Null)
    );
    assert!(number(&section, "/deviation/rms_nm") > 1.0, "{section:#}");
    let (status, body) = http(&address, "GET", "/api/v1/section?line=0,0,3,4", &[]);
    let said = String::from_utf8_lossy(&body);
    assert!(
        (400..500).contains(&status) && said.contains("upright plane there is -4,3,0,0"),
        "{said}"
    );
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
    // The paper draws the limit into the histogram, and says where there is none.
    assert_eq!(number(&found, "/form/histogram/pv_limit_nm"), 100.0);
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
fn an_opening_is_told_with_the_way_to_it() {
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

/// Circles of a ball, with their deviation, as CSV, JSON and text; where it is open they are arcs.
#[test]
fn a_ball_is_cut_by_planes() {
    let folder = tempfile::tempdir().unwrap();
    let (ball, nominal) = (ball(folder.path(), 9.0), nominal(folder.path(), ""));
    let cut = |plane: &str, more: &[&str]| {
        run([&["section", &ball, "--along", "none", "--plane", plane][..], more].concat())
    };
    let with = ["--nominal", &nominal, "--json"];
    let whole = json(&cut("0,0,1,6", &with));
    assert_eq!(
        whole["path"],
        serde_json::json!({"kind": "plane", "normal": [0.0, 0.0, 1.0], "offset_mm": 6.0})
    );
    assert!((number(&whole, "/length_mm") / (16.0 * PI) - 1.0).abs() < 1e-3, "{whole:#}");
    assert_eq!(whole["pieces"][0]["begins"], "closed");
    assert!(number(&whole, "/deviation/pv_nm") < 0.01, "{whole:#}");
    // Upright through the middle: it ends at the hole, 9 mm above.
    let open = json(&cut("1,0,0,0", &with));
    let arc_mm = 10.0 * 2.0 * (PI - 0.9_f64.acos());
    assert!((number(&open, "/length_mm") / arc_mm - 1.0).abs() < 0.02, "{open:#}");
    let piece = &open["pieces"][0];
    assert_eq!((&piece["begins"], &piece["ends"]), (&"border".into(), &"border".into()));
    let out = folder.path().join("section.csv");
    let said = cut("0,0,1,6", &["-o", out.to_str().unwrap()]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(
        said.starts_with("section    50.2") && said.contains("mm in one closed piece"),
        "{said}"
    );
    let csv = std::fs::read_to_string(&out).unwrap();
    let (head, rows) = csv.split_once('\n').unwrap();
    assert_eq!(head, "piece,s_mm,x_mm,y_mm,z_mm");
    let places: Vec<&str> = rows.lines().map(|row| row.splitn(3, ',').nth(2).unwrap()).collect();
    assert!(places.len() > 100 && places.first() == places.last(), "{csv}");
    // What cannot be done is said, with what can.
    let line = ["section", &ball, "--along", "none", "--line", "0,0,1,0"];
    let said = run(line);
    let said = String::from_utf8_lossy(&said.stderr);
    assert!(said.contains("the upright plane there is 0,1,0,0"), "{said}");
    let beyond = cut("0,0,1,12", &[]);
    let beyond = String::from_utf8_lossy(&beyond.stderr);
    assert!(beyond.contains("meets no measured surface"), "{beyond}");
    let folded = run(["section", &ball, "--plane", "0,0,1,6"]);
    let folded = String::from_utf8_lossy(&folded.stderr);
    assert!(folded.contains("does not project") && folded.contains("--along none"), "{folded}");
}

/// Fewer points of a ball: near enough to every point of it by brute force, in any order, and sampled as the report of them says.
#[test]
fn a_ball_is_reduced_to_an_epsilon_sample() {
    let folder = tempfile::tempdir().unwrap();
    let (ball, nominal) = (ball(folder.path(), 9.0), nominal(folder.path(), ""));
    let out = folder.path().join("fewer.xyz");
    let reduce = |file: &str, more: &[&str]| {
        let out = out.to_str().unwrap();
        run([&["reduce", file, "--epsilon", "0.1", "-o", out, "--force"][..], more].concat())
    };
    let with = ["--along", "none", "--nominal", &nominal, "--json"];
    let report = json(&reduce(&ball, &with));
    assert_eq!(report["format"], "asphera.reduction-in-space/1");
    for name in ["components", "genus", "border_loops", "flaws"] {
        assert_eq!(report["before"][name], report["after"][name], "{name}");
    }
    assert_eq!(count(&report, "/after/border_loops"), 1);
    assert!(number(&report, "/after/epsilon_max") <= 0.1 && number(&report, "/away_max_mm") <= 1.0);
    assert_eq!(number(&report, "/lfs/min_mm"), 10.0);
    let kept = std::fs::read_to_string(&out).unwrap();
    assert!(kept.contains("epsilon 0.1 of the local feature size (nominal)"), "{kept}");
    let places = |text: &str| -> Vec<[f64; 3]> {
        let rows =
            text.lines().filter(|line| line.starts_with(|c: char| c == '-' || c.is_ascii_digit()));
        let of =
            |row: &str| -> Vec<f64> { row.split(' ').map(|word| word.parse().unwrap()).collect() };
        rows.map(|row| of(row).try_into().unwrap()).collect()
    };
    let (all, few) = (places(&std::fs::read_to_string(&ball).unwrap()), places(&kept));
    assert_eq!(few.len() as u64, count(&report, "/kept"));
    assert!(few.len() < 1_400 && few.iter().all(|place| all.contains(place)), "{}", few.len());
    for place in &all {
        let away =
            |one: &[f64; 3]| (0..3).map(|axis| (one[axis] - place[axis]).powi(2)).sum::<f64>();
        assert!(few.iter().map(away).fold(f64::INFINITY, f64::min) <= 1.0, "{place:?}");
    }
    let fewer = out.to_str().unwrap();
    let sampling = measured(
        &[
            "sampling",
            fewer,
            "--along",
            "none",
            "--nominal",
            &nominal,
            "--epsilon",
            "0.1",
            "--json",
        ],
        0,
    );
    assert!(number(&sampling, "/epsilon_max") <= 0.1, "{sampling:#}");
    // Backwards the same, and folded points are asked to be meshed in space.
    let backwards = folder.path().join("backwards.xyz");
    let text = std::fs::read_to_string(&ball).unwrap();
    let (head, rows) = text.split_once('\n').unwrap();
    let turned: Vec<&str> = rows.lines().rev().collect();
    std::fs::write(&backwards, format!("{head}\n{}\n", turned.join("\n"))).unwrap();
    let said = reduce(backwards.to_str().unwrap(), &["--along", "auto", "--nominal", &nominal]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    assert!(said.contains("components 1, genus 0, borders 1, largest ε 0.0"), "{said}");
    assert_eq!(places(&std::fs::read_to_string(&out).unwrap()), few);
    for (more, why) in [
        (&[][..], "does not project"),
        (&["--along", "1,0,0"], "expected z, none or auto, found `1,0,0`"),
        (&["--along", "none", "--average"], "found --average: leave it out"),
        (&["--along", "none", "--keep", "most"], "found --keep: leave it out"),
        (
            &["--along", "none", "--rho", "0.001"],
            "facets of the points have larger gaps than the limit",
        ),
    ] {
        let refused = reduce(&ball, more);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() != Some(0) && said.contains(why), "{more:?}: {said}");
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

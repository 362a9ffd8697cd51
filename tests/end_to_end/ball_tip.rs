//! A stylus with a ball tip, from its simulated devices to the report.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use asphera_tests::{Running, asphera, json_file, recording, root};
use serde_json::Value;

/// Simulates the stylus with one tip, and measures with another. The report and its session's replay, without timing.
fn measured(simulated_mm: f64, stated_mm: f64) -> [Value; 2] {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(root().join("config/examples/stylus.toml")).unwrap();
    let mut document: toml_edit::DocumentMut = text.parse().unwrap();
    let recordings = folder.path().join("recordings");
    document["session"]["dir"] = toml_edit::value(recordings.display().to_string());
    document["publish"]["listen"] = toml_edit::value("127.0.0.1:0");
    document["station"]["autostart"] = toml_edit::value(true);
    let files: toml_edit::Array = ["report.json"].into_iter().collect();
    document["output"]["files"] = toml_edit::value(files);
    document["tip"]["radius_mm"] = toml_edit::value(simulated_mm);
    let [mine, there] = ["mine.toml", "there.toml"].map(|name| folder.path().join(name));
    std::fs::write(&mine, document.to_string()).unwrap();
    let mut simulate = Command::new(asphera());
    simulate.arg("simulate").arg(&mine).arg("--station").arg(&there);
    // The largest deviations stand at the border: among fewer points than these, the nearest one to it decides.
    simulate.args(["--form-nm", "100", "--noise-nm", "0", "--points", "30000", "--rate", "10000"]);
    let mut simulating = Running::start(&mut simulate);
    simulating.line("simulating", Duration::from_secs(60));
    let mut station: toml_edit::DocumentMut =
        std::fs::read_to_string(&there).unwrap().parse().unwrap();
    station["tip"]["radius_mm"] = toml_edit::value(stated_mm);
    // Contacts lie further in than centres: all three measure what the ball reaches.
    station["nominal"]["aperture"]["radius_mm"] = toml_edit::value(5.5);
    std::fs::write(&there, station.to_string()).unwrap();
    let running =
        Running::start(Command::new(asphera()).args(["run", "--once", "--config"]).arg(&there));
    let output = running.wait(Duration::from_secs(240));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!([0, 10, 11].contains(&output.status.code().unwrap()), "{said}");
    let session = recording(&recordings);
    let live = json_file(&session.join("report.json"));
    [live, replayed(&session)].map(|mut report| {
        report["timing"] = Value::Null;
        report
    })
}

fn replayed(session: &Path) -> Value {
    let output = Command::new(asphera()).arg("replay").arg(session).arg("--json").output().unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

fn deviation(report: &Value, figure: &str) -> f64 {
    report["form"]["deviation"][figure].as_f64().unwrap()
}

/// The form error is that of a point tip to a nanometre, micrometres without compensation, and the same in a replay.
#[test]
fn the_form_error_comes_back_from_under_the_ball() {
    let [point, _] = measured(0.0, 0.0);
    let [ball, replay] = measured(0.5, 0.5);
    let [without, _] = measured(0.5, 0.0);
    let [truth, found, without] =
        [&point, &ball, &without].map(|report| deviation(report, "pv_nm"));
    let [rms_nm, found_rms_nm] = [&point, &ball].map(|report| deviation(report, "rms_nm"));
    assert!((found_rms_nm - rms_nm).abs() < 0.05, "{found_rms_nm} for {rms_nm} nm");
    assert!((found - truth).abs() < 1.0, "{found} for {truth} nm");
    assert!(without > truth + 1000.0, "{without} for {truth} nm");
    assert_eq!(ball, replay);
    let tip = &ball["points"]["tip"];
    assert_eq!(tip["radius_mm"], 0.5);
    assert!(tip["largest_height_nm"].as_f64().unwrap() > 20_000.0, "{tip}");
    assert!(point["points"].get("tip").is_none());
}

/// A file of ball centres on paper: its contacts are the sphere, and what the radius leaves open stands in its table.
#[test]
fn a_report_of_a_file_knows_its_ball() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let side = || (-30..=30).map(|step| 0.25 * f64::from(step));
    let centres =
        side().flat_map(|x| side().map(move |y| [x, y])).filter(|[x, y]| x.hypot(*y) < 7.5);
    let line = |[x, y]: [f64; 2]| {
        format!("{x} {y} {:.9}\n", (20.5_f64.powi(2) - x * x - y * y).sqrt() - 20.0)
    };
    std::fs::write(file("centres.xyz"), centres.map(line).collect::<String>()).unwrap();
    let nominal = "[surface]\nkind = \"sphere\"\nradius_mm = -20\n[aperture]\nshape = \"circle\"\nradius_mm = 6.5\n\
                   [fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n[tolerance]\npv_nm = 100\n";
    std::fs::write(file("sphere.toml"), nominal).unwrap();
    let report = |more: &[&str], out: &str| {
        let mut command = Command::new(asphera());
        command.arg("report").arg(file("centres.xyz")).args(["--unit", "mm", "--nominal"]);
        command.arg(file("sphere.toml")).args(more).arg("--out").arg(file(out));
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let page = std::fs::read_to_string(file(out)).unwrap_or_else(|_| panic!("{said}"));
        (output.status.code().unwrap(), page)
    };
    let ball = ["--tip-radius", "0.5", "--tip-u-radius", "0.0002", "--tip-centre"];
    let (code, page) = report(&ball, "ball.html");
    assert_eq!(code, 0, "the contacts are the sphere");
    assert!(page.contains("radius of the ball tip"));
    assert!(page.contains("by noise and the systematic errors below"));
    let (code, page) = report(&[], "bare.html");
    assert_eq!(code, 10, "the centres are not");
    assert!(!page.contains("radius of the ball tip"));
}

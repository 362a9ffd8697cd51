//! Defects and sections in planes, through the command line.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use asphera_tests::{count, json, number, run};
use serde_json::Value;

use crate::random::Random;

const NOMINAL: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 25\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 1.9\n[tolerance]\npv_nm = 1000\n";

/// 201 × 201 points every 0.02 mm on a sphere with 20 nm of noise, a pit of 400 nm at (0.8, -0.5), and a level scratch
/// of 250 nm at y = 1 from x = -0.8 to 0.6.
fn damaged(folder: &Path) -> PathBuf {
    let mut text = String::new();
    let mut random = Random(23);
    for row in -100..=100 {
        for column in -100..=100 {
            let [x, y] = [column, row].map(|index| 0.02 * f64::from(index));
            let noise = random.normal();
            let sag = 25.0 - (625.0 - x * x - y * y).sqrt();
            let pit = -4e-4 * (-((x - 0.8_f64).powi(2) + (y + 0.5_f64).powi(2)) / 0.006).exp();
            let within = (y - 1.0_f64).abs() < 0.05 && (-0.8..=0.6).contains(&x);
            let scratch = if within { -2.5e-4 } else { 0.0 };
            writeln!(text, "{x} {y} {}", sag + 20e-6 * noise + pit + scratch).unwrap();
        }
    }
    let path = folder.join("damaged.xyz");
    std::fs::write(&path, text).unwrap();
    path
}

fn nominal(folder: &Path, more: &str) -> String {
    let path = folder.join("nominal.toml");
    std::fs::write(&path, format!("{more}{NOMINAL}")).unwrap();
    path.to_str().unwrap().to_owned()
}

fn figures(words: &[&str]) -> Value {
    let output = run([words, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    json(&output)
}

fn assert_both(found: &Value) {
    let defects = found["defects"].as_array().unwrap();
    assert_eq!((defects.len(), count(found, "/defects_more")), (2, 0), "{defects:?}");
    let of = |kind: &str| defects.iter().find(|defect| defect["kind"] == kind).unwrap();
    let (pit, scratch) = (of("pit"), of("scratch"));
    assert!((number(pit, "/height_nm") / -400.0 - 1.0).abs() < 0.1, "{pit}");
    assert!((number(pit, "/at_mm/0") - 0.8).abs() < 0.02, "{pit}");
    assert!((number(pit, "/at_mm/1") + 0.5).abs() < 0.02, "{pit}");
    assert!((number(scratch, "/height_nm") / -250.0 - 1.0).abs() < 0.1, "{scratch}");
    assert!((number(scratch, "/length_mm") / 1.4 - 1.0).abs() < 0.05, "{scratch}");
    let orientation_deg = number(scratch, "/orientation_deg");
    assert!(!(2.0..178.0).contains(&orientation_deg), "{scratch}");
    for name in
        ["shape", "area_mm2", "area_u_mm2", "height_u_nm", "width_mm", "points", "significance"]
    {
        assert!(!pit[name].is_null(), "{name}: {pit}");
    }
    assert!((number(found, "/defects_search/sigma_nm") / 20.0 - 1.0).abs() < 0.15);
    assert!(number(found, "/partition/shares/concave") > 0.95, "{}", found["partition"]);
}

#[test]
fn defects_are_named_with_and_without_a_nominal() {
    let dir = tempfile::tempdir().unwrap();
    let file = damaged(dir.path());
    let file = file.to_str().unwrap();
    let with = nominal(dir.path(), "");
    assert_both(&figures(&["sampling", file]));
    assert_both(&figures(&["sampling", file, "--nominal", &with]));
    let report = figures(&["measure", file, "--nominal", &with]);
    assert_both(&report);
    assert_eq!(report["verdict"]["status"], "pass");
    let text = run(["measure", file, "--nominal", &with]).stdout;
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("defects    2 beyond ") && text.contains("scratch -2"), "{text}");
    let text = run(["measure", file, "--nominal", &with, "--details"]).stdout;
    assert!(String::from_utf8(text).unwrap().contains("  By curvature: concave "));
    // Not wanted is not the same as none.
    let without = nominal(dir.path(), "defects = false\n");
    let found = figures(&["sampling", file, "--nominal", &without]);
    assert!(found.get("defects").is_none());
    assert!(found["defects_unknown"].as_str().unwrap().contains("defects = false"));
    let wrong = nominal(dir.path(), "defects = 3\n");
    let refused = run(["sampling", file, "--nominal", &wrong]);
    assert_eq!(refused.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("defects"));
}

#[test]
fn a_plane_of_any_direction_cuts_a_part() {
    let dir = tempfile::tempdir().unwrap();
    let file = damaged(dir.path());
    let file = file.to_str().unwrap();
    // Level at 0.04 mm: a circle of radius √(2·25·0.04), but where noise and the scratch shift it.
    let with = nominal(dir.path(), "");
    let found = figures(&["section", file, "--plane", "0,0,1,0.04", "--nominal", &with]);
    assert_eq!(found["path"]["kind"], "plane");
    let radius_mm = (2.0 * 25.0 * 0.04_f64 - 0.04 * 0.04).sqrt();
    let around_mm = std::f64::consts::TAU * radius_mm;
    assert!((number(&found, "/length_mm") / around_mm - 1.0).abs() < 0.01, "{found}");
    assert!(number(&found, "/deviation/rms_nm") < 60.0, "{found}");
    let leaning = run(["section", file, "--plane", "0.3,0.2,-1,0"]);
    let csv = String::from_utf8(leaning.stdout).unwrap();
    assert!(csv.starts_with("piece,s_mm,x_mm,y_mm,z_mm\n0,0,"), "{csv}");
    for line in csv.lines().skip(1) {
        let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
        let [_, _, x, y, z] = fields[..] else { panic!("{line}") };
        assert!((0.3 * x + 0.2 * y - z).abs() < 1e-12, "{line}");
    }
    let nowhere = run(["section", file, "--plane", "0,0,1,-3"]);
    assert_eq!(nowhere.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&nowhere.stderr).contains("meets no measured surface"));
    let none = run(["section", file, "--plane", "0,0,0,1"]);
    assert!(String::from_utf8_lossy(&none.stderr).contains("plane with normal (0, 0, 0)"));
}

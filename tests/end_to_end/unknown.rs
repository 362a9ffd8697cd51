//! Files of points without a design, with outliers, and with uncertainties, through the commands.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use asphera_tests::{json, run};

/// 2,500 points on a sphere of 30 mm with ±10 nm, every `each`th too high by 5 µm, with uncertainties of 10 and 5000 nm.
fn points(each: i32) -> String {
    let mut text = "x[mm] y[mm] z[mm] u_z[mm]\n".to_owned();
    for index in 0..2500 {
        let (i, j) = (index % 50, index / 50);
        let (x, y) = (0.1 * f64::from(i) - 2.5, 0.1 * f64::from(j) - 2.5);
        let rr = x * x + y * y;
        let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
        let (off, u) = if (index + 1) % each == 0 { (5e-3, 5e-3) } else { (1e-5 * sign, 1e-5) };
        let z = rr / (30.0 + (900.0 - rr).sqrt()) + off;
        writeln!(text, "{x} {y} {z} {u}").unwrap();
    }
    text
}

fn measure(folder: &Path, nominal: &str, points: &str) -> std::process::Output {
    let (file, part) = (folder.join("points.xyz"), folder.join("part.toml"));
    fs::write(&file, points).unwrap();
    fs::write(&part, nominal).unwrap();
    run(["measure", file.to_str().unwrap(), "--nominal", part.to_str().unwrap(), "--json"])
}

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 30\n[fit]\nfree = [\"tz\"]\n";

#[test]
fn a_file_without_a_design_has_a_verdict_that_says_what_it_is_of() {
    let folder = tempfile::tempdir().unwrap();
    let unknown = "[surface]\nkind = \"unknown\"\ncells = 8\n[tolerance]\nrms_nm = 2000\n";
    let output = measure(folder.path(), unknown, &points(10_000));
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let report = json(&output);
    assert_eq!(report["form"]["reference"]["cells"][0], 8, "{report:#}");
    assert!(report["verdict"]["reasons"].to_string().contains("made from these points"));
    let line = "0 0 0\n1 0 0\n2 0 0\n".repeat(10);
    let output = measure(folder.path(), unknown, &line);
    assert_eq!(output.status.code(), Some(11), "{output:?}");
}

#[test]
fn outliers_are_put_up_with_by_loss_or_by_weights() {
    let folder = tempfile::tempdir().unwrap();
    let tz_nm = |rest: &str| {
        let report = json(&measure(folder.path(), &format!("{SPHERE}{rest}"), &points(50)));
        let tz = report["form"]["fit"]["parameters"]["tz"]["value"].as_f64().unwrap();
        (1e6 * tz, report)
    };
    let (plain, _) = tz_nm("");
    assert!((plain - 100.0).abs() < 1.0, "{plain}");
    let (tukey, report) = tz_nm("loss = \"tukey\"\n");
    assert!(tukey.abs() < 0.5, "{tukey}");
    assert_eq!(report["form"]["fit"]["loss"]["left_out"], 50, "{report:#}");
    let (weighted, report) = tz_nm("weights = \"uncertainty\"\n");
    assert!(weighted.abs() < 0.5, "{weighted}");
    let effective = report["form"]["fit"]["effective_points"].as_f64().unwrap();
    assert!((effective - 2450.0).abs() < 2.0, "{effective}");
}

#[test]
fn uncertainties_that_are_none_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let nominal = format!("{SPHERE}weights = \"uncertainty\"\n");
    for (from, to, said) in [
        ("u_z[mm]", "quality", "expected a column u_z[mm]"),
        ("0.00001\n", "0\n", "the u_z of measured point 1 is 0 mm, expected a number above 0"),
        ("0.00001\n", "inf\n", "the u_z of measured point 1 is NaN mm"),
    ] {
        let output = measure(folder.path(), &nominal, &points(50).replacen(from, to, 1));
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains(said), "{told}");
    }
}

#[test]
fn a_nominal_file_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("part.toml");
    fs::write(&file, SPHERE).unwrap();
    let output = run(["nominal", file.to_str().unwrap(), "--sag", "0,18"]);
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(told.contains("nominal    sphere") && told.contains("6.000000000"), "{told}");
    fs::write(&file, SPHERE.replace("radius_mm", "radius")).unwrap();
    let output = run(["nominal", file.to_str().unwrap()]);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(told.contains("part.toml:3: surface.radius"), "{told}");
}

//! Profiles from files: two columns of heights or slopes, judged along their line.

use std::path::{Path, PathBuf};

use asphera_tests::{data, json, number, run};
use serde_json::Value;

fn measured(file: &Path, nominal: &str, more: &[&str]) -> (Option<i32>, Value) {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("nominal.toml");
    std::fs::write(&path, nominal).unwrap();
    let mut arguments =
        vec!["measure", file.to_str().unwrap(), "--nominal", path.to_str().unwrap(), "--json"];
    arguments.extend(more);
    let output = run(&arguments);
    (output.status.code(), json(&output))
}

fn near(report: &Value, place: &str, expected: f64, relative: f64) {
    let found = number(report, place);
    assert!((found / expected - 1.0).abs() < relative, "{place}: {found}, expected {expected}");
}

const CIRCLE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = RADIUS\n[fit]\nfree = [\"tx\", \"tz\", \"radius\"]\n[tolerance]\n";
const LINE: &str = "[surface]\nkind = \"plane\"\n[fit]\nfree = [\"tz\", \"ry\"]\n[tolerance]\n";

fn dabam(number: u32) -> Option<PathBuf> {
    data(&format!("mirrors/dabam/dabam-{number:03}.dat"))
}

/// Heights in nm against mm. NumPy and SciPy's `least_squares` of orthogonal distances from a circle: R 83.1817089 m, RMS
/// 15.3411677 nm, PV 62.6070799 nm, slopes by `numpy.diff` 1.0960077 µrad. Published with the file: RMS 15.372782 nm.
#[test]
fn heights_of_a_spherical_mirror() {
    let Some(file) = dabam(14) else { return };
    let circle = CIRCLE.replace("RADIUS", "83000");
    let more = ["--skip-lines", "1", "--columns", "1,2", "--unit", "mm,nm"];
    let (code, report) = measured(&file, &format!("{circle}pv_nm = 80\nrms_nm = 20\n"), &more);
    assert_eq!(
        (code, &report["verdict"]["status"]),
        (Some(0), &Value::from("pass")),
        "{:#}",
        report["verdict"]
    );
    near(&report, "/form/deviation/rms_nm", 15.341_167_7, 1e-6);
    near(&report, "/form/deviation/rms_nm", 15.372_782, 0.003);
    near(&report, "/form/deviation/pv_nm", 62.607_079_9, 1e-6);
    near(&report, "/form/fit/parameters/radius/value", 83_181.708_9, 1e-6);
    near(&report, "/profile/slope_rms_urad", 1.096_007_7, 1e-6);
    // 1.4826 times the median of `numpy.abs(numpy.diff(z, 3))` over the root of 20.
    near(&report, "/profile/noise_sigma_nm", 0.066_304, 1e-3);
    near(&report, "/profile/slope_noise_urad", 0.093_768, 1e-3);
    near(&report, "/sampling/coverage", 1.0, 1e-9);
    let (code, report) = measured(&file, &format!("{circle}rms_nm = 15\n"), &more);
    assert_eq!((code, &report["verdict"]["status"]), (Some(10), &Value::from("fail")));
}

/// Slopes in µrad against mm. The file's own second line says, of the best circle: RMS 10.854 nm, PV of shape error 52.842 nm, of
/// slopes 0.437 µrad RMS. NumPy: RMS 10.8527472, PV 52.6093095 nm; slopes less those of the best line in heights
/// 0.436767643 µrad about their mean.
#[test]
fn slopes_of_a_spherical_mirror() {
    let Some(file) = dabam(41) else { return };
    let more = ["--skip-lines", "4", "--columns", "1,2", "--unit", "mm,urad"];
    let circle = CIRCLE.replace("RADIUS", "3e9");
    let (code, report) = measured(&file, &format!("{circle}pv_nm = 60\nrms_nm = 12\n"), &more);
    assert_eq!(code, Some(0), "{:#}", report["verdict"]);
    near(&report, "/form/deviation/rms_nm", 10.852_747_2, 1e-5);
    near(&report, "/form/deviation/rms_nm", 10.854, 5e-4);
    near(&report, "/form/deviation/pv_nm", 52.609_309_5, 1e-5);
    near(&report, "/form/deviation/pv_nm", 52.842, 0.005);
    near(&report, "/profile/slope_rms_about_mean_urad", 0.441_631_089, 1e-5);
    let (_, report) = measured(&file, &format!("{LINE}pv_nm = 60\n"), &more);
    near(&report, "/form/deviation/rms_nm", 12.360_124_6, 1e-6);
    near(&report, "/profile/slope_rms_about_mean_urad", 0.436_767_643, 1e-6);
    near(&report, "/profile/slope_rms_about_mean_urad", 0.437, 1e-3);
    assert!(report["profile"]["source"].as_str().unwrap().contains("trapezoidal"));
}

/// A head of its own: `x(mm)  Slope (urad)` below three lines of text. NumPy: RMS 2955.80936 nm of the best line.
#[test]
fn slopes_with_a_head() {
    let Some(file) = dabam(1) else { return };
    let (code, report) = measured(&file, &format!("{LINE}rms_nm = 3000\n"), &["--skip-lines", "3"]);
    assert_eq!(code, Some(0), "{:#}", report["verdict"]);
    near(&report, "/form/deviation/rms_nm", 2_955.809_36, 1e-7);
    near(&report, "/form/deviation/pv_nm", 9_922.711_07, 1e-7);
    near(&report, "/profile/slope_rms_urad", 18.938_762_1, 1e-6);
    assert_eq!(report["reading"]["columns"][1]["unit"], "urad");
}

#[test]
fn a_profile_has_a_report_on_paper() {
    let Some(file) = dabam(14) else { return };
    let dir = tempfile::tempdir().unwrap();
    let [nominal, out, qif] = ["n.toml", "out.html", "out.xml"].map(|name| dir.path().join(name));
    std::fs::write(&nominal, format!("{}pv_nm = 80\n", CIRCLE.replace("RADIUS", "83000"))).unwrap();
    let words = |path: &Path| path.to_str().unwrap().to_owned();
    let output = run([
        "report",
        &words(&file),
        "--nominal",
        &words(&nominal),
        "-o",
        &words(&out),
        "--qif",
        &words(&qif),
        "--skip-lines",
        "1",
        "--columns",
        "1,2",
        "--unit",
        "mm,nm",
    ]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.contains("profile    of heights") && text.contains("slope RMS 1.096 µrad"),
        "{text}"
    );
    assert!(std::fs::read_to_string(&out).unwrap().contains("62.6"));
}

//! A dense cloud is reduced to points that were measured, and what happened is told.

use std::path::{Path, PathBuf};
use std::process::Output;

use asphera_tests::{count, json, number, run};

/// A cap of a sphere of radius 20 mm with deterministic noise of 30 nm, 150 × 150 points over 3 mm.
fn cap(folder: &Path) -> PathBuf {
    cap_with(folder, 30e-6, 0)
}

/// The same with noise of `sigma_mm`, every twentieth of the points off by 40 of it if `outliers` is 20.
fn cap_with(folder: &Path, sigma_mm: f64, outliers: usize) -> PathBuf {
    let mut text = String::from("# a cap\n");
    let mut state = 7_u64;
    let mut unit = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    for row in 0..150 {
        for column in 0..150 {
            let [x, y] = [column, row].map(|index| 0.02 * (f64::from(index) - 74.5));
            // Twelve uniform numbers less six are nearly normal.
            let noise = (0..12).map(|_| unit()).sum::<f64>() - 6.0;
            let mut z = 20.0 - (400.0 - x * x - y * y).sqrt() + sigma_mm * noise;
            if outliers > 0 && unit() * (outliers as f64) < 1.0 {
                z += if unit() < 0.5 { 40.0 } else { -40.0 } * sigma_mm;
            }
            text.push_str(&format!("{x} {y} {z}\n"));
        }
    }
    let path = folder.join("cap.xyz");
    std::fs::write(&path, text).unwrap();
    path
}

fn reduce(file: &Path, out: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["reduce", file.to_str().unwrap(), "-o", out.to_str().unwrap()];
    arguments.extend(more);
    run(&arguments)
}

fn complaint(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// The lines of a file of points, without comments and names.
fn lines(path: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    let is_point = |line: &&str| !line.starts_with(['#', 'x']);
    text.lines().filter(is_point).map(str::to_owned).collect()
}

#[test]
fn what_is_kept_was_measured_and_passes() {
    let dir = tempfile::tempdir().unwrap();
    let (file, out) = (cap(dir.path()), dir.path().join("reduced.xyz"));
    let output = reduce(&file, &out, &["--epsilon", "0.01", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let report = json(&output);
    let kept = lines(&out);
    assert_eq!(kept.len() as u64, count(&report, "/kept"));
    assert_eq!(count(&report, "/kept") + count(&report, "/dropped"), 22_500);
    assert!(kept.len() < 2_000, "{}", kept.len());
    let mut measured = lines(&file).into_iter();
    assert!(kept.iter().all(|line| measured.any(|other| other == *line)), "a point was moved");
    assert!((number(&report, "/noise/sigma_nm") / 30.0 - 1.0).abs() < 0.03);
    assert!((number(&report, "/lfs/range_mm/min_mm") / 20.0 - 1.0).abs() < 0.6);
    // Noise tilts facets of 20 µm by 3 mrad: 10 are allowed.
    assert_eq!(number(&report, "/before/overdense_fraction"), 0.0);
    assert!((number(&report, "/before/tilt_median_rad") / 3e-3 - 1.0).abs() < 0.05);
    assert_eq!(number(&report, "/after/overdense_fraction"), 0.0);
    assert!(number(&report, "/after/epsilon_max") <= 0.01);
    assert!(count(&report, "/mended") <= count(&report, "/kept"));
    let shrunk = number(&report, "/after/area_mm2") / number(&report, "/before/area_mm2");
    assert!((0.99..=1.0).contains(&shrunk), "{shrunk}");

    // The result can be read again, with the nominal and averaged as well.
    let nominal = dir.path().join("sphere.toml");
    std::fs::write(&nominal, "[surface]\nkind = \"sphere\"\nradius_mm = 20\n").unwrap();
    let again = dir.path().join("averaged.csv");
    let wanted =
        ["--epsilon", "0.02", "--nominal", nominal.to_str().unwrap(), "--average", "--json"];
    let report = json(&reduce(&file, &again, &wanted));
    assert!((number(&report, "/lfs/range_mm/max_mm") / 20.0 - 1.0).abs() < 0.01);
    assert!(count(&report, "/averaged") > 0);
    assert!(lines(&again).iter().all(|line| line.split(',').count() == 4));
    let report = json(&reduce(
        &again,
        &out,
        &[
            "--epsilon",
            "0.5",
            "--noise",
            "0",
            "--force",
            "--json",
            "--nominal",
            nominal.to_str().unwrap(),
        ],
    ));
    assert_eq!(count(&report, "/input/points"), lines(&again).len() as u64);
}

/// Points too dense for the noise, which is taken from them although a twentieth of them are wrong.
#[test]
fn points_too_dense_for_their_noise_are_thinned_as_asked() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("reduced.xyz");
    for outliers in [0, 20] {
        // 1 µm over 20 µm tilts facets by 0.1 rad; 0.05 are allowed.
        let file = cap_with(dir.path(), 1e-3, outliers);
        let mut kept_before = 0;
        for keep in ["fewest", "truest", "most"] {
            let wanted = ["--epsilon", "0.05", "--keep", keep, "--force", "--json"];
            let report = json(&reduce(&file, &out, &wanted));
            let sigma_nm = number(&report, "/noise/sigma_nm");
            assert!((sigma_nm / 1e3 - 1.0).abs() < 0.08, "{outliers}: {sigma_nm}");
            let share = number(&report, "/noise/outlier_share");
            assert!((share - if outliers > 0 { 0.05 } else { 0.0 }).abs() < 0.01, "{share}");
            // Wrong readings make facets so steep that noise along z hardly turns them.
            let least = if outliers > 0 { 0.2 } else { 0.95 };
            assert!(number(&report, "/before/overdense_fraction") > least, "{outliers}");
            assert_eq!(number(&report, "/after/overdense_fraction"), 0.0, "{outliers} {keep}");
            assert!(number(&report, "/after/epsilon_max") <= 0.05, "{outliers} {keep}");
            let kept = count(&report, "/kept");
            assert!(kept > kept_before && kept < 12_000, "{outliers} {keep}: {kept}");
            kept_before = kept;
        }
        // With a wider limit nothing is too dense: all may stay.
        let wanted = ["--epsilon", "0.05", "--tilt", "0.5", "--keep", "most", "--force", "--json"];
        let report = json(&reduce(&file, &out, &wanted));
        assert_eq!(number(&report, "/before/overdense_fraction"), 0.0);
        assert_eq!(count(&report, "/kept"), 22_500);
    }
    let refused = complaint(&reduce(
        &dir.path().join("cap.xyz"),
        &out,
        &["--epsilon", "0.05", "--tilt", "2"],
    ));
    assert!(refused.contains("tilt is 2 rad"), "{refused}");
}

/// A share of the reach is one spacing everywhere; of two limits the smaller counts.
#[test]
fn a_share_of_the_reach_thins_all_alike() {
    let dir = tempfile::tempdir().unwrap();
    let (file, out) = (cap(dir.path()), dir.path().join("reduced.xyz"));
    let nominal = dir.path().join("paraboloid.toml");
    // Its smaller radius of curvature is 2.5 mm at the vertex, 3.3 mm at the corners of the cap.
    let paraboloid = "[surface]\nkind = \"asphere\"\nradius_mm = 2.5\nconic = -1\n";
    std::fs::write(&nominal, paraboloid).unwrap();
    let text: String = lines(&file)
        .iter()
        .map(|line| {
            let at: Vec<f64> = line.split(' ').map(|word| word.parse().unwrap()).collect();
            let flat = at[2] - 20.0 + (400.0 - at[0] * at[0] - at[1] * at[1]).sqrt();
            let z = (at[0] * at[0] + at[1] * at[1]) / 5.0 + flat;
            format!("{} {} {z}\n", at[0], at[1])
        })
        .collect();
    std::fs::write(&file, text).unwrap();
    let reduced = |limits: &[&str]| {
        let common = ["--nominal", nominal.to_str().unwrap(), "--noise", "0", "--force", "--json"];
        json(&reduce(&file, &out, &[limits, &common].concat()))
    };
    let by_rho = reduced(&["--rho", "0.05"]);
    assert!(by_rho["epsilon"].is_null() && number(&by_rho, "/rho") == 0.05);
    assert!((number(&by_rho, "/lfs/range_mm/min_mm") / 2.5 - 1.0).abs() < 0.01, "{by_rho:#}");
    assert!(number(&by_rho, "/after/rho_max") <= 0.05, "{by_rho:#}");
    assert_eq!(number(&by_rho, "/after/over_epsilon_area_mm2"), 0.0);
    assert!(std::fs::read_to_string(&out).unwrap().contains("rho 0.05 of the reach"));
    let by_epsilon = reduced(&["--epsilon", "0.05"]);
    assert!(number(&by_epsilon, "/after/epsilon_max") <= 0.05, "{by_epsilon:#}");
    assert!(number(&by_epsilon, "/after/rho_max") > 0.05, "{by_epsilon:#}");
    let kept = |report: &serde_json::Value| count(report, "/kept");
    assert!(kept(&by_epsilon) < kept(&by_rho), "{} {}", kept(&by_epsilon), kept(&by_rho));
    // The other limit changes nothing where it is looser everywhere.
    assert_eq!(kept(&reduced(&["--rho", "0.05", "--epsilon", "0.05"])), kept(&by_rho));
    assert_eq!(kept(&reduced(&["--rho", "0.9", "--epsilon", "0.05"])), kept(&by_epsilon));
    // Where it is the smaller in places, more are kept than for either alone.
    let both = reduced(&["--rho", "0.055", "--epsilon", "0.05"]);
    assert!(number(&both, "/after/rho_max") <= 0.055, "{both:#}");
    assert!(kept(&both) > kept(&by_epsilon) && kept(&both) < kept(&by_rho), "{both:#}");

    for rho in ["0", "-0.1", "2", "NaN"] {
        let text = complaint(&reduce(&file, &out, &[&format!("--rho={rho}"), "--force"]));
        assert!(text.contains("rho is") && text.contains("up to 1"), "{text}");
    }
    assert_eq!(reduce(&file, &out, &["--force"]).status.code(), Some(2));
}

#[test]
fn what_cannot_be_done_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let (file, out) = (cap(dir.path()), dir.path().join("reduced.xyz"));
    for epsilon in ["0", "-0.1", "2", "NaN"] {
        let text = complaint(&reduce(&file, &out, &[&format!("--epsilon={epsilon}")]));
        assert!(text.contains("epsilon") && text.contains("up to 1"), "{text}");
    }
    let odd = dir.path().join("reduced.stl");
    assert!(complaint(&reduce(&file, &odd, &["--epsilon", "0.1"])).contains(".xyz"));
    let nowhere = dir.path().join("no/folder/reduced.xyz");
    assert!(complaint(&reduce(&file, &nowhere, &["--epsilon", "0.1"])).contains("cannot write"));
    std::fs::write(&out, "mine").unwrap();
    assert!(complaint(&reduce(&file, &out, &["--epsilon", "0.1"])).contains("--force"));
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "mine");
    let itself = complaint(&reduce(&file, &file, &["--epsilon", "0.1", "--force"]));
    assert!(itself.contains("expected another"), "{itself}");
    for (content, expected) in [
        ("", "at least one line"),
        ("1 2 3\n", "span an area"),
        ("0 0 0\n0.5 1 1\n1 2 2\n", "span an area"),
        ("0 0 0\n1 0 0\n0 1 0\n", "--noise"),
    ] {
        let few = dir.path().join("few.xyz");
        std::fs::write(&few, content).unwrap();
        let text = complaint(&reduce(&few, &out, &["--epsilon", "0.1", "--force"]));
        assert!(text.contains(expected), "{text}");
    }
    assert_eq!(reduce(&file, &out, &["--epsilon", "0.1", "--noise", "-3"]).status.code(), Some(2));
}

//! How densely the points of a file sample their surface, and what to measure next.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Output;

use asphera_tests::{json, number, run};
use serde_json::Value;

use crate::random::Random;

const RADIUS_MM: f64 = 25.0;

const NOMINAL: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 25\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 4\n\
    [sampling]\ngap_limit_mm = 0.05\n";

/// A cap of a sphere, 201 × 201 points every 0.05 mm, as far as they are kept, with some 20 nm of noise.
fn cap(folder: &Path, keep: impl Fn(i32, i32) -> bool) -> PathBuf {
    let mut text = String::from("# a cap\n");
    let mut random = Random(11);
    for row in -100..=100 {
        for column in -100..=100 {
            let noise = random.normal();
            if keep(column, row) {
                let [x, y] = [column, row].map(|index| 0.05 * f64::from(index));
                let z = RADIUS_MM - (RADIUS_MM * RADIUS_MM - x * x - y * y).sqrt();
                writeln!(text, "{x} {y} {}", z + 20e-6 * noise).unwrap();
            }
        }
    }
    let path = folder.join("cap.xyz");
    std::fs::write(&path, text).unwrap();
    path
}

fn sampling(file: &Path, more: &[&str]) -> Output {
    let mut arguments = vec!["sampling", file.to_str().unwrap()];
    arguments.extend(more);
    run(&arguments)
}

fn figures(file: &Path, more: &[&str]) -> Value {
    let output = sampling(file, &[more, &["--json"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    json(&output)
}

fn nominal(folder: &Path) -> String {
    let path = folder.join("nominal.toml");
    std::fs::write(&path, NOMINAL).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn the_names_are_those_that_were_promised() {
    let dir = tempfile::tempdir().unwrap();
    let file = cap(dir.path(), |i, j| !(20..30).contains(&i) || !(10..40).contains(&j));
    let found = figures(&file, &["--nominal", &nominal(dir.path())]);
    let names: Vec<&str> = found.as_object().unwrap().keys().map(String::as_str).collect();
    let mut expected = [
        "lfs_min_mm",
        "lfs_source",
        "gap_max_mm",
        "gap_p99_mm",
        "gap_limit_mm",
        "epsilon_target",
        "epsilon_max",
        "epsilon_p99",
        "rho_target",
        "rho_max",
        "reach_mm",
        "at_max_mm",
        "coverage",
        "undersampled_area_mm2",
        "uncovered_area_mm2",
        "noise_sigma_nm",
        "noise_u_nm",
        "spacing_median_mm",
        "overdense_fraction",
        "spacing_coarsest_mm",
        "spacing_finest_mm",
        "spacing_recommended_mm",
        "next",
        "next_more",
        "next_more_area_mm2",
        "islands",
        "holes",
        "hole_max_mm2",
        "unknown",
        "as_of_points",
        "defects",
        "defects_more",
        "defects_search",
        "partition",
    ];
    expected.sort_unstable();
    let mut names = names;
    names.sort_unstable();
    assert_eq!(names, expected);
    let next = found["next"][0].as_object().unwrap();
    for name in [
        "area_mm2",
        "undersampled_mm2",
        "uncovered_mm2",
        "adds_coverage",
        "epsilon_max",
        "gap_max_mm",
        "spacing_needed_mm",
        "points_needed",
        "at_mm",
        "polygons",
        "simplified_mm",
    ] {
        assert!(next.contains_key(name), "{name}: {next:?}");
    }
    // Missing are 10 × 30 points: the region reaches to those about them.
    let expected_mm2 = 11.0 * 31.0 * 0.05 * 0.05;
    assert!((number(&found, "/next/0/area_mm2") / expected_mm2 - 1.0).abs() < 0.02);
    assert!((number(&found, "/lfs_min_mm") / RADIUS_MM - 1.0).abs() < 5e-3);
    assert!((number(&found, "/noise_sigma_nm") / 20.0 - 1.0).abs() < 0.1);
    assert!((number(&found, "/spacing_median_mm") / 0.05 - 1.0).abs() < 0.02);
    assert_eq!((&found["islands"], &found["holes"]), (&1.into(), &1.into()));
}

#[test]
fn a_stripe_at_a_tenth_of_the_density_comes_first() {
    let dir = tempfile::tempdir().unwrap();
    // From column -40 to 0 every third column and row is measured: a ninth of the points.
    let coarse = |i: i32| (-39..0).contains(&i);
    let file = cap(dir.path(), |i, j| !coarse(i) || ((i + 40) % 3 == 0 && j % 3 == 0));
    let found = figures(&file, &["--nominal", &nominal(dir.path())]);
    // The stripe from x = -2 mm to 0 in the disc of radius 4 mm. Where it ends lies between columns of both
    // kinds: the region reaches to the dense ones.
    let segment = |x: f64| x * (16.0 - x * x).sqrt() + 16.0 * (x / 4.0).asin();
    let expected_mm2 = segment(2.0);
    let first_mm2 = number(&found, "/next/0/area_mm2");
    assert!((first_mm2 / expected_mm2 - 1.0).abs() < 0.02, "{first_mm2}, not {expected_mm2}");
    // A limit of 0.05 mm is met within quarters of discs about points 0.15 mm apart, and in the rows beside the dense ones.
    let under_mm2 = number(&found, "/next/0/undersampled_mm2");
    let beyond = 1.0 - std::f64::consts::PI * (0.05_f64 / 0.15).powi(2);
    let share = under_mm2 / first_mm2;
    assert!((0.96 * beyond..beyond).contains(&share), "{share}, at most {beyond}");
    let disc_mm2 = 16.0 * std::f64::consts::PI;
    assert!((number(&found, "/coverage") + under_mm2 / disc_mm2 - 1.0).abs() < 1e-3);
    // The outline of a polygon in the report encloses as much.
    let outline: Vec<[f64; 2]> = found["next"][0]["polygons"][0]["outline_mm"]
        .as_array()
        .unwrap()
        .iter()
        .map(|place| [0, 1].map(|axis| place[axis].as_f64().unwrap()))
        .collect();
    let pairs = outline.iter().zip(outline.iter().cycle().skip(1));
    let drawn_mm2 = 0.5 * pairs.map(|(p, q)| p[0] * q[1] - p[1] * q[0]).sum::<f64>();
    assert!((drawn_mm2 / first_mm2 - 1.0).abs() < 0.02, "{drawn_mm2}, not {first_mm2}");
}

#[test]
fn a_wedge_that_was_not_measured_comes_first() {
    let dir = tempfile::tempdir().unwrap();
    // A sixth of the turn, from 0° to 60°.
    let file = cap(dir.path(), |i, j| {
        let angle = f64::from(j).atan2(f64::from(i)).to_degrees();
        !(0.0..60.0).contains(&angle)
    });
    let found = figures(&file, &["--nominal", &nominal(dir.path())]);
    let expected_mm2 = 16.0 * std::f64::consts::PI / 6.0;
    let first_mm2 = number(&found, "/next/0/area_mm2");
    // The region reaches to the outermost points about it, half a spacing farther on each side.
    assert!((first_mm2 - expected_mm2).abs() < 8.0 * 0.05, "{first_mm2}, not {expected_mm2}");
    assert!(number(&found, "/next/0/uncovered_mm2") > 0.9 * first_mm2);
}

#[test]
fn threads_do_not_show() {
    let dir = tempfile::tempdir().unwrap();
    let file = cap(dir.path(), |i, j| (i * i + j * j) % 97 > 3 && (i - 30).pow(2) + j * j > 150);
    let nominal = nominal(dir.path());
    for more in [&["--nominal", &nominal][..], &[]] {
        let with = |threads: &str| {
            sampling(&file, &[more, &["--json", "--threads", threads]].concat()).stdout
        };
        let one = with("1");
        assert!(one.len() > 1000);
        assert!(one == with("2") && one == with("5"), "the threads changed the result");
    }
}

#[test]
fn without_a_nominal_the_points_tell_the_feature_size() {
    let dir = tempfile::tempdir().unwrap();
    let file = cap(dir.path(), |_, _| true);
    let found = figures(&file, &[]);
    assert_eq!(found["lfs_source"], "measured", "{found:#}");
    assert!((number(&found, "/lfs_min_mm") / RADIUS_MM - 1.0).abs() < 0.15, "{found:#}");
    assert_eq!(number(&found, "/coverage"), 1.0);
    // Squares of a spacing of 0.02 mm have gaps of 0.0141 mm.
    let tight = figures(&file, &["--spacing", "0.02"]);
    let discs = 0.5 * std::f64::consts::PI * (0.02_f64 / 0.05).powi(2);
    let share = number(&tight, "/coverage") / discs;
    assert!((0.97..1.001).contains(&share), "{share}");
}

#[test]
fn places_to_measure_are_written() {
    let dir = tempfile::tempdir().unwrap();
    let file = cap(dir.path(), |i, j| (i - 30).pow(2) + j * j > 150);
    let out = dir.path().join("next.csv");
    let nominal = nominal(dir.path());
    let arguments = ["--nominal", &nominal, "--waypoints", out.to_str().unwrap()];
    let output = sampling(&file, &arguments);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(0), "{text}");
    for part in ["sampled densely enough", "largest gap", "noise", "To measure next:", "waypoints"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let written = std::fs::read_to_string(&out).unwrap();
    let mut lines = written.lines();
    assert_eq!(lines.next(), Some("region,x_mm,y_mm,z_mm"));
    let mut places = 0;
    for line in lines {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let [1.0, x, y, z] = numbers[..] else { panic!("{line}") };
        assert!((x - 1.5).hypot(y) < 0.7, "{line}");
        let sphere = RADIUS_MM - (RADIUS_MM * RADIUS_MM - x * x - y * y).sqrt();
        assert!((z - sphere).abs() < 1e-4, "{line}");
        places += 1;
    }
    assert!(places > 50, "{written}");
    let again = sampling(&file, &arguments);
    assert_eq!(again.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&again.stderr).contains("--force"));
}

#[test]
fn what_cannot_be_known_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let few = dir.path().join("few.xyz");
    let of_nominal = nominal(dir.path());
    let with = ["--json", "--nominal", of_nominal.as_str()];
    let (alone, with) = (&with[..1], &with[..]);
    // Points on a line have a coverage along it where there is a nominal.
    for (content, all) in [
        ("1 2 3\n", vec![alone, with]),
        ("0 0 0\n0.5 1 1\n1 2 2\n1.5 3 3\n", vec![alone]),
        ("1 2 3\n1 2 3\n1 2 3\n", vec![alone, with]),
    ] {
        std::fs::write(&few, content).unwrap();
        for more in all {
            let output = sampling(&few, more);
            assert_eq!(
                output.status.code(),
                Some(11),
                "{}",
                String::from_utf8_lossy(&output.stderr)
            );
            let found = json(&output);
            assert!(found["unknown"].to_string().contains("span no area"), "{found:#}");
            for name in ["coverage", "gap_max_mm", "epsilon_max", "noise_sigma_nm", "islands"] {
                assert!(found[name].is_null(), "{name}: {found:#}");
            }
        }
    }
    std::fs::write(&few, "").unwrap();
    assert_eq!(sampling(&few, &[]).status.code(), Some(1));
    for (option, value) in
        [("--epsilon", "0"), ("--epsilon", "-0.1"), ("--epsilon", "NaN"), ("--spacing", "0")]
            .into_iter()
            .chain(["0", "-0.1", "1.5", "NaN", "inf"].map(|rho| ("--rho", rho)))
    {
        let output = sampling(&few, &[&format!("{option}={value}")]);
        assert_eq!(output.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&output.stderr).contains("expected"));
    }
}

/// A target in ρ, asked for on the command line, by a nominal file, and beside one of ε.
#[test]
fn a_target_in_rho_is_a_share_of_the_reach() {
    let dir = tempfile::tempdir().unwrap();
    let (file, nominal) = (cap(dir.path(), |_, _| true), nominal(dir.path()));
    // The gaps of the raster are 0.035 mm at most, and a little more on the slope: 0.0014 of the radius. A limit of 0.02 mm is
    // met within quarters of discs about the points.
    let discs = std::f64::consts::PI * 0.16;
    for (more, coverage) in [
        (&["--rho", "0.0016", "--nominal", &nominal][..], 1.0),
        (&["--rho", "0.0008", "--nominal", &nominal], discs),
        (&["--rho", "0.0016", "--epsilon", "0.0008", "--nominal", &nominal], discs),
        (&["--rho", "0.0008", "--epsilon", "0.9", "--nominal", &nominal], discs),
        (&["--rho", "0.01"], 1.0),
    ] {
        let found = figures(&file, more);
        let share = number(&found, "/coverage") / coverage;
        assert!((0.98..1.001).contains(&share), "{more:?}: {found:#}");
        let told = more.iter().position(|word| *word == "--rho").map(|at| more[at + 1]);
        assert_eq!(found["rho_target"].to_string(), told.unwrap());
        assert_eq!(found["epsilon_target"].is_null(), !more.contains(&"--epsilon"));
        let ratio = number(&found, "/gap_max_mm") / number(&found, "/reach_mm");
        assert!((number(&found, "/rho_max") / ratio - 1.0).abs() < 1e-12, "{found:#}");
        if more.contains(&"--nominal") {
            assert!((number(&found, "/reach_mm") / RADIUS_MM - 1.0).abs() < 5e-3, "{found:#}");
        }
    }
    let needed = figures(&file, &["--rho", "0.0008", "--nominal", &nominal]);
    let spacing_mm = 2.0_f64.sqrt() * 0.0008 * number(&needed, "/reach_mm");
    assert!((number(&needed, "/next/0/spacing_needed_mm") / spacing_mm - 1.0).abs() < 1e-9);

    let file_of_nominal = dir.path().join("rho.toml");
    std::fs::write(&file_of_nominal, format!("{NOMINAL}rho_limit = 0.0008\n")).unwrap();
    let asked = figures(&file, &["--nominal", file_of_nominal.to_str().unwrap()]);
    assert_eq!(asked["next"], needed["next"]);
    let output = sampling(&file, &["--nominal", file_of_nominal.to_str().unwrap()]);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let told = "largest ρ 0.001424 of 0.0008000 allowed, reach 25.00 mm";
    assert!(text.contains(told), "{text}");
}

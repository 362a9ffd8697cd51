//! Commands without a report say on stderr how they read their points: columns, units, and what they left out.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use asphera_tests::{asphera, json, number, run};

/// Points of a ring of 10 mm, in two rows of height 0 and 2.
fn ring(folder: &Path) -> PathBuf {
    let mut text = String::new();
    for index in 0..400 {
        let (sin, cos) = (f64::from(index / 2) / 200.0 * TAU).sin_cos();
        writeln!(text, "{} {} {}", 10.0 * cos, 10.0 * sin, 2 * (index % 2)).unwrap();
    }
    text.push_str("NaN NaN NaN\n");
    let path = folder.join("ring.xyz");
    std::fs::write(&path, text).unwrap();
    path
}

fn told(output: &Output) -> String {
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[test]
fn units_that_were_assumed_and_points_that_were_left_out_are_said_by_every_command() {
    let folder = tempfile::tempdir().unwrap();
    let ring = ring(folder.path());
    let ring = ring.to_str().unwrap();
    for words in [
        &["contour", ring][..],
        &["contour", ring, "--json"],
        &["contour", ring, "--plane", "0,0,1,0", "--within", "0.5", "--json"],
        &["compare", ring, ring],
        &["compare", "--shapes", ring, ring],
        &["reconstruct", ring],
        &["reconstruct", ring, "--json"],
        &["graph", ring, "--json"],
        &["parts", ring],
        &["parts", ring, "--json"],
    ] {
        let said = told(&run(words));
        assert!(said.contains("mm is assumed: the file states no unit"), "{words:?}: {said}");
        assert!(said.contains("1 places without a height, left out"), "{words:?}: {said}");
    }
    let circle = folder.path().join("circle.xy");
    let text = (0..40).map(|index| {
        let (sin, cos) = (f64::from(index) / 40.0 * TAU).sin_cos();
        format!("{cos} {sin}\n")
    });
    std::fs::write(&circle, text.collect::<String>()).unwrap();
    let said = told(&run(["contour", circle.to_str().unwrap()]));
    assert!(said.contains("x in column 1 in mm, y in column 2 in mm (mm is assumed"), "{said}");
    let said = told(&run(["contour", ring, "--unit", "um"]));
    assert!(said.contains("x in column 1 in um") && !said.contains("assumed"), "{said}");
}

#[test]
fn a_contour_says_which_heights_it_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let ring = ring(folder.path());
    let ring = ring.to_str().unwrap();
    for words in [&["contour", ring][..], &["compare", ring, ring]] {
        let said = told(&run(words));
        assert!(said.contains("heights    0 to 2.000 mm of "), "{words:?}: {said}");
        assert!(said.contains("--plane A,B,C,D --within MM"), "{words:?}: {said}");
    }
    let cut = run(["contour", ring, "--plane", "0,0,1,0", "--within", "0.5", "--json"]);
    assert!(!told(&cut).contains("left out; a body"), "{cut:?}");
    assert_eq!(number(&json(&cut), "/input/points"), 200.0);
}

#[test]
fn points_that_come_through_a_pipe_are_measured() {
    let folder = tempfile::tempdir().unwrap();
    let nominal = folder.path().join("plane.toml");
    std::fs::write(&nominal, "[surface]\nkind = \"plane\"\n").unwrap();
    let points: String =
        (0..900).map(|index| format!("{} {} 0\n", index % 30, index / 30)).collect();
    let mut child = Command::new(asphera())
        .args(["measure", "/dev/stdin", "--json", "--nominal"])
        .arg(&nominal)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    // The end of the pipe is the end of the points.
    std::io::Write::write_all(&mut child.stdin.take().unwrap(), points.as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(number(&json(&output), "/points/received"), 900.0, "{output:?}");
}

#[test]
fn a_negative_number_is_the_value_of_its_option() {
    let folder = tempfile::tempdir().unwrap();
    let ring = ring(folder.path());
    let ring = ring.to_str().unwrap();
    for (words, expected) in [
        (&["contour", ring, "--gaps", "-1"][..], "expected more than 0 mm"),
        (&["parts", ring, "--within", "-1", "--library", "."], "expected auto or a length"),
        (&["graph", ring, "--min-loop", "-1"], "expected 0 or a length"),
        (&["plan", ring, "--dwell", "-1", "-o", "p.csv"], "found `-1`"),
        (&["contour", ring, "--gaps", "x"], "'x' for '--gaps <MM>': expected a number"),
        (&["graph", ring, "--halvings", "x"], "'x' for '--halvings <N>': expected a whole number"),
    ] {
        let output = run(words);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(expected) && !said.contains("-- -1"), "{words:?}: {said}");
    }
}

//! Two CANopen drives that the station homes and moves over slcan, and a gauge over the part on them.

use std::time::Duration;

use asphera_rig::DriveFault;
use asphera_tests::{count, json, json_file, number, run};

use crate::closed_loop::{Bench, flat_pv_nm};

/// Bench and station of the example, on free ports, with some text replaced.
fn bench(changes: &[(&str, &str)]) -> Bench {
    Bench::of("drives", "drives", ["127.0.0.1:7741", "127.0.0.1:7742"], changes)
}

/// Runs the station, armed, until its scan says these words.
fn run_until(bench: &Bench, words: &str) {
    bench.run(&["--arm"]).until(words, |snapshot| snapshot["scan"].to_string().contains(words));
}

#[test]
fn drives_find_home_and_are_driven_over_the_plan() {
    let bench = bench(&[]);
    let drives = bench.rig.drives().unwrap();
    // They were switched on in the middle of their travel, and count from there.
    assert_eq!(drives.places(), [150_000.0, 200_000.0]);
    let output = bench.run(&["--once", "--arm"]).running.wait(Duration::from_secs(200));
    let words = String::from_utf8_lossy(&output.stderr);
    let session = bench.session();
    let report = json_file(&session.join("report.json"));
    assert_eq!(report["session"]["ended"], "complete", "{words}");
    assert_eq!(report["verdict"]["status"], "pass", "{:#}", report["verdict"]);
    assert_eq!(output.status.code(), Some(0), "{words}");
    assert!(number(&report, "/sampling/coverage") >= 0.99, "{:#}", report["sampling"]);
    // The form of the part where homed axes say that it lies; 5 nm of noise.
    let mut heights = Vec::new();
    for k in 0..=40 {
        for l in 0..=30 {
            let place = [-4.0 + 0.2 * f64::from(k), -3.0 + 0.2 * f64::from(l)];
            heights.push((place, bench.rig.height_mm(place).unwrap() * 1e6));
        }
    }
    let (pv_nm, found_nm) = (flat_pv_nm(&heights), number(&report, "/form/deviation/pv_nm"));
    assert!(pv_nm > 150.0, "{pv_nm} nm");
    assert!((found_nm - pv_nm).abs() < 30.0, "{found_nm} nm found, {pv_nm} nm are there");
    assert!(count(&report, "/points/used") > 100, "{:#}", report["points"]);
    let moves = drives.moves();
    assert!(moves.iter().all(|moves| *moves > 4), "{moves:?}");
    assert!(!drives.is_moving());

    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for of in ["form", "points", "links", "session", "sampling", "verdict"] {
        assert_eq!(replayed[of], report[of], "a replay gives the same figures");
    }
    assert_eq!(drives.moves(), moves, "a replay sends nothing");
}

#[test]
fn drives_that_are_not_homed_do_not_move_and_the_cure_is_said() {
    let bench = bench(&[("home = true\n", "")]);
    run_until(&bench, "home = true in [scan.plan]");
    assert_eq!(bench.rig.drives().unwrap().moves(), [0, 0]);
}

#[test]
fn a_home_that_is_not_found_halts_and_says_so() {
    let bench = bench(&[]);
    let drives = bench.rig.drives().unwrap();
    drives.fault(1, DriveFault::HomingFails);
    run_until(&bench, "homing error: check its switches");
    assert!(!drives.is_moving());
}

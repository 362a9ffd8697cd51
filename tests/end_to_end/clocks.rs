//! Clocks that jump and hosts that stand still: figures are right, or flagged.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{Running, asphera, count, json, number};
use serde_json::Value;

use crate::demo::{replayed, timeless};
use crate::preloaded::Preloaded;

static CLOCK: Preloaded = Preloaded::new("clock.c");

/// Somebody sets the clock an hour back, a time server a day ahead: a session counts on its own.
#[test]
fn a_wall_clock_that_jumps_changes_nothing() {
    let Some(library) = CLOCK.library() else { return };
    let out = tempfile::tempdir().unwrap();
    let clock = out.path().join("clock");
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--exit", "--json", "--points", "16000", "--speed", "1", "--out"])
            .arg(out.path())
            .env("LD_PRELOAD", library)
            .env("ASPHERA_CLOCK", &clock)
            .stdout(Stdio::piped()),
    );
    daemon.line("results:", Duration::from_secs(60));
    for jump in ["-3600", "86400", "-86400", "0"] {
        std::thread::park_timeout(Duration::from_millis(600));
        std::fs::write(&clock, jump).unwrap();
    }
    let report = json(&daemon.wait(Duration::from_secs(120)));
    assert_eq!(count(&report, "/points/used"), 16_000, "{:#}", report["points"]);
    let took = number(&report, "/timing/total_s");
    assert!((4.0..60.0).contains(&took), "{took} s of 4 s at 4 kHz");
    assert_eq!(timeless(replayed(out.path())), timeless(report));
}

/// A host that stands still for 5 s while the instruments go on. What does not fit into the buffers is gone; it is counted, and
/// no point is joined wrongly.
#[tokio::test(flavor = "multi_thread")]
async fn a_host_that_stands_still_for_five_seconds_counts_what_it_missed() {
    let report = stopped(Duration::from_secs(5), None).await;
    let unused = count(&report, "/points/received") - count(&report, "/points/used");
    if count(&report, "/points/lost") + unused > 0 {
        assert!(!report["verdict"]["reasons"].as_array().unwrap().is_empty(), "{report:#}");
    }
}

/// A computer that is suspended for an hour: its monotonic clock stands still, its timers do not run out, and yet a companion may
/// have missed whole cycles of its count. The verdict says so.
#[tokio::test(flavor = "multi_thread")]
async fn a_computer_that_was_suspended_is_told_and_passes_nothing() {
    let Some(library) = CLOCK.library() else { return };
    let report = stopped(Duration::from_secs(1), Some(library)).await;
    let reasons = report["verdict"]["reasons"].to_string();
    assert!(reasons.contains("the computer was suspended for 3600.0 s"), "{reasons}");
    assert_ne!(report["verdict"]["status"], "pass", "{report:#}");
    assert!(number(&report, "/timing/total_s") > 3600.0, "{}", report["timing"]);
}

/// The report of a session of which the daemon was stopped for some time, and, with a library of clocks, found afterwards that it
/// had been suspended for an hour. No point is joined wrongly, none is missing without a word, and a replay gives the same.
async fn stopped(time: Duration, clocks: Option<&Path>) -> Value {
    let points = 40_000;
    let folder = tempfile::tempdir().unwrap();
    let scene =
        Scene::built_in("asphere").unwrap().with_points(points).with_speed(Speed::Times(1.0));
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let recordings = folder.path().join("recordings");
    let options =
        StationOptions { recordings: recordings.clone(), listen: ([127, 0, 0, 1], 0).into() };
    let config = folder.path().join("station.toml");
    let text = rig.station_toml(&options) + "\n[output]\nfiles = [\"report.json\"]\n";
    std::fs::write(&config, text).unwrap();
    let truth = serde_json::to_value(rig.truth()).unwrap();
    let suspended = folder.path().join("suspended");
    let mut command = Command::new(asphera());
    command.args(["run", "--once", "--config"]).arg(config);
    if let Some(library) = clocks {
        command.env("LD_PRELOAD", library).env("ASPHERA_SUSPENDED", &suspended);
    }
    let (report, replayed) = tokio::task::spawn_blocking(move || {
        let mut daemon = Running::start(&mut command);
        daemon.line("page:", Duration::from_secs(60));
        std::thread::park_timeout(Duration::from_secs(3));
        daemon.signal("STOP");
        std::thread::park_timeout(time);
        std::fs::write(&suspended, "3600").unwrap();
        daemon.signal("CONT");
        let output = daemon.wait(Duration::from_secs(120));
        let words = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(matches!(output.status.code(), Some(0 | 10 | 11)), "{words}");
        let session = asphera_tests::recording(&recordings);
        (asphera_tests::json_file(&session.join("report.json")), replayed(&recordings))
    })
    .await
    .unwrap();
    let missing = count(&report, "/points/lost");
    assert_eq!(count(&report, "/points/received") + missing, points, "{:#}", report["points"]);
    // A point of a wrong trigger would be off by micrometres.
    let (pv, had) =
        (number(&report, "/form/deviation/pv_nm"), number(&truth, "/form/deviation/pv_nm"));
    assert!(pv < had + 20.0, "PV {pv} nm, the simulator had {had} nm");
    assert_eq!(timeless(replayed), timeless(report.clone()));
    report
}

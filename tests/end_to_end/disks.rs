//! Disks that fill up, fail, vanish or give no answer, under a daemon at work.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, count, json_file, page, recording, skipped, snapshot};
use serde_json::Value;

use crate::demo::{replayed, timeless};
use crate::preloaded::Preloaded;

/// The faulty disk; `None`, said on stderr, without a C compiler.
fn faulty_disk() -> Option<&'static Path> {
    static BUILT: Preloaded = Preloaded::new("disk.c");
    BUILT.library()
}

/// A demo on such a disk.
struct Demo {
    daemon: Running,
    address: String,
    out: tempfile::TempDir,
}

impl Demo {
    fn start(points: &str, options: &[&str]) -> Option<Demo> {
        let out = tempfile::tempdir().unwrap();
        let mut daemon = Running::start(
            Command::new(asphera())
                .args(["demo", "--points", points, "--listen", "127.0.0.1:0"])
                .args(options)
                .arg("--out")
                .arg(out.path())
                .env("LD_PRELOAD", faulty_disk()?)
                .env("ASPHERA_DISK", out.path().join("disk"))
                .stdout(Stdio::null()),
        );
        let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
        Some(Demo { daemon, address, out })
    }

    fn disk(&self, how: &str) {
        let (next, disk) = (self.out.path().join("disk.next"), self.out.path().join("disk"));
        std::fs::write(&next, how).unwrap();
        std::fs::rename(next, disk).unwrap();
    }

    /// The first snapshot of which something holds.
    fn until(&self, what: &str, holds: impl Fn(&Value) -> bool) -> Value {
        asphera_tests::until(&self.address, what, Duration::from_secs(60), holds)
    }

    fn received(&self, points: u64) {
        self.until("enough points", |snapshot| count(snapshot, "/points/received") >= points);
    }
}

fn reason(value: &Value, words: &str) -> bool {
    let reasons = value["verdict"]["reasons"].as_array().unwrap();
    reasons.iter().any(|reason| reason.as_str().unwrap().contains(words))
}

#[test]
fn a_disk_that_fails_or_fills_up_is_told_everywhere_and_the_measurement_goes_on() {
    for (fault, words) in
        [("eio", "Input/output error"), ("enospc", "No space left"), ("short", "No space left")]
    {
        let Some(mut demo) = Demo::start("30000", &["--speed", "1"]) else { return };
        demo.received(4000);
        demo.disk(fault);
        let troubled = demo.until("in trouble", |snapshot| reason(snapshot, words));
        assert_ne!(troubled["state"], "complete", "{fault}");
        demo.daemon.line("the page stays", Duration::from_secs(60));
        let report = json_file(&demo.out.path().join("report.json"));
        assert_eq!(count(&report, "/points/received"), 30_000, "{fault}: no point is lost");
        assert_eq!(report["verdict"]["status"], "undecided");
        assert!(
            reason(&report, "the recording is not complete") && reason(&report, words),
            "{fault}: {:#}",
            report["verdict"]
        );
        let shown = snapshot(&demo.address);
        assert!(reason(&shown, words), "{fault}: {:#}", shown["verdict"]);
        // What reached the disk is there, and said to be a part.
        let replayed = replayed(demo.out.path());
        assert_eq!(replayed["session"]["ended"], "interrupted", "{fault}");
        assert!(count(&replayed, "/points/received") >= 2000, "{fault}");
        assert_eq!(replayed["verdict"]["status"], "undecided");
        end(demo.daemon, 11);
    }
}

#[test]
fn a_disk_that_gives_no_answer_for_some_seconds_costs_nothing() {
    let Some(mut demo) = Demo::start("24000", &["--speed", "1"]) else { return };
    demo.received(2000);
    demo.disk("hang");
    demo.until("in trouble", |snapshot| reason(snapshot, "the disk has not answered for 3 s"));
    demo.disk("");
    demo.until("well again", |snapshot| !reason(snapshot, "the disk"));
    demo.daemon.line("the page stays", Duration::from_secs(60));
    let report = json_file(&demo.out.path().join("report.json"));
    assert_eq!(count(&report, "/points/received"), 24_000);
    assert!(!reason(&report, "the recording"), "{:#}", report["verdict"]);
    assert_eq!(timeless(replayed(demo.out.path())), timeless(report));
    end(demo.daemon, 0);
}

#[test]
fn a_station_on_a_disk_that_gives_no_answer_ends_in_time_all_the_same() {
    let Some(demo) = Demo::start("200000", &["--speed", "1"]) else { return };
    demo.received(4000);
    demo.disk("hang");
    demo.until("in trouble", |snapshot| reason(snapshot, "the disk has not answered"));
    let words = end(demo.daemon, 1);
    assert!(words.contains("asphera replay"), "{words}");
    let replayed = replayed(demo.out.path());
    assert_eq!(replayed["session"]["ended"], "interrupted");
    assert!(count(&replayed, "/points/received") >= 2000);
}

#[test]
fn a_session_on_a_disk_that_takes_nothing_does_not_begin() {
    let Some(library) = faulty_disk() else { return };
    let out = tempfile::tempdir().unwrap();
    std::fs::write(out.path().join("disk"), "erofs").unwrap();
    let output = Command::new(asphera())
        .args(["demo", "--exit", "--points", "1000", "--out"])
        .arg(out.path())
        .env("LD_PRELOAD", library)
        .env("ASPHERA_DISK", out.path().join("disk"))
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.contains("cannot record to") && words.contains("Read-only"), "{words}");
}

/// A stick that is pulled: the files go on for who has them open, and nobody can find them.
#[test]
fn a_folder_that_vanishes_is_told_at_the_latest_at_the_end() {
    let Some(mut demo) = Demo::start("20000", &["--speed", "2"]) else { return };
    demo.received(4000);
    std::fs::remove_dir_all(recording(demo.out.path())).unwrap();
    demo.daemon.line("the page stays", Duration::from_secs(60));
    let report = json_file(&demo.out.path().join("report.json"));
    assert_eq!(count(&report, "/points/received"), 20_000);
    assert_eq!(report["verdict"]["status"], "undecided");
    assert!(
        reason(&report, "the recording is not complete") && reason(&report, "No such file"),
        "{:#}",
        report["verdict"]
    );
    end(demo.daemon, 11);
}

/// Somebody waits for the report: a part that passed does not end in success without it.
#[tokio::test(flavor = "multi_thread")]
async fn a_run_without_its_report_has_failed() {
    use asphera_rig::{Rig, Scene, Speed, StationOptions};

    let Some(library) = faulty_disk() else { return };
    let folder = tempfile::tempdir().unwrap();
    let recordings = folder.path().join("recordings");
    let disk = folder.path().join("disk");
    let scene = Scene::built_in("sphere").unwrap().with_points(5_000).with_speed(Speed::Max);
    for (how, code) in [("", 0), ("report", 1)] {
        std::fs::write(&disk, how).unwrap();
        let rig = Rig::start(scene.clone(), &folder.path().join("ports")).await.unwrap();
        let options =
            StationOptions { recordings: recordings.clone(), listen: ([127, 0, 0, 1], 0).into() };
        let config = folder.path().join("station.toml");
        std::fs::write(&config, rig.station_toml(&options)).unwrap();
        let mut command = Command::new(asphera());
        command.args(["run", "--once", "--config"]).arg(&config);
        command.env("LD_PRELOAD", library).env("ASPHERA_DISK", &disk);
        let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap();
        let words = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        assert_eq!(output.status.code(), Some(code), "{how}: {words}");
        assert_eq!(
            words.contains("results: not written: cannot write"),
            code == 1,
            "{how}: {words}"
        );
        drop(rig);
    }
}

/// A file system of 512 KiB, half of what the session needs, in a namespace of its own, so nothing stands between the daemon and
/// the kernel.
#[tokio::test(flavor = "multi_thread")]
async fn a_file_system_that_is_full_is_told_and_what_fits_is_replayed() {
    use asphera_rig::{Rig, Scene, Speed, StationOptions};

    const MOUNT: &str = "mount -t tmpfs -o size=512k tmpfs \"$0\"";
    let folder = tempfile::tempdir().unwrap();
    let small = folder.path().join("small");
    std::fs::create_dir(&small).unwrap();
    let inside = |script: &str, arguments: &[&Path]| {
        let mut command = Command::new("unshare");
        command.args(["--user", "--map-root-user", "--mount", "sh", "-c", script]).arg(&small);
        command.args(arguments);
        command
    };
    if !inside(MOUNT, &[]).output().is_ok_and(|output| output.status.success()) {
        return skipped("the kernel lets no user mount a file system of their own");
    }
    let scene = Scene::built_in("sphere").unwrap().with_points(40_000).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options = StationOptions { recordings: small.clone(), listen: ([127, 0, 0, 1], 0).into() };
    let config = folder.path().join("station.toml");
    let text = rig.station_toml(&options).replace("[session]\n", "[session]\nreserve_mib = 0\n");
    std::fs::write(&config, text).unwrap();
    let script = format!(
        "{MOUNT} && {{ \"$1\" run --once --config \"$2\"; echo \"run ended with $?\"; \"$1\" replay \"$0\"/session-*; }}"
    );
    let mut command = inside(&script, &[asphera(), &config]);
    let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await.unwrap();
    let words = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(words.contains("run ended with 11"), "{words}");
    assert_eq!(words.matches("40000 received").count(), 1, "{words}");
    assert!(
        words.contains("the recording is not complete") && words.contains("No space left"),
        "{words}"
    );
    assert!(words.contains("(interrupted)"), "{words}");
    drop(rig);
}

/// Ends a daemon by SIGTERM, which takes 5 s at most, and gives what it said.
fn end(daemon: Running, code: i32) -> String {
    daemon.signal("TERM");
    let output = daemon.wait(Duration::from_secs(5));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{words}");
    words
}

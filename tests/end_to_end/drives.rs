//! Two CANopen drives that the station homes and moves over slcan, and a gauge over the part on them.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use asphera_rig::{DriveFault, DriveRig, DriveScene};
use asphera_tests::{
    Running, asphera, count, http, json, json_file, now, number, page, recording, root, run,
};

use crate::closed_loop::flat_pv_nm;

/// Bench and station of the example, on free ports.
struct Bench {
    rig: DriveRig,
    config: PathBuf,
    folder: tempfile::TempDir,
    _runtime: tokio::runtime::Runtime,
}

impl Bench {
    /// The example with some text replaced.
    fn new(changes: &[(&str, &str)]) -> Bench {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .unwrap();
        let scene =
            std::fs::read_to_string(root().join("simulators/rig/scenes/drives.toml")).unwrap();
        let scene = DriveScene::parse("drives", &scene).unwrap().unwrap().on_free_ports();
        let rig = runtime.block_on(DriveRig::start(scene)).unwrap();
        let [gauge, bus] = rig.addresses().map(|address| address.to_string());
        let mut text = std::fs::read_to_string(root().join("config/examples/drives.toml")).unwrap();
        let ports = [("127.0.0.1:7741", gauge.as_str()), ("127.0.0.1:7742", bus.as_str())];
        for (from, to) in ports.iter().chain(changes) {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let folder = tempfile::tempdir().unwrap();
        text += &format!(
            "\n[session]\ndir = {:?}\n[publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
            folder.path().join("recordings").display().to_string()
        );
        let config = folder.path().join("station.toml");
        std::fs::write(&config, text).unwrap();
        Bench { rig, config, folder, _runtime: runtime }
    }

    /// Measures once, armed; gives the exit code and what was said.
    fn measure(&self) -> (Option<i32>, String) {
        let mut command = Command::new(asphera());
        command.args(["run", "--once", "--arm", "--config"]).arg(&self.config);
        let running = Running::start(command.stdout(std::process::Stdio::piped()));
        let output = running.wait(Duration::from_secs(200));
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    }

    /// Runs the station, armed, until its scan says these words.
    fn run_until(&self, words: &str) {
        let mut command = Command::new(asphera());
        command.args(["run", "--arm", "--config"]).arg(&self.config);
        let mut running = Running::start(command.stdout(std::process::Stdio::piped()));
        let (address, _) = page(&running.line("/#token=", Duration::from_secs(20)));
        let end = now() + Duration::from_secs(60);
        loop {
            let (_, body) = http(&address, "GET", "/api/v1/snapshot", &[]);
            let snapshot: serde_json::Value = serde_json::from_slice(&body).unwrap();
            let scan = snapshot["scan"].to_string();
            if scan.contains(words) {
                return;
            }
            assert!(now() < end, "expected {words:?} in {scan}");
            std::thread::park_timeout(Duration::from_millis(20));
        }
    }

    fn session(&self) -> PathBuf {
        recording(&self.folder.path().join("recordings"))
    }
}

#[test]
fn drives_find_home_and_are_driven_over_the_plan() {
    let bench = Bench::new(&[]);
    let drives = bench.rig.drives().unwrap();
    // They were switched on in the middle of their travel, and count from there.
    assert_eq!(drives.places(), [150_000.0, 200_000.0]);
    let (code, words) = bench.measure();
    let session = bench.session();
    let report = json_file(&session.join("report.json"));
    assert_eq!(report["session"]["ended"], "complete", "{words}");
    assert_eq!(report["verdict"]["status"], "pass", "{:#}", report["verdict"]);
    assert_eq!(code, Some(0), "{words}");
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
    let bench = Bench::new(&[("home = true\n", "")]);
    bench.run_until("home = true in [scan.plan]");
    assert_eq!(bench.rig.drives().unwrap().moves(), [0, 0]);
}

#[test]
fn a_home_that_is_not_found_halts_and_says_so() {
    let bench = Bench::new(&[]);
    let drives = bench.rig.drives().unwrap();
    drives.fault(1, DriveFault::HomingFails);
    bench.run_until("homing error: check its switches");
    assert!(!drives.is_moving());
}

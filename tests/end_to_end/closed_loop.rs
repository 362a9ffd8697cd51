//! A scan that the station drives: a stage that obeys, and a gauge over the part on it, both over TCP.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_rig::{DriveRig, DriveScene, StageFault};
use asphera_tests::{
    Running, asphera, count, http, json, json_file, number, page, recording, root, run, snapshot,
    wait_for,
};
use serde_json::Value;

/// Bench and station of an example, on free ports.
pub(crate) struct Bench {
    pub(crate) rig: DriveRig,
    config: PathBuf,
    folder: tempfile::TempDir,
    runtime: tokio::runtime::Runtime,
}

impl Bench {
    /// The example of a stage with some lines replaced.
    fn new(changes: &[(&str, &str)]) -> Bench {
        Bench::of("stage", "closed-loop", ["127.0.0.1:7731", "127.0.0.1:7732"], changes)
    }

    /// A scene and its example, whose gauge and axes have these addresses there, with some text replaced.
    pub(crate) fn of(
        scene: &str,
        example: &str,
        addresses: [&str; 2],
        changes: &[(&str, &str)],
    ) -> Bench {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .unwrap();
        let text =
            std::fs::read_to_string(root().join(format!("simulators/rig/scenes/{scene}.toml")));
        let scene = DriveScene::parse(scene, &text.unwrap()).unwrap().unwrap().on_free_ports();
        let rig = runtime.block_on(DriveRig::start(scene)).unwrap();
        let ports = rig.addresses().map(|address| address.to_string());
        let text = std::fs::read_to_string(root().join(format!("config/examples/{example}.toml")));
        let mut text = text.unwrap();
        let ports = addresses.into_iter().zip(ports.iter().map(String::as_str));
        for (from, to) in ports.chain(changes.iter().copied()) {
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
        Bench { rig, config, folder, runtime }
    }

    pub(crate) fn run(&self, arguments: &[&str]) -> Station {
        let mut command = Command::new(asphera());
        command.arg("run").args(arguments).arg("--config").arg(&self.config);
        let mut running = Running::start(command.stdout(std::process::Stdio::piped()));
        let (address, token) = page(&running.line("/#token=", Duration::from_secs(20)));
        Station { running, address, authorization: format!("Bearer {token}") }
    }

    pub(crate) fn session(&self) -> PathBuf {
        recording(&self.folder.path().join("recordings"))
    }

    /// How long after a time the stage received its first stop.
    fn stop_after(&self, pressed: Duration) -> Duration {
        let stopped = || self.stopped_at().ok_or("none");
        wait_for("stop", Duration::from_secs(2), stopped).checked_sub(pressed).unwrap()
    }

    /// When the stage received a stop first, since it was started.
    fn stopped_at(&self) -> Option<Duration> {
        let received = self.rig.stage().unwrap().received();
        received
            .iter()
            .find(|one| one.bytes.windows(4).any(|four| four == b"stop"))
            .map(|one| one.at)
    }
}

pub(crate) struct Station {
    pub(crate) running: Running,
    address: String,
    authorization: String,
}

impl Station {
    pub(crate) fn until(&self, what: &str, is_there: impl Fn(&Value) -> bool) -> Value {
        asphera_tests::until(&self.address, what, Duration::from_secs(60), is_there)
    }

    fn until_moving(&self) -> Value {
        self.until("moving along a line", |snapshot| snapshot["scan"]["points"].as_u64() > Some(5))
    }

    fn post(&self, path: &str) -> (u16, String) {
        let (status, body) = asphera_tests::post(&self.address, path, &self.authorization, "");
        (status, String::from_utf8_lossy(&body).into_owned())
    }
}

fn report(folder: &Path) -> Value {
    json_file(&folder.join("report.json"))
}

/// The scan comes to its end by itself: covered, judged; its figures are those of the part, and a replay finds them again.
#[test]
fn a_closed_loop_reaches_its_verdict_and_a_replay_gives_the_same() {
    let bench = Bench::new(&[]);
    let output = bench.run(&["--once", "--arm"]).running.wait(Duration::from_secs(200));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = bench.session();
    let report = report(&session);
    assert_eq!(report["session"]["ended"], "complete", "{words}");
    assert_eq!(report["verdict"]["status"], "pass", "{:#}", report["verdict"]);
    assert_eq!(output.status.code(), Some(0), "{words}");
    assert!(number(&report, "/sampling/coverage") >= 0.99, "{:#}", report["sampling"]);

    // The form of the simulated part over the aperture, by its own heights; 5 nm of noise.
    let mut heights = Vec::new();
    for k in 0..=40 {
        for l in 0..=30 {
            let place = [-4.0 + 0.2 * f64::from(k), -3.0 + 0.2 * f64::from(l)];
            heights.push((place, bench.rig.height_mm(place).unwrap() * 1e6));
        }
    }
    let pv_nm = flat_pv_nm(&heights);
    let found_nm = number(&report, "/form/deviation/pv_nm");
    assert!(pv_nm > 150.0, "{pv_nm} nm");
    assert!((found_nm - pv_nm).abs() < 30.0, "{found_nm} nm found, {pv_nm} nm are there");

    // Nothing at rest and nothing between lines is a point.
    assert!(count(&report, "/points/flagged/off_plan") > 100, "{:#}", report["points"]);
    assert!(count(&report, "/points/used") > 100, "{:#}", report["points"]);
    assert!(bench.rig.stage().unwrap().moves() > 10);
    // The last command is no move that goes on.
    assert!(!bench.rig.stage().unwrap().is_moving());

    let moves = bench.rig.stage().unwrap().moves();
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for of in ["form", "points", "links", "session", "sampling", "verdict"] {
        assert_eq!(replayed[of], report[of], "a replay gives the same figures");
    }
    assert_eq!(bench.rig.stage().unwrap().moves(), moves, "a replay sends nothing");
}

/// Range of the heights about their plane of least squares, by normal equations over a symmetric grid.
pub(crate) fn flat_pv_nm(heights: &[([f64; 2], f64)]) -> f64 {
    let n = heights.len() as f64;
    let mean = heights.iter().map(|(_, z)| z).sum::<f64>() / n;
    let slope = |axis: usize| {
        let squares: f64 = heights.iter().map(|(place, _)| place[axis] * place[axis]).sum();
        heights.iter().map(|(place, z)| place[axis] * z).sum::<f64>() / squares
    };
    let [a, b] = [slope(0), slope(1)];
    let off = heights.iter().map(|([x, y], z)| z - mean - a * x - b * y);
    let (low, high) =
        off.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(z), high.max(z)));
    high - low
}

#[test]
fn nothing_moves_before_it_is_armed_and_only_who_may_arms_it() {
    let bench = Bench::new(&[]);
    let station = bench.run(&[]);
    station.until("both links", |snapshot| {
        let links = snapshot["links"].as_array().unwrap();
        links.iter().all(|link| link["state"] == "connected")
    });
    std::thread::park_timeout(Duration::from_secs(2));
    let scan = snapshot(&station.address)["scan"].clone();
    assert_eq!(
        (scan["state"].as_str(), scan["points"].as_u64()),
        (Some("disarmed"), Some(0)),
        "{scan:#}"
    );
    assert!(
        bench.rig.stage().unwrap().received().is_empty(),
        "{:?}",
        bench.rig.stage().unwrap().received()
    );
    assert_eq!(http(&station.address, "POST", "/api/v1/scan/arm", &[]).0, 401);
    assert_eq!(http(&station.address, "GET", "/api/v1/scan/arm", &[]).0, 405);
    assert_eq!(bench.rig.stage().unwrap().moves(), 0);
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    let moving = station.until_moving();
    assert_eq!(moving["scan"]["state"], "moving");
    assert!(
        moving["scan"]["place_mm"].is_array() && count(&moving, "/scan/pieces") >= 3,
        "{:#}",
        moving["scan"]
    );
    let (status, why) = station.post("/api/v1/scan/arm");
    assert!(status == 409 && why.contains("armed already"), "{why}");
    assert!(bench.rig.stage().unwrap().moves() > 0);
}

/// The bytes of the stop are on the link within 100 ms, and the stage stands; an armed scan goes on.
#[test]
fn a_stop_reaches_the_stage_within_a_tenth_of_a_second() {
    let bench = Bench::new(&[("scan_speed_mm_s = 10", "scan_speed_mm_s = 2")]);
    let station = bench.run(&[]);
    station.until("a session", |snapshot| snapshot["state"] == "measuring");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until_moving();
    assert_eq!(bench.stopped_at(), None);
    let pressed = bench.rig.stage().unwrap().now();
    let (status, why) = station.post("/api/v1/scan/stop");
    assert_eq!(status, 204, "{why}");
    let late = bench.stop_after(pressed);
    assert!(late < Duration::from_millis(100), "{late:?}");
    std::thread::park_timeout(Duration::from_millis(300));
    assert!(!bench.rig.stage().unwrap().is_moving());
    let scan =
        station.until("disarmed", |snapshot| snapshot["scan"]["state"] == "disarmed")["scan"]
            .clone();
    assert_eq!(scan["text"], "stopped by hand");
    let moves = bench.rig.stage().unwrap().moves();
    std::thread::park_timeout(Duration::from_secs(1));
    assert_eq!(bench.rig.stage().unwrap().moves(), moves, "nothing moves until it is armed again");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until("moving again", |_| bench.rig.stage().unwrap().moves() > moves + 1);

    // The end of a session halts, too; its replay is armed, halted and armed as it was.
    assert_eq!(station.post("/api/v1/session/stop").0, 204);
    station.until("complete", |snapshot| snapshot["outputs"].is_object());
    std::thread::park_timeout(Duration::from_millis(300));
    assert!(!bench.rig.stage().unwrap().is_moving());
    let session = bench.session();
    let report = report(&session);
    assert_eq!(report["session"]["ended"], "stopped");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for of in ["form", "points", "links", "session"] {
        assert_eq!(replayed[of], report[of], "a replay gives the same figures");
    }
}

/// The same while mesh, sections and places are asked for without a pause. That a link sends while nothing at all is taken from it is tested with
/// the links.
#[test]
fn a_stop_does_not_wait_for_a_busy_pipeline() {
    // A mesh of many points, and a question for it again and again.
    let bench =
        Bench::new(&[("scan_speed_mm_s = 10", "scan_speed_mm_s = 1\npoint_spacing_mm = 0.0001")]);
    let station = bench.run(&[]);
    station.until("a session", |snapshot| snapshot["state"] == "measuring");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until_moving();
    let address = station.address.clone();
    let asking = std::thread::spawn(move || {
        for _ in 0..200 {
            for path in ["/api/v1/mesh.ply", "/api/v1/section?radius=2", "/api/v1/waypoints.csv"] {
                http(&address, "GET", path, &[]);
            }
        }
    });
    std::thread::park_timeout(Duration::from_millis(300));
    let pressed = bench.rig.stage().unwrap().now();
    let (status, why) = station.post("/api/v1/scan/stop");
    assert_eq!(status, 204, "{why}");
    let late = bench.stop_after(pressed);
    assert!(late < Duration::from_millis(100), "{late:?}");
    drop(station);
    // Its requests end with the daemon.
    let _ = asking.join();
}

/// A limit, a stall, a knob, silence: the axes are halted, and the page says why.
#[test]
fn trouble_of_the_stage_halts_and_is_said() {
    for (fault, words) in [
        (StageFault::Limit(0), "WL"),
        (StageFault::Stall(0), "FS"),
        (StageFault::Knob(1, 3.0), "something else moves it"),
    ] {
        let bench = Bench::new(&[("scan_speed_mm_s = 10", "scan_speed_mm_s = 2")]);
        let station = bench.run(&[]);
        station.until("a session", |snapshot| snapshot["state"] == "measuring");
        assert_eq!(station.post("/api/v1/scan/arm").0, 204);
        station.until_moving();
        bench.rig.stage().unwrap().fault(fault);
        let scan = station.until(words, |snapshot| snapshot["scan"]["state"] == "disarmed")["scan"]
            .clone();
        let text = scan["text"].as_str().unwrap();
        assert!(text.contains(words) && text.contains("arm the scan again"), "{text}");
        assert!(bench.stopped_at().is_some());
        std::thread::park_timeout(Duration::from_millis(500));
        assert!(!bench.rig.stage().unwrap().is_moving(), "{words}");
    }
}

#[test]
fn a_lost_link_halts_and_disarms() {
    let mut bench = Bench::new(&[("scan_speed_mm_s = 10", "scan_speed_mm_s = 1")]);
    let station = bench.run(&[]);
    station.until("a session", |snapshot| snapshot["state"] == "measuring");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until_moving();
    bench.runtime.block_on(bench.rig.unplug_stage());
    let scan =
        station.until("disarmed", |snapshot| snapshot["scan"]["state"] == "disarmed")["scan"]
            .clone();
    let text = scan["text"].as_str().unwrap();
    assert!(
        text.contains("the link stage was lost") && text.contains("arm the scan again"),
        "{text}"
    );
    // What the stage was sent to it may run to; a stop is the first thing it hears when its link is back.
    assert_eq!(bench.stopped_at(), None);
    bench.runtime.block_on(bench.rig.plug_stage()).unwrap();
    station.until("stopped", |_| bench.stopped_at().is_some());
    let moves = bench.rig.stage().unwrap().moves();
    std::thread::park_timeout(Duration::from_secs(1));
    assert_eq!(bench.rig.stage().unwrap().moves(), moves);
    assert_eq!(snapshot(&station.address)["scan"]["state"], "disarmed");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until("moving again", |_| bench.rig.stage().unwrap().moves() > moves);
}

#[test]
fn a_part_that_fails_ends_the_scan_early() {
    let whole =
        Bench::new(&[("gap_limit_mm = 0.6", "gap_limit_mm = 0.2"), ("pv_nm = 400", "pv_nm = 20")]);
    let output = whole.run(&["--once", "--arm"]).running.wait(Duration::from_secs(200));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let report = report(&whole.session());
    assert_eq!(report["verdict"]["status"], "fail", "{words}");
    assert!(number(&report, "/sampling/coverage") < 0.99, "{:#}", report["sampling"]);
    assert!(whole.stopped_at().is_some(), "{words}");
    std::thread::park_timeout(Duration::from_millis(300));
    assert!(!whole.rig.stage().unwrap().is_moving());
}

#[test]
fn a_plan_beyond_the_travel_is_refused_at_check() {
    let bench = Bench::new(&[("x = { travel_mm = [-25, 25]", "x = { travel_mm = [-3, 25]")]);
    let output = run(["check".as_ref(), "--config".as_ref(), bench.config.as_os_str()]);
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && words.contains("scan.plan.x.travel_mm"), "{words}");
    assert!(
        words.contains("expected -3 to 25 mm") && words.contains("plan a smaller aperture"),
        "{words}"
    );
}

//! A coordinate measuring machine that runs the program of the station, over TCP.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use asphera_rig::{CmmRig, CmmScene, MachineFault};
use asphera_tests::{
    Running, asphera, count, http, json, json_file, number, page, recording, root, run, wait_for,
};
use serde_json::Value;

/// Machine and station of the example, on free ports.
struct Bench {
    rig: CmmRig,
    config: PathBuf,
    folder: tempfile::TempDir,
    runtime: tokio::runtime::Runtime,
}

impl Bench {
    /// The example with some lines replaced, in scene and station.
    fn new(scene_changes: &[(&str, &str)], changes: &[(&str, &str)]) -> Bench {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .build()
            .unwrap();
        let scene = changed("simulators/rig/scenes/cmm.toml", scene_changes);
        let scene = CmmScene::parse("cmm", &scene).unwrap().unwrap().on_free_port();
        let rig = runtime.block_on(CmmRig::start(scene)).unwrap();
        let address = rig.address().to_string();
        let mut text = changed("config/examples/cmm.toml", changes);
        text = text.replace("127.0.0.1:1294", &address);
        let folder = tempfile::tempdir().unwrap();
        text += &format!(
            "\n[session]\ndir = {:?}\n[publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
            folder.path().join("recordings").display().to_string()
        );
        let config = folder.path().join("station.toml");
        std::fs::write(&config, text).unwrap();
        Bench { rig, config, folder, runtime }
    }

    fn run(&self, arguments: &[&str]) -> Station {
        let mut command = Command::new(asphera());
        command.arg("run").args(arguments).arg("--config").arg(&self.config);
        let mut running = Running::start(command.stdout(std::process::Stdio::piped()));
        let (address, token) = page(&running.line("/#token=", Duration::from_secs(20)));
        Station { running, address, authorization: format!("Bearer {token}") }
    }

    fn session(&self) -> PathBuf {
        recording(&self.folder.path().join("recordings"))
    }

    /// Commands that the machine received, without tags.
    fn commands(&self) -> Vec<String> {
        let received = self.rig.machine().received();
        let text: String = received.into_iter().map(|received| received.text).collect();
        text.lines().map(|line| line[6..].to_owned()).collect()
    }

    /// How long after a time the machine received its first halt.
    fn halted_after(&self, pressed: Duration) -> Duration {
        let halted = || {
            let received = self.rig.machine().received();
            received
                .iter()
                .find(|one| one.text.contains("AbortE()"))
                .map(|one| one.at)
                .ok_or("none")
        };
        wait_for("halt", Duration::from_secs(2), halted).checked_sub(pressed).unwrap()
    }
}

fn changed(file: &str, changes: &[(&str, &str)]) -> String {
    let mut text = std::fs::read_to_string(root().join(file)).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    text
}

struct Station {
    running: Running,
    address: String,
    authorization: String,
}

impl Station {
    fn until(&self, what: &str, is_there: impl Fn(&Value) -> bool) -> Value {
        asphera_tests::until(&self.address, what, Duration::from_secs(60), is_there)
    }

    fn until_measuring(&self) {
        self.until("points", |snapshot| snapshot["scan"]["points"].as_u64() > Some(100));
    }

    fn post(&self, path: &str) -> (u16, String) {
        let (status, body) = asphera_tests::post(&self.address, path, &self.authorization, "");
        (status, String::from_utf8_lossy(&body).into_owned())
    }
}

/// Slow enough that a person could halt it.
const SLOW: (&str, &str) = ("scan_mm_s = 40.0", "scan_mm_s = 4.0");

/// The program runs to its end and its points are judged; figures are those of the part, z is that of the ball's centre, and a
/// replay finds both again.
#[test]
fn a_program_reaches_its_verdict_and_a_replay_gives_the_same() {
    let bench = Bench::new(&[], &[(", offset_mm = -1", "")]);
    let output = bench.run(&["--once", "--arm"]).running.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = bench.session();
    let report = json_file(&session.join("report.json"));
    assert_eq!(report["session"]["ended"], "complete", "{words}");
    assert_eq!(report["verdict"]["status"], "pass", "{:#}", report["verdict"]);
    assert_eq!(output.status.code(), Some(0), "{words}");
    // Two points, and 11 lines of 81.
    assert_eq!(count(&report, "/points/received"), 2 + 11 * 81, "{:#}", report["points"]);
    assert!(number(&report, "/sampling/coverage") > 0.95, "{:#}", report["sampling"]);

    // Fringe terms 4, 5 and 7 over the aperture, by their formulas; noise of 100 nm a point adds some hundred nm.
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let heights: Vec<([f64; 2], f64)> = grid().map(|place| (place, error_nm(place))).collect();
    let plane = plane_of(&heights);
    for (place, height) in &heights {
        let off = height - plane[0] - plane[1] * place[0] - plane[2] * place[1];
        (low, high) = (low.min(off), high.max(off));
    }
    let (pv_nm, found_nm) = (high - low, number(&report, "/form/deviation/pv_nm"));
    assert!(pv_nm > 700.0, "{pv_nm} nm");
    assert!((found_nm - pv_nm).abs() < 500.0, "{found_nm} nm found, {pv_nm} nm are there");
    // The centre of the ball, R 1 mm, over the part at 0.0312 mm.
    let tz_mm = number(&report, "/form/fit/pose/tz_mm");
    assert!((tz_mm - 1.0312 + plane[0].abs() * 1e-6).abs() < 3e-3, "{tz_mm} mm");

    let commands = bench.commands();
    assert_eq!(commands[0], "StartSession()");
    assert_eq!(commands[5], "Home()");
    assert_eq!(commands.last().unwrap(), "EndSession()");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for of in ["form", "points", "links", "session", "sampling", "verdict"] {
        assert_eq!(replayed[of], report[of], "a replay gives the same figures");
    }
    assert_eq!(bench.commands().len(), commands.len(), "a replay sends nothing");
}

/// Places of the aperture, 19 mm × 19 mm.
fn grid() -> impl Iterator<Item = [f64; 2]> {
    (0..=76).flat_map(|k| (0..=76).map(move |l| [k, l].map(|at| -9.5 + 0.25 * f64::from(at))))
}

/// Form error of the scene in nm: power, astigmatism and coma over a radius of 25 mm.
fn error_nm([x, y]: [f64; 2]) -> f64 {
    let (u, v) = (x / 25.0, y / 25.0);
    let square = u * u + v * v;
    2000.0 * (2.0 * square - 1.0) + 1500.0 * (u * u - v * v) + 800.0 * (3.0 * square - 2.0) * u
}

/// Plane of least squares over a symmetric grid: mean and slopes.
fn plane_of(heights: &[([f64; 2], f64)]) -> [f64; 3] {
    let mean = heights.iter().map(|(_, z)| z).sum::<f64>() / heights.len() as f64;
    let slope = |axis: usize| {
        let squares: f64 = heights.iter().map(|(place, _)| place[axis] * place[axis]).sum();
        heights.iter().map(|(place, z)| place[axis] * z).sum::<f64>() / squares
    };
    [mean, slope(0), slope(1)]
}

/// Idle times do not count while the station waits to be armed: those of the example are shortened to a fraction of the wait.
#[test]
fn nothing_moves_before_it_is_armed_however_long_that_takes() {
    let bench = Bench::new(&[SLOW], &[("idle_s = 10", "idle_s = 0.5")]);
    let station = bench.run(&[]);
    station.until("the link", |snapshot| snapshot["links"][0]["state"] == "connected");
    std::thread::park_timeout(Duration::from_secs(3));
    let snapshot = station.until("a session", |snapshot| snapshot["state"] == "measuring");
    assert_eq!(snapshot["scan"]["state"], "disarmed", "{:#}", snapshot["scan"]);
    assert!(!bench.rig.machine().is_moving());
    let moves = ["Home", "ChangeTool", "GoTo", "PtMeas", "Scan"];
    let commands = bench.commands();
    assert!(
        commands.iter().all(|line| !moves.iter().any(|name| line.starts_with(name))),
        "{commands:?}"
    );
    assert_eq!(http(&station.address, "POST", "/api/v1/scan/arm", &[]).0, 401);
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until_measuring();
    assert!(bench.rig.machine().is_moving());
    let (status, why) = station.post("/api/v1/scan/arm");
    assert!(status == 409 && why.contains("armed already"), "{why}");
}

/// The bytes of the halt are on the link within 100 ms; the program is not begun again, and the session ends by itself.
#[test]
fn a_stop_reaches_the_machine_and_the_program_is_over() {
    let bench = Bench::new(&[SLOW], &[("idle_s = 10", "idle_s = 3")]);
    let station = bench.run(&[]);
    station.until("a session", |snapshot| snapshot["state"] == "measuring");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until_measuring();
    let pressed = bench.rig.machine().now();
    let (status, why) = station.post("/api/v1/scan/stop");
    assert_eq!(status, 204, "{why}");
    let late = bench.halted_after(pressed);
    assert!(late < Duration::from_millis(100), "{late:?}");
    let scan = station.until("disarmed", |one| one["scan"]["state"] == "disarmed")["scan"].clone();
    assert_eq!(scan["text"], "stopped by hand");
    assert!(!bench.rig.machine().is_moving());
    let (status, why) = station.post("/api/v1/scan/arm");
    assert!(status == 409 && why.contains("start a session"), "{why}");
    station.until("complete", |snapshot| snapshot["outputs"].is_object());
    let session = bench.session();
    let report = json_file(&session.join("report.json"));
    assert_eq!(report["session"]["ended"], "idle", "{:#}", report["session"]);
    assert_ne!(report["verdict"]["status"], "pass", "half a program is no part that passes");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for of in ["form", "points", "links", "session"] {
        assert_eq!(replayed[of], report[of], "a replay gives the same figures");
    }
}

/// A collision, an emergency stop, a foreign client: the machine is halted, and the page says why.
#[test]
fn trouble_of_the_machine_ends_the_program_and_is_said() {
    for (fault, words) in [
        (MachineFault::Collision, "take away what the probe ran into"),
        (MachineFault::EmergencyStop, "release the emergency stop"),
        (MachineFault::ForeignTag, "the link cmm was lost"),
    ] {
        let bench = Bench::new(&[SLOW], &[]);
        let station = bench.run(&[]);
        station.until("a session", |snapshot| snapshot["state"] == "measuring");
        assert_eq!(station.post("/api/v1/scan/arm").0, 204);
        station.until_measuring();
        bench.rig.machine().fault(fault);
        let scan = station.until(words, |snapshot| snapshot["scan"]["state"] == "disarmed")["scan"]
            .clone();
        let text = scan["text"].as_str().unwrap();
        assert!(text.contains(words), "{text}");
        std::thread::park_timeout(Duration::from_millis(500));
        assert!(!bench.rig.machine().is_moving(), "{words}");
    }
}

/// A machine whose link was lost hears a halt as soon as it is back.
#[test]
fn a_lost_link_halts_the_machine_when_it_opens() {
    let mut bench = Bench::new(&[SLOW], &[]);
    let station = bench.run(&[]);
    station.until("a session", |snapshot| snapshot["state"] == "measuring");
    assert_eq!(station.post("/api/v1/scan/arm").0, 204);
    station.until_measuring();
    bench.runtime.block_on(bench.rig.unplug());
    let scan = station.until("disarmed", |one| one["scan"]["state"] == "disarmed")["scan"].clone();
    assert!(scan["text"].as_str().unwrap().contains("the link cmm was lost"), "{scan:#}");
    let before = bench.commands().len();
    bench.runtime.block_on(bench.rig.plug()).unwrap();
    station.until("halted", |_| bench.commands()[before..].contains(&"AbortE()".to_owned()));
    assert!(!bench.rig.machine().is_moving());
}

/// Points that touch nothing, and those of poor quality, are counted; the rest is measured.
#[test]
fn missed_and_poor_points_are_in_the_report() {
    let bench = Bench::new(&[], &[]);
    bench.rig.machine().fault(MachineFault::NoTouch);
    bench.rig.machine().fault(MachineFault::PoorPoints(20));
    let output = bench.run(&["--once", "--arm"]).running.wait(Duration::from_secs(120));
    let report = json_file(&bench.session().join("report.json"));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(report["session"]["ended"], "complete", "{words}");
    assert_eq!(count(&report, "/points/received"), 1 + 11 * 81, "{:#}", report["points"]);
    assert_eq!(count(&report, "/points/flagged/weak"), 20, "{:#}", report["points"]);
    assert_eq!(count(&report, "/links/0/devices/0/faults/device"), 1, "{:#}", report["links"]);
}

#[test]
fn a_program_that_cannot_be_is_refused_at_check() {
    for (from, to, words) in [
        ("'GoTo(Z(20))'", "'GoTo(Z(20)'", "expected , or ) at character 11"),
        ("'GoTo(Z(20))'", "'AbortE()'", "a command that waits for its turn"),
        ("idle_s = 10", "idle_s = 10\npoints = 100", "the program of cmm says what is measured"),
    ] {
        let bench = Bench::new(&[], &[(from, to)]);
        let output = run(["check".as_ref(), "--config".as_ref(), bench.config.as_os_str()]);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && said.contains(words), "{said}");
    }
}

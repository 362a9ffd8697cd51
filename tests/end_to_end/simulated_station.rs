//! Stations tried without their instruments: `asphera simulate` plays the devices of a configuration, and `asphera run` measures.

use std::io::{Read as _, Write as _};
use std::net::{TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_tests::{Running, asphera, count, json, json_file, number, recording, root, run};
use serde_json::Value;

use crate::demo::timeless;

/// A configuration with its files beside it, for a test of its own: another folder for the recordings, another port for the page.
fn configuration(folder: &Path, name: &str) -> PathBuf {
    let text = std::fs::read_to_string(root().join(name)).unwrap();
    let mut document: toml_edit::DocumentMut = text.parse().unwrap();
    let recordings = folder.join("recordings").display().to_string();
    document["session"]["dir"] = toml_edit::value(recordings);
    document["publish"]["listen"] = toml_edit::value("127.0.0.1:0");
    document["station"]["autostart"] = toml_edit::value(true);
    document["scan"]["idle_s"] = toml_edit::value(idle_s(name));
    let files: toml_edit::Array = ["report.json"].into_iter().collect();
    document["output"]["files"] = toml_edit::value(files);
    let links = document["link"].as_table_like_mut().unwrap();
    let scanner = links.get_mut("scanner").and_then(toml_edit::Item::as_table_like_mut);
    if let Some(listen) = scanner.and_then(|scanner| scanner.get_mut("listen")) {
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        *listen = toml_edit::value(free.to_string());
    }
    if let Some(file) = document["nominal"].get("file").and_then(|file| file.as_str()) {
        let nominal = root().join(name).parent().unwrap().join(file);
        std::fs::copy(&nominal, folder.join(file)).unwrap();
    }
    let path = folder.join("mine.toml");
    std::fs::write(&path, document.to_string()).unwrap();
    path
}

/// Silence after which a scan is over. A companion that is silent before the scan lets the primary wait for 5 s.
fn idle_s(name: &str) -> f64 {
    if name.ends_with("can-transducers.toml") { 7.0 } else { 2.0 }
}

/// The simulated devices of a configuration.
pub(crate) struct Simulated {
    name: String,
    folder: tempfile::TempDir,
    _devices: Running,
}

impl Simulated {
    /// Simulates the devices of a configuration of this repository.
    pub(crate) fn start(name: &str, options: &[&str]) -> Simulated {
        Simulated::changed(name, options, &[])
    }

    /// The same with some text of the configuration replaced.
    fn changed(name: &str, options: &[&str], changes: &[(&str, &str)]) -> Simulated {
        let folder = tempfile::tempdir().unwrap();
        let mine = configuration(folder.path(), name);
        let mut text = std::fs::read_to_string(&mine).unwrap();
        for (from, to) in changes {
            assert!(text.contains(from), "{name}: {from}");
            text = text.replace(from, to);
        }
        std::fs::write(&mine, text).unwrap();
        let mut simulate = Command::new(asphera());
        simulate.arg("simulate").arg(&mine).arg("--station").arg(folder.path().join("try.toml"));
        let mut devices = Running::start(simulate.args(options));
        devices.line("simulating", Duration::from_secs(60));
        Simulated { name: name.to_owned(), folder, _devices: devices }
    }

    /// The configuration of a station that measures them.
    pub(crate) fn station(&self) -> PathBuf {
        self.folder.path().join("try.toml")
    }

    /// Changes that configuration.
    pub(crate) fn change(&self, change: impl FnOnce(&mut toml_edit::DocumentMut)) {
        let text = std::fs::read_to_string(self.station()).unwrap();
        let mut document = text.parse().unwrap();
        change(&mut document);
        std::fs::write(self.station(), document.to_string()).unwrap();
    }

    /// Measures once: exit code and report.
    pub(crate) fn measure(&self) -> (i32, Value) {
        self.measure_with(&[])
    }

    fn measure_with(&self, options: &[&str]) -> (i32, Value) {
        let mut run = Command::new(asphera());
        run.args(["run", "--once"]).args(options).arg("--config").arg(self.station());
        let output = Running::start(&mut run).wait(Duration::from_secs(240));
        let code = output.status.code().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!([0, 10, 11].contains(&code), "{}: {said}", self.name);
        let report = self.session().join("report.json");
        assert!(report.exists(), "{}: {said}", self.name);
        (code, json_file(&report))
    }

    /// Folder of the one session that was measured.
    pub(crate) fn session(&self) -> PathBuf {
        recording(&self.folder.path().join("recordings"))
    }
}

/// Simulates the devices of a configuration and measures once: exit code and report.
fn tried(name: &str, options: &[&str]) -> (i32, Value) {
    Simulated::start(name, options).measure()
}

/// The figures of a flawless part are those of rounding alone: what its devices cannot show, and nothing else.
#[test]
fn a_flawless_part_has_no_deviation_but_rounding() {
    let flawless = ["--form-nm", "0", "--noise-nm", "0", "--points", "3000", "--rate", "3000"];
    for (name, rounding_nm) in [
        // Text with all digits; what is left is that of adding in double precision.
        ("config/examples/described.toml", 0.01),
        // A telegram's distance has 24 bits: 0.3 nm at 5 mm, half of it either way.
        ("config/examples/om30-line.toml", 0.5),
        ("config/examples/ox200-line.toml", 0.5),
        ("config/asphera.toml", 0.6),
    ] {
        let (_, report) = tried(name, &flawless);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        assert!(pv_nm <= rounding_nm, "{name}: {pv_nm} nm");
        let (received, used) = (count(&report, "/points/received"), count(&report, "/points/used"));
        assert!(received >= 2800 && used + 5 >= received, "{name}: {used} of {received}");
    }
}

/// A part with form error has that form error, and passes where it should.
#[test]
fn examples_pass_as_they_stand() {
    for name in ["config/examples/om30-line.toml", "config/asphera.toml"] {
        let (code, report) =
            tried(name, &["--form-nm", "100", "--noise-nm", "0", "--rate", "4000"]);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        // The fit takes a share of the form error: piston, tilts, and power of the reference.
        assert!((40.0..=100.5).contains(&pv_nm), "{name}: {pv_nm} nm");
        assert_eq!(code, 0, "{name}: {}", report["verdict"]);
    }
}

/// Line scanners send profile by profile, a confocal line over TCP and a laser scanner over UDP.
#[test]
fn line_scanners_are_played_too() {
    for (name, step_nm) in [
        // 1 mm in 15 bits.
        ("config/examples/confocal-line.toml", 31.0),
        // 10 mm in 14 bits.
        ("config/examples/line-scanner.toml", 611.0),
        // Text with nine decimals.
        ("config/examples/profiles-from-a-pipe.toml", 0.01),
    ] {
        let (_, report) = tried(name, &["--form-nm", "0", "--noise-nm", "0", "--rate", "400"]);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        assert!(pv_nm <= step_nm, "{name}: {pv_nm} nm");
        let least = if name.contains("pipe") { 25_000 } else { 70_000 };
        assert!(count(&report, "/points/used") > least, "{name}: {}", report["points"]);
        let bent = ["--form-nm", "5000", "--noise-nm", "0", "--rate", "400"];
        let (_, report) = tried(name, &bent);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        // The fit takes piston and tilts.
        assert!((3500.0..=5000.0 + step_nm).contains(&pv_nm), "{name}: {pv_nm} nm");
    }
}

/// Laser sensors by count and by time, and a laser profiler on two ports: each example runs to its verdict, a flawless part shows the
/// steps of its sensor, and a form error is found.
#[test]
fn laser_sensors_and_profilers_are_played() {
    for (name, points, step_nm, places_nm) in [
        // 10.2 mm in 65520 steps.
        ("config/examples/laser-sensor.toml", "4000", 156.0, 0.0),
        // 10 mm in 16384 steps. Places come by time: 50 µm on a slope of some 1e-3 are 50 nm.
        ("config/examples/laser-sensor-by-time.toml", "500", 611.0, 50.0),
        // 0.08 µm.
        ("config/examples/laser-profiler.toml", "4000", 80.0, 0.0),
    ] {
        found(name, points, step_nm, places_nm);
    }
}

/// Two described transducers on a CAN bus, one with CAN FD.
#[test]
fn transducers_on_a_bus_are_played() {
    // 0.1 µm.
    found("config/examples/can-transducers.toml", "7000", 100.0, 0.0);
}

/// Measures an example twice, without and with form error.
fn found(name: &str, points: &str, step_nm: f64, places_nm: f64) {
    let flawless = ["--form-nm", "0", "--noise-nm", "0", "--points", points];
    let (_, report) = tried(name, &flawless);
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    // Rounding is half a step either way, and the fit may follow some of it.
    let steps_nm = 1.5 * step_nm + places_nm;
    assert!(pv_nm <= steps_nm, "{name}: {pv_nm} nm");
    let bent =
        Simulated::start(name, &["--form-nm", "9000", "--noise-nm", "0", "--points", points]);
    let (code, report) = bent.measure();
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    // The fit takes a share of the form error: piston and tilts, or the centre of the sphere.
    assert!((5000.0..=9000.0 + steps_nm).contains(&pv_nm), "{name}: {pv_nm} nm");
    // What is allowed: 250 nm on the bus, 12 µm and more elsewhere.
    let expected = if name.ends_with("can-transducers.toml") { 10 } else { 0 };
    assert_eq!(code, expected, "{name}: {}", report["verdict"]);
    let session = bent.session();
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!(timeless(replayed), timeless(report), "{name}: a replay gives the same");
}

/// An adapter that stamps its frames gives readings their times, and a replay has the same ones.
#[test]
fn an_adapter_may_stamp_the_frames() {
    let name = "config/examples/can-transducers.toml";
    let options = ["--form-nm", "100", "--noise-nm", "0", "--points", "7000"];
    let simulated = Simulated::start(name, &options);
    simulated.change(|station| station["link"]["bus"]["timestamps"] = toml_edit::value(true));
    let checked = run(["check".as_ref(), "--config".as_ref(), simulated.station().as_os_str()]);
    let words = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(words.contains("clock: adapter, which stamps each frame"), "{words}");
    let (_, report) = simulated.measure();
    assert_eq!(report["links"][0]["clock"], "adapter", "{:#}", report["links"]);
    assert_eq!(count(&report, "/links/0/discarded_bytes"), 0);
    assert!(count(&report, "/points/used") > 6900, "{:#}", report["points"]);
    let session = simulated.session();
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!(timeless(replayed), timeless(report));
}

/// The frames of the simulated bus as candump logs them are measured like the bus itself.
#[test]
fn a_log_of_the_simulated_bus_is_measured_too() {
    let options = ["--form-nm", "9000", "--noise-nm", "0", "--points", "2000"];
    let simulated = Simulated::start("config/examples/can-transducers.toml", &options);
    let log = simulated.station().with_file_name("bus.log");
    simulated.change(|station| {
        let address = station["link"]["bus"]["address"].as_str().unwrap().to_owned();
        std::fs::write(&log, candump(&slcan_lines(&address))).unwrap();
        let mut link = toml_edit::Table::new();
        link["kind"] = toml_edit::value("candump");
        link["file"] = toml_edit::value("bus.log");
        station["link"]["bus"] = toml_edit::Item::Table(link);
        // Nothing can be sent to a log.
        let gauge = station["device"]["gauge"]["settings"].as_table_like_mut().unwrap();
        gauge.remove("on_start");
        gauge.remove("on_stop");
    });
    let (_, report) = simulated.measure();
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    assert!((5000.0..=9150.0).contains(&pv_nm), "{pv_nm} nm");
    let (received, used) = (count(&report, "/points/received"), count(&report, "/points/used"));
    assert!(received >= 1900 && used + 5 >= received, "{used} of {received}");
    assert_eq!(count(&report, "/links/0/discarded_bytes"), 0);
}

/// Lines of frames that the gauge and the scale send once the gauge was started, with their stamps.
fn slcan_lines(address: &str) -> Vec<String> {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(3))).unwrap();
    stream.write_all(b"S6\rY2\rZ1\rO\rt605101\r").unwrap();
    let (mut bytes, mut text) = ([0; 4096], Vec::new());
    // The scan is over when nothing comes for a while.
    while let Ok(len @ 1..) = stream.read(&mut bytes) {
        text.extend_from_slice(&bytes[..len]);
    }
    let text = String::from_utf8(text).unwrap();
    text.split('\r').filter(|line| line.len() > 4).map(str::to_owned).collect()
}

/// The same as a log of candump: `(s) can0 185##1…` and `(s) can0 00FF1200#…`.
fn candump(lines: &[String]) -> String {
    let entry = |line: &String| {
        let (frame, stamp) = line.split_at(line.len() - 4);
        let seconds = f64::from(u32::from_str_radix(stamp, 16).unwrap()) / 1000.0;
        let frame = match frame.split_at(1) {
            ("b", frame) => format!("{}##1{}", &frame[..3], &frame[4..]),
            (_, frame) => format!("{}#{}", &frame[..8], &frame[9..]),
        };
        format!("({seconds:.6}) can0 {frame}\n")
    };
    lines.iter().map(entry).collect()
}

/// A probe that runs by its own clock: the scan ends by the number of its points.
#[test]
fn a_probe_by_its_own_clock_is_played() {
    let name = "config/examples/tilting-probe.toml";
    let changes = [
        ("sample_rate_hz = 4000", "sample_rate_hz = 4000\ntrigger = \"free\""),
        ("points = 500000\n", ""),
    ];
    let options = ["--form-nm", "0", "--noise-nm", "0", "--points", "2000"];
    let (_, report) = Simulated::changed(name, &options, &changes).measure();
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    assert!(pv_nm <= 0.6, "{pv_nm} nm");
    let used = count(&report, "/points/used");
    assert!((1900..=2100).contains(&used), "{:#}", report["points"]);
    assert_eq!(report["session"]["ended"], "complete");
}

/// Stations that move their axes or run a program themselves: the simulated devices obey, and the part is where they stand.
#[test]
fn stations_that_move_their_devices_are_played() {
    // Three lines without later passes.
    let fewer = [("adaptive = true", "adaptive = false")];
    let quick = ["--form-nm", "2000", "--noise-nm", "0"];
    for (name, options, changes) in [
        ("config/examples/drives.toml", &quick[..], &fewer[..]),
        (
            "config/examples/cmm.toml",
            &["--form-nm", "2000", "--noise-nm", "0", "--speed", "20"],
            &[],
        ),
    ] {
        let simulated = Simulated::changed(name, options, changes);
        let (_, report) = simulated.measure_with(&["--arm"]);
        assert_eq!(report["session"]["ended"], "complete", "{name}: {:#}", report["session"]);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        // The fit takes piston and tilts; the CMM rounds to 10 nm.
        assert!((900.0..=2015.0).contains(&pv_nm), "{name}: {pv_nm} nm");
        assert!(count(&report, "/points/used") > 60, "{name}: {}", report["points"]);
        let replayed =
            json(&run(["replay".as_ref(), simulated.session().as_os_str(), "--json".as_ref()]));
        assert_eq!(timeless(replayed), timeless(report), "{name}: a replay gives the same");
    }
}

/// What cannot be simulated is said with what would do.
#[test]
fn what_cannot_be_played_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for (name, (from, to), words) in [
        (
            "config/examples/tilting-probe.toml",
            ("sample_rate_hz = 4000", "sample_rate_hz = 4000\naveraging = 4"),
            "averaging = 1",
        ),
        ("config/examples/drives.toml", ("method = 17", "method = 1"), "17, 35 and 37"),
        (
            "config/examples/closed-loop.toml",
            ("offset_mm = -25 }\ny", "offset_mm = 25 }\ny"),
            "counts from 0 on",
        ),
        (
            "config/examples/shaft-scanner.toml",
            ("offset_mm = 12.5", "offset_mm = 99"),
            "offset_mm of [kinematics] height",
        ),
    ] {
        let mine = configuration(folder.path(), name);
        let text = std::fs::read_to_string(&mine).unwrap();
        assert!(text.contains(from), "{name}: {from}");
        std::fs::write(&mine, text.replace(from, to)).unwrap();
        let output = Command::new(asphera()).arg("simulate").arg(&mine).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && said.contains(words), "{name}: {said}");
    }
}

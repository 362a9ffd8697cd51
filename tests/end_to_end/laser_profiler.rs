//! A Keyence laser profiler over two TCP connections: profiles of a part on a stage, by the count of its encoder.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_rig::{ProfilerFault, ProfilerRig, ProfilerScene};
use asphera_tests::{Running, asphera, count, json, json_file, number, recording, root, run};
use serde_json::Value;

/// Profiles and points of each.
const PROFILES: u32 = 80;
const POINTS: u32 = 100;

/// The scene of the example, coarser and without noise.
fn scene() -> ProfilerScene {
    let path = root().join("simulators/rig/scenes/profiler.toml");
    let mut text = std::fs::read_to_string(path).unwrap();
    for (from, to) in [
        ("points = 400", "points = 100"),
        ("pitch_um = 50", "pitch_um = 200"),
        ("noise_um = 0.2", "noise_um = 0"),
        ("counts = 50", "counts = 250"),
        ("profiles = 400", "profiles = 80"),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    ProfilerScene::parse("profiler", &text).unwrap().unwrap().on_free_ports()
}

/// Points of the scan by the formulas of the maker, without those of the profiles that were lost: text of x, y and z in mm, with
/// all digits. x in steps of 10 nm, z in units of 80 nm. `lost` are triggers; `skipped` of them had no profile before the last.
fn points(scene: &ProfilerScene, lost: &[u32], skipped: u32) -> String {
    let mut text = String::from("x_mm,y_mm,z_mm\n");
    for profile in (0..PROFILES + skipped).filter(|profile| !lost.contains(profile)) {
        let y_mm = f64::from(250 * profile) * 0.001 - 10.0;
        for index in 0..POINTS {
            let x_mm = (f64::from(index) * 20_000.0 - 990_000.0) / 1e5;
            if let Some(z_mm) = scene.height_mm([x_mm, y_mm]) {
                let z_mm = (z_mm * 1e5 / 8.0).round() * 8.0 / 1e5;
                text += &format!("{x_mm:?},{y_mm:?},{z_mm:?}\n");
            }
        }
    }
    text
}

/// The example for these ports, coarser.
fn station(folder: &Path, rig: &ProfilerRig) -> PathBuf {
    let mut text =
        std::fs::read_to_string(root().join("config/examples/laser-profiler.toml")).unwrap();
    let [commands, stream] = rig.addresses();
    for (from, to) in [
        ("127.0.0.1:24691".to_owned(), commands.to_string()),
        ("second_port = 24692".to_owned(), format!("second_port = {}", stream.port())),
        ("gap_limit_mm = 0.3".to_owned(), "gap_limit_mm = 1".to_owned()),
        ("points = 400\nidle_s = 5".to_owned(), "idle_s = 2".to_owned()),
    ] {
        assert!(text.contains(&from), "{from}");
        text = text.replacen(&from, &to, 1);
    }
    text += &format!(
        "[session]\ndir = {:?}\n[publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        folder.join("recordings").display().to_string()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// One session with these faults: exit code, report and recording.
fn measured(folder: &Path, faults: &[(u32, ProfilerFault)]) -> (i32, Value, PathBuf) {
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(1).enable_all().build().unwrap();
    let rig = runtime.block_on(ProfilerRig::start(scene(), faults)).unwrap();
    let config = station(folder, &rig);
    let running =
        Running::start(Command::new(asphera()).args(["run", "--once", "--config"]).arg(&config));
    let output = running.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = recording(&folder.join("recordings"));
    let report = session.join("report.json");
    assert!(report.exists(), "{words}");
    (output.status.code().unwrap_or(-1), json_file(&report), session)
}

/// Figures of a file with the points, as the same daemon gives them.
fn of_file(folder: &Path, points: &str) -> Value {
    let path = folder.join("points.csv");
    std::fs::write(&path, points).unwrap();
    let nominal = folder.join("dome.toml");
    let text = "[surface]\nkind = \"sphere\"\nradius_mm = -60\n[aperture]\nshape = \"circle\"\nradius_mm = 8.9\n\
                [fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n[tolerance]\npv_nm = 12000\n[sampling]\ngap_limit_mm = 1\n";
    std::fs::write(&nominal, text).unwrap();
    let arguments = ["measure".as_ref(), path.as_os_str(), "--nominal".as_ref()];
    json(&run(arguments.into_iter().chain([nominal.as_os_str(), "--json".as_ref()])))
}

/// Figures of the form that are the same to a millionth of a nm.
fn assert_same_form(report: &Value, of_file: &Value) {
    for place in ["/form/deviation/pv_nm", "/form/deviation/rms_nm"] {
        let (found, expected) = (number(report, place), number(of_file, place));
        assert!((found - expected).abs() < 1e-6, "{place}: {found}, expected {expected}");
    }
    assert_eq!(count(report, "/points/used"), count(of_file, "/points/used"));
}

#[test]
fn profiles_of_two_connections_become_a_measured_part() {
    let folder = tempfile::tempdir().unwrap();
    let (code, report, session) = measured(folder.path(), &[]);
    assert_eq!(code, 0, "{report:#}");
    assert_same_form(&report, &of_file(folder.path(), &points(&scene(), &[], 0)));
    // Heights are 20 bits of 80 nm, and the astigmatism and coma of the scene stay: 1500 nm and 800 nm at the edge.
    let pv_nm = number(&report, "/form/deviation/pv_nm");
    assert!((2000.0..9000.0).contains(&pv_nm), "{pv_nm}");
    let device = &report["links"][0]["devices"][0];
    assert_eq!(count(device, "/readings"), u64::from(PROFILES));
    assert_eq!(count(&report, "/points/received"), u64::from(PROFILES * POINTS));
    assert_eq!(count(&report, "/points/lost"), 0);
    // Beside the dome there is no peak, and no other reason.
    let without = count(&report, "/points/flagged/no_signal") as f64;
    assert_eq!(number(device, "/channels/no_peak/mean"), without / f64::from(PROFILES));
    assert_eq!(number(device, "/channels/dead_zone/max"), 0.0);
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!((&replayed["form"], &replayed["links"]), (&report["form"], &report["links"]));
    let played = run(["simulate".as_ref(), "--session".as_ref(), session.as_os_str()]);
    let words = String::from_utf8_lossy(&played.stderr).into_owned();
    assert!(words.contains("two connections of profiler, which cannot be played"), "{words}");
}

#[test]
fn faults_of_stream_and_controller_cost_what_they_must() {
    let folder = tempfile::tempdir().unwrap();
    let faults = [
        (10, ProfilerFault::BadSum),
        (20, ProfilerFault::Lost(3)),
        (30, ProfilerFault::Stop(2)),
        (40, ProfilerFault::Unplug),
    ];
    let (_, report, session) = measured(folder.path(), &faults);
    // Where no profile comes after a loss of the link, nobody knows how many were missed: here none.
    let expected = points(&scene(), &[10, 20, 21, 22], 3);
    assert_same_form(&report, &of_file(folder.path(), &expected));
    let link = &report["links"][0];
    assert_eq!((count(link, "/opened"), count(link, "/closed")), (2, 1));
    // The profile with the wrong sum: 24 bytes, 100 points of 20 bits filled up to a u32, its sum.
    assert_eq!(count(link, "/discarded_bytes"), 24 + 252 + 4);
    assert_eq!(count(link, "/devices/0/readings"), u64::from(PROFILES) - 1);
    assert_eq!(count(link, "/devices/0/lost"), 4);
    // The wrong sum and two gaps; the stop.
    assert_eq!(count(link, "/devices/0/faults/protocol"), 3);
    assert_eq!(count(link, "/devices/0/faults/device"), 1);
    let reasons = report["verdict"]["reasons"].to_string();
    assert!(reasons.contains("profiler: 4 triggers were lost"), "{reasons}");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!((&replayed["form"], &replayed["links"]), (&report["form"], &report["links"]));
}

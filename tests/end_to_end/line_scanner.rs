//! A line scanner over UDP: profiles of a part on a stage, on a network that loses, repeats and mixes datagrams.

use std::io::Write as _;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_sim_rf627::{Fault, Optics, Part, Scan, Scanner, send};
use asphera_tests::{Running, asphera, count, json, json_file, number, recording, run, wait_for};

const PART: Part =
    Part { radius_mm: Some(40.0), wave_um: 5.0, wave_length_mm: 4.0, half_width_mm: 4.8 };

const SCAN: Scan = Scan { part: PART, first_y_mm: -5.0, steps: 4, step_mm: 0.04, profiles: 64 };

/// The axis of [`SCAN`].
const LINEAR: &str =
    "along = { device = \"scanner\", channel = \"step\", mm_per_count = 0.04, offset_mm = -5 }";

/// A cap that turns about its own axis: every profile is the one through the centre.
const TURNED: Scan =
    Scan { part: Part { wave_um: 0.0, ..PART }, first_y_mm: 0.0, step_mm: 0.0, ..SCAN };

/// The axis of [`TURNED`]: half a turn in all, for a profile reaches over the centre.
const ROTARY: &str = "profile = \"radial\"\n\
                      rotary = { device = \"scanner\", channel = \"step\", counts_per_turn = 512 }";

fn optics() -> Optics {
    Optics { points: 80, ..Optics::default() }
}

/// Points of the scan by the formulas of the maker, without those of the profiles that were lost: text of x, y and z in mm,
/// with all digits. A step is 11 mm / 16384 in x and 10 mm / 16384 in z.
fn points(lost: &[u32]) -> String {
    points_of(&SCAN, lost, |steps, x_mm| [x_mm, steps * 0.04 - 5.0])
}

/// The same of any scan, whose places follow from steps and x.
fn points_of(scan: &Scan, lost: &[u32], place_mm: impl Fn(f64, f64) -> [f64; 2]) -> String {
    let round = |value_mm: f64, range_mm: f64| {
        (value_mm / range_mm * 16_384.0).round() * range_mm / 16_384.0
    };
    let mut text = String::from("x_mm,y_mm,z_mm\n");
    for profile in (0..64).filter(|profile| !lost.contains(profile)) {
        let steps = f64::from(4 * profile);
        let over_mm = scan.first_y_mm + steps * scan.step_mm;
        for index in 0..80 {
            let x_mm = round(((f64::from(index) + 0.5) / 80.0 - 0.5) * 10.0, 11.0);
            if let Some(z_mm) = scan.part.height_mm(x_mm, over_mm) {
                let [x_mm, y_mm] = place_mm(steps, x_mm);
                let z_mm = 5.0 - round(5.0 - z_mm, 10.0);
                text += &format!("{x_mm:?},{y_mm:?},{z_mm:?}\n");
            }
        }
    }
    text
}

fn nominal(folder: &Path) -> PathBuf {
    let path = folder.join("sphere.toml");
    let text = "[surface]\nkind = \"sphere\"\nradius_mm = 40\n[fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n\
                [tolerance]\npv_nm = 20000\nrms_nm = 4000\n";
    std::fs::write(&path, text).unwrap();
    path
}

fn station(folder: &Path, listen: &str, axis: &str) -> PathBuf {
    nominal(folder);
    let text = format!(
        "[station]\nname = \"scanner\"\n[link.scanner]\nkind = \"udp\"\nlisten = \"{listen}\"\n\
         [device.scanner]\ndriver = \"rf627\"\nlink = \"scanner\"\n\
         [device.scanner.settings]\nreorder_ms = 50\n\
         [sync]\ndevices = [\"scanner\"]\n[kinematics]\nkind = \"line\"\n\
         across = {{ device = \"scanner\" }}\nheight = {{ offset_mm = 5, reverse = true }}\n\
         {axis}\n\
         [nominal]\nfile = \"sphere.toml\"\n[scan]\nidle_s = 2\n[session]\ndir = {:?}\n\
         [publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        folder.join("recordings").display().to_string()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// One session with these faults: exit code, report and recording.
fn measured(folder: &Path, faults: &[(u32, Fault)]) -> (i32, serde_json::Value, PathBuf) {
    measured_by(folder, (&SCAN, LINEAR), faults)
}

/// The same of any scan, by an axis.
fn measured_by(
    folder: &Path,
    (scan, axis): (&Scan, &str),
    faults: &[(u32, Fault)],
) -> (i32, serde_json::Value, PathBuf) {
    let free = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = free.local_addr().unwrap();
    drop(free);
    let config = station(folder, &address.to_string(), axis);
    let running =
        Running::start(Command::new(asphera()).args(["run", "--once", "--config"]).arg(&config));
    // The port is taken when the session has begun.
    wait_for("session", Duration::from_secs(60), || {
        UdpSocket::bind(address).err().ok_or("nobody listens at the port")
    });
    let departures = scan.departures(&mut Scanner::new(optics(), 1), faults, 3).unwrap();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(send(&departures, address)).unwrap();
    let output = running.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = recording(&folder.join("recordings"));
    let report = session.join("report.json");
    assert!(report.exists(), "{words}");
    (output.status.code().unwrap_or(-1), json_file(&report), session)
}

/// Figures of a file with the points, as the same daemon gives them.
fn of_file(folder: &Path, points: &str) -> serde_json::Value {
    let path = folder.join("points.csv");
    std::fs::File::create(&path).unwrap().write_all(points.as_bytes()).unwrap();
    let nominal = nominal(folder);
    json(&run([
        "measure".as_ref(),
        path.as_os_str(),
        "--nominal".as_ref(),
        nominal.as_os_str(),
        "--json".as_ref(),
    ]))
}

/// Figures of the form that are the same to a millionth of a nm.
fn assert_same_form(report: &serde_json::Value, of_file: &serde_json::Value) {
    for place in ["/form/deviation/pv_nm", "/form/deviation/rms_nm"] {
        let (found, expected) = (number(report, place), number(of_file, place));
        assert!((found - expected).abs() < 1e-6, "{place}: {found}, expected {expected}");
    }
    assert_eq!(count(report, "/points/used"), count(of_file, "/points/used"));
}

#[test]
fn profiles_become_a_measured_part() {
    let folder = tempfile::tempdir().unwrap();
    let (code, report, session) = measured(folder.path(), &[]);
    assert_eq!(code, 0, "{report:#}");
    assert_same_form(&report, &of_file(folder.path(), &points(&[])));
    // The waves' rms is half their amplitude, and a step of z has 0.18 µm.
    let rms_nm = number(&report, "/form/deviation/rms_nm");
    assert!((rms_nm - 2500.0).abs() < 150.0, "{rms_nm}");
    assert_eq!(count(&report, "/links/0/devices/0/readings"), 64);
    // A point in 25 is beside the part on each side.
    assert_eq!(count(&report, "/points/received"), 64 * 80);
    assert_eq!(count(&report, "/points/flagged/no_signal"), 64 * 4);
    assert_eq!(count(&report, "/points/lost"), 0);
    let replayed = run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]);
    assert_eq!(json(&replayed)["form"], report["form"], "a replay gives the same figures");
    let played = run(["simulate".as_ref(), "--session".as_ref(), session.as_os_str()]);
    let words = String::from_utf8_lossy(&played.stderr).into_owned();
    assert!(words.contains("datagrams of scanner, which cannot be played"), "{words}");
}

/// Places follow from the angle here by formulas of their own.
#[test]
fn a_part_that_turns_under_a_profile_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let (code, report, session) = measured_by(folder.path(), (&TURNED, ROTARY), &[]);
    assert_eq!(code, 0, "{report:#}");
    let turned = points_of(&TURNED, &[], |steps, x_mm| {
        let angle_rad = steps / 512.0 * std::f64::consts::TAU;
        [x_mm * angle_rad.cos(), x_mm * angle_rad.sin()]
    });
    assert_same_form(&report, &of_file(folder.path(), &turned));
    // The cap is a sphere but for the steps of z, which have 0.6 µm.
    let rms_nm = number(&report, "/form/deviation/rms_nm");
    assert!(rms_nm < 400.0, "{rms_nm}");
    assert_eq!(count(&report, "/points/flagged/no_signal"), 64 * 4);
    let replayed = run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]);
    assert_eq!(json(&replayed)["form"], report["form"], "a replay gives the same figures");
}

#[test]
fn a_bad_network_costs_what_it_lost_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let faults = [
        (10, Fault::Lose),
        (20, Fault::Repeat),
        (30, Fault::Swap),
        (40, Fault::Garbage(700)),
        (45, Fault::Cut(100)),
        (50, Fault::Silence(700)),
    ];
    let (_, report, session) = measured(folder.path(), &faults);
    assert_same_form(&report, &of_file(folder.path(), &points(&[10, 45])));
    assert_eq!(count(&report, "/points/lost"), 2);
    let link = &report["links"][0];
    // Garbage, a cut profile, a copy of one with 80 points.
    assert_eq!(count(link, "/discarded_bytes"), 700 + 100 + 64 + 320);
    assert_eq!(count(link, "/devices/0/readings"), 62);
    assert_eq!(count(link, "/devices/0/lost"), 2);
    // Two losses, one copy, one in the wrong place, garbage and the cut one.
    assert_eq!(count(link, "/devices/0/faults/protocol"), 6);
    let reasons = report["verdict"]["reasons"].to_string();
    assert!(reasons.contains("scanner: 2 triggers were lost"), "{reasons}");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    assert_eq!((&replayed["form"], &replayed["links"]), (&report["form"], &report["links"]));
}

#[test]
fn profiles_after_a_restart_of_the_scanner_are_not_used() {
    let folder = tempfile::tempdir().unwrap();
    let (code, report, _) = measured(folder.path(), &[(50, Fault::Restart)]);
    assert_ne!(code, 1, "{report:#}");
    assert_same_form(&report, &of_file(folder.path(), &points(&(50..64).collect::<Vec<_>>())));
    assert_eq!(count(&report, "/points/flagged/ambiguous_count"), 14 * 80);
    assert_eq!(count(&report, "/links/0/devices/0/faults/device"), 1);
    assert_eq!(count(&report, "/points/lost"), 0);
}

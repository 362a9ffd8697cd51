//! Line profiles from a program of one's own: through a FIFO, a file, a growing file, and the standard input.

use std::fs::OpenOptions;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{
    Running, asphera, count, http, json, json_file, number, page, recording, root, run,
};
use serde_json::Value;

/// Profiles, and points of each: steps of 0.1 mm both ways.
const SIDE: u32 = 181;
const RADIUS_MM: f64 = 60.0;
/// Astigmatism: the part lies this much times x² - y² above its sphere, per mm.
const ASTIGMATISM: f64 = 5e-6;
/// PV of the astigmatism on the points within the aperture, whose last on each axis lies at 8.9 mm.
const PV_NM: f64 = 2.0 * ASTIGMATISM * 8.9 * 8.9 * 1e6;

/// A profile as the program writes it, heights to 0.1 nm. The deviation is along the normals of the sphere, and a fit of its
/// place leaves it as it is: it is odd under an exchange of x and y.
fn line(n: u32) -> String {
    let y_um = i64::from(n) * 100 - 9000;
    let y_mm = y_um as f64 * 1e-3;
    let mut text = format!("{n},{y_um}");
    for index in 0..SIDE {
        let x_mm = -9.0 + 0.1 * f64::from(index);
        let radius_mm = RADIUS_MM - ASTIGMATISM * (x_mm * x_mm - y_mm * y_mm);
        let z_mm = RADIUS_MM - (radius_mm * radius_mm - x_mm * x_mm - y_mm * y_mm).sqrt();
        // Nothing is measured in a corner outside the aperture.
        text += &if n == 0 && index < 3 { ",nan".to_owned() } else { format!(",{z_mm:.7}") };
    }
    text + "\n"
}

fn lines(profiles: std::ops::Range<u32>) -> String {
    profiles.map(line).collect()
}

/// The example, with its link as `link`, after these replacements.
fn station(folder: &Path, link: &str, replacements: &[(&str, &str)]) -> PathBuf {
    let path = root().join("config/examples/profiles-from-a-pipe.toml");
    let mut text = std::fs::read_to_string(path).unwrap();
    let all = [&[("path = \"profiles.fifo\"", link)][..], replacements].concat();
    for (from, to) in all {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    text += &format!(
        "[session]\ndir = {:?}\n[publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        folder.join("recordings").display().to_string()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    path
}

fn fifo(folder: &Path) -> PathBuf {
    let path = folder.join("profiles.fifo");
    assert!(Command::new("mkfifo").arg(&path).status().unwrap().success());
    path
}

fn once(config: &Path) -> Command {
    let mut command = Command::new(asphera());
    command.args(["run", "--once", "--config"]).arg(config);
    command
}

fn report_of(folder: &Path, words: &[u8]) -> (Value, PathBuf) {
    let session = recording(&folder.join("recordings"));
    let report = session.join("report.json");
    assert!(report.exists(), "{}", String::from_utf8_lossy(words));
    (json_file(&report), session)
}

/// All points came, the form is that of the part to 1 nm, and a replay says the same.
fn assert_measured(report: &Value, session: &Path) {
    let points = u64::from(SIDE * SIDE);
    assert_eq!(count(report, "/points/received"), points, "{:#}", report["points"]);
    assert_eq!(count(report, "/points/flagged/no_signal"), 3);
    assert_eq!(count(report, "/points/lost"), 0);
    let pv_nm = number(report, "/form/deviation/pv_nm");
    assert!((pv_nm - PV_NM).abs() < 1.0, "{pv_nm} nm, expected {PV_NM} nm");
    let replayed = json(&run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]));
    for key in ["form", "points", "links", "verdict"] {
        assert_eq!(replayed[key], report[key], "{key}");
    }
}

#[test]
fn profiles_through_a_fifo_become_a_measured_part() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = fifo(folder.path());
    let config = station(folder.path(), "path = \"profiles.fifo\"", &[]);
    let running = Running::start(&mut once(&config));
    let program = std::thread::spawn(move || {
        let mut pipe = OpenOptions::new().write(true).open(pipe).unwrap();
        for n in 0..SIDE {
            pipe.write_all(line(n).as_bytes()).unwrap();
        }
    });
    let output = running.wait(Duration::from_secs(120));
    program.join().unwrap();
    let (report, session) = report_of(folder.path(), &output.stderr);
    assert_eq!(output.status.code(), Some(0), "{report:#}");
    assert_measured(&report, &session);
    assert_eq!(count(&report, "/links/0/discarded_bytes"), 0);
}

/// The program dies in the middle of a line and is started again at the profile that was cut.
#[test]
fn a_program_that_dies_and_comes_back_loses_half_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = fifo(folder.path());
    let config = station(folder.path(), "path = \"profiles.fifo\"", &[]);
    let mut daemon = Running::start(
        Command::new(asphera()).args(["run", "--config"]).arg(&config).stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    let open = || OpenOptions::new().write(true).open(&pipe).unwrap();
    let half = &line(90)[..500];
    open().write_all((lines(0..90) + half).as_bytes()).unwrap();
    daemon.line("closed it: start it again", Duration::from_secs(60));
    // It stays until the end: its own end would be the last that is said of the link.
    let mut again = open();
    again.write_all(lines(90..SIDE).as_bytes()).unwrap();
    daemon.line("recording:", Duration::from_secs(60));
    let (report, session) = report_of(folder.path(), b"");
    assert_measured(&report, &session);
    let link = &report["links"][0];
    assert_eq!((count(link, "/opened"), count(link, "/discarded_bytes")), (2, 500), "{link:#}");
    let (_, body) = http(&address, "GET", "/api/v1/links", &[]);
    let links = String::from_utf8(body).unwrap();
    let words = "its last 500 bytes are no whole record: let the program end its last line";
    assert!(links.contains(words), "{links}");
}

/// A finished file is read at once, and ends as a log does; a session ends with its last profile.
#[test]
fn profiles_of_a_file_need_no_program() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("scan.csv"), lines(0..SIDE)).unwrap();
    let more = [("points = 181\nidle_s = 5", "idle_s = 1")];
    let config = station(folder.path(), "path = \"scan.csv\"", &more);
    let output = Running::start(&mut once(&config)).wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("scan.csv was read to its end"), "{words}");
    let (report, session) = report_of(folder.path(), &output.stderr);
    assert_measured(&report, &session);
    let link = &report["links"][0];
    assert_eq!((count(link, "/opened"), count(link, "/closed")), (1, 1), "{link:#}");
    // The recording needs the file no more, and plays as a station of its own.
    let played = run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]);
    assert_eq!(json(&played)["points"], report["points"]);
}

/// A program appends to a file; then it empties it by mistake, and begins again.
#[test]
fn a_growing_file_that_is_truncated_is_said_and_read_anew() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scan.csv");
    std::fs::write(&file, "of another scan\n").unwrap();
    let link = "path = \"scan.csv\"\nfollow = true";
    let config = station(folder.path(), link, &[]);
    let mut daemon = Running::start(&mut once(&config));
    daemon.line("page:", Duration::from_secs(60));
    // Opened at its end: what is written from now on counts. Whether it is open the daemon does not say before that.
    std::thread::park_timeout(Duration::from_millis(500));
    let append = |text: &str| {
        let mut file = OpenOptions::new().append(true).open(&file).unwrap();
        file.write_all(text.as_bytes()).unwrap();
    };
    append(&lines(0..100));
    // What was written before is read before: the daemon looks twenty times a second.
    std::thread::park_timeout(Duration::from_secs(1));
    OpenOptions::new().write(true).open(&file).unwrap().set_len(0).unwrap();
    let words = daemon.line("was truncated from", Duration::from_secs(60));
    assert!(words.contains("to 0 bytes: reading begins anew"), "{words}");
    append(&lines(100..SIDE));
    let output = daemon.wait(Duration::from_secs(120));
    let (report, session) = report_of(folder.path(), &output.stderr);
    assert_measured(&report, &session);
}

#[test]
fn profiles_of_the_standard_input_end_with_their_program() {
    let folder = tempfile::tempdir().unwrap();
    let more = [("points = 181\nidle_s = 5", "idle_s = 1")];
    let config = station(folder.path(), "path = \"-\"", &more);
    let mut daemon = once(&config)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    daemon.stdin.take().unwrap().write_all(lines(0..SIDE).as_bytes()).unwrap();
    let output = daemon.wait_with_output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(words.contains("the program that wrote to standard input ended"), "{words}");
    let (report, session) = report_of(folder.path(), &output.stderr);
    assert_measured(&report, &session);
}

#[test]
fn a_missing_file_and_a_folder_are_said_with_their_cure() {
    let folder = tempfile::tempdir().unwrap();
    let more = [("points = 181\nidle_s = 5", "points = 181\nopen_s = 1")];
    for (path, words) in [
        ("path = \"none.fifo\"", "or make a FIFO with `mkfifo`"),
        ("path = \".\"", "name a file in this folder"),
    ] {
        let config = station(folder.path(), path, &more);
        let mut daemon = Running::start(&mut once(&config));
        daemon.line(words, Duration::from_secs(60));
        daemon.wait(Duration::from_secs(60));
    }
}

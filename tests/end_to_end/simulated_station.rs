//! Stations tried without their instruments: `asphera simulate` plays the devices of a configuration, and `asphera run` measures.

use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_tests::{Running, asphera, count, json_file, number, recording, root};
use serde_json::Value;

/// A configuration with its files beside it, for a test of its own: another folder for the recordings, another port for the page.
fn configuration(folder: &Path, name: &str) -> PathBuf {
    let text = std::fs::read_to_string(root().join(name)).unwrap();
    let mut document: toml_edit::DocumentMut = text.parse().unwrap();
    let recordings = folder.join("recordings").display().to_string();
    document["session"]["dir"] = toml_edit::value(recordings);
    document["publish"]["listen"] = toml_edit::value("127.0.0.1:0");
    document["station"]["autostart"] = toml_edit::value(true);
    document["scan"]["idle_s"] = toml_edit::value(2.0);
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

/// Simulates the devices of a configuration and measures once: exit code and report.
fn tried(name: &str, options: &[&str]) -> (i32, Value) {
    let folder = tempfile::tempdir().unwrap();
    let mine = configuration(folder.path(), name);
    let there = folder.path().join("try.toml");
    let mut simulate = Command::new(asphera());
    simulate.arg("simulate").arg(&mine).arg("--station").arg(&there).args(options);
    let mut simulating = Running::start(&mut simulate);
    simulating.line("simulating", Duration::from_secs(60));
    let running =
        Running::start(Command::new(asphera()).args(["run", "--once", "--config"]).arg(&there));
    let output = running.wait(Duration::from_secs(240));
    let code = output.status.code().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!([0, 10, 11].contains(&code), "{name}: {said}");
    let report = recording(&folder.path().join("recordings")).join("report.json");
    assert!(report.exists(), "{name}: {said}");
    (code, json_file(&report))
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
    ] {
        let (_, report) = tried(name, &["--form-nm", "0", "--noise-nm", "0", "--rate", "400"]);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        assert!(pv_nm <= step_nm, "{name}: {pv_nm} nm");
        assert!(count(&report, "/points/used") > 70_000, "{name}: {}", report["points"]);
        let bent = ["--form-nm", "5000", "--noise-nm", "0", "--rate", "400"];
        let (_, report) = tried(name, &bent);
        let pv_nm = number(&report, "/form/deviation/pv_nm");
        // The fit takes piston and tilts.
        assert!((3500.0..=5000.0 + step_nm).contains(&pv_nm), "{name}: {pv_nm} nm");
    }
}

/// What cannot be simulated is said with the device's name and what would do.
#[test]
fn what_cannot_be_played_is_named() {
    for (name, words) in [
        ("config/examples/closed-loop.toml", "moves its devices itself"),
        ("config/examples/laser-profiler.toml", "device profiler"),
    ] {
        let output =
            Command::new(asphera()).arg("simulate").arg(root().join(name)).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && said.contains(words), "{name}: {said}");
    }
}

//! A tray of lenses under a line scanner: its parts are found, recognised and measured while the scan goes on.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, count, json, json_file, number, recording, run};
use serde_json::Value;

use crate::demo::{replayed, timeless};

/// The report of a tray, and its truth.
fn measured(folder: &Path, seed: &str) -> [Value; 2] {
    let daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--scene", "tray", "--exit", "--speed", "8", "--seed", seed, "--out"])
            .arg(folder)
            .stdout(Stdio::null()),
    );
    let output = daemon.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let report = json_file(&folder.join("report.json"));
    assert_eq!(output.status.code(), Some(0), "{words}\n{:#}", report["verdict"]);
    [report, json_file(&folder.join("truth.json"))]
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap()
}

fn place(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| value[axis].as_f64().unwrap())
}

fn apart_mm(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[test]
fn every_part_is_what_it_is_while_the_scan_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let [report, truth] = measured(folder.path(), "1");
    let found = &report["parts"];
    assert_eq!((list(found, "parts").len(), list(&truth, "parts").len()), (8, 8), "{found:#}");
    assert_eq!((count(found, "/open"), count(found, "/waiting"), count(found, "/late")), (0, 0, 0));
    for part in list(&truth, "parts") {
        let at = place(&part["place_mm"]);
        let near = |other: &&Value| apart_mm(place(&other["form"]["place_mm"]), at) < 0.5;
        let twin = list(found, "parts").iter().find(near).unwrap();
        assert_eq!(twin["match"]["verdict"], "confirmed", "{twin:#}");
        assert_eq!(twin["match"]["name"], format!("{}.toml", part["name"].as_str().unwrap()));
        assert_eq!(twin["loops"], part["loops"], "{twin:#}");
        let [rms_nm, u_nm, true_nm] = [
            number(twin, "/form/rms_without_noise_nm"),
            number(twin, "/form/u_rms_nm"),
            number(part, "/rms_nm"),
        ];
        // The truth is of other places of the same face.
        let off_nm = (rms_nm - true_nm).abs();
        assert!(
            off_nm < 3.0 * u_nm + 0.03 * true_nm,
            "{rms_nm} ± {u_nm} nm for {true_nm} nm: {part:#}"
        );
    }
    // The gaps between them are no form, and nothing is to be measured there.
    assert!(report["form"].is_null() && report["sampling"]["coverage"].is_null(), "{report:#}");
    assert!(report["sampling"]["next"].as_array().is_none_or(Vec::is_empty), "{report:#}");
    let pass = "all 8 parts hold the limits of their nominals";
    assert_eq!(report["verdict"]["reasons"], serde_json::json!([pass]));
    // What ends on the way is measured on the way: only the last row of parts is there until the end.
    let open = list(found, "parts").iter().filter(|part| part["is_open"] == true).count();
    assert!(open < 8, "{found:#}");
    let events = list(found, "events");
    let of = |word: &str| events.iter().filter(|event| event["event"] == word).count();
    assert!(of("begun") >= 7 && of("ended") >= 7, "{events:?}");

    // The same session as a whole, by the command for files.
    let session = recording(folder.path());
    let library = folder.path().join("library");
    let tau = number(found, "/tau_mm").to_string();
    let whole = json(&run([
        "parts".as_ref(),
        session.as_os_str(),
        "--library".as_ref(),
        library.as_os_str(),
        "--tau".as_ref(),
        tau.as_ref(),
        "--measure".as_ref(),
        "--json".as_ref(),
    ]));
    assert_eq!(list(&whole, "parts").len(), 8);
    for part in list(&whole, "parts") {
        let at = place(&part["centre_mm"]);
        let near = |other: &&Value| apart_mm(place(&other["centre_mm"]), at) < 1e-9;
        let twin = list(found, "parts").iter().find(near).unwrap();
        assert_eq!(
            (&twin["points"], &twin["box_mm"], &twin["loops"], &twin["match"]["name"]),
            (&part["points"], &part["box_mm"], &part["loops"], &part["match"]["name"])
        );
        for key in ["/form/pv_nm", "/form/rms_nm", "/form/u_rms_nm"] {
            let [a, b] = [number(twin, key), number(part, key)];
            assert!((a - b).abs() <= 1e-3 * a.abs(), "{key}: {a} and {b}");
        }
    }
    assert_eq!(timeless(replayed(folder.path())), timeless(report));
}

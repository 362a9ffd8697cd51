//! The API of a running station: snapshots, mesh, links, start and stop.

use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, http, page, post, python};
use futures_util::StreamExt as _;
use serde_json::Value;
use tokio_tungstenite::tungstenite::Message;

fn get(address: &str, path: &str) -> Value {
    let (status, body) = http(address, "GET", path, &[]);
    assert_eq!(status, 200, "{path}: {}", String::from_utf8_lossy(&body));
    serde_json::from_slice(&body).unwrap()
}

/// Asks until a snapshot is as wanted.
pub(crate) fn until(address: &str, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
    asphera_tests::until(address, what, Duration::from_secs(30), wanted)
}

/// Starts a demo whose page stays, and waits for the end of its first session.
fn finished_demo(out: &std::path::Path) -> (Running, String, String) {
    let mut daemon = Running::start(
        Command::new(asphera())
            .args([
                "demo",
                "--points",
                "3000",
                "--speed",
                "max",
                "--listen",
                "127.0.0.1:0",
                "--out",
            ])
            .arg(out)
            .stdout(Stdio::null()),
    );
    let (address, token) = page(&daemon.line("page:", Duration::from_secs(60)));
    until(&address, "complete", |snapshot| snapshot["outputs"].is_object());
    (daemon, address, token)
}

#[test]
fn a_demo_measures_again_and_again_and_earlier_results_stay() {
    let out = tempfile::tempdir().unwrap();
    let (_daemon, address, token) = finished_demo(out.path());
    let bearer = format!("Bearer {token}");
    let first = get(&address, "/api/v1/report");
    let label = r#"{"part": "lens 7", "serial": "0815", "operator": "W"}"#;
    let (status, body) = post(&address, "/api/v1/session/start", &bearer, label);
    assert_eq!(status, 204, "{}", String::from_utf8_lossy(&body));
    let again = until(&address, "complete again", |snapshot| {
        snapshot["outputs"].is_object() && snapshot["session"]["id"] != first["session"]["id"]
    });
    assert_eq!(again["form"], get(&address, "/api/v1/report")["form"]);
    for figure in ["form", "mesh", "points"] {
        assert_eq!(again[figure], first[figure], "the same part by the same scan");
    }
    assert_eq!(again["outputs"]["files"], serde_json::json!(["report.json", "report.html"]));

    let listed = get(&address, "/api/v1/sessions")["sessions"].clone();
    let ids: Vec<_> = listed.as_array().unwrap().iter().map(|entry| entry["id"].clone()).collect();
    assert_eq!(ids.len(), 2, "{listed:#}");
    assert!(ids.contains(&first["session"]["id"]) && ids.contains(&again["session"]["id"]));
    let newest =
        listed.as_array().unwrap().iter().find(|entry| entry["id"] == again["session"]["id"]);
    assert_eq!(newest.unwrap()["label"]["serial"], "0815");
    assert_eq!(newest.unwrap()["verdict"], again["verdict"]["status"]);
    for id in ids {
        let path = format!("/api/v1/sessions/{}/report.html", id.as_str().unwrap());
        let (status, html) = http(&address, "GET", &path, &[]);
        let html = String::from_utf8(html).unwrap();
        assert_eq!(status, 200);
        assert_eq!(html.contains("lens 7, no. 0815"), id == again["session"]["id"]);
    }
    // The recording has the label, too.
    let folder = out.path().join(again["session"]["id"].as_str().unwrap());
    let replayed = asphera_tests::run(["replay", folder.to_str().unwrap(), "--json"]);
    assert_eq!(asphera_tests::json(&replayed)["session"], again["session"]);
}

#[test]
fn a_station_is_watched_stopped_and_started_again() {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--points", "200000", "--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let (address, token) = page(&daemon.line("page:", Duration::from_secs(60)));
    let snapshot = until(&address, "measuring with a fit and a mesh", |snapshot| {
        snapshot["state"] == "measuring"
            && snapshot["form"].is_object()
            && snapshot["map"].is_object()
            && snapshot["mesh"]["triangles"].as_u64() > Some(0)
    });
    assert_eq!(snapshot["form"]["provisional"], true);
    assert_eq!(snapshot["verdict"]["status"], "undecided");
    let links = get(&address, "/api/v1/links");
    assert!(links.to_string().contains("connected"), "{links:#}");
    let (status, ply) = http(&address, "GET", "/api/v1/mesh.ply", &[]);
    assert_eq!(status, 200);
    assert!(ply.starts_with(b"ply\nformat binary_little_endian 1.0\n"));

    let section = get(&address, "/api/v1/section?radius=30");
    assert_eq!(section["format"], "asphera.section/1");
    assert!(section["deviation"]["pv_nm"].as_f64().is_some_and(|pv_nm| pv_nm > 0.0), "{section:#}");
    let maps = until(&address, "mapped", |snapshot| snapshot["maps"].is_object())["maps"].clone();
    let found = get(&address, "/api/v1/maps");
    assert_eq!(found["format"], "asphera.maps/1");
    assert!(found["version"].as_u64() >= maps["version"].as_u64());
    assert!(found["gap_mm"]["values"].as_array().unwrap().iter().any(Value::is_number));
    let (status, problem) = http(&address, "GET", "/api/v1/section?line=0,0,0,0", &[]);
    assert_eq!(status, 400);
    assert!(String::from_utf8_lossy(&problem).contains("no length"));

    let bearer = format!("Bearer {token}");
    let stop = "/api/v1/session/stop";
    assert_eq!(http(&address, "POST", stop, &[]).0, 401);
    assert_eq!(
        http(&address, "POST", stop, &[("Authorization", "Bearer guessed-guessed-guessed")]).0,
        403
    );
    let foreign = [("Authorization", bearer.as_str()), ("Origin", "http://evil.example")];
    assert_eq!(http(&address, "POST", stop, &foreign).0, 403);
    assert_eq!(http(&address, "GET", "/api/v1/snapshot", &[("Host", "evil.example")]).0, 403);
    assert_eq!(
        until(&address, "measuring", |_| true)["state"],
        "measuring",
        "a refused request stopped it"
    );

    let authorized = [("Authorization", bearer.as_str())];
    assert_eq!(http(&address, "POST", "/api/v1/session/start", &authorized).0, 409);
    assert_eq!(http(&address, "POST", stop, &authorized).0, 204);
    // What is asked for while the final figures are made waits for them.
    get(&address, "/api/v1/section?radius=30");
    let done = until(&address, "complete", |snapshot| snapshot["state"] == "complete");
    assert_eq!(done["session"]["ended"], "stopped");
    let report = get(&address, "/api/v1/report");
    assert_eq!(report["format"], "asphera.report/1");
    let section = get(&address, "/api/v1/section?radius=30");
    assert!(section["deviation"]["pv_nm"].is_number(), "{section:#}");
    assert_eq!(get(&address, "/api/v1/maps")["version"], done["maps"]["version"]);
    assert_eq!(get(&address, "/api/v1/maps")["as_of_points"], done["maps"]["as_of_points"]);
}

/// The parser of Prometheus' own client takes the text, and finds what the snapshot says.
#[test]
fn the_client_of_prometheus_reads_the_metrics() {
    let Some(python) = python("prometheus_client") else { return };
    let out = tempfile::tempdir().unwrap();
    let (_daemon, address, _) = finished_demo(out.path());
    let before = get(&address, "/api/v1/links");
    let (status, body) = http(&address, "GET", "/metrics", &[]);
    assert_eq!(status, 200);
    let file = out.path().join("metrics.txt");
    std::fs::write(&file, &body).unwrap();
    let script = "import json, sys\n\
        from prometheus_client.parser import text_string_to_metric_families as families\n\
        found = {}\n\
        for family in families(open(sys.argv[1]).read()):\n\
        \x20   for s in family.samples:\n\
        \x20       found[s.name + ' ' + ' '.join(sorted(s.labels.values()))] = [family.type, s.value]\n\
        print(json.dumps(found))\n";
    let read = Command::new(python).args(["-c", script]).arg(&file).output().unwrap();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let found: Value = serde_json::from_slice(&read.stdout).unwrap();
    let snapshot = get(&address, "/api/v1/snapshot");
    let value =
        |name: &str| found[name][1].as_f64().unwrap_or_else(|| panic!("no {name} in {found}"));
    let nm = snapshot["form"]["deviation"]["pv_nm"].as_f64().unwrap();
    assert!((value("asphera_form_pv_meters ") * 1e9 - nm).abs() <= 1e-12 * nm);
    assert_eq!(value("asphera_form_provisional "), 0.0);
    assert_eq!(value("asphera_session_points_used "), snapshot["points"]["used"].as_f64().unwrap());
    assert_eq!(
        value("asphera_verdict pass"),
        f64::from(u8::from(snapshot["verdict"]["status"] == "pass"))
    );
    for (index, link) in snapshot["links"].as_array().unwrap().iter().enumerate() {
        let name = format!("asphera_link_readings_total {}", link["name"].as_str().unwrap());
        assert_eq!(found[&name][0], "counter");
        // Devices go on sending between two questions.
        let [least, most] =
            [&before["links"][index], link].map(|of| of["readings"].as_f64().unwrap());
        let read = value(&name);
        assert!(least <= read && read <= most, "{read}, expected {least} to {most}");
    }
}

/// While points arrive there are at least five snapshots a second, each newer than the one before.
#[test]
fn snapshots_stream_at_least_five_times_a_second() {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--points", "60000", "--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    let times: Vec<f64> = runtime.block_on(async {
        let url = format!("ws://{address}/api/v1/stream");
        let (mut stream, _) = tokio_tungstenite::connect_async(url).await.unwrap();
        let (mut times, mut sequence) = (Vec::new(), None);
        while let Some(message) = stream.next().await {
            let Message::Text(text) = message.unwrap() else { continue };
            let snapshot: Value = serde_json::from_str(&text).unwrap();
            if snapshot["format"] != "asphera.snapshot/1" {
                continue;
            }
            let next = snapshot["sequence"].as_u64();
            assert!(next > sequence, "snapshot {next:?} after {sequence:?}");
            sequence = next;
            if snapshot["state"] == "complete" {
                break;
            }
            if snapshot["points"]["received"].as_u64() > Some(0) {
                times.push(snapshot["elapsed_s"].as_f64().unwrap());
            }
        }
        times
    });
    let span = times.last().unwrap() - times[0];
    let rate = (times.len() - 1) as f64 / span;
    assert!(rate >= 5.0, "{} snapshots in {span} s", times.len());
}

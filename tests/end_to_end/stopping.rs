//! SIGTERM and SIGINT: a daemon ends within 5 s, whatever it is at.

use std::io::Write as _;
use std::net::{TcpListener, TcpStream};
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, json_file, now, page, recording, root, wait_for};

use crate::api::until;
use crate::demo::replayed;

/// From a signal to the end of the process.
const LIMIT: Duration = Duration::from_secs(5);

/// Ends a daemon; gives what it said and its exit code.
fn end(daemon: Running, signal: &str) -> (String, Option<i32>) {
    daemon.signal(signal);
    let output = daemon.wait(LIMIT);
    (String::from_utf8_lossy(&output.stderr).into_owned(), output.status.code())
}

/// A device that takes a connection and says nothing, and an address that takes none.
#[test]
fn links_that_never_answer_hold_nothing_up() {
    let silent = TcpListener::bind("127.0.0.1:0").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let example = std::fs::read_to_string(root().join("config/examples/om30-line.toml")).unwrap();
    let example = example.replace("autostart = false", "autostart = true");
    // 192.0.2.0/24 is for documentation: nobody is there, and nobody says so.
    for address in [silent.local_addr().unwrap().to_string(), "192.0.2.1:7891".to_owned()] {
        let config = folder.path().join("station.toml");
        let text = format!(
            "{}\n[publish]\nlisten = \"127.0.0.1:0\"\n[session]\ndir = {:?}\n",
            example.replace("192.168.170.2:7890", &address),
            folder.path().join("recordings")
        );
        std::fs::write(&config, text).unwrap();
        std::fs::copy(root().join("config/examples/flat.toml"), folder.path().join("flat.toml"))
            .unwrap();
        for signal in ["TERM", "INT"] {
            let mut daemon =
                Running::start(Command::new(asphera()).args(["run", "--config"]).arg(&config));
            daemon.line("page:", Duration::from_secs(60));
            std::thread::park_timeout(Duration::from_millis(700));
            let (words, code) = end(daemon, signal);
            assert_eq!(code, Some(0), "{address}: {words}");
            assert!(words.contains("recording: "), "{words}");
        }
    }
}

/// Figures that are not there in time are left; the recording is whole, and gives them.
#[test]
fn figures_that_take_long_are_left_to_a_replay() {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--json", "--points", "1000000", "--speed", "max"])
            .args(["--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::piped()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    let is_at_end =
        |now: &serde_json::Value| now["state"] == "finishing" || now["state"] == "complete";
    let ended =
        asphera_tests::until(&address, "end of the scan", Duration::from_secs(120), is_at_end);
    assert_eq!(ended["state"], "finishing", "the figures were there at once");
    let (words, code) = end(daemon, "TERM");
    let folder = recording(out.path());
    assert_eq!(code, Some(1), "{words}");
    assert!(words.contains("ended without the figures"), "{words}");
    let command = format!("asphera replay {}", folder.display());
    assert!(words.contains(&command), "{words}");
    // Told as whole: no need to make all the figures again to see that.
    let manifest = std::fs::read_to_string(folder.join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_str(&manifest).unwrap();
    assert_eq!(manifest["end"]["ended"]["how"], "finished", "{manifest:#}");
    assert_eq!(manifest["end"]["ended"]["reason"], "complete", "{manifest:#}");
}

/// Browsers that ask for much and take nothing.
#[test]
fn browsers_that_never_read_hold_nothing_up() {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args([
                "demo",
                "--points",
                "20000",
                "--speed",
                "max",
                "--listen",
                "127.0.0.1:0",
                "--out",
            ])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    daemon.line("the page stays", Duration::from_secs(60));
    let stream = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                  Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let requests = [("/api/v1/stream", stream), ("/api/v1/mesh.ply", ""), ("/api/v1/report", "")];
    let held: Vec<TcpStream> = requests
        .iter()
        .cycle()
        .take(30)
        .map(|(path, head)| {
            let mut client = TcpStream::connect(&address).unwrap();
            let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\n{head}\r\n");
            client.write_all(request.as_bytes()).unwrap();
            client
        })
        .collect();
    std::thread::park_timeout(Duration::from_millis(500));
    let (words, code) = end(daemon, "TERM");
    assert!(matches!(code, Some(0 | 10 | 11)), "{code:?}: {words}");
    drop(held);
    assert_eq!(replayed(out.path())["session"]["ended"], "complete");
}

/// A full pipe whose reader sleeps, as a pager does: the figures are left out, and stderr says so.
#[test]
fn a_stdout_that_nobody_reads_holds_nothing_up() {
    for (more, announced) in [(&["--exit"][..], "results:"), (&[], "the page stays")] {
        let out = tempfile::tempdir().unwrap();
        let (reader, mut pipe) = std::io::pipe().unwrap();
        // What Linux lets a pipe hold.
        pipe.write_all(&[b'x'; 1 << 16]).unwrap();
        let mut daemon = Running::start(
            Command::new(asphera())
                .args(["demo", "--json", "--points", "5000", "--speed", "max"])
                .args(["--listen", "127.0.0.1:0", "--out"])
                .arg(out.path())
                .args(more)
                .stdout(pipe),
        );
        daemon.line(announced, Duration::from_secs(60));
        let report = out.path().join("report.json");
        let there = || report.exists().then_some(()).ok_or("none");
        wait_for("report", Duration::from_secs(60), there);
        std::thread::park_timeout(Duration::from_millis(300));
        let (words, code) = end(daemon, "TERM");
        assert!(matches!(code, Some(0 | 10 | 11)), "{code:?}: {words}");
        assert!(words.contains("nobody reads stdout"), "{words}");
        drop(reader);
    }
}

/// A log that nobody reads holds up whoever writes to it; the recording is not lost.
#[test]
fn a_stderr_that_nobody_reads_holds_nothing_up() {
    let out = tempfile::tempdir().unwrap();
    let (reader, mut pipe) = std::io::pipe().unwrap();
    pipe.write_all(&[b'x'; 1 << 16]).unwrap();
    let mut daemon = Command::new(asphera())
        .args(["demo", "--points", "5000", "--speed", "max", "--listen", "127.0.0.1:0", "--out"])
        .arg(out.path())
        .stdout(Stdio::null())
        .stderr(pipe)
        .spawn()
        .unwrap();
    std::thread::park_timeout(Duration::from_millis(1500));
    let signalled = Command::new("kill").args(["-TERM", &daemon.id().to_string()]).status();
    assert!(signalled.unwrap().success());
    let until = now() + LIMIT;
    while daemon.try_wait().unwrap().is_none() {
        if now() > until {
            daemon.kill().unwrap();
            panic!("still running after {LIMIT:?}");
        }
        std::thread::park_timeout(Duration::from_millis(20));
    }
    drop(reader);
}

/// A command of `[output]` that goes on for a minute is left to itself; without a signal it is waited for.
#[tokio::test(flavor = "multi_thread")]
async fn a_command_of_the_results_holds_nothing_up() {
    use asphera_rig::{Rig, Scene, Speed, StationOptions};

    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::built_in("sphere").unwrap().with_points(2000).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let options = StationOptions {
        recordings: folder.path().join("recordings"),
        listen: ([127, 0, 0, 1], 0).into(),
    };
    let config = folder.path().join("station.toml");
    let text = rig.station_toml(&options)
        + "\n[output]\ncommand = [\"sh\", \"-c\", \"echo began >&2; sleep 45\", \"sh\"]\n";
    std::fs::write(&config, text).unwrap();
    let ended = tokio::task::spawn_blocking(move || {
        let mut daemon = Running::start(
            Command::new(asphera()).args(["run", "--once", "--config"]).arg(&config),
        );
        daemon.line("began", Duration::from_secs(60));
        end(daemon, "TERM")
    });
    let (words, code) = ended.await.unwrap();
    assert!(code.is_some(), "{words}");
    assert!(
        words.contains("the command of [output] still runs; asphera does not wait for it"),
        "{words}"
    );
    drop(rig);
}

#[test]
fn a_measurement_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let points = folder.path().join("points.xyz");
    let text: String = (0..300_000).map(|i| format!("{} {} 0\n", i % 600, i / 600)).collect();
    std::fs::write(&points, text).unwrap();
    let nominal = root().join("config/examples/flat.toml");
    let daemon = Running::start(
        Command::new(asphera())
            .args(["measure", "--json", "--nominal"])
            .arg(nominal)
            .arg(&points)
            .stdout(Stdio::piped()),
    );
    std::thread::park_timeout(Duration::from_millis(150));
    // A shell has the programs it starts behind itself ignore SIGINT, and a test run may be one of them.
    let (words, code) = end(daemon, "TERM");
    assert_eq!(code, None, "not ended by the signal itself: {words}");
}

/// What was never triggered is not lost: the report says how much of the scan never came.
#[test]
fn a_scan_that_is_stopped_lost_nothing() {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--points", "100000", "--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    until(&address, "on its way", |now| now["points"]["received"].as_u64() > Some(2000));
    let (words, code) = end(daemon, "TERM");
    assert_eq!(code, Some(11), "undecided: {words}");
    let report = json_file(&out.path().join("report.json"));
    let points = &report["points"];
    let counted = |name: &str| points[name].as_u64().unwrap();
    assert_eq!(counted("lost"), 0, "{points:#}");
    assert_eq!(counted("missing"), 100_000 - counted("received"), "{points:#}");
    assert_eq!(replayed(out.path())["points"], *points);
}

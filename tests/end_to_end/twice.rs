//! Two daemons that want the same: the second says who has it and what to do.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{Running, asphera, page};

struct Bench {
    rig: Rig,
    folder: tempfile::TempDir,
}

impl Bench {
    async fn start() -> Bench {
        let folder = tempfile::tempdir().unwrap();
        let scene = Scene::built_in("sphere").unwrap().with_points(2000).with_speed(Speed::Max);
        let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
        Bench { rig, folder }
    }

    /// A station that watches the ports of the bench.
    fn station(&self, recordings: &str, listen: u16) -> PathBuf {
        let options = StationOptions {
            recordings: self.folder.path().join(recordings),
            listen: ([127, 0, 0, 1], listen).into(),
        };
        let text = self
            .rig
            .station_toml(&options)
            .replace("[station]\n", "[station]\nautostart = false\n");
        let path = self.folder.path().join(format!("{recordings}-{listen}.toml"));
        std::fs::write(&path, text).unwrap();
        path
    }
}

fn run(config: &Path) -> Running {
    Running::start(Command::new(asphera()).args(["run", "--config"]).arg(config))
}

fn failed(config: &Path) -> String {
    let output = Command::new(asphera()).args(["run", "--config"]).arg(config).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{words}");
    words
}

#[tokio::test(flavor = "multi_thread")]
async fn a_folder_and_an_address_have_one_daemon() {
    let bench = Bench::start().await;
    let (config, other) = (bench.station("recordings", 0), bench.station("others", 1));
    tokio::task::spawn_blocking(move || {
        let mut first = run(&config);
        let (address, _) = page(&first.line("page:", Duration::from_secs(60)));
        let process = format!("process {}", first.id());

        let words = failed(&config);
        assert!(words.contains(&process) && words.contains("[session] dir"), "{words}");

        let text = std::fs::read_to_string(&other).unwrap();
        std::fs::write(&other, text.replace("127.0.0.1:1\"", &format!("{address}\""))).unwrap();
        let words = failed(&other);
        assert!(words.contains(&process) && words.contains(&address), "{words}");
        assert!(words.contains("[publish] listen"), "{words}");
        first.signal("TERM");
        assert_eq!(first.wait(Duration::from_secs(5)).status.code(), Some(0));
    })
    .await
    .unwrap();
}

#[test]
fn a_second_demo_in_a_folder_leaves_the_first_alone() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let demo = ["demo", "--listen", "127.0.0.1:0", "--out", out];
    let mut first = Running::start(Command::new(asphera()).args(demo));
    first.line("results:", Duration::from_secs(60));
    let truth = std::fs::read(folder.path().join("truth.json")).unwrap();
    let second = Command::new(asphera()).args(demo).args(["--seed", "9", "--force"]).output();
    let second = second.unwrap();
    let words = String::from_utf8_lossy(&second.stderr).into_owned();
    assert_eq!(second.status.code(), Some(1), "{words}");
    let process = format!("process {}", first.id());
    assert!(words.contains(&process) && words.contains("--out of demo"), "{words}");
    assert_eq!(std::fs::read(folder.path().join("truth.json")).unwrap(), truth);
    first.signal("TERM");
    first.wait(Duration::from_secs(10));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_serial_port_has_one_daemon() {
    let bench = Bench::start().await;
    let configs = [bench.station("recordings", 0), bench.station("others", 0)];
    tokio::task::spawn_blocking(move || {
        let mut first = run(&configs[0]);
        let (address, _) = page(&first.line("page:", Duration::from_secs(60)));
        until(&address, |links| links.iter().all(|link| link["state"] != "opening"));
        let mut second = run(&configs[1]);
        let (address, _) = page(&second.line("page:", Duration::from_secs(60)));
        let process = format!("in use by process {}", first.id());
        let says = |link: &serde_json::Value| {
            let error = link["last_error"].as_str().unwrap_or("");
            error.contains(&process) && error.contains("another port")
        };
        until(&address, |links| links.iter().filter(|link| says(link)).count() == 2);
        // Once the first has gone the second takes over by itself.
        first.signal("TERM");
        first.wait(Duration::from_secs(5));
        until(&address, |links| links.iter().all(|link| link["state"] != "opening"));
        drop(second);
    })
    .await
    .unwrap();
}

/// Waits until the links of a daemon are as they should be.
fn until(address: &str, holds: impl Fn(&[serde_json::Value]) -> bool) {
    asphera_tests::until(address, "links as wanted", Duration::from_secs(30), |snapshot| {
        let links = snapshot["links"].as_array().unwrap();
        !links.is_empty() && holds(links)
    });
}

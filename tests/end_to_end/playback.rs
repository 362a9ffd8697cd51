//! A recorded session, played back as its devices, is measured once more with the same figures.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{Running, asphera, json_file, run};

/// Measures one session, and gives the path of its folder.
fn measured(config: &Path, recordings: &Path) -> std::path::PathBuf {
    let before = sessions(recordings);
    let mut command = Command::new(asphera());
    command.args(["run", "--once", "--config"]).arg(config).stdout(Stdio::piped());
    let output = Running::start(&mut command).wait(Duration::from_secs(180));
    let [said, verdict] = [&output.stderr, &output.stdout].map(|of| String::from_utf8_lossy(of));
    assert_eq!(output.status.code(), Some(0), "{said}{verdict}");
    let new: Vec<_> =
        sessions(recordings).into_iter().filter(|path| !before.contains(path)).collect();
    assert_eq!(new.len(), 1);
    new[0].clone()
}

fn sessions(recordings: &Path) -> Vec<std::path::PathBuf> {
    let Ok(entries) = std::fs::read_dir(recordings) else { return Vec::new() };
    entries.map(|entry| entry.unwrap().path()).filter(|path| path.is_dir()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn a_session_played_back_by_its_devices_gives_the_same_figures() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::built_in("sphere").unwrap().with_points(3000).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let recordings = folder.path().join("recordings");
    let options =
        StationOptions { recordings: recordings.clone(), listen: ([127, 0, 0, 1], 0).into() };
    let config = folder.path().join("station.toml");
    let output = "\n[output]\nfiles = [\"report.json\"]\n";
    std::fs::write(&config, rig.station_toml(&options) + output).unwrap();
    let again = folder.path().join("again.toml");
    tokio::task::spawn_blocking(move || {
        let first = measured(&config, &recordings);
        let mut devices = Running::start(
            Command::new(asphera())
                .args(["simulate", "--speed", "max", "--session"])
                .arg(&first)
                .arg("--station")
                .arg(&again)
                .stdout(Stdio::null()),
        );
        devices.line("playing", Duration::from_secs(30));
        let second = measured(&again, &recordings);
        let [one, two] = [&first, &second].map(|session| json_file(&session.join("report.json")));
        assert_eq!(one["points"], two["points"]);
        assert_eq!(one["form"], two["form"]);
        let text = std::fs::read_to_string(&again).unwrap();
        assert!(text.contains("kind = \"slcan-tcp\"") && !text.contains("/ports/"), "{text}");
        // Whoever comes next is served from the beginning.
        let third = measured(&again, &recordings);
        assert_eq!(json_file(&third.join("report.json"))["form"], one["form"]);
        devices.signal("INT");
        assert_eq!(devices.wait(Duration::from_secs(10)).status.code(), Some(0));
        let there = run([
            "simulate".as_ref(),
            "--session".as_ref(),
            first.as_os_str(),
            "--station".as_ref(),
            again.as_os_str(),
        ]);
        assert_eq!(there.status.code(), Some(1), "the file is not overwritten");
    })
    .await
    .unwrap();
    drop(rig);
}

//! The daemon under a service manager: a socket of our own in the place of systemd's.

use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use asphera_rig::{Rig, Scene, Speed, StationOptions};
use asphera_tests::{Running, asphera, http, root, skipped};

/// A station whose instruments are not there, with its page at any port.
fn configuration(folder: &Path) -> std::path::PathBuf {
    let example = std::fs::read_to_string(root().join("config/examples/om30-line.toml")).unwrap();
    let recordings = folder.join("recordings");
    let text = format!(
        "{example}\n[publish]\nlisten = \"127.0.0.1:0\"\n[session]\ndir = {:?}\n",
        recordings.to_str().unwrap()
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    std::fs::copy(root().join("config/examples/flat.toml"), folder.join("flat.toml")).unwrap();
    path
}

fn words(socket: &UnixDatagram) -> String {
    let mut bytes = [0; 4096];
    let length = socket.recv(&mut bytes).expect("the daemon says something in time");
    String::from_utf8(bytes[..length].to_vec()).unwrap()
}

#[test]
fn a_service_says_when_it_is_ready_that_it_gets_on_and_that_it_stops() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("notify");
    let socket = UnixDatagram::bind(&place).unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["run", "--config"])
            .arg(configuration(folder.path()))
            .env("NOTIFY_SOCKET", &place)
            .env("WATCHDOG_USEC", "800000")
            .env("ASPHERA_TOKEN", "a-token-that-was-chosen"),
    );
    let line = daemon.line("page:", Duration::from_secs(60));
    // A token that its operator knows is not printed: it would end in the journal.
    assert!(!line.contains("token"), "{line}");
    let ready = words(&socket);
    let (_, address) = line.split_once("http://").unwrap();
    assert_eq!(ready, format!("READY=1\nSTATUS=page: http://{address}\n"));
    for _ in 0..5 {
        assert_eq!(words(&socket), "WATCHDOG=1\n");
    }
    let address = address.trim_end_matches('/');
    for (token, status) in [("a-token-that-was-chosen", 202), ("a-token-that-was-guessed", 403)] {
        let bearer = format!("Bearer {token}");
        let (found, _) =
            http(address, "POST", "/api/v1/session/start", &[("Authorization", &bearer)]);
        assert_eq!(found / 100, status / 100, "{token}: {found}");
    }
    daemon.signal("TERM");
    let until_stopping = (0..50).map(|_| words(&socket)).find(|words| words != "WATCHDOG=1\n");
    assert_eq!(until_stopping.as_deref(), Some("STOPPING=1\n"));
    let output = daemon.wait(Duration::from_secs(20));
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_token_that_is_none_is_refused_without_repeating_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("token");
    std::fs::write(&file, "too short").unwrap();
    let output = Command::new(asphera())
        .args(["run", "--config"])
        .arg(configuration(folder.path()))
        .arg("--token-file")
        .arg(&file)
        .output()
        .unwrap();
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        words.contains("16 to 128 characters, found 9") && !words.contains("too short"),
        "{words}"
    );
}

/// They are one unit, but for what names the station.
#[test]
fn the_units_agree() {
    let unit = |name: &str| std::fs::read_to_string(root().join("systemd").join(name)).unwrap();
    let settings = |text: String| {
        text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>()
    };
    let (one, several) = (settings(unit("asphera.service")), settings(unit("asphera@.service")));
    assert_eq!(one.len(), several.len());
    for (one, several) in one.iter().zip(&several) {
        assert!(one == several || several.contains("%i"), "{one} {several}");
    }
}

/// 2.0 of 10 and less is what systemd calls OK.
#[test]
fn the_units_leave_little_open() {
    for unit in ["asphera.service", "asphera@.service"] {
        let analysed = Command::new("systemd-analyze")
            .args(["security", "--offline=true", "--threshold=20"])
            .arg(root().join("systemd").join(unit))
            .output();
        let Ok(output) = analysed else { return skipped("there is no systemd-analyze") };
        let words = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success(), "{unit}: {words}");
        assert!(words.contains("Overall exposure level"), "{unit}: {words}");
    }
}

/// One part, measured by a station that ends with its verdict: what a cell of a line asks for.
#[tokio::test(flavor = "multi_thread")]
async fn a_station_measures_once_and_ends_with_the_verdict() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::built_in("sphere").unwrap().with_points(3000).with_speed(Speed::Max);
    let rig = Rig::start(scene, &folder.path().join("ports")).await.unwrap();
    let recordings = folder.path().join("recordings");
    let options =
        StationOptions { recordings: recordings.clone(), listen: ([127, 0, 0, 1], 0).into() };
    let config = folder.path().join("station.toml");
    for (limit, code) in [("pv_nm = 1e6", 0), ("pv_nm = 1", 10)] {
        let (before, after) =
            rig.station_toml(&options).split_once("[nominal.tolerance]\n").map_or_else(
                || panic!("the scene has limits"),
                |(before, after)| (before.to_owned(), after.to_owned()),
            );
        let rest = after.find("\n[").map_or("", |at| &after[at..]).to_owned();
        let text = format!(
            "{before}[nominal.tolerance]\n{limit}\n{rest}\n[output]\nfiles = [\"report.json\", \"qif.xml\", \"deviation.x3p\"]\n"
        );
        std::fs::write(&config, text).unwrap();
        let arguments = ["run", "--once", "--config", config.to_str().unwrap()].map(str::to_owned);
        let output = tokio::task::spawn_blocking(move || {
            Command::new(asphera()).args(arguments).output().unwrap()
        });
        let output = output.await.unwrap();
        assert_eq!(output.status.code(), Some(code), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let sessions: Vec<_> =
        std::fs::read_dir(&recordings).unwrap().map(|entry| entry.unwrap().path()).collect();
    // Beside them lies the lock of the folder.
    let sessions: Vec<_> = sessions.into_iter().filter(|path| path.is_dir()).collect();
    assert_eq!(sessions.len(), 2);
    for session in sessions {
        for file in ["report.json", "qif.xml", "deviation.x3p"] {
            assert!(session.join(file).is_file(), "{file} of {}", session.display());
        }
        assert!(!session.join("report.html").exists(), "it was not asked for");
    }
}

//! A device that no driver knows, described in the configuration: an arm that sends places as lines of text.

use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{TcpListener, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use asphera_tests::{Running, asphera, count, json, json_file, number, recording, run};

/// Radius of the sphere the arm touches, mm.
const RADIUS_MM: f64 = 50.0;

/// Lines of the arm: `n,x,y,z` in mm, to 0.1 nm, on a raster over a cap of the sphere.
fn lines(points: usize) -> Vec<String> {
    let row = (points as f64).sqrt().ceil() as usize;
    let place = |index: usize| -10.0 + 20.0 * index as f64 / (row - 1) as f64;
    let line = |n: usize| {
        let (x_mm, y_mm) = (place(n % row), place(n / row));
        let s2 = x_mm * x_mm + y_mm * y_mm;
        let z_mm = s2 / (RADIUS_MM + (RADIUS_MM * RADIUS_MM - s2).sqrt());
        format!("{},{x_mm:.7},{y_mm:.7},{z_mm:.7}\r\n", n % 1000)
    };
    (0..points).map(line).collect()
}

fn station(folder: &Path, link: &str, more: &str) -> PathBuf {
    std::fs::write(
        folder.join("sphere.toml"),
        format!(
            "[surface]\nkind = \"sphere\"\nradius_mm = {RADIUS_MM}\n[fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n\
             [tolerance]\npv_nm = 100\nrms_nm = 20\n"
        ),
    )
    .unwrap();
    let field = |name: &str, column: usize| {
        format!(
            "[[device.arm.settings.field]]\nname = \"{name}\"\ncolumn = {column}\nunit = \"mm\"\n\
             valid_range = [-20, 20]\n"
        )
    };
    let axis = |name: &str| format!("{name} = {{ device = \"arm\", channel = \"{name}\" }}\n");
    let text = format!(
        "[station]\nname = \"arm\"\n{link}\n[device.arm]\ndriver = \"described\"\nlink = \"arm\"\n\
         [device.arm.settings]\nseparator = \",\"\ncolumns = 4\n{more}\n{}{}{}\
         [[device.arm.settings.field]]\nname = \"n\"\ncolumn = 1\nrole = \"count\"\nmodulus = 1000\n\
         [sync]\ndevices = [\"arm\"]\n[kinematics]\nkind = \"cartesian\"\n{}{}{}\
         [nominal]\nfile = \"sphere.toml\"\n[scan]\nidle_s = 2\n\
         [session]\ndir = {:?}\n[publish]\nlisten = \"127.0.0.1:0\"\n[output]\nfiles = [\"report.json\"]\n",
        field("x", 2),
        field("y", 3),
        field("z", 4),
        axis("x"),
        axis("y"),
        axis("z"),
        folder.join("recordings").display().to_string(),
    );
    let path = folder.join("station.toml");
    std::fs::write(&path, text).unwrap();
    path
}

/// One session, and its report.
fn measured(config: &Path) -> (i32, serde_json::Value, PathBuf) {
    let running =
        Running::start(Command::new(asphera()).args(["run", "--once", "--config"]).arg(config));
    let output = running.wait(Duration::from_secs(120));
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    let session = recording(&config.parent().unwrap().join("recordings"));
    let report = session.join("report.json");
    assert!(report.exists(), "{words}");
    (output.status.code().unwrap_or(-1), json_file(&report), session)
}

/// It says who it is, begins when told to, and sends a line that nobody can read and one that is cut.
#[test]
fn lines_over_tcp_become_a_measured_part() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            std::thread::spawn(move || {
                let mut words = BufReader::new(stream.try_clone().unwrap());
                let mut stream = stream;
                let mut word = String::new();
                while words.read_line(&mut word).is_ok_and(|len| len > 0) {
                    let answer = match word.trim() {
                        "ID" => "ARM 7, serial 42\r\n".to_owned(),
                        "GO" => {
                            let mut lines = lines(2500);
                            lines[100] = "100,not a number,,\r\n".to_owned();
                            lines[200] = "200,1.5\r\n".to_owned();
                            lines.concat()
                        }
                        _ => String::new(),
                    };
                    // A client that went away ends the device's thread.
                    if stream.write_all(answer.as_bytes()).is_err() {
                        return;
                    }
                    word.clear();
                }
            });
        }
    });
    let folder = tempfile::tempdir().unwrap();
    let link = format!("[link.arm]\nkind = \"tcp\"\naddress = \"{address}\"\n");
    let more = "on_start = ['GO\\r\\n']\nhello = { ask = 'ID\\r\\n', answer = 'ARM 7,.*' }";
    let config = station(folder.path(), &link, more);
    let (code, report, session) = measured(&config);
    assert_eq!(code, 0, "{report:#}");
    // The line behind each of the two may be noise, too: nothing guards it.
    assert_eq!(count(&report, "/points/used"), 2496);
    assert_eq!(count(&report, "/points/flagged/suspect"), 2);
    assert!(number(&report, "/form/deviation/rms_nm") < 0.1, "{report:#}");
    let replayed = run(["replay".as_ref(), session.as_os_str(), "--json".as_ref()]);
    assert_eq!(json(&replayed)["form"], report["form"], "a replay gives the same figures");
}

/// It sends by itself, a few lines a datagram, and says nothing of itself.
#[test]
fn datagrams_become_a_measured_part() {
    let free = UdpSocket::bind("127.0.0.1:0").unwrap();
    let address = free.local_addr().unwrap();
    drop(free);
    let folder = tempfile::tempdir().unwrap();
    let link = format!("[link.arm]\nkind = \"udp\"\nlisten = \"{address}\"\n");
    let config = station(folder.path(), &link, "");
    std::thread::spawn(move || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        // Until the daemon has the port nobody hears: it may have to be built first.
        while UdpSocket::bind(address).is_ok() {
            std::thread::park_timeout(Duration::from_millis(500));
        }
        // Lines of which the daemon, once it listens, cannot say where the first begins; then the part.
        let part = lines(2500);
        for round in 0.. {
            if socket.send_to(b"0,0.0000000,0.0000000,0.0000000\r\n", address).is_err()
                && round > 600
            {
                return;
            }
            std::thread::park_timeout(Duration::from_millis(50));
            if round == 60 {
                for datagram in part.chunks(20) {
                    socket.send_to(datagram.concat().as_bytes(), address).unwrap();
                    std::thread::park_timeout(Duration::from_millis(2));
                }
                return;
            }
        }
    });
    let (code, report, _) = measured(&config);
    assert_eq!(code, 0, "{report:#}");
    assert!(count(&report, "/points/used") >= 2499, "{report:#}");
    assert!(number(&report, "/form/deviation/rms_nm") < 0.1, "{report:#}");
}

/// A gauge that must be asked is listened to, described, and tried.
#[test]
fn a_gauge_is_described_by_listening_to_it() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            let mut words = BufReader::new(stream.try_clone().unwrap());
            let (mut stream, mut word, mut n) = (stream, Vec::new(), 0);
            while words.read_until(b'\r', &mut word).is_ok_and(|len| len > 0) {
                n += 1;
                let answer = format!("MAIN,{:+08.4}\r", 1.2 + 0.001 * f64::from(n));
                if word != b"MAIN,1\r" || stream.write_all(answer.as_bytes()).is_err() {
                    break;
                }
                word.clear();
            }
        }
    });
    let words = ["--ask", r"MAIN,1\r", "--every-ms", "50", "--seconds", "2", "--name", "depth"];
    let output = run([&["describe", "--tcp", &address][..], &words].concat());
    let (told, remarks) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{remarks}");
    assert!(
        told.contains("[link.depth]\nkind = \"tcp\"") && told.contains(r"ask = 'MAIN,1\r'"),
        "{told}"
    );
    assert!(told.contains("[[device.depth.settings.field]]"), "{told}");
    assert!(remarks.contains("5 readings with it, the last: value2 1.2"), "{remarks}");
}

//! Devices nobody of us wrote: python `canopen` and `python-can` as a transducer over slcan, `pymodbus` as a
//! Baumer OM20. The daemon reads both.

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, http, json_file, number, page, python, recording, root};

use crate::faults::device;

/// Two hosts on one null modem: what either sends the other receives.
fn null_modem() -> (u16, u16) {
    let ends = [0, 1].map(|_| TcpListener::bind("127.0.0.1:0").unwrap());
    let ports = ends.each_ref().map(|end| end.local_addr().unwrap().port());
    std::thread::spawn(move || {
        let [a, b] = ends.map(|end| end.accept().unwrap().0);
        let pump = |mut from: TcpStream, mut to: TcpStream| {
            let mut buffer = [0; 4096];
            while let Ok(count @ 1..) = from.read(&mut buffer) {
                if to.write_all(&buffer[..count]).is_err() {
                    return;
                }
            }
        };
        let (from_a, to_a) = (a.try_clone().unwrap(), a);
        let (from_b, to_b) = (b.try_clone().unwrap(), b);
        std::thread::spawn(move || pump(from_a, to_b));
        pump(from_b, to_a);
    });
    (ports[0], ports[1])
}

/// A peer's process; it ends with the test, however that ends.
struct Peer(Child);

impl Peer {
    fn start(command: &mut Command) -> Peer {
        // Nothing of it may keep the test's own output open.
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        Peer(command.spawn().unwrap())
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended; then there is nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A station with a stage on a CAN bus and a gauge by Modbus.
fn config(daemon_port: u16, modbus_port: u16, recordings: &Path) -> String {
    format!(
        r#"
[station]
name = "peers"
[link.bus]
kind = "slcan-tcp"
address = "127.0.0.1:{daemon_port}"
bit_rate_bps = 500000
[link.table]
kind = "tcp"
address = "127.0.0.1:{modbus_port}"
[device.stage]
driver = "cia406"
link = "bus"
settings = {{ node_id = 5, step_nm = 1000, map_velocity = true, map_status = true }}
[device.table]
driver = "modbus"
link = "table"
settings = {{ framing = "tcp", map = "baumer-om20", poll_interval_ms = 20, skip_repeated = false }}
[sync]
devices = ["stage"]
[kinematics]
kind = "cartesian"
x = {{ device = "stage", channel = "position" }}
y = {{ constant_mm = 0 }}
z = {{ constant_mm = 0 }}
[nominal.surface]
kind = "plane"
[scan]
idle_s = 2
[session]
dir = "{dir}"
[publish]
listen = "127.0.0.1:0"
"#,
        dir = recordings.display()
    )
}

#[test]
fn the_daemon_reads_a_canopen_stack_and_pymodbus() {
    let Some(python) = python("canopen, can, serial, pymodbus") else { return };
    let (daemon_port, peer_port) = null_modem();
    let modbus_port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();

    let mut modbus = Peer::start(
        Command::new(&python)
            .arg(root().join("drivers/modbus/tests/peer.py"))
            .args(["tcp", &modbus_port.to_string()]),
    );
    let mut ready = [0; 5];
    modbus.0.stdout.as_mut().unwrap().read_exact(&mut ready).unwrap();

    let dir = tempfile::tempdir().unwrap();
    let cycles = 400;
    let config = config(daemon_port, modbus_port, &dir.path().join("recordings"));
    let path = dir.path().join("station.toml");
    std::fs::write(&path, config).unwrap();
    let mut daemon = Running::start(
        Command::new(asphera()).args(["run", "--config"]).arg(&path).stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    let _stage = Peer::start(
        Command::new(&python)
            .arg(root().join("drivers/cia406/tests/peer.py"))
            .arg(peer_port.to_string())
            .arg(root().join("drivers/cia406/tests/peer.eds"))
            .args(["5", &cycles.to_string(), "240"]),
    );
    daemon.line("recording:", Duration::from_secs(60));
    let (status, body) = http(&address, "GET", "/api/v1/report", &[]);
    assert_eq!(status, 200);
    let report: serde_json::Value = serde_json::from_slice(&body).unwrap();

    let transducer = device(&report, "stage");
    assert_eq!(transducer["readings"], cycles, "{transducer:#}");
    assert_eq!(transducer["lost"], 0);
    assert!(
        transducer["faults"].to_string().contains("device"),
        "the emergency was not seen: {transducer:#}"
    );
    let gauge = device(&report, "table");
    for place in ["/channels/distance/min", "/channels/distance/max"] {
        let distance = number(gauge, place);
        assert!((distance - 69.7426).abs() < 5e-5, "{place}: {distance} mm");
    }
    assert!(gauge["readings"].as_u64().unwrap() > 10, "{gauge:#}");
    let manifest = json_file(&recording(&dir.path().join("recordings")).join("manifest.json"));
    assert_eq!(manifest["session"]["station"], "peers");
}

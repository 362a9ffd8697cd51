//! CAN frames without a CAN interface: a log of candump, and a server of socketcand.

use std::fmt::Write as _;
use std::io::Read as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use asphera_tests::{
    Running, asphera, count, http, json, json_file, number, page, python, recording, root, run,
};

use crate::demo::timeless;
use crate::faults::device;

const CYCLES: u32 = 500;

/// Two transducers that answer every SYNC, 2 ms apart, as candump logs a bus that another master has set up. Beside them
/// come another bus, CAN FD, an error frame and a remark.
fn log() -> String {
    let mut text = String::from("# bench 7, second shift\n");
    // Heartbeats say that both nodes are operational before the first SYNC.
    for node in [5, 6] {
        let _ = writeln!(text, "(1436509052.20000{node}) can0 70{node}#05");
    }
    for cycle in 0..CYCLES {
        let us = 1_436_509_052_249_713 + 2_000 * u64::from(cycle);
        let at =
            |after: u64| format!("({}.{:06})", (us + after) / 1_000_000, (us + after) % 1_000_000);
        // Little endian; steps of 1 µm.
        let (x, z) = (i32::try_from(cycle).unwrap() * 10 - 2000, i32::try_from(cycle % 7).unwrap());
        let hex = |value: i32| format!("{:08X}", value.cast_unsigned().swap_bytes());
        let _ = writeln!(text, "{} can0 080#{:02X}", at(0), 1 + cycle % 240);
        let _ = writeln!(text, "{} can0 185#{}", at(150), hex(x));
        let _ = writeln!(text, "{} can1 185#{} R", at(160), hex(-x));
        let _ = writeln!(text, "{} can0 186#{}", at(300), hex(z));
        if cycle == 100 {
            let _ = writeln!(text, "{} can0 123##11122334455667788", at(400));
            let _ = writeln!(text, "{} can0 20000040#0000000000000000", at(410));
        }
    }
    text
}

fn station(link: &str, settings: [&str; 2], recordings: &Path) -> String {
    let [x, z] = settings;
    format!(
        "[station]\nname = \"can\"\n[link.bus]\n{link}\n\
         [device.x]\ndriver = \"cia406\"\nlink = \"bus\"\nsettings = {{ {x} }}\n\
         [device.z]\ndriver = \"cia406\"\nlink = \"bus\"\nsettings = {{ {z} }}\n\
         [sync]\ndevices = [\"x\", \"z\"]\n\
         [kinematics]\nkind = \"cartesian\"\nx = {{ device = \"x\", channel = \"position\" }}\n\
         y = {{ constant_mm = 0 }}\nz = {{ device = \"z\", channel = \"position\" }}\n\
         [nominal.surface]\nkind = \"plane\"\n[scan]\nidle_s = 1\n[session]\ndir = {recordings:?}\n\
         [publish]\nlisten = \"127.0.0.1:0\"\n"
    )
}

#[test]
fn a_log_of_a_bus_is_measured_without_a_bus() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("bus.log"), log()).unwrap();
    let link = "kind = \"candump\"\nfile = \"bus.log\"\ninterface = \"can0\"";
    let settings = [
        "node_id = 5, listen_only = true, step_nm = 1000",
        "node_id = 6, listen_only = true, step_nm = 1000",
    ];
    let config = dir.path().join("station.toml");
    let recordings = dir.path().join("recordings");
    std::fs::write(&config, station(link, settings, &recordings)).unwrap();
    let mut daemon = Running::start(
        Command::new(asphera()).args(["run", "--config"]).arg(&config).stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    daemon.line("recording:", Duration::from_secs(60));
    let (_, body) = http(&address, "GET", "/api/v1/report", &[]);
    let report: serde_json::Value = serde_json::from_slice(&body).unwrap();

    let cycles = u64::from(CYCLES);
    assert_eq!(count(&report, "/points/received"), cycles);
    assert_eq!(count(&report, "/points/used"), cycles, "{:#}", report["points"]);
    for name in ["x", "z"] {
        let device = device(&report, name);
        assert_eq!((count(device, "/readings"), count(device, "/lost")), (cycles, 0), "{device:#}");
        assert_eq!(device["faults"].to_string(), "{}", "{device:#}");
    }
    let link = &report["links"][0];
    let log = log();
    assert_eq!(count(link, "/received_bytes"), log.len() as u64);
    let left_out = log.lines().filter(|line| line.starts_with('#') || line.contains("##"));
    let left_out: usize = left_out.map(|line| line.len() + 1).sum();
    assert_eq!(count(link, "/discarded_bytes"), left_out as u64, "{link:#}");
    // 500 cycles of 2 ms at the pace of the log; the session ends a second later.
    let duration_s = number(&report, "/timing/total_s");
    assert!((1.9..20.0).contains(&duration_s), "{duration_s} s");

    let (_, body) = http(&address, "GET", "/api/v1/links", &[]);
    let links = String::from_utf8(body).unwrap();
    for words in [
        "bus.log ended: 1502 frames in 2005 lines",
        "no line of candump, first in line 1",
        "CAN FD frame, first in line 408",
    ] {
        assert!(links.contains(words), "expected {words:?} in {links}");
    }
    drop(daemon);

    // The recording needs the log no more.
    std::fs::remove_file(dir.path().join("bus.log")).unwrap();
    let session = recording(&recordings);
    let replay = run(["replay".as_ref(), "--json".as_ref(), session.as_os_str()]);
    assert_eq!(timeless(json(&replay)), timeless(report));
}

#[test]
fn a_device_that_would_ask_a_log_is_refused_with_the_cure() {
    let dir = tempfile::tempdir().unwrap();
    let link = "kind = \"candump\"\nfile = \"bus.log\"\nspeed = 0";
    let settings = ["node_id = 5", "node_id = 6, listen_only = true"];
    let config = dir.path().join("station.toml");
    std::fs::write(&config, station(link, settings, dir.path())).unwrap();
    let output = run(["check".as_ref(), "--config".as_ref(), config.as_os_str()]);
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success());
    for words in [
        "listen_only = true",
        "bus, a log that answers nothing",
        "speed",
        "0.01 to 1000",
        "step_nm",
    ] {
        assert!(text.contains(words), "expected {words:?} in {text}");
    }
}

/// The server's process; it ends with the test, however that ends.
struct Server(Child);

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended; then there is nothing to kill.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A server in python with two nodes of the python package canopen behind it. It breaks the first connection off in the
/// middle of its answer.
#[test]
fn nodes_behind_a_server_of_socketcand_are_set_up_and_read() {
    let Some(python) = python("canopen, can") else { return };
    let cycles = 300;
    let mut server = Server(
        Command::new(python)
            .arg(root().join("tests/end_to_end/socketcand.py"))
            .arg(root().join("drivers/cia406/tests/peer.eds"))
            .args(["can0", &cycles.to_string(), "240"])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let mut port = [0; 5];
    server.0.stdout.as_mut().unwrap().read_exact(&mut port).unwrap();
    let port = String::from_utf8_lossy(&port);

    let dir = tempfile::tempdir().unwrap();
    let recordings = dir.path().join("recordings");
    let link = format!("kind = \"socketcand\"\naddress = \"127.0.0.1:{port}\"\nbus = \"can0\"");
    let settings = ["node_id = 5, step_nm = 1000", "node_id = 6, step_nm = 1000"];
    let config = dir.path().join("station.toml");
    std::fs::write(&config, station(&link, settings, &recordings)).unwrap();
    let mut daemon = Running::start(
        Command::new(asphera()).args(["run", "--config"]).arg(&config).stdout(Stdio::null()),
    );
    daemon.line("recording:", Duration::from_secs(90));
    let report = json_file(&recording(&recordings).join("report.json"));
    for name in ["x", "z"] {
        let device = device(&report, name);
        assert_eq!((count(device, "/readings"), count(device, "/lost")), (cycles, 0), "{device:#}");
    }
    assert_eq!(count(&report, "/points/used"), cycles, "{:#}", report["points"]);
    let link = &report["links"][0];
    assert_eq!((count(link, "/opened"), count(link, "/closed")), (2, 1), "{link:#}");
    // Half an answer, `< o`, and an element that is none. Beside them come whole SDO answers that nobody waits for.
    let discarded = count(link, "/discarded_bytes");
    assert!(discarded >= 3 + 15 && (discarded - 3 - 15).is_multiple_of(8), "{link:#}");
}

//! Clients that mean no good: what they cost the measurement.

use std::io::Write as _;
use std::net::TcpStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_tests::{Running, asphera, json_file, page};
use serde_json::Value;

/// A demo whose page has so many clients that ask for the stream and never read: its report, and the most memory it
/// ever had in KiB.
fn measured(clients: usize) -> (Value, u64) {
    let out = tempfile::tempdir().unwrap();
    let mut daemon = Running::start(
        Command::new(asphera())
            .args(["demo", "--points", "30000", "--speed", "2", "--listen", "127.0.0.1:0", "--out"])
            .arg(out.path())
            .stdout(Stdio::null()),
    );
    let (address, _) = page(&daemon.line("page:", Duration::from_secs(60)));
    let handshake = format!(
        "GET /api/v1/stream HTTP/1.1\r\nHost: {address}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
         Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
    );
    // Those beyond the bounds are refused; they keep their ends open and read nothing either.
    let held: Vec<TcpStream> = (0..clients)
        .filter_map(|_| {
            let mut client = TcpStream::connect(&address).ok()?;
            client.write_all(handshake.as_bytes()).ok()?;
            Some(client)
        })
        .collect();
    assert!(held.len() >= clients.min(250), "{} of {clients} got through", held.len());
    daemon.line("the page stays", Duration::from_secs(120));
    let status = std::fs::read_to_string(format!("/proc/{}/status", daemon.id())).unwrap();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    let peak_kib = peak.trim().trim_end_matches(" kB").parse().unwrap();
    (report(out.path()), peak_kib)
}

fn report(out: &Path) -> Value {
    json_file(&out.join("report.json"))
}

#[test]
fn five_hundred_streams_that_never_read_cost_neither_a_point_nor_memory() {
    let (alone, alone_kib) = measured(0);
    let (crowded, crowded_kib) = measured(500);
    assert_eq!(crowded["points"]["received"], 30_000);
    for figures in ["points", "mesh", "form"] {
        assert_eq!(crowded[figures], alone[figures], "{figures}");
    }
    let more_mib = crowded_kib.saturating_sub(alone_kib) / 1024;
    assert!(more_mib < 64, "{more_mib} MiB more than the {} MiB without", alone_kib / 1024);
}

//! The simulator on real streams, asked by clients of another make.

use std::process::Output;
use std::time::Duration;

use asphera_modbus::Transport;
use asphera_sim_modbus::{Device, Fault, Pty, serve, serve_tcp};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpListener;
use tokio::process::Command;
use tokio::time::Instant;

fn device() -> Device {
    let device = Device::om20(1, |_| 0.0);
    // The clock stands still, so that the answer is known.
    device.animate(|_, image| {
        for (name, value) in [("distance", 69.742_607), ("rate", 500.0), ("time_s", 12.0)] {
            image.set(name, value).expect("the OM20 has the field");
        }
    });
    device
}

/// A poll of an OM20 over a stream in memory: the request answered late, then a close.
#[tokio::test(start_paused = true)]
async fn answers_come_when_they_are_due() {
    let (mut client, server) = tokio::io::duplex(64);
    let device = device();
    device.fail_next(Fault::Late(Duration::from_millis(250)));
    device.fail_next(Fault::Close);
    let start = Instant::now();
    let served = tokio::spawn(serve(server, device, Transport::Tcp, start));
    let request = [0, 9, 0, 0, 0, 6, 1, 4, 0, 200, 0, 13];
    client.write_all(&request).await.unwrap();
    let mut answer = [0; 35];
    client.read_exact(&mut answer).await.unwrap();
    assert_eq!(start.elapsed().as_millis(), 250);
    assert_eq!(answer[..13], [0, 9, 0, 0, 0, 29, 1, 4, 26, 0, 0, 0, 0]);
    assert_eq!(answer[13..17], [0x7C, 0x37, 0x42, 0x8B]);
    client.write_all(&request).await.unwrap();
    assert_eq!(client.read(&mut answer).await.unwrap(), 0);
    assert!(served.await.unwrap().is_ok());
}

#[tokio::test]
async fn pymodbus_reads_over_tcp() {
    let listener = TcpListener::bind(("127.0.0.1", 0)).await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let server = tokio::spawn(serve_tcp(listener, device()));
    check_peer(&["tcp", &port.to_string()]).await;
    server.abort();
}

#[tokio::test]
async fn pymodbus_reads_over_a_serial_line() {
    let pty = Pty::open().unwrap();
    let path = pty.path().to_str().unwrap().to_owned();
    let server = tokio::spawn(pty.serve(device()));
    // Twice: the line stays up when a client goes.
    for _ in 0..2 {
        check_peer(&["rtu", &path]).await;
    }
    server.abort();
}

/// pymodbus reads the measurement of `device()` alone and whole, and is refused another part. The interpreter is that
/// of ASPHERA_PYTHON, else `python3`; without pymodbus nothing is checked.
#[expect(clippy::print_stderr, reason = "a skipped test says so")]
async fn check_peer(arguments: &[&str]) {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let run = |arguments: Vec<String>| Command::new(&python).args(arguments).output();
    let import = run(vec!["-c".into(), "import pymodbus.client, serial".into()]).await;
    if !import.is_ok_and(|output| output.status.success()) {
        eprintln!("skipped: pymodbus 3.16 and pyserial for {python} not found");
        return;
    }
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py");
    let arguments = [&[script], arguments].concat().iter().map(ToString::to_string).collect();
    let Output { stdout, stderr, .. } = run(arguments).await.expect("the interpreter starts");
    // 202 = 7C37h = 31799, 203 = 428Bh = 17035; 500.0 is 43FA_0000h.
    let expected = "0 0 31799 17035 0 17402 0 0 0 12 0 0 0\n31799 17035\n2\n";
    let stderr = String::from_utf8_lossy(&stderr);
    assert_eq!(String::from_utf8_lossy(&stdout), expected, "{stderr}");
}

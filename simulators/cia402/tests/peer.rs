//! The simulated drive against an independent client: python `canopen`'s `profiles.p402` over slcan and TCP.
//!
//! Needs an interpreter with canopen, python-can and pyserial (tried: 2.4.1, 4.6.1, 3.5), named by the environment variable
//! `ASPHERA_PYTHON` or found as `python3`; skipped without.

use std::process::{Command, Stdio};
use std::time::Duration;

use asphera_sim_cia402::{Drive, DriveSettings, SharedDrives, serve};
use tokio::net::TcpListener;
use tokio::time::timeout;

const TARGET: i32 = 12_345;

#[tokio::test]
async fn an_independent_client_homes_and_moves_it() {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python)
        .args(["-c", "import canopen, can, serial"])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !found {
        eprintln!("skipped: {python} cannot import canopen, can, serial");
        return;
    }
    let drive = DriveSettings { node_id: 5, travel: 50_000, at: 20_000, acceleration: 200_000 };
    let shared = SharedDrives::new(vec![Drive::new(drive).expect("a node")]);
    let listener = TcpListener::bind("127.0.0.1:0").await.expect("a free port");
    let port = listener.local_addr().expect("a bound port").port();
    let served = shared.clone();
    let server = tokio::spawn(async move {
        let (stream, _) = listener.accept().await.expect("the client connects");
        stream.set_nodelay(true).expect("TCP");
        serve(&served, stream).await
    });
    let client = tokio::task::spawn_blocking(move || {
        Command::new(python)
            .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py"))
            .args([port.to_string(), "5".to_owned(), TARGET.to_string()])
            .output()
    });
    let output = timeout(Duration::from_secs(120), client).await.expect("in time");
    let output = output.expect("no panic").expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(
        text.lines().collect::<Vec<_>>(),
        ["homed 0".to_owned(), format!("arrived {TARGET}")]
    );
    assert_eq!(shared.places(), [f64::from(TARGET)], "counted from the switch");
    server.abort();
}

//! The driver against an independent CANopen device: python `canopen` on python-can's slcan, over TCP.
//!
//! Needs an interpreter with both packages (tried: canopen 2.4.1, python-can 4.6.1, pyserial 3.5),
//! named by the environment variable `ASPHERA_PYTHON` or found as `python3`; skipped without.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command as Process, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use asphera_cia406::{Cia406, Settings};
use asphera_link::{Command, Driver, Event, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_slcan::{Decoder, Item, encode};

const NODE: u8 = 5;
const CYCLES: usize = 100;
const OVERFLOW: u8 = 10;
const PATIENCE: Duration = Duration::from_secs(60);

/// The python device; ends with the test.
struct Peer(Child);

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself: then there is nothing to end.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn python() -> Option<String> {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Process::new(&python)
        .args(["-c", "import canopen, can, serial"])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    found.then_some(python)
}

fn connect(python: &str) -> (Peer, TcpStream) {
    let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    let port = listener.local_addr().expect("a bound port").port();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
    let child = Process::new(python)
        .arg(format!("{folder}/peer.py"))
        .args([port.to_string(), format!("{folder}/peer.eds")])
        .args([NODE.to_string(), CYCLES.to_string(), OVERFLOW.to_string()])
        .stdin(Stdio::piped())
        .spawn()
        .expect("the interpreter just ran");
    let peer = Peer(child);
    let (accepted, connection) = mpsc::channel();
    std::thread::spawn(move || accepted.send(listener.accept()));
    let (stream, _) = connection
        .recv_timeout(PATIENCE)
        .expect("the peer connects")
        .expect("the connection is good");
    stream.set_nodelay(true).expect("TCP");
    (peer, stream)
}

/// Runs the driver on the line until it has given `CYCLES` readings, or patience ends.
#[expect(clippy::disallowed_methods, reason = "the peer lives on the host's clock")]
fn run(driver: &mut Cia406, stream: &mut TcpStream) -> Vec<Event> {
    let origin = Instant::now();
    let now = || Nanos::from_nanos(origin.elapsed().as_nanos() as u64);
    let mut decoder = Decoder::new();
    let mut events = Vec::new();
    let mut buffer = [0; 512];
    driver.command(now(), Command::Start);
    driver.connected(now());
    while origin.elapsed() < PATIENCE
        && events.iter().filter(|event| matches!(event, Event::Reading(_))).count() < CYCLES
    {
        let mut lines = Vec::new();
        while let Some(Output::Frame(frame)) = driver.poll_transmit() {
            encode(&frame, &mut lines);
        }
        stream.write_all(&lines).expect("the peer listens");
        let wait = driver.poll_timeout().map_or(PATIENCE, |due| due.since(now()));
        stream.set_read_timeout(Some(wait.max(Duration::from_millis(1)))).expect("not zero");
        match stream.read(&mut buffer) {
            Ok(0) => panic!("the peer left: {events:?}"),
            Ok(count) => {
                let mut bytes = &buffer[..count];
                while !bytes.is_empty() {
                    match decoder.decode(&mut bytes) {
                        Some(Item::Frame(frame, None)) => {
                            driver.receive(now(), Input::Frame(&frame));
                        }
                        // The peer takes us for an adapter and opens it.
                        Some(Item::Command(_) | Item::Ok) | None => {}
                        Some(other) => panic!("the peer said {other:?}"),
                    }
                }
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => panic!("the line broke: {error}"),
        }
        let time = now();
        if driver.poll_timeout().is_some_and(|due| due <= time) {
            driver.timeout(time);
        }
        events.extend(std::iter::from_fn(|| driver.poll_event()));
    }
    events
}

#[test]
fn an_independent_device_is_set_up_and_read() {
    let Some(python) = python() else {
        eprintln!("skipped: python packages canopen, python-can and pyserial not found");
        return;
    };
    let (_peer, mut stream) = connect(&python);
    let settings = Settings {
        node_id: NODE,
        vendor_id: Some(0x40),
        map_velocity: true,
        map_status: true,
        sync_counter_overflow: Some(OVERFLOW),
        sdo_timeout_ms: 2000,
        ..Settings::default()
    };
    let mut driver = Cia406::new(settings).expect("good settings");
    let events = run(&mut driver, &mut stream);

    assert_eq!(events.iter().filter(|event| **event == Event::Online).count(), 1, "{events:?}");
    assert_eq!(events.iter().filter(|event| **event == Event::Ready).count(), 1, "{events:?}");
    let readings: Vec<Reading> = events
        .iter()
        .filter_map(|event| match event {
            Event::Reading(reading) => Some(reading.clone()),
            _ => None,
        })
        .collect();
    assert_eq!(readings.len(), CYCLES, "{events:?}");
    for (k, reading) in readings.iter().enumerate() {
        let outside = k.is_multiple_of(7);
        let position = (37 * k * k) as f64 - 50_000.0;
        let values = [
            // Steps of 0.5 µm and of 0.25 mm/s, as the device's dictionary has them.
            Some(position * 500.0 / 1e6),
            Some((k as f64 - 30.0) * 0.25),
            Some(f64::from(u8::from(outside))),
        ];
        assert_eq!(reading.values.iter().collect::<Vec<_>>(), values, "cycle {k}");
        let count = reading.count.expect("every position answers a SYNC");
        let raw = 1 + (k as u32) % u32::from(OVERFLOW);
        assert_eq!((count.raw, count.first, count.modulus), (raw, 1, OVERFLOW.into()));
        let mut flags = Flags::empty();
        flags.set(Flags::OUT_OF_RANGE, outside);
        flags.set(Flags::DEVICE_ERROR, (20..30).contains(&k));
        assert_eq!(reading.flags, flags, "cycle {k}");
    }
    let faults: Vec<_> = events
        .iter()
        .filter_map(|event| match event {
            Event::Fault(fault) => Some((fault.kind, fault.detail.as_str())),
            _ => None,
        })
        .collect();
    let emergency = "node 5: emergency 5000h (device hardware), error register 01h, 01 02 03 04 05; see its manual";
    assert_eq!(faults, [(FaultKind::Device, emergency)]);
}

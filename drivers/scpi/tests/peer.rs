//! The driver against an instrument of another make: pyvisa-sim, over TCP.
//!
//! The interpreter is that of the environment variable ASPHERA_PYTHON, else `python3`; without pyvisa-sim the
//! tests are skipped.

use std::io::{BufRead as _, BufReader, ErrorKind, Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asphera_link::{Event, FaultKind, Flags, Input, Nanos, Output, Reading};
use asphera_scpi::FAMILY;

#[test]
fn pyvisa_sim_is_asked() {
    let Some(python) = python() else { return };
    let peer = Peer::start(&python);
    let settings = "identity = 'BRISTOL.*'\nquery = 'FETC:WAV?'\ninterval_ms = 20\ntimeout_ms = 300\n\
        field = [{ name = 'wavelength', unit = 'mm', scale = 1e-6 }]";
    let events = peer.run(settings, |events| readings(events).len() >= 5);
    assert_eq!(events[0], Event::Online);
    let reading = readings(&events)[4].clone();
    assert!((reading.values.get(0).expect("a wavelength") - 632.991e-6).abs() < 1e-15);
    assert!(reading.flags.is_empty());
    assert!(faults(&events).is_empty(), "{events:?}");
}

#[test]
fn numbers_of_scpi_that_are_none() {
    let Some(python) = python() else { return };
    let peer = Peer::start(&python);
    let settings = "identity = 'BRISTOL.*'\nquery = 'FETC:BOTH?'\ncolumns = 2\ninterval_ms = 20\n\
        field = [{ name = 'wavelength' }, { name = 'power', column = 2 }]";
    let events = peer.run(settings, |events| readings(events).len() >= 2);
    let reading = readings(&events)[0].clone();
    assert_eq!(reading.values.iter().collect::<Vec<_>>(), [Some(632.991), None]);
    assert_eq!(reading.flags, Flags::NO_SIGNAL);
}

#[test]
fn pyvisa_sim_queues_an_error_for_what_it_does_not_know() {
    let Some(python) = python() else { return };
    let peer = Peer::start(&python);
    let settings = "identity = 'BRISTOL.*'\nquery = 'FETC:POW?'\ninterval_ms = 20\ntimeout_ms = 200\n\
        setup = ['CONF:NONE']\nfield = [{ name = 'power' }]";
    let found = |events: &[Event]| faults(events).len() >= 3;
    let events = peer.run(settings, found);
    let expected = [
        (
            FaultKind::Device,
            "the device reports the error `-113,\"Undefined header\"`: see its manual",
        ),
        (
            FaultKind::Timeout,
            "no answer to `FETC:POW?\\n` within 200 ms: check cable and power, or increase timeout_ms",
        ),
        (
            FaultKind::Device,
            "the device reports the error `-113,\"Undefined header\"`: see its manual",
        ),
    ];
    assert_eq!(faults(&events)[..3], expected.map(|(kind, text)| (kind, text.to_owned())));
    assert!(readings(&events).is_empty());
}

fn readings(events: &[Event]) -> Vec<Reading> {
    let reading = |event: &Event| match event {
        Event::Reading(reading) => Some(reading.clone()),
        _ => None,
    };
    events.iter().filter_map(reading).collect()
}

fn faults(events: &[Event]) -> Vec<(FaultKind, String)> {
    let fault = |event: &Event| match event {
        Event::Fault(fault) | Event::Reopen(fault) => Some((fault.kind, fault.detail.clone())),
        _ => None,
    };
    events.iter().filter_map(fault).collect()
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn python() -> Option<String> {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let import = Command::new(&python).args(["-c", "import pyvisa, pyvisa_sim"]).output();
    if import.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: pyvisa-sim for {python} not found");
    None
}

/// The running peer; ends with the test.
struct Peer {
    child: Child,
    port: u16,
}

impl Peer {
    fn start(python: &str) -> Peer {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests");
        let port = {
            let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
            listener.local_addr().expect("a bound listener has an address").port()
        };
        let mut child = Command::new(python)
            .args([format!("{folder}/peer.py"), format!("{folder}/peer.yaml"), port.to_string()])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the interpreter starts");
        let stdout = child.stdout.take().expect("stdout is piped");
        let mut line = String::new();
        BufReader::new(stdout).read_line(&mut line).expect("the peer speaks");
        assert_eq!(line.trim(), "ready");
        Peer { child, port }
    }

    /// Drives the driver until what happened is enough, at most 20 s.
    #[expect(clippy::disallowed_methods, reason = "a real device answers in real time")]
    fn run(&self, settings: &str, enough: impl Fn(&[Event]) -> bool) -> Vec<Event> {
        let settings = FAMILY.parse("meter", settings).expect("settings of a test are sound");
        let mut driver = settings.driver().expect("settings of a test are sound");
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("the peer listens");
        stream.set_read_timeout(Some(Duration::from_millis(2))).expect("a read timeout");
        let start = Instant::now();
        let now = || Nanos::ZERO + start.elapsed();
        let mut events = Vec::new();
        driver.connected(now());
        while !enough(&events) {
            assert!(start.elapsed() < Duration::from_secs(20), "{events:?}");
            while let Some(Output::Bytes(bytes)) = driver.poll_transmit() {
                stream.write_all(&bytes).expect("the peer listens");
            }
            let mut bytes = [0; 300];
            match stream.read(&mut bytes) {
                Ok(0) => panic!("the peer closed the link"),
                Ok(len) => driver.receive(now(), Input::Bytes(&bytes[..len])),
                Err(error)
                    if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => panic!("reading from the peer: {error}"),
            }
            if driver.poll_timeout().is_some_and(|due| due <= now()) {
                driver.timeout(now());
            }
            events.extend(std::iter::from_fn(|| driver.poll_event()));
        }
        events
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

//! The driver against a Modbus device of another make: pymodbus, over TCP and over a serial line.
//!
//! The interpreter is that of the environment variable ASPHERA_PYTHON, else `python3`; without
//! pymodbus the tests are skipped. Pseudo-terminals refuse parity, so the serial line has none.

use std::io::{BufRead as _, BufReader, ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use asphera_link::{Driver as _, Event, FaultKind, Input, Nanos, Output, Reading, Unit};
use asphera_modbus::{Field, Function, Kind, Map, Modbus, Settings, Transport};
use serialport::{SerialPort as _, TTYPort};

#[test]
fn pymodbus_over_tcp() {
    let Some(python) = python() else { return };
    let port = free_port();
    let _peer = Peer::start(&python, "tcp", &port.to_string());
    let mut stream = connect(port);
    let mut driver = driver(Transport::Tcp, "baumer-om20");
    let events = run(&mut driver, &mut stream, |driver| driver.tally().repeated >= 3);
    check_om20(&driver, &events);
}

#[test]
fn pymodbus_over_a_serial_line() {
    let Some(python) = python() else { return };
    let (mut master, slave) = TTYPort::pair().expect("a pseudo-terminal");
    master.set_timeout(PATIENCE).expect("a read timeout");
    let path = slave.name().expect("a pseudo-terminal has a path");
    // The peer wants the port for itself.
    drop(slave);
    let _peer = Peer::start(&python, "rtu", &path);
    let mut driver = driver(Transport::Rtu, "baumer-om20");
    let events = run(&mut driver, &mut master, |driver| driver.tally().repeated >= 3);
    check_om20(&driver, &events);
}

#[test]
fn pymodbus_refuses_what_it_does_not_have() {
    let Some(python) = python() else { return };
    let port = free_port();
    let _peer = Peer::start(&python, "tcp", &port.to_string());
    let mut stream = connect(port);
    let field =
        |name, address| Field::channel(name, Function::ReadHolding, address, Kind::U16, Unit::One);
    let fields = vec![field("precision", 101), field("average", 103), field("nothing", 900)];
    let map = Map { name: "holding".to_owned(), fields, blocks: Vec::new() };
    let mut driver = driver(Transport::Tcp, map);
    let events = run(&mut driver, &mut stream, |driver| driver.tally().readings >= 2);
    let refused = "unit 1 refused to read holding registers 900: illegal data address (exception 2); check unit_id and the map of registers";
    let is_refusal = |event: &Event| matches!(event, Event::Fault(fault) if fault.kind == FaultKind::Refused && fault.detail == refused);
    assert!(events.iter().any(is_refusal), "{events:?}");
    let values: Vec<_> = readings(&events)[1].values.iter().collect();
    assert_eq!(values, [Some(1.0), Some(3.0), None]);
}

fn check_om20(driver: &Modbus, events: &[Event]) {
    assert_eq!(events[0], Event::Online);
    let readings = readings(events);
    assert_eq!(readings.len(), 1, "the device time stands still");
    let reading = readings[0].clone();
    assert!((reading.values.get(0).expect("a distance") - 69.7426).abs() < 5e-5);
    let rest: Vec<_> = reading.values.iter().skip(1).collect();
    assert_eq!(rest, [Some(500.0), Some(87.0), Some(2000.0 * 1e-6), Some(1.0)]);
    assert_eq!(reading.device_time_ns, Some(12_345_678_000));
    assert!(reading.flags.is_empty());
    let tally = driver.tally();
    assert_eq!((tally.timeouts, tally.refused, tally.discarded_bytes), (0, 0, 0), "{tally:?}");
}

fn driver(transport: Transport, map: impl Into<asphera_modbus::MapSource>) -> Modbus {
    let settings = Settings {
        transport,
        map: map.into(),
        poll_interval_ms: 20,
        timeout_ms: 1000,
        late_limit_ms: Some(1000),
        ..Settings::default()
    };
    Modbus::new(settings).expect("settings of a test are sound")
}

fn readings(events: &[Event]) -> Vec<Reading> {
    let reading = |event: &Event| match event {
        Event::Reading(reading) => Some(reading.clone()),
        _ => None,
    };
    events.iter().filter_map(reading).collect()
}

/// Drives the driver over a stream until it is `done`, at most 20 s.
#[expect(clippy::disallowed_methods, reason = "a real device answers in real time")]
fn run(
    driver: &mut Modbus,
    stream: &mut (impl Read + Write),
    done: impl Fn(&Modbus) -> bool,
) -> Vec<Event> {
    let start = Instant::now();
    let now = || Nanos::ZERO + start.elapsed();
    let mut events = Vec::new();
    driver.connected(now());
    while !done(driver) {
        assert!(start.elapsed() < Duration::from_secs(20), "{:?} {events:?}", driver.tally());
        while let Some(Output::Bytes(bytes)) = driver.poll_transmit() {
            stream.write_all(&bytes).expect("the peer listens");
        }
        let mut bytes = [0; 300];
        match stream.read(&mut bytes) {
            Ok(0) => panic!("the peer closed the link"),
            Ok(len) => driver.receive(now(), Input::Bytes(&bytes[..len])),
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(error) => panic!("reading from the peer: {error}"),
        }
        if driver.poll_timeout().is_some_and(|due| due <= now()) {
            driver.timeout(now());
        }
        while let Some(event) = driver.poll_event() {
            events.push(event);
        }
    }
    events
}

#[expect(clippy::print_stderr, reason = "a skipped test says so")]
fn python() -> Option<String> {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let import = Command::new(&python).args(["-c", "import pymodbus.simulator, serial"]).output();
    if import.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!("skipped: pymodbus 3.16 and pyserial for {python} not found");
    None
}

fn free_port() -> u16 {
    let listener = TcpListener::bind(("127.0.0.1", 0)).expect("a free port");
    listener.local_addr().expect("a bound listener has an address").port()
}

fn connect(port: u16) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", port)).expect("the peer listens");
    stream.set_read_timeout(Some(PATIENCE)).expect("a read timeout");
    stream
}

/// The running peer; ends with the test.
struct Peer(Child);

impl Peer {
    fn start(python: &str, kind: &str, place: &str) -> Peer {
        let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py");
        let mut child = Command::new(python)
            .args([script, kind, place])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the interpreter starts");
        let stdout = child.stdout.take().expect("stdout is piped");
        let mut line = String::new();
        BufReader::new(stdout).read_line(&mut line).expect("the peer speaks");
        assert_eq!(line.trim(), "ready");
        Peer(child)
    }
}

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

const PATIENCE: Duration = Duration::from_millis(2);

//! Logs against python-can, and a connection against a server of socketcand written in python.
//!
//! Needs an interpreter with python-can (tried: 4.6.1), named by the environment variable `ASPHERA_PYTHON` or found as
//! `python3`; skipped without.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use asphera_cantext::candump::{self, Content, Line};
use asphera_cantext::socketcand::{self, Client, Event};
use asphera_link::{CanFrame, CanId};

/// The server; it ends with the test.
struct Peer(Child);

impl Drop for Peer {
    fn drop(&mut self) {
        // It may have ended by itself: then there is nothing to end.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The peer with its arguments, or `None` where no interpreter has python-can.
#[expect(clippy::print_stderr, reason = "what is skipped must be seen")]
fn peer(arguments: &[&str]) -> Option<Command> {
    let python = std::env::var("ASPHERA_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let found = Command::new(&python)
        .args(["-c", "import can"])
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success());
    if !found {
        eprintln!("skipped: {python} cannot import can");
        return None;
    }
    let mut command = Command::new(python);
    command.arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/peer.py")).args(arguments);
    Some(command)
}

/// A line as the peer prints what it read.
fn shown(line: &Line<'_>) -> String {
    let us = line.time_ns / 1000;
    match line.content {
        Content::Frame(frame) => {
            let kind = match frame.fd() {
                Some(fd) => match (fd.bit_rate_switch, fd.error_passive) {
                    (false, false) => "fd",
                    (true, false) => "fd-brs",
                    (false, true) => "fd-esi",
                    (true, true) => "fd-brs-esi",
                },
                None if frame.is_remote() => "remote",
                None => "data",
            };
            let name = match frame.id() {
                CanId::Standard(id) => format!("{id:03X}"),
                CanId::Extended(id) => format!("{id:08X}"),
            };
            let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
            let len = if frame.is_remote() { frame.dlc() } else { frame.data().len() };
            format!("{us},{},{kind},{name},{len},{data}", line.interface)
        }
        Content::BusError(error) => {
            assert_eq!(error.0, 0x80, "python-can writes bus errors alone");
            format!("{us},,error,,0,")
        }
        Content::ExtraLong => panic!("python-can writes no CAN XL"),
    }
}

#[test]
fn python_can_and_we_read_the_same_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("bus.log");
    let path = path.to_str().expect("UTF-8");
    let Some(mut write) = peer(&["write", path]) else { return };
    assert!(write.status().expect("it just ran").success());
    let text = std::fs::read(path).expect("it was written");
    let lines: Vec<&[u8]> =
        text.split(|&byte| byte == b'\n').filter(|line| !line.is_empty()).collect();
    let ours: Vec<String> =
        lines.iter().map(|line| shown(&Line::parse(line).expect("a line of candump"))).collect();

    // Frames of a log that we write are read there in the same way.
    let mut log = String::new();
    for line in &lines {
        let line = Line::parse(line).expect("it was read before");
        if let Content::Frame(frame) = line.content {
            candump::encode(line.time_ns / 1000, line.interface, &frame, &mut log);
        }
    }
    let again = folder.path().join("again.log");
    std::fs::write(&again, log).expect("a file");
    let read = |path: &str| {
        let output = peer(&["read", path]).expect("it ran before").output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("ASCII").lines().map(str::to_owned).collect()
    };
    let theirs: Vec<String> = read(path);
    assert_eq!((ours.len(), theirs.len()), (200, 200));
    assert_eq!(ours, theirs);
    assert_eq!(ours.iter().filter(|line| line.contains(",fd-brs-esi,")).count(), 6);
    let theirs: Vec<String> = read(again.to_str().expect("UTF-8"));
    let frames: Vec<&String> = ours.iter().filter(|line| !line.contains(",error,")).collect();
    assert_eq!(theirs.iter().collect::<Vec<_>>(), frames);
}

fn connect(bus: &str) -> Option<(Peer, TcpStream)> {
    let child = peer(&["serve", bus])?.stdout(Stdio::piped()).spawn().expect("it just ran");
    let mut server = Peer(child);
    let mut port = String::new();
    let out = server.0.stdout.take().expect("piped");
    BufReader::new(out).read_line(&mut port).expect("the server says its port");
    let stream = TcpStream::connect(format!("127.0.0.1:{}", port.trim())).expect("it listens");
    stream.set_read_timeout(Some(Duration::from_secs(20))).expect("TCP");
    Some((server, stream))
}

/// Runs a connection until it has given `frames`, or failed.
fn run(client: &mut Client, stream: &mut TcpStream, send: &[CanFrame]) -> Vec<Event> {
    let (mut events, mut buffer) = (Vec::new(), [0; 64]);
    loop {
        let count = stream.read(&mut buffer).expect("the server answers");
        let mut input = &buffer[..count];
        while !input.is_empty() {
            match client.receive(&mut input) {
                Some(Event::Send(bytes)) => stream.write_all(&bytes).expect("the server reads"),
                Some(Event::Open) => {
                    let mut bytes = Vec::new();
                    send.iter().for_each(|frame| socketcand::encode(frame, &mut bytes));
                    stream.write_all(&bytes).expect("the server reads");
                }
                event => events.extend(event),
            }
        }
        let failed = matches!(events.last(), Some(Event::Failed(_)));
        if events.len() >= send.len() && !events.is_empty() || failed || count == 0 {
            return events;
        }
    }
}

#[test]
fn frames_go_to_a_server_and_come_back() {
    let Some((_server, mut stream)) = connect("can0") else { return };
    let send: Vec<CanFrame> = (0..=8)
        .flat_map(|len| {
            let data = [0x00, 0x0F, 0xF0, 0xFF, 0x1A, 0xA1, 0x80, 0x08];
            let ids = [CanId::Standard(len as u16), CanId::Extended(0x1AAA_AAAA)];
            ids.map(|id| CanFrame::data_frame(id, &data[..len]).expect("a good frame"))
        })
        .chain([CanFrame::remote_frame(CanId::Extended(5), 4).expect("a good frame")])
        .collect();
    let events = run(&mut Client::new("can0"), &mut stream, &send);
    let expected: Vec<Event> = send.into_iter().map(Event::Frame).collect();
    assert_eq!(events, expected);
}

#[test]
fn a_bus_that_the_server_does_not_have_is_named() {
    let Some((_server, mut stream)) = connect("can0") else { return };
    let events = run(&mut Client::new("can7"), &mut stream, &[]);
    let [Event::Failed(words)] = &events[..] else { panic!("{events:?}") };
    assert!(words.contains("can7") && words.contains("could not open bus"), "{words}");
}

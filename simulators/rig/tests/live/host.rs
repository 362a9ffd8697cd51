//! Hosts that know the wire and nothing else.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::path::Path;
use std::time::Duration;

use asphera_rig::{Rig, Scene};

/// Far longer than any of these tests takes.
pub(crate) const PATIENCE: Duration = Duration::from_secs(60);

/// Starts a bench in a folder of its own.
pub(crate) async fn start(scene: Scene) -> (tempfile::TempDir, Rig) {
    let dir = tempfile::tempdir().unwrap();
    let rig = Rig::start(scene, &dir.path().join("ports")).await.unwrap();
    (dir, rig)
}

/// The address of a link of the bench.
pub(crate) fn address(rig: &Rig, name: &str) -> String {
    let listing = rig.listing();
    listing.iter().find(|device| device.name == name).unwrap().address.clone()
}

/// A serial port, opened as a plain file: the pseudo-terminal is raw from the start.
#[derive(Debug)]
pub(crate) struct Host {
    port: File,
    held: Vec<u8>,
}

impl Host {
    pub(crate) fn open(path: impl AsRef<Path>) -> Host {
        let port = OpenOptions::new().read(true).write(true).open(path).unwrap();
        Host { port, held: Vec::new() }
    }

    pub(crate) fn say(&mut self, said: &str) {
        self.port.write_all(said.as_bytes()).unwrap();
    }

    /// Everything up to and with the end; `None` when the line hangs up.
    pub(crate) fn until(&mut self, end: &[u8]) -> Option<Vec<u8>> {
        loop {
            if let Some(place) = self.held.windows(end.len()).position(|window| window == end) {
                return Some(self.held.drain(..place + end.len()).collect());
            }
            self.more()?;
        }
    }

    /// So many bytes; `None` when the line hangs up.
    pub(crate) fn exactly(&mut self, len: usize) -> Option<Vec<u8>> {
        while self.held.len() < len {
            self.more()?;
        }
        Some(self.held.drain(..len).collect())
    }

    fn more(&mut self) -> Option<()> {
        let mut bytes = [0; 4096];
        match self.port.read(&mut bytes) {
            Ok(len) if len > 0 => {
                self.held.extend(&bytes[..len]);
                Some(())
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => Some(()),
            _ => None,
        }
    }
}

/// A telegram of the signals 75, 76, 65, 256 and 257.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Telegram {
    pub(crate) exposure: u16,
    pub(crate) encoder: i32,
    pub(crate) distance_um: f32,
}

/// A CHRocodile's host: has each exposure triggered, sent in binary, and the data started.
pub(crate) fn arm_probe(path: impl AsRef<Path>) -> Host {
    let mut host = Host::open(path);
    for command in ["$STO", "$BIN", "$SODX 75 76 65 256 257", "$TRE", "$STA"] {
        host.say(&format!("{command}\r"));
        // Telegrams of a scan that already runs may come before the answer.
        let answer = host.until(b"ready\r\n").unwrap();
        assert!(!String::from_utf8_lossy(&answer).contains("not valid"), "{answer:?}");
    }
    host
}

pub(crate) fn telegram(host: &mut Host) -> Option<Telegram> {
    let bytes = host.exactly(18)?;
    assert_eq!(bytes[..2], [0xFF, 0xFF], "no sync where it is due: {bytes:02X?}");
    // 16-bit numbers come with the high byte first, 32-bit numbers with the low byte first.
    let telegram = Telegram {
        exposure: u16::from_be_bytes([bytes[2], bytes[3]]),
        encoder: i32::from_le_bytes(bytes[6..10].try_into().unwrap()),
        distance_um: f32::from_le_bytes(bytes[10..14].try_into().unwrap()),
    };
    assert_eq!(bytes[4..6], [0, 0], "exposure flags");
    assert_eq!(f32::from_le_bytes(bytes[14..18].try_into().unwrap()), 100.0);
    Some(telegram)
}

/// A host of the stage: opens the adapter's channel at 1 Mbit/s and has the nodes answer each SYNC
/// with their position alone.
pub(crate) fn arm_stage(path: impl AsRef<Path>, nodes: &[u8]) -> Host {
    let mut host = open_stage(path);
    for node in nodes {
        for data in [
            // 1800.01h off, 1800.02h each SYNC, 1019h counter to 240, 1A00h one object: 6020.01h.
            format!("23001801{:02X}010080", 0x80 + node),
            "2F00180201000000".to_owned(),
            "2F191000F0000000".to_owned(),
            "2F001A0000000000".to_owned(),
            "23001A0120012060".to_owned(),
            "2F001A0001000000".to_owned(),
            format!("23001801{:02X}010000", 0x80 + node),
        ] {
            host.say(&format!("t6{node:02X}8{data}\r"));
            let done = format!("t5{:02X}860{}", 0x80 + node, &data[2..8]);
            host.until(done.as_bytes()).unwrap();
            host.until(b"\r").unwrap();
        }
        host.say(&format!("t000201{node:02X}\r"));
    }
    host
}

/// Ends the data of the probe and takes the nodes into pre-operational, as a host does that wants no more.
pub(crate) fn disarm(probe: &mut Host, stage: &mut Host) {
    probe.say("$STO\r");
    probe.until(b"ready\r\n").unwrap();
    stage.say("t00028000\r");
}

/// Opens the adapter's channel; it may be open already.
pub(crate) fn open_stage(path: impl AsRef<Path>) -> Host {
    let mut host = Host::open(path);
    host.say("C\rS8\rO\rV\r");
    host.until(b"V1013\r").unwrap();
    host
}

/// The next SYNC and the positions of so many nodes after it, all whole; other lines are passed
/// over. `None` when the line hangs up.
pub(crate) fn cycle(host: &mut Host, nodes: usize) -> Option<(u8, Vec<i32>)> {
    loop {
        let line = host.until(b"\r")?;
        let line = String::from_utf8(line).unwrap();
        let line = line.trim_start_matches('\x07').trim_end();
        let Some(counter) = line.strip_prefix("t0801") else { continue };
        let counter = u8::from_str_radix(counter, 16).unwrap();
        let mut positions = Vec::new();
        for _ in 0..nodes {
            let line = String::from_utf8(host.until(b"\r")?).unwrap();
            let bytes = line.trim_end().strip_prefix("t18").unwrap();
            // The last digit of the identifier 180h + node, and four bytes of position.
            assert_eq!(bytes.as_bytes()[1], b'4', "{line}");
            let position = u32::from_str_radix(&bytes[2..], 16).unwrap().swap_bytes();
            positions.push(position.cast_signed());
        }
        return Some((counter, positions));
    }
}

/// Runs what blocks beside the bench.
pub(crate) async fn aside<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    tokio::time::timeout(PATIENCE, tokio::task::spawn_blocking(work)).await.unwrap().unwrap()
}

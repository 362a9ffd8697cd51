//! Tests of recording and reading together.

mod damage;
mod faults;
mod kill;
mod memory_disk;
mod python;
mod round_trip;

use std::path::Path;

use asphera_link::{Command, Nanos};

use super::{
    Disk, Entries, Entry, Header, LinkInfo, ReadError, Recorder, Recovery, Session, SessionId,
    Settings, What,
};

fn header() -> Header {
    let link = |name: &str, kind: &str, address: &str| LinkInfo {
        name: name.to_owned(),
        kind: kind.to_owned(),
        address: address.to_owned(),
    };
    Header {
        id: SessionId(0xbad_cafe),
        station: "bench".to_owned(),
        version: "0.1.0".to_owned(),
        started_wall_ns: 1_795_221_606_500_000_000,
        config_toml: "[station]\nname = \"bench\"\n".to_owned(),
        links: vec![
            link("probe", "tcp", "192.168.170.2:7891"),
            link("stage", "serial", "/dev/ttyUSB0"),
            link("axes", "can", "can0"),
        ],
        label: asphera_report::Label::default(),
    }
}

/// Small chunks, no reserve.
fn settings() -> Settings {
    Settings { chunk_bytes: 1024, reserve_bytes: 0, ..Settings::default() }
}

/// The entry of an index, 1 ms after the one before. No two are equal.
fn entry(index: u64) -> Entry {
    let link = (index % 3) as usize;
    let bytes: Vec<u8> =
        (0..index % 41).map(|byte| (byte * 7 + index) as u8).chain(index.to_le_bytes()).collect();
    let what = match index {
        0..3 => What::Opened { link },
        3 => What::Command(Command::Start),
        _ if index.is_multiple_of(19) => {
            What::Closed { link, reason: format!("end of stream {index}") }
        }
        _ if index.is_multiple_of(7) => What::Sent { link, bytes },
        _ => What::Received { link, bytes },
    };
    Entry { at: Nanos::from_millis(index), what }
}

fn entries(count: u64) -> Vec<Entry> {
    (0..count).map(entry).collect()
}

fn create(parent: &Path, settings: Settings) -> Recorder {
    Recorder::create(parent, header(), settings, Box::new(Disk), Nanos::ZERO).unwrap()
}

/// Records `count` entries and finishes.
fn record(parent: &Path, settings: Settings, count: u64) -> super::Summary {
    let mut recorder = create(parent, settings);
    entries(count).iter().for_each(|entry| recorder.append(entry).unwrap());
    recorder.finish(Nanos::from_millis(count), "complete", None).unwrap()
}

/// Entries as [`record`] leaves them.
fn recorded(count: u64) -> Vec<Entry> {
    let what = What::Finish { reason: "complete".to_owned() };
    entries(count).into_iter().chain([Entry { at: Nanos::from_millis(count), what }]).collect()
}

/// All entries of a session, and what was found.
fn read(path: &Path) -> Result<(Vec<Entry>, Recovery), ReadError> {
    read_entries(Session::open(path)?.entries())
}

fn read_entries(mut entries: Entries) -> Result<(Vec<Entry>, Recovery), ReadError> {
    let all = entries.by_ref().collect::<Result<Vec<_>, _>>()?;
    Ok((all, entries.recovery().clone()))
}

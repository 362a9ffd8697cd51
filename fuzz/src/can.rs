//! CAN frames as text and as records, cut anyhow, and settings of devices on a bus; and what must hold for whatever is read of them.
//!
//! The first byte of an input says what it is, the second into pieces of how many bytes it is cut: 0 leaves it whole. The text or the
//! records follow; a device of its own settings has them before the first zero byte, and its records after it.

use std::fmt::Debug;

use asphera_cantext::candump::{self, Content, Line};
use asphera_cantext::socketcand::{self, Client};
use asphera_link::{CanFrame, Command, Event, Family, Input, Nanos};
use asphera_slcan::{StampClock, Timestamps};

/// Reads an input and checks what came out of it.
///
/// # Panics
///
/// Where a law is broken.
pub fn hold(input: &[u8]) {
    let [which, cut, bytes @ ..] = input else { return };
    let cut = usize::from(*cut);
    match which % 8 {
        0 => adapter(Timestamps::Maybe, bytes, cut),
        1 => adapter(Timestamps::Never, bytes, cut),
        2 => adapter(Timestamps::Always, bytes, cut),
        3 => log(None, bytes, cut),
        4 => log(Some("can0"), bytes, cut),
        5 => server(bytes, cut),
        6 => session(bytes, cut),
        _ => device(bytes),
    }
}

/// Lines of an slcan adapter. A frame is written as it was read; its stamp is one of the adapter's clock, and gives no time to come.
fn adapter(timestamps: Timestamps, bytes: &[u8], cut: usize) {
    let read = |cut| {
        let mut decoder = asphera_slcan::Decoder::expecting(timestamps);
        let items = items(bytes, cut, |input| decoder.decode(input));
        (items, decoder.pending())
    };
    let (found, pending) = read(0);
    assert_eq!(read(cut), (found.clone(), pending), "pieces change what is read");
    let mut malformed = pending;
    let (mut clock, mut now) = (StampClock::default(), Nanos::ZERO);
    for item in found {
        match item {
            asphera_slcan::Item::Frame(frame, stamp) => {
                assert!(stamp.is_none() || timestamps != Timestamps::Never);
                assert!(stamp.is_some() || timestamps != Timestamps::Always);
                now = now + std::time::Duration::from_millis(40);
                if let Some(stamp_ms) = stamp {
                    assert!(stamp_ms < asphera_slcan::TIMESTAMP_MODULUS_MS);
                    assert!(clock.take(stamp_ms, now).at <= now, "a time to come");
                }
                let mut line = Vec::new();
                match stamp {
                    Some(stamp_ms) => {
                        asphera_slcan::encode_timestamped(&frame, stamp_ms.into(), &mut line);
                    }
                    None => asphera_slcan::encode(&frame, &mut line),
                }
                let mut decoder = asphera_slcan::Decoder::expecting(timestamps);
                let again = decoder.decode(&mut line.as_slice());
                assert_eq!(again, Some(asphera_slcan::Item::Frame(frame, stamp)));
            }
            asphera_slcan::Item::Malformed { bytes } => malformed += bytes,
            _ => {}
        }
    }
    assert!(malformed <= bytes.len() as u64, "more is malformed than came");
}

/// Lines of a log of candump. A frame is written as it was read, and a line that is left out is said in words.
fn log(interface: Option<&str>, bytes: &[u8], cut: usize) {
    let read = |cut| {
        let reader = candump::Reader::new(interface.map(str::to_owned));
        let mut reader = reader.with_fd(interface.is_none());
        let items = items(bytes, cut, |input| reader.read(input));
        (items, reader.pending(), reader.summary())
    };
    let whole = read(0);
    assert_eq!(read(cut), whole, "pieces change what is read");
    is_readable(&whole.2);
    let mut left_out = whole.1;
    for item in whole.0 {
        match item {
            candump::Item::Frame(frame) => {
                assert!(frame.fd().is_none() || interface.is_none(), "nobody wants CAN FD");
                let mut line = String::new();
                candump::encode(1_436_509_052_249_713, "can0", &frame, &mut line);
                let again = Line::parse(line.trim_end().as_bytes());
                let again = again.unwrap_or_else(|error| panic!("{line:?}: {error}"));
                assert_eq!(again.content, Content::Frame(frame), "{line:?}");
            }
            candump::Item::BusError(_) => {}
            candump::Item::LeftOut { bytes, why } => {
                left_out += bytes;
                is_readable(&why);
            }
        }
    }
    assert!(left_out <= bytes.len() as u64, "more is left out than came");
}

/// Elements of a server of socketcand.
fn server(bytes: &[u8], cut: usize) {
    let read = |cut| {
        let mut decoder = socketcand::Decoder::new();
        let items = items(bytes, cut, |input| decoder.decode(input));
        (items, decoder.pending())
    };
    let (found, pending) = read(0);
    assert_eq!(read(cut), (found.clone(), pending), "pieces change what is read");
    for item in found {
        match item {
            socketcand::Item::Frame(frame) => {
                let mut command = Vec::new();
                socketcand::encode(&frame, &mut command);
                assert!(command.starts_with(b"< send") && command.ends_with(b" >"));
                assert!(command.is_ascii() && command.len() <= socketcand::MAX_ELEMENT);
            }
            socketcand::Item::Refused(words) | socketcand::Item::Other(words) => {
                is_readable(&words);
            }
            _ => {}
        }
    }
}

/// A connection to such a server: nothing comes before the bus is open, nor after it failed, and what is sent are two commands.
fn session(bytes: &[u8], cut: usize) {
    let read = |cut| {
        let mut client = Client::new("can0");
        let events = items(bytes, cut, |input| client.receive(input));
        (events, client.is_open(), client.is_waiting(), client)
    };
    let (events, is_open, is_waiting, mut client) = read(0);
    let again = read(cut);
    assert_eq!((&again.0, again.1, again.2), (&events, is_open, is_waiting));
    let (mut open, mut failed, mut sent) = (false, false, 0);
    for event in &events {
        match event {
            socketcand::Event::Send(_) => sent += 1,
            socketcand::Event::Open => open = true,
            socketcand::Event::Frame(_) => assert!(open && !failed, "a frame of a closed bus"),
            socketcand::Event::Failed(words) => {
                is_readable(words);
                failed = true;
            }
            socketcand::Event::Refused(words) => is_readable(words),
            socketcand::Event::BusError(_) | socketcand::Event::Discarded { .. } => {}
        }
    }
    assert!(sent <= 2 && open >= is_open && !(is_open && is_waiting));
    is_readable(&client.expire());
}

/// A device of settings that somebody wrote, on a bus. What is wrong with them is said with its line; a device that is none of these
/// settings' fault reads whatever frames come.
fn device(bytes: &[u8]) {
    let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
    let (text, records) = bytes.split_at(end);
    let (which, text) = text.split_first().unwrap_or((&0, &[]));
    let family: Family =
        [asphera_described::FAMILY, asphera_cia406::FAMILY, asphera_cia402::FAMILY]
            [usize::from(*which) % 3];
    let text = String::from_utf8_lossy(text).into_owned();
    let settings = match family.parse("settings", &text) {
        Ok(settings) => settings,
        Err(problems) => {
            assert!(!problems.0.is_empty(), "refused for nothing");
            for problem in &problems.0 {
                let is_there = (1..=text.lines().count().max(1) + 1).contains(&problem.line);
                assert!(is_there && !problem.expected.is_empty(), "{problem}");
            }
            return;
        }
    };
    let mut driver = settings.driver().unwrap_or_else(|problems| panic!("{problems:?}"));
    let channels = driver.channels().len();
    assert_eq!(settings.channels().len(), channels);
    driver.connected(Nanos::ZERO);
    driver.command(Nanos::ZERO, Command::Start);
    let mut left = records.get(1..).unwrap_or_default();
    while !left.is_empty() {
        let (record, after) = CanFrame::split_record(left);
        left = after;
        if let Ok(frame) = CanFrame::from_record(record) {
            assert_eq!(CanFrame::from_record(&frame.to_record()), Ok(frame));
            if frame.fd().is_none() || driver.reads_fd() {
                driver.receive(Nanos::ZERO, Input::Frame(&frame));
            }
        }
        let mut events = 0;
        while let Some(event) = driver.poll_event() {
            events += 1;
            assert!(events < 100, "it does not stop");
            match event {
                Event::Reading(reading) => assert_eq!(reading.values.len(), channels),
                Event::Fault(fault) | Event::Reopen(fault) => is_readable(&fault.detail),
                _ => {}
            }
        }
        while driver.poll_transmit().is_some() {}
    }
}

/// All that is read of bytes in pieces of so many; 0 leaves them whole.
fn items<T: Debug>(
    bytes: &[u8],
    cut: usize,
    mut read: impl FnMut(&mut &[u8]) -> Option<T>,
) -> Vec<T> {
    let mut found = Vec::new();
    for mut piece in bytes.chunks(if cut == 0 { bytes.len().max(1) } else { cut }) {
        while !piece.is_empty() {
            let before = piece.len();
            let item = read(&mut piece);
            assert!(item.is_some() || piece.len() < before, "it spins");
            found.extend(item);
            assert!(found.len() <= bytes.len() + 8, "more items than bytes");
        }
    }
    found
}

/// Words for a person: some, not too many, and none that move a terminal.
fn is_readable(words: &str) {
    assert!(words.chars().count() <= 600 && !words.contains(char::is_control), "{words:?}");
}

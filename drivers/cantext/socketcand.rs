//! The protocol of socketcand: elements in angle brackets over TCP, port 29536.
//!
//! ```text
//! server                                   client
//! < hi >
//!                                          < open can0 >
//! < ok >                                                    or < error … > and the end
//!                                          < rawmode >
//! < ok >
//! < frame 123 23.424242 11223344 >         < send 123 4 11 22 33 44 >
//! < rtr 123 23.424242 4 >                  < sendrtr 123 4 >
//! < error 040 23.424242 >
//! ```
//!
//! The document shows data with blanks between bytes, the server sends them without; both are read.

use std::fmt::Write as _;

use asphera_link::{CanFrame, CanId, shown};

use crate::BusError;
use crate::hex;

mod client;
mod decoder;

pub use client::{Client, Event, HANDSHAKE_TIME};
pub use decoder::{Decoder, MAX_ELEMENT};

/// Longest name of a bus, as the document has it.
pub const MAX_BUS_NAME: usize = 16;

/// Element that a server sends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Item {
    /// `< hi >`: the greeting.
    Greeting,
    /// `< ok >`: the last command was done.
    Done,
    /// `< frame … >` or `< rtr … >`.
    Frame(CanFrame),
    /// `< error CLASSES TIME >`: trouble on the bus.
    BusError(BusError),
    /// `< error words >`: a command was refused.
    Refused(String),
    /// Another element, as its text.
    Other(String),
    /// Bytes that are no element.
    Malformed {
        /// How many.
        bytes: u64,
    },
}

/// Appends the command that sends a frame; nothing for a CAN FD frame, for which the protocol has no command.
pub fn encode(frame: &CanFrame, out: &mut Vec<u8>) {
    if frame.fd().is_some() {
        return;
    }
    let verb = if frame.is_remote() { "sendrtr" } else { "send" };
    let mut text = match frame.id() {
        CanId::Standard(id) => format!("< {verb} {id:03X} {}", frame.dlc()),
        CanId::Extended(id) => format!("< {verb} {id:08X} {}", frame.dlc()),
    };
    for byte in frame.data() {
        // Writing to a string cannot fail.
        let _ = write!(text, " {byte:X}");
    }
    text.push_str(" >");
    out.extend_from_slice(text.as_bytes());
}

/// Item of the text between two brackets.
fn parse(element: &[u8]) -> Item {
    let words: Vec<&[u8]> =
        element.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).collect();
    let known = match *words.as_slice() {
        [b"hi"] => Some(Item::Greeting),
        [b"ok"] => Some(Item::Done),
        [b"frame", id, time, ref data @ ..] => frame(id, time, data).map(Item::Frame),
        [b"rtr", id, time, length] => remote(id, time, length).map(Item::Frame),
        [b"error", classes] => hex::number(classes).map(|bits| Item::BusError(BusError(bits))),
        [b"error", classes, time] if is_time(time) => {
            hex::number(classes).map(|bits| Item::BusError(BusError(bits)))
        }
        _ => None,
    };
    known.unwrap_or_else(|| match words.as_slice() {
        [b"error", words @ ..] => Item::Refused(shown(&words.join(&b' '))),
        [b"frame" | b"rtr", ..] => Item::Malformed { bytes: element.len() as u64 + 2 },
        _ => Item::Other(shown(element.trim_ascii())),
    })
}

/// Identifiers of up to three digits are short ones.
fn identifier(word: &[u8]) -> Option<CanId> {
    let number = hex::number(word)?;
    match word.len() {
        1..=3 => u16::try_from(number).ok().map(CanId::Standard),
        _ => Some(CanId::Extended(number)),
    }
}

fn frame(id: &[u8], time: &[u8], words: &[&[u8]]) -> Option<CanFrame> {
    let (id, mut data) = (identifier(id).filter(|_| is_time(time))?, Vec::new());
    for word in words {
        if let [digit] = word {
            data.push(hex::value(*digit)?);
            continue;
        }
        let (pairs, []) = word.as_chunks::<2>() else { return None };
        for [high, low] in pairs {
            data.push(hex::value(*high)? << 4 | hex::value(*low)?);
        }
    }
    CanFrame::data_frame(id, &data).ok()
}

fn remote(id: &[u8], time: &[u8], length: &[u8]) -> Option<CanFrame> {
    let id = identifier(id).filter(|_| is_time(time))?;
    CanFrame::remote_frame(id, usize::try_from(hex::decimal(length)?).ok()?).ok()
}

/// Whether a word is `seconds.microseconds`.
fn is_time(word: &[u8]) -> bool {
    let mut parts = word.split(|&byte| byte == b'.');
    let is_number = |part: Option<&[u8]>| part.is_some_and(|part| hex::decimal(part).is_some());
    is_number(parts.next()) && is_number(parts.next()) && parts.next().is_none()
}

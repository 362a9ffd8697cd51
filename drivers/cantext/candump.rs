//! Logs of `candump -l` and `candump -L`, line by line.
//!
//! ```text
//! (1436509052.249713) can0 123#1122334455667788      data frame, 11-bit identifier
//! (1436509052.249713) can0 12345678#11.22            29-bit identifier; dots between bytes may be there
//! (1436509052.249713) can0 123#R7 R                  remote frame of 7 bytes, received (T: sent)
//! (1436509052.249713) can0 20000040#0000000000000000 error frame, classes in the identifier
//! (1436509052.249713) can0 123##1112233              CAN FD: flags (1 BRS, 2 ESI, 4 FDF), then data
//! (1436509052.249713) can0 45123#81:00:12345678#11   CAN XL: recognised, and left out
//! ```

use std::fmt::Write as _;

use asphera_link::{CanFrame, CanId, FdFlags, shown};
use thiserror::Error;

use crate::BusError;
use crate::bus_error::ERROR_FLAG;
use crate::hex;

mod reader;

pub use reader::{Item, Reader};

/// Longest line that counts: a CAN XL frame of 2048 bytes with a dot after each.
pub const MAX_LINE: usize = 6400;

/// One line of a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'a> {
    /// Time of the frame in ns, on the clock of whoever wrote the log.
    pub time_ns: u64,
    /// Network interface that carried the frame: `can0`.
    pub interface: &'a str,
    /// The frame.
    pub content: Content,
}

/// Frame of a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A frame, classic or CAN FD.
    Frame(CanFrame),
    /// An error frame.
    BusError(BusError),
    /// A CAN XL frame.
    ExtraLong,
}

/// Reason why a text is no line of a log.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("expected {expected}, found {found}")]
pub struct LineError {
    /// Part of the line that is wrong, as it should be.
    pub expected: &'static str,
    /// Text that stands there.
    pub found: String,
}

impl<'a> Line<'a> {
    /// Reads one line, without its end.
    ///
    /// # Errors
    ///
    /// The first part of it that is not as candump writes it.
    pub fn parse(line: &'a [u8]) -> Result<Line<'a>, LineError> {
        let wrong = |expected, found: &[u8]| LineError { expected, found: shown(found) };
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let time = words.next().unwrap_or_default();
        let time_ns = parenthesised(time).ok_or_else(|| wrong(TIME, time))?;
        let interface = words.next().unwrap_or_default();
        let interface = std::str::from_utf8(interface)
            .ok()
            .filter(|name| !name.is_empty() && !name.contains('#'))
            .ok_or_else(|| wrong("the name of an interface after the time", interface))?;
        let frame = words.next().unwrap_or_default();
        let content = content(frame).ok_or_else(|| wrong(FRAME, frame))?;
        match (words.next(), words.next()) {
            (None | Some(b"R" | b"T"), None) => Ok(Line { time_ns, interface, content }),
            (more, _) => Err(wrong("R, T or nothing after the frame", more.unwrap_or_default())),
        }
    }
}

/// Time of a line in ns, whatever follows it; `None` where it does not begin with one.
pub fn time_of(line: &[u8]) -> Option<u64> {
    let end = line.iter().position(|&byte| byte == b')')?;
    parenthesised(line.get(..=end)?)
}

/// Appends the line of a frame, as `candump -l` writes it.
pub fn encode(time_us: u64, interface: &str, frame: &CanFrame, log: &mut String) {
    let (s, us) = (time_us / 1_000_000, time_us % 1_000_000);
    // Writing to a string cannot fail. Frames show themselves as candump does, but for a remote frame of no byte.
    let _ = match frame.is_remote() && frame.dlc() == 0 {
        false => writeln!(log, "({s:010}.{us:06}) {interface} {frame:?}"),
        true => writeln!(
            log,
            "({s:010}.{us:06}) {interface} {}",
            format!("{frame:?}").trim_end_matches('0')
        ),
    };
}

/// Nanoseconds of `(seconds.fraction)`.
fn parenthesised(word: &[u8]) -> Option<u64> {
    let inner = word.strip_prefix(b"(")?.strip_suffix(b")")?;
    let point = inner.iter().position(|&byte| byte == b'.')?;
    let (seconds, fraction) = (hex::decimal(&inner[..point])?, &inner[point + 1..]);
    if fraction.len() > 9 {
        return None;
    }
    let places = 9 - u32::try_from(fraction.len()).ok()?;
    let fraction = hex::decimal(fraction)? * 10_u64.pow(places);
    seconds.checked_mul(1_000_000_000)?.checked_add(fraction)
}

/// Content of `identifier#…`.
fn content(word: &[u8]) -> Option<Content> {
    let end = word.iter().position(|&byte| byte == b'#')?;
    let (digits, rest) = (&word[..end], &word[end + 1..]);
    let number = hex::number(digits)?;
    match digits.len() {
        3 if number <= 0x7FF => {
            classic_or_flexible(CanId::Standard(u16::try_from(number).ok()?), rest)
        }
        5 => extra_long(rest).then_some(Content::ExtraLong),
        8 if number & ERROR_FLAG != 0 => {
            let is_error = number <= ERROR_FLAG | 0x1FFF_FFFF && data(rest).is_some();
            is_error.then_some(Content::BusError(BusError(number & !ERROR_FLAG)))
        }
        8 if number <= 0x1FFF_FFFF => classic_or_flexible(CanId::Extended(number), rest),
        _ => None,
    }
}

/// Content after the first `#`.
fn classic_or_flexible(id: CanId, rest: &[u8]) -> Option<Content> {
    let frame = match rest {
        [b'#', flags, data @ ..] => {
            let (flags, (data, len)) = (hex::value(*flags)?, bytes::<64>(data)?);
            let flags = FdFlags { bit_rate_switch: flags & 1 != 0, error_passive: flags & 2 != 0 };
            CanFrame::fd_frame(id, &data[..len], flags)
        }
        [b'R' | b'r'] => CanFrame::remote_frame(id, 0),
        [b'R' | b'r', length] => CanFrame::remote_frame(id, hex::value(*length)?.into()),
        // The raw length code of a frame of eight bytes, 9 to F, follows `_`.
        [b'R' | b'r', b'8', b'_', code] => {
            is_long_code(*code).then_some(())?;
            CanFrame::remote_frame(id, 8)
        }
        _ => {
            let (data, len) = data(rest)?;
            CanFrame::data_frame(id, &data[..len])
        }
    };
    frame.ok().map(Content::Frame)
}

/// Data of a classic frame, with the raw length code that may follow eight bytes.
fn data(text: &[u8]) -> Option<([u8; 8], usize)> {
    match text.split_last_chunk::<2>() {
        Some((head, [b'_', code])) => {
            bytes::<8>(head).filter(|(_, len)| *len == 8 && is_long_code(*code))
        }
        _ => bytes(text),
    }
}

fn is_long_code(code: u8) -> bool {
    hex::value(code).is_some_and(|code| code > 8)
}

/// Up to `N` bytes of two digits each; one dot may stand before each of them.
fn bytes<const N: usize>(mut text: &[u8]) -> Option<([u8; N], usize)> {
    let mut bytes = [0; N];
    let mut len = 0;
    while !text.is_empty() {
        let pair = text.strip_prefix(b".").unwrap_or(text);
        let (&[high, low], rest) = pair.split_first_chunk::<2>()?;
        *bytes.get_mut(len)? = hex::value(high)? << 4 | hex::value(low)?;
        len += 1;
        text = rest;
    }
    Some((bytes, len))
}

/// Whether a text is `flags:type:acceptance#data` of a CAN XL frame.
fn extra_long(rest: &[u8]) -> bool {
    let Some(end) = rest.iter().position(|&byte| byte == b'#') else { return false };
    let fields: Vec<&[u8]> = rest[..end].split(|&byte| byte == b':').collect();
    let data = rest[end + 1..].iter();
    fields.len() == 3
        && fields.iter().all(|field| hex::number(field).is_some())
        && data.clone().all(|&byte| byte == b'.' || hex::value(byte).is_some())
}

const TIME: &str = "(seconds.fraction) at the begin, as candump -l writes it";
const FRAME: &str = "a frame, as 123#1122 or 12345678#R4";

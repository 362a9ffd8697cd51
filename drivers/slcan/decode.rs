//! Bytes to lines to items.

use asphera_link::{CanFrame, CanId, FD_LENGTHS, FdFlags};

use crate::{AdapterStatus, BEL, CR, Command, Item, TIMESTAMP_MODULUS_MS, hex};

/// Longest line, without its CR: a CAN FD frame of 64 bytes with 29-bit identifier and timestamp.
pub const MAX_LINE: usize = 1 + 8 + 1 + 2 * 64 + 4;

/// Whether received frames carry the adapter's time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Timestamps {
    /// Some may. A frame that lost or gained two data bytes cannot be told from one with a time.
    #[default]
    Maybe,
    /// None does (`Z0`).
    Never,
    /// Every one does (`Z1`).
    Always,
}

/// Bytes of a serial line, cut anywhere, to [`Item`]s.
///
/// Every byte given to [`Decoder::decode`] is counted in exactly one item or still waits for the end
/// of its line. What is read does not depend on how the bytes were cut. O(1) memory, O(1) a byte.
///
/// ```
/// use asphera_slcan::{Decoder, Item};
/// let mut decoder = Decoder::new();
/// let mut bytes = &b"t1854"[..];
/// assert_eq!(decoder.decode(&mut bytes), None);
/// let mut bytes = &b"40E20100\r"[..];
/// let Some(Item::Frame(frame, None)) = decoder.decode(&mut bytes) else { panic!() };
/// assert_eq!(frame.data(), [0x40, 0xE2, 0x01, 0x00]);
/// ```
#[derive(Clone, Debug)]
pub struct Decoder {
    timestamps: Timestamps,
    line: [u8; MAX_LINE],
    /// Bytes of the unfinished line, also of those that no longer fit into `line`.
    pending: u64,
}

impl Decoder {
    /// A decoder that has received nothing and takes frames with and without a time.
    pub const fn new() -> Decoder {
        Decoder::expecting(Timestamps::Maybe)
    }

    /// A decoder that has received nothing.
    pub const fn expecting(timestamps: Timestamps) -> Decoder {
        Decoder { timestamps, line: [0; MAX_LINE], pending: 0 }
    }

    /// Bytes that wait for the end of their line.
    pub fn pending(&self) -> u64 {
        self.pending
    }

    /// Takes bytes off the front of `input` up to and with the end of the next item, or all of them
    /// if none ends in them.
    #[must_use]
    pub fn decode(&mut self, input: &mut &[u8]) -> Option<Item> {
        let Some(end) = input.iter().position(|&byte| byte == CR || byte == BEL) else {
            self.store(input);
            *input = &[];
            return None;
        };
        if input[end] == BEL {
            if end > 0 || self.pending > 0 {
                // The BEL stays for the next call: it is an answer of its own.
                let bytes = self.pending + end as u64;
                *input = &input[end..];
                self.pending = 0;
                return Some(Item::Malformed { bytes });
            }
            *input = &input[1..];
            return Some(Item::Error);
        }
        let (head, rest) = input.split_at(end);
        *input = &rest[1..];
        if self.pending == 0 {
            let malformed = Item::Malformed { bytes: end as u64 + 1 };
            return Some(parse(head, self.timestamps).unwrap_or(malformed));
        }
        self.store(head);
        let length = self.pending;
        self.pending = 0;
        let line = usize::try_from(length).ok().and_then(|length| self.line.get(..length));
        let item = line.and_then(|line| parse(line, self.timestamps));
        Some(item.unwrap_or(Item::Malformed { bytes: length + 1 }))
    }

    fn store(&mut self, bytes: &[u8]) {
        let at = usize::try_from(self.pending).unwrap_or(MAX_LINE).min(MAX_LINE);
        let fitting = bytes.len().min(MAX_LINE - at);
        self.line[at..at + fitting].copy_from_slice(&bytes[..fitting]);
        self.pending += bytes.len() as u64;
    }
}

impl Default for Decoder {
    fn default() -> Decoder {
        Decoder::new()
    }
}

/// The item of a line without its CR.
fn parse(line: &[u8], timestamps: Timestamps) -> Option<Item> {
    let Some((&letter, rest)) = line.split_first() else {
        return Some(Item::Ok);
    };
    match letter {
        b't' => frame(rest, Header::Standard, Kind::Data, timestamps),
        b'T' => frame(rest, Header::Extended, Kind::Data, timestamps),
        b'r' => frame(rest, Header::Standard, Kind::Remote, timestamps),
        b'R' => frame(rest, Header::Extended, Kind::Remote, timestamps),
        b'd' => flexible(rest, Header::Standard, false, timestamps),
        b'D' => flexible(rest, Header::Extended, false, timestamps),
        b'b' => flexible(rest, Header::Standard, true, timestamps),
        b'B' => flexible(rest, Header::Extended, true, timestamps),
        b'z' if rest.is_empty() => Some(Item::TransmitAck { extended: false }),
        b'Z' if rest.is_empty() => Some(Item::TransmitAck { extended: true }),
        b'V' if !rest.is_empty() => match *rest {
            [a, b, c, d] if rest.iter().all(u8::is_ascii_alphanumeric) => {
                Some(Item::Version { hardware: [a, b], software: [c, d] })
            }
            _ => None,
        },
        b'N' if !rest.is_empty() => rest
            .try_into()
            .ok()
            .filter(|number: &[u8; 4]| number.iter().all(u8::is_ascii_alphanumeric))
            .map(Item::SerialNumber),
        b'F' if rest.len() == 2 => {
            hex::number(rest).map(|bits| Item::Status(AdapterStatus::from_bits_retain(bits as u8)))
        }
        _ => Command::parse(line).map(Item::Command),
    }
}

#[derive(Clone, Copy)]
enum Header {
    Standard,
    Extended,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Data,
    Remote,
}

impl Header {
    /// The identifier and what follows it.
    fn split(self, rest: &[u8]) -> Option<(CanId, &[u8])> {
        match self {
            Header::Standard => {
                let (digits, rest) = rest.split_at_checked(3)?;
                let id = hex::number(digits).filter(|&id| id <= 0x7FF)?;
                Some((CanId::Standard(id as u16), rest))
            }
            Header::Extended => {
                let (digits, rest) = rest.split_at_checked(8)?;
                let id = hex::number(digits).filter(|&id| id <= 0x1FFF_FFFF)?;
                Some((CanId::Extended(id), rest))
            }
        }
    }
}

fn frame(rest: &[u8], header: Header, kind: Kind, timestamps: Timestamps) -> Option<Item> {
    let (id, rest) = header.split(rest)?;
    let (&dlc, rest) = rest.split_first()?;
    if !(b'0'..=b'8').contains(&dlc) {
        return None;
    }
    let dlc = usize::from(dlc - b'0');
    let len = if kind == Kind::Data { dlc } else { 0 };
    let (digits, tail) = rest.split_at_checked(2 * len)?;
    let timestamp = timestamp(tail, timestamps)?;
    let mut data = [0; 8];
    if !hex::bytes(digits, &mut data[..len]) {
        return None;
    }
    let frame = match kind {
        Kind::Data => CanFrame::data_frame(id, &data[..len]),
        Kind::Remote => CanFrame::remote_frame(id, dlc),
    };
    Some(Item::Frame(frame.ok()?, timestamp))
}

/// A CAN FD line. It does not say whether the sender is error passive.
fn flexible(
    rest: &[u8],
    header: Header,
    bit_rate_switch: bool,
    timestamps: Timestamps,
) -> Option<Item> {
    let (id, rest) = header.split(rest)?;
    let (code, rest) = rest.split_at_checked(1)?;
    let len = FD_LENGTHS[hex::number(code)? as usize];
    let (digits, tail) = rest.split_at_checked(2 * len)?;
    let timestamp = timestamp(tail, timestamps)?;
    let mut data = [0; 64];
    if !hex::bytes(digits, &mut data[..len]) {
        return None;
    }
    let flags = FdFlags { bit_rate_switch, error_passive: false };
    Some(Item::Frame(CanFrame::fd_frame(id, &data[..len], flags).ok()?, timestamp))
}

/// The time at the end of a frame's line: `None` if what stands there cannot be.
fn timestamp(tail: &[u8], timestamps: Timestamps) -> Option<Option<u16>> {
    match (tail.len(), timestamps) {
        (0, Timestamps::Maybe | Timestamps::Never) => Some(None),
        (4, Timestamps::Maybe | Timestamps::Always) => {
            let time = hex::number(tail)? as u16;
            (time < TIMESTAMP_MODULUS_MS).then_some(Some(time))
        }
        _ => None,
    }
}

//! The packet protocol as bytes: commands and their answers, formats, data. Everything is little-endian.
//!
//! ```text
//! packet    0 AA55AA55h (u32)   4 length with this header (s32)   8 zero (s32)   12 zero (u32)   16 kind (u32)
//!          20 body
//! CMD       0 command   4 destination   8 source (u32 each)   12 flags   14 zero   16 ticket   18 arguments (u16 each)
//!          20 arguments: kind (u32), then four bytes, or a length (u32) and bytes with zeros up to a multiple of four
//! DFT       0 stream (u32)   4 format counter (s32)   8 sample rate (float)   12 signals (s32)
//!          16 for each signal: number type, zero (u8 each), points, first point, identifier (u16 each)
//! DAT       0 stream (u32)   4 format counter (s32)   8 time in s, 32.32 bits (u64)   16 samples (s32)
//!          20 samples without gaps, zeros up to a multiple of four
//! ```
//!
//! Source: CR, packet protocol. The codes of commands are ASCII, first letter first, filled with zeros: so
//! `chr_cmd_id.py` of the maker's library has them.

mod command;
mod data;
mod format;

use thiserror::Error;

pub use command::{Argument, CommandFlags, Message, Name};
pub use data::{Data, DataError};
pub use format::{Format, FormatError, FormatSignal, NumberType, SampleLayout};

/// The four bytes that begin each packet, as a number.
pub const MAGIC: u32 = 0xAA55_AA55;

/// Bytes before the body.
pub const HEADER_LEN: usize = 20;

/// Longest packet, its header included.
pub const MAX_LEN: usize = 4096;

/// Kind of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `CMD`: a command, its answer, or an update.
    Command,
    /// `DFT`: how samples are laid out.
    Format,
    /// `DAT`: samples.
    Data,
    /// A kind that CR does not describe.
    Other(u32),
}

impl Kind {
    /// The code in the header.
    pub const fn code(self) -> u32 {
        match self {
            Kind::Command => 0x0044_4D43,
            Kind::Format => 0x0054_4644,
            Kind::Data => 0x0054_4144,
            Kind::Other(code) => code,
        }
    }

    fn from_code(code: u32) -> Kind {
        [Kind::Command, Kind::Format, Kind::Data]
            .into_iter()
            .find(|kind| kind.code() == code)
            .unwrap_or(Kind::Other(code))
    }
}

/// Header of a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Header {
    /// Bytes of the packet, this header included.
    pub len: usize,
    /// Its kind.
    pub kind: Kind,
}

/// Why bytes are no header.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum HeaderError {
    /// Another number where a packet begins.
    #[error("{0:08X}h where a packet begins, expected AA55AA55h")]
    Magic(u32),
    /// A length that no packet has.
    #[error("a packet of {0} bytes, expected {HEADER_LEN} to {MAX_LEN}")]
    Length(i32),
    /// Numbers other than zero where the header has zeros.
    #[error("a header with {0:X}h and {1:X}h where zeros stand")]
    Zeros(u32, u32),
}

impl Header {
    /// Reads the header of a packet. `None` where fewer than [`HEADER_LEN`] bytes are there.
    ///
    /// # Errors
    ///
    /// Why no packet begins here.
    pub fn decode(bytes: &[u8]) -> Option<Result<Header, HeaderError>> {
        let bytes = bytes.first_chunk::<HEADER_LEN>()?;
        let word = |at: usize| u32_at(bytes, at);
        let len = word(4).cast_signed();
        Some(if word(0) != MAGIC {
            Err(HeaderError::Magic(word(0)))
        } else if (word(8), word(12)) != (0, 0) {
            Err(HeaderError::Zeros(word(8), word(12)))
        } else {
            match usize::try_from(len) {
                Ok(len) if (HEADER_LEN..=MAX_LEN).contains(&len) => {
                    Ok(Header { len, kind: Kind::from_code(word(16)) })
                }
                _ => Err(HeaderError::Length(len)),
            }
        })
    }
}

/// Appends a packet whose body `write` appends. The caller keeps it within [`MAX_LEN`].
pub fn encode(kind: Kind, out: &mut Vec<u8>, write: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    for word in [MAGIC, 0, 0, 0, kind.code()] {
        out.extend(word.to_le_bytes());
    }
    write(out);
    let len = (out.len() - start) as u32;
    out[start + 4..start + 8].copy_from_slice(&len.to_le_bytes());
}

/// The number at an offset within the bytes.
fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// The number at an offset within the bytes.
fn u16_at(bytes: &[u8], at: usize) -> u16 {
    u16::from_le_bytes([bytes[at], bytes[at + 1]])
}

/// Appends zeros up to a multiple of four bytes after `start`.
fn pad(out: &mut Vec<u8>, start: usize) {
    out.resize(start + (out.len() - start).next_multiple_of(4), 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_read_back_and_a_wrong_one_named() {
        let mut bytes = Vec::new();
        encode(Kind::Other(7), &mut bytes, |out| out.extend([1, 2, 3, 4]));
        let header = Header { len: 24, kind: Kind::Other(7) };
        assert_eq!(Header::decode(&bytes), Some(Ok(header)));
        assert_eq!(Header::decode(&bytes[..19]), None);
        let with = |at: usize, byte: u8| {
            let mut bytes = bytes.clone();
            bytes[at] = byte;
            Header::decode(&bytes).unwrap().unwrap_err().to_string()
        };
        assert_eq!(with(0, 0x54), "AA55AA54h where a packet begins, expected AA55AA55h");
        assert_eq!(with(4, 19), "a packet of 19 bytes, expected 20 to 4096");
        assert!(with(5, 16).starts_with("a packet of 4120 bytes"));
        assert!(with(7, 0xFF).starts_with("a packet of -16777192 bytes"));
        assert!(with(12, 1).contains("0h and 1h where zeros stand"));
    }
}

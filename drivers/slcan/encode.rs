//! Frames to lines.

use asphera_link::{CanFrame, CanId};

use crate::{CR, hex};

/// An adapter's clock counts ms from 0 to one less than this (0xEA5F), then starts again.
pub const TIMESTAMP_MODULUS_MS: u16 = 60_000;

/// Appends the line of a frame, in upper case, with its CR: at most 27 bytes, of CAN FD 139. ESI has no letter, and is lost.
pub fn encode(frame: &CanFrame, out: &mut Vec<u8>) {
    body(frame, out);
    out.push(CR);
}

/// Appends the line of a frame with the adapter's time, as adapters send it while `Z1` is set. The
/// time is taken modulo [`TIMESTAMP_MODULUS_MS`].
pub fn encode_timestamped(frame: &CanFrame, timestamp_ms: u64, out: &mut Vec<u8>) {
    body(frame, out);
    let time = timestamp_ms % u64::from(TIMESTAMP_MODULUS_MS);
    hex::push(out, time as u32, 4);
    out.push(CR);
}

fn body(frame: &CanFrame, out: &mut Vec<u8>) {
    let [short, long] = match frame.fd() {
        None if frame.is_remote() => *b"rR",
        None => *b"tT",
        Some(flags) if flags.bit_rate_switch => *b"bB",
        Some(_) => *b"dD",
    };
    match frame.id() {
        CanId::Standard(id) => {
            out.push(short);
            hex::push(out, id.into(), 3);
        }
        CanId::Extended(id) => {
            out.push(long);
            hex::push(out, id, 8);
        }
    }
    hex::push(out, frame.dlc() as u32, 1);
    for &byte in frame.data() {
        hex::push(out, byte.into(), 2);
    }
}

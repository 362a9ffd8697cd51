//! Frames to lines.

use asphera_link::{CanFrame, CanId};

use crate::{CR, hex};

/// An adapter's clock counts ms from 0 to one less than this (0xEA5F), then starts again.
pub const TIMESTAMP_MODULUS_MS: u16 = 60_000;

/// Appends the line of a frame, in upper case, with its CR: at most 27 bytes.
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
    match (frame.id(), frame.is_remote()) {
        (CanId::Standard(id), remote) => {
            out.push(if remote { b'r' } else { b't' });
            hex::push(out, id.into(), 3);
        }
        (CanId::Extended(id), remote) => {
            out.push(if remote { b'R' } else { b'T' });
            hex::push(out, id, 8);
        }
    }
    out.push(b'0' + frame.dlc() as u8);
    for &byte in frame.data() {
        hex::push(out, byte.into(), 2);
    }
}

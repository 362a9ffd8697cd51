//! Settings for a device of which only its bytes are known.

mod column;
mod record;
mod text;
mod write;

use asphera_link::{Capture, Proposal};

use crate::settings::Poll;

/// Share of printable bytes from which a device sends text, in percent.
const MOSTLY_TEXT: usize = 95;

/// Settings that read what a device sent, as the table `settings` of a configuration, with remarks on what was seen.
///
/// Worked out: the ends of lines or the length of records; a beginning that all share; a check that all have;
/// columns, or the text about numbers; numbers, counters, states and units. Not worked out, and said: what a number
/// means, and its unit where the device does not send it.
///
/// The time is proportional to the bytes looked at; those beyond the first 64 kB are not.
pub(crate) fn propose(capture: &Capture) -> Proposal {
    const LOOKED_AT: usize = 64 * 1024;
    let bytes = &capture.received[..capture.received.len().min(LOOKED_AT)];
    if bytes.is_empty() {
        let remark = "nothing was received: a device that sends only when asked needs its question";
        return Proposal { settings: None, remarks: vec![remark.to_owned()] };
    }
    let is_text = |byte: &&u8| matches!(**byte, 0x20..0x7F | b'\r' | b'\n' | b'\t' | 2 | 3);
    let texts = bytes.iter().filter(is_text).count();
    if texts * 100 >= bytes.len() * MOSTLY_TEXT {
        text::propose(capture, bytes)
    } else {
        record::propose(capture, bytes)
    }
}

/// The question that was asked, with room for slow answers.
fn poll(capture: &Capture) -> Option<Poll> {
    let (ask, interval_ms) = capture.asked.clone()?;
    Some(Poll { ask, interval_ms, timeout_ms: 500, late_limit_ms: 1000 })
}

//! Replies of a stage as patterns, and commands as bytes.
//!
//! ```text
//! /1 2 get pos:CC⏎                      command: device 1, axis 2 (0 or none: all axes of it)
//! @01 2 OK IDLE -- 12345:CC⏎            reply: device, axis, OK or RJ, BUSY or IDLE, warning flag, data
//! !01 1 IDLE --⏎                        alert, sent by itself
//! #01 0 text⏎                           information, after some replies
//! ```
//!
//! `CC` is the check of all between the first sign and the colon: the two's complement of the sum, in two digits.

use asphera_described::{Algorithm, Checksum, Digits, Pattern, PatternError};

/// Check of commands and replies.
pub(crate) const CHECKSUM: Checksum =
    Checksum { algorithm: Algorithm::Lrc8, digits: Digits::Hex, skip_first: 1, skip_last: 1 };

/// Bytes of a command to an axis of a device.
pub(crate) fn command(address: u8, axis: u8, words: &str, is_checked: bool) -> Vec<u8> {
    framed(format!("/{address} {axis} {words}"), is_checked)
}

/// Bytes of a command with a message number, which its reply repeats.
pub(crate) fn numbered(
    address: u8,
    axis: u8,
    number: u8,
    words: &str,
    is_checked: bool,
) -> Vec<u8> {
    framed(format!("/{address} {axis} {number} {words}"), is_checked)
}

fn framed(text: String, is_checked: bool) -> Vec<u8> {
    let mut bytes = text.into_bytes();
    if is_checked {
        bytes.push(b':');
        // A command is longer than the sign that the check leaves out.
        bytes.extend(CHECKSUM.compute(&bytes).unwrap_or_default());
    }
    bytes.push(b'\n');
    bytes
}

/// Reply with so many positions, without its check. Groups: `warning`, `p1`, `p2`, …
///
/// Positions are whole microsteps, or decimals where a device has finer steps.
pub(crate) fn positions(address: u8, axis: u8, count: usize) -> Result<Pattern, PatternError> {
    let positions: String = (1..=count).map(|n| format!(r" (?<p{n}>-?\d+(?:\.\d+)?)")).collect();
    let head = head(address, axis);
    Pattern::new(&format!("{head} OK (?:BUSY|IDLE) (?<warning>--|[A-Z][A-Z0-9]){positions}"))
}

/// Reply that rejects a command.
pub(crate) fn rejection(address: u8, axis: u8) -> Result<Pattern, PatternError> {
    Pattern::new(&format!("{} RJ .*", head(address, axis)))
}

/// Any reply of the device that accepts a command: it proves that the device speaks this protocol.
pub(crate) fn acceptance(address: u8) -> Result<Pattern, PatternError> {
    Pattern::new(&format!(r"@{address:02} \d (?:\d\d? )?OK (?:BUSY|IDLE) (?:--|[A-Z][A-Z0-9]) .*"))
}

/// Alerts and information of any device, and replies of others on the same line.
pub(crate) fn others(address: u8) -> Result<[Pattern; 2], PatternError> {
    let spontaneous = Pattern::new("[!#].*")?;
    let digits = format!("{address:02}").into_bytes();
    let (tens, ones) = (char::from(digits[0]), char::from(digits[1]));
    let foreign = Pattern::new(&format!(r"@(?:[^{tens}]\d|\d[^{ones}]) .*"))?;
    Ok([spontaneous, foreign])
}

/// Beginning of the replies of an axis; a message number may follow it.
fn head(address: u8, axis: u8) -> String {
    format!(r"@{address:02} {axis}(?: \d\d?)?")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Commands of zproto's documentation and tests; the check is that of its test vector.
    #[test]
    fn commands_as_zproto_writes_them() {
        assert_eq!(command(1, 3, "get pos", false), b"/1 3 get pos\n");
        assert_eq!(CHECKSUM.compute(b"/01 tools echo:"), Some(b"8F".to_vec()));
        let checked = command(2, 1, "get pos", true);
        let (message, end) = checked.split_at(checked.len() - 1);
        assert_eq!((CHECKSUM.body(message), end), (Some(&b"/2 1 get pos"[..]), &b"\n"[..]));
    }

    #[test]
    fn replies_of_others_are_told_apart() {
        let [spontaneous, foreign] = others(2).unwrap();
        assert!(spontaneous.matches(b"!01 1 IDLE --") && spontaneous.matches(b"#01 0 text"));
        assert!(foreign.matches(b"@01 0 OK IDLE WR 3") && foreign.matches(b"@12 0 OK IDLE -- 3"));
        assert!(!foreign.matches(b"@02 0 OK IDLE -- 2"));
    }
}

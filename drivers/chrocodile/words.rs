//! Words of the device in either protocol.

/// How much of a message of the device is repeated in a fault.
pub(crate) const MESSAGE_LEN: usize = 120;

/// The message, cut where it is long.
pub(crate) fn shortened(message: &str) -> String {
    let mut words: String = message.chars().take(MESSAGE_LEN).collect();
    if words.len() < message.len() {
        words.push('…');
    }
    words
}

/// Whether a number can be the full scale of a probe in µm.
pub(crate) fn is_full_scale(number: &f64) -> bool {
    number.is_finite() && *number > 0.0
}

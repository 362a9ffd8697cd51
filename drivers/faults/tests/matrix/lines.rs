//! Devices that are asked in lines of text: what all of them share.

use asphera_faults::Sent;
use asphera_link::Output;

/// The text of a parcel without its end.
pub(crate) fn text(parcel: &Output) -> &str {
    let Output::Bytes(bytes) = parcel else { return "" };
    std::str::from_utf8(bytes).unwrap_or_default().trim_end()
}

/// An answer in a line.
pub(crate) fn line(text: &str) -> Vec<Sent> {
    vec![Sent::answer(format!("{text}\r\n"))]
}

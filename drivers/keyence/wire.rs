//! Bytes of an LJ-X8000 or LJ-V7000 controller, as types, without state. All numbers are little-endian.
//!
//! ```text
//! request  0 length of the rest (u32)   4 series 03 or 01, 00 F0 00   8 zero (u32)   12 length of the body (u32)
//!         16 command, 0, 0, 0           20 arguments
//! answer   0 length of the rest (u32)  16 command   17 error, 0: none   18 status   24 active program   28 content
//!
//! profile  0 reserved (u32)   4 trigger count (u32)   8 encoder count (i32)   12 reserved (3 u32)
//!         24 heights, 20 bits a point, filled up to a u32; then, if bit 6 of the kind is set, luminances, 10 bits a point
//!        end sum of all u32 before it (u32)
//! notice   0 FF FF FF FF   4 bits 0 to 15: the transmission has stopped; bit 16: end of a batch
//! ```
//!
//! Sources: README.md of this folder.

mod answer;
mod height;
mod layout;
mod profile;
mod request;

pub use answer::{Answer, AnswerError, ErrorCodes, Unit};
pub use height::{Height, NoHeight, heights, pack_heights};
pub use layout::{Layout, LayoutError, MOST_POINTS};
pub use profile::{NOTICE_LEN, Notice, Profile, ProfileError, is_notice};
pub use request::{Request, RequestError, Series};

/// A number at a place of `bytes`; `None` where they end before it.
fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..)?.first_chunk::<4>()?;
    Some(u32::from_le_bytes(*four))
}

fn u16_at(bytes: &[u8], at: usize) -> Option<u16> {
    let two = bytes.get(at..)?.first_chunk::<2>()?;
    Some(u16::from_le_bytes(*two))
}

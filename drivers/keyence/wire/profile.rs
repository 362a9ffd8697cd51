//! Profiles and notices of the stream.

use thiserror::Error;

use super::{Height, Layout, heights, pack_heights, u32_at};

/// Profile of a stream. Nothing is copied.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Profile<'a> {
    /// Count of triggers.
    pub trigger_count: u32,
    /// Count of the encoder.
    pub encoder_count: i32,
    points: u16,
    heights: &'a [u8],
}

/// Why bytes are no profile.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum ProfileError {
    /// The sum at the end is not that of the bytes.
    #[error("its sum is {found:08X}h, expected {expected:08X}h")]
    Sum {
        /// Sum of the bytes.
        expected: u32,
        /// Sum that stands at the end.
        found: u32,
    },
}

/// Notice between profiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Notice(pub u32);

impl<'a> Profile<'a> {
    /// Bytes of a profile.
    pub fn len(layout: &Layout) -> usize {
        HEAD + layout.height_bytes() + layout.luminance_bytes() + SUM
    }

    /// Reads the profile at the beginning of `bytes`; `None`: more bytes are needed.
    ///
    /// # Errors
    ///
    /// When its sum is wrong.
    pub fn decode(bytes: &'a [u8], layout: &Layout) -> Option<Result<Profile<'a>, ProfileError>> {
        let (body, sum) = bytes.get(..Profile::len(layout))?.split_last_chunk::<SUM>()?;
        let (expected, found) = (sum_of(body), u32::from_le_bytes(*sum));
        if expected != found {
            return Some(Err(ProfileError::Sum { expected, found }));
        }
        Some(Ok(Profile {
            trigger_count: u32_at(body, 4)?,
            encoder_count: u32_at(body, 8)?.cast_signed(),
            points: layout.points,
            heights: body.get(HEAD..HEAD + layout.height_bytes())?,
        }))
    }

    /// Heights from the first point to the last, in units of the layout.
    pub fn heights(&self) -> impl Iterator<Item = Height> + use<'a> {
        heights(self.heights, self.points.into())
    }

    /// Bytes of a profile with these heights, as many as the layout has points. Luminances are 0.
    pub fn encode(
        layout: &Layout,
        trigger_count: u32,
        encoder_count: i32,
        heights: impl IntoIterator<Item = Height>,
    ) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(Profile::len(layout));
        bytes.extend([0; 4]);
        bytes.extend(trigger_count.to_le_bytes());
        bytes.extend(encoder_count.to_le_bytes());
        bytes.extend([0; 12]);
        pack_heights(heights.into_iter().take(layout.points.into()), &mut bytes);
        bytes.resize(Profile::len(layout) - SUM, 0);
        let sum = sum_of(&bytes);
        bytes.extend(sum.to_le_bytes());
        bytes
    }
}

impl Notice {
    /// Reads the notice at the beginning of `bytes`; `None` where there is none, or not all of it.
    pub fn decode(bytes: &[u8]) -> Option<Notice> {
        let whole = is_notice(bytes) && bytes.len() >= NOTICE_LEN;
        whole.then(|| u32_at(bytes, 4).map(Notice)).flatten()
    }

    /// Bytes of the notice.
    pub fn encode(self) -> [u8; NOTICE_LEN] {
        let mut bytes = [0xFF; NOTICE_LEN];
        bytes[4..].copy_from_slice(&self.0.to_le_bytes());
        bytes
    }

    /// Why the transmission has stopped; `None`: it goes on.
    pub fn stopped(self) -> Option<u16> {
        let reason = self.0 as u16;
        (reason != 0).then_some(reason)
    }

    /// Whether a batch has ended.
    pub fn ends_batch(self) -> bool {
        self.0 & 0x1_0000 != 0
    }
}

/// Whether bytes begin as a notice does. No profile begins so.
pub fn is_notice(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0xFF; 4])
}

fn sum_of(bytes: &[u8]) -> u32 {
    bytes.chunks_exact(4).fold(0, |sum: u32, word| {
        sum.wrapping_add(u32::from_le_bytes([word[0], word[1], word[2], word[3]]))
    })
}

/// Bytes of a notice.
pub const NOTICE_LEN: usize = 8;

/// Bytes before the heights.
const HEAD: usize = 24;

/// Bytes of the sum.
const SUM: usize = 4;

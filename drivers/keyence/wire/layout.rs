//! Layout of the profiles of a stream, as its preparation tells it.

use thiserror::Error;

use super::{u16_at, u32_at};

/// Layout of the profiles of a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Code that starts the stream.
    pub start_code: u32,
    /// Kind of the profiles; bit 6: with luminances.
    pub kind: u8,
    /// Points of a profile.
    pub points: u16,
    /// Unit of the heights, in 10 nm.
    pub unit_10nm: u16,
    /// x of the first point, in 10 nm.
    pub x_start_10nm: i32,
    /// Distance of points along x, in 10 nm.
    pub x_pitch_10nm: i32,
}

/// Why profiles cannot be read.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum LayoutError {
    /// The answer ends before its fields.
    #[error("an answer with {0} bytes of content, expected {CONTENT} or more")]
    Short(usize),
    /// No head has so many points.
    #[error("profiles of {0} points, expected 1 to {MOST_POINTS}")]
    Points(u16),
    /// All points would lie at one place.
    #[error("points 0 mm apart: set the X pitch of the active program")]
    Pitch,
}

impl Layout {
    /// Reads the content of an answer to [`super::Request::Prepare`].
    ///
    /// # Errors
    ///
    /// Why profiles of this layout cannot be read. A unit of 0 is none of it: some controllers give it.
    pub fn decode(content: &[u8]) -> Result<Layout, LayoutError> {
        let short = || LayoutError::Short(content.len());
        let layout = Layout {
            start_code: u32_at(content, 4).ok_or_else(short)?,
            kind: *content.get(12).ok_or_else(short)?,
            points: u16_at(content, 16).ok_or_else(short)?,
            unit_10nm: u16_at(content, 18).ok_or_else(short)?,
            x_start_10nm: u32_at(content, 20).ok_or_else(short)?.cast_signed(),
            x_pitch_10nm: u32_at(content, 24).ok_or_else(short)?.cast_signed(),
        };
        if !(1..=MOST_POINTS).contains(&layout.points) {
            return Err(LayoutError::Points(layout.points));
        }
        if layout.x_pitch_10nm == 0 {
            return Err(LayoutError::Pitch);
        }
        Ok(layout)
    }

    /// Content of an answer with this layout.
    pub fn encode(&self) -> Vec<u8> {
        let mut content = vec![0; 4];
        content.extend(self.start_code.to_le_bytes());
        content.extend([0; 4]);
        content.extend([self.kind, 0, 0, 0]);
        content.extend(self.points.to_le_bytes());
        content.extend(self.unit_10nm.to_le_bytes());
        content.extend(self.x_start_10nm.to_le_bytes());
        content.extend(self.x_pitch_10nm.to_le_bytes());
        content
    }

    /// Unit of the heights in the content of an answer to [`super::Request::Profile`], in 10 nm.
    pub fn unit_of_profile(content: &[u8]) -> Option<u16> {
        u16_at(content, 26)
    }

    /// Bytes of the heights of a profile, those that fill the last u32 among them.
    pub fn height_bytes(&self) -> usize {
        words(usize::from(self.points) * 20)
    }

    /// Bytes of the luminances of a profile; 0 where there are none.
    pub fn luminance_bytes(&self) -> usize {
        if self.kind & HAS_LUMINANCES == 0 { 0 } else { words(usize::from(self.points) * 10) }
    }
}

/// Bytes of the u32 that hold so many bits.
fn words(bits: usize) -> usize {
    bits.div_ceil(32) * 4
}

/// Most points of a profile: `MAX_LJXA_XDATANUM` of the maker's code. Those of the LJ-V7000 have 800.
pub const MOST_POINTS: u16 = 3200;

const HAS_LUMINANCES: u8 = 0x40;

/// Bytes of content that hold all fields.
const CONTENT: usize = 28;

//! Where the samples of a volume lie, as its header says.

use super::element::Element;
use super::unpack::{Packing, exactly, unpacked_and_more};
use super::{Beside, Frame, MAX_SAMPLES, Volume};
use crate::{Format, Place, ReadError};

/// What a header tells of samples of one type, in one file, one after another.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    pub(super) format: Format,
    /// Columns, rows and slices.
    pub(super) size: [u64; 3],
    /// Where the header says so.
    pub(super) size_at: Place,
    pub(super) element: Element,
    pub(super) is_big: bool,
    pub(super) frame: Frame,
    pub(super) file: SamplesIn,
    /// Bytes of that file before the samples.
    pub(super) start: u64,
    pub(super) packing: Option<Packing>,
    /// Lines before the samples, after `start`.
    pub(super) skip_lines: u64,
    pub(super) skip: Skip,
    /// Whether the file must be as long as its samples ask before they are read.
    pub(super) is_all: bool,
}

/// What lies before the samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skip {
    /// So many bytes, of those that come out where the samples are packed.
    Bytes(u64),
    /// All but the bytes of the samples.
    AllBefore,
}

/// The file that holds the samples.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum SamplesIn {
    /// That of the header.
    Own,
    /// One beside it, which the header names at a place.
    Beside(String, Place),
}

impl Layout {
    /// The number of samples, if each side has one and there are `most` at most.
    pub(super) fn count(&self, most: u64) -> Result<u64, ReadError> {
        super::sample_count_up_to(self.format, self.size_at.clone(), self.size, most)
    }

    /// The whole volume; `bytes` are those of the header's file, `beside` is asked for another.
    pub(super) fn volume(&self, bytes: &[u8], beside: Beside<'_>) -> Result<Volume, ReadError> {
        match &self.file {
            SamplesIn::Own => self.volume_in(bytes),
            SamplesIn::Beside(name, place) => {
                let bytes = beside(name).map_err(|why| self.no_file(place, why))?;
                self.volume_in(&bytes)
            }
        }
    }

    /// Why there is no file with the samples.
    pub(super) fn no_file(&self, place: &Place, why: String) -> ReadError {
        ReadError::Malformed {
            format: self.format,
            place: place.clone(),
            expected: "the file with the samples beside the header".into(),
            found: why,
        }
    }

    /// The whole volume from the bytes of the file that holds the samples.
    pub(super) fn volume_in(&self, bytes: &[u8]) -> Result<Volume, ReadError> {
        let expected = self.count(MAX_SAMPLES)? as usize * self.element.bytes();
        self.check_length(bytes.len() as u64)?;
        let from = |bytes: usize, skip: u64| usize::try_from(skip).unwrap_or(bytes).min(bytes);
        let stored = self.behind_lines(bytes);
        let samples = match (self.packing, self.skip) {
            (None, Skip::AllBefore) => stored[stored.len().saturating_sub(expected)..].to_vec(),
            (None, Skip::Bytes(skip)) => {
                let stored = &stored[from(stored.len(), skip)..];
                self.check_no_more(stored.len() as u64)?;
                stored.to_vec()
            }
            (Some(packing), skip) => {
                let Skip::Bytes(skip) = skip else { return Err(self.packed_tail()) };
                let limit = (expected as u64).saturating_add(skip);
                let (mut out, more) =
                    unpacked_and_more(self.format, self.start, stored, packing, limit)?;
                self.check_no_more((expected as u64).saturating_add(more))?;
                out.drain(..from(out.len(), skip));
                out
            }
        };
        let samples = exactly(self.format, self.start, samples, expected)?;
        Ok(Volume {
            size: self.size.map(|side| side as usize),
            values: self.element.decoded(samples, self.is_big),
            frame: self.frame,
            format: self.format,
        })
    }

    /// Those of a file's bytes that lie behind `start` and the lines that are passed over.
    pub(super) fn behind_lines<'a>(&self, bytes: &'a [u8]) -> &'a [u8] {
        let start = usize::try_from(self.start).unwrap_or(bytes.len()).min(bytes.len());
        let mut stored = &bytes[start..];
        for _ in 0..self.skip_lines {
            let Some(end) = stored.iter().position(|&byte| byte == b'\n') else { break };
            stored = &stored[end + 1..];
        }
        stored
    }

    /// Whether a file of so many bytes may hold the samples.
    pub(super) fn check_length(&self, found: u64) -> Result<(), ReadError> {
        let Skip::Bytes(skip) = self.skip else { return Ok(()) };
        let samples = self.size.iter().fold(1_u64, |all, &side| all.saturating_mul(side));
        let bytes = samples.saturating_mul(self.element.bytes() as u64);
        let expected = self.start.saturating_add(skip).saturating_add(bytes);
        if !self.is_all || found == expected {
            return Ok(());
        }
        Err(ReadError::Malformed {
            format: self.format,
            place: self.size_at.clone(),
            expected: format!(
                "a file of {expected} bytes with the samples: header_bytes, then size × type"
            ),
            found: format!("{found} bytes"),
        })
    }

    /// Checks that there are no more bytes than those of the samples.
    pub(super) fn check_no_more(&self, found: u64) -> Result<(), ReadError> {
        let [columns, rows, slices] = self.size;
        let samples = columns.saturating_mul(rows).saturating_mul(slices);
        let bytes = self.element.bytes();
        let expected = samples.saturating_mul(bytes as u64);
        if found <= expected {
            return Ok(());
        }
        Err(ReadError::Malformed {
            format: self.format,
            place: self.size_at.clone(),
            expected: format!(
                "{expected} bytes of samples, {columns} × {rows} × {slices} of {bytes} each"
            ),
            found: format!("{found}: the sizes or the type in the header may be wrong"),
        })
    }

    /// Packed samples have no length that they could be the last of.
    pub(super) fn packed_tail(&self) -> ReadError {
        ReadError::Unsupported {
            format: self.format,
            place: self.size_at.clone(),
            expected: "raw samples where those before them are not counted".into(),
            found: "packed ones".into(),
        }
    }
}

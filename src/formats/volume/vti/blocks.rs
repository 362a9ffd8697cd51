//! Samples of VTK's XML as they lie in the file: a count of bytes before them, or counts of packed blocks.

use std::borrow::Cow;

use super::super::unpack::{Packing, exactly, unpacked};
use super::{FORMAT, malformed};
use crate::{Place, ReadError};

/// How bytes are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    Raw,
    Base64,
}

/// Samples of an array, as the file has them.
pub(super) struct Packed<'a> {
    pub(super) coding: Coding,
    /// From the array's start on, maybe beyond its end.
    pub(super) data: &'a [u8],
    /// Where it begins in the file.
    pub(super) start: u64,
    /// Bytes of a count.
    pub(super) word_bytes: usize,
    pub(super) is_big: bool,
}

impl Packed<'_> {
    /// The bytes of the samples, exactly as many as are expected.
    pub(super) fn samples(&self, is_zlib: bool, expected: usize) -> Result<Vec<u8>, ReadError> {
        let word = self.word_bytes;
        if !is_zlib {
            let counted = self.word(&self.first(word)?, 0)?;
            self.hold_count(counted, expected)?;
            let whole = self.first(word.saturating_add(expected))?;
            let samples = whole.get(word..).unwrap_or_default().to_vec();
            return exactly(FORMAT, self.start, samples, expected);
        }
        let head = self.first(3 * word)?;
        let [blocks, block_bytes, last_bytes] =
            [self.word(&head, 0)?, self.word(&head, 1)?, self.word(&head, 2)?];
        let head_bytes =
            usize::try_from(blocks).unwrap_or(usize::MAX).saturating_add(3).saturating_mul(word);
        let head = self.first(head_bytes)?;
        // A last block of no bytes says that it is as large as the others.
        let sizes =
            |at: u64| if at + 1 == blocks && last_bytes > 0 { last_bytes } else { block_bytes };
        let all = match blocks {
            0 => 0,
            _ => (blocks - 1).saturating_mul(block_bytes).saturating_add(sizes(blocks - 1)),
        };
        self.hold_count(all, expected)?;
        let mut ends = vec![head_bytes];
        for block in 0..blocks as usize {
            let packed = usize::try_from(self.word(&head, 3 + block)?).unwrap_or(usize::MAX);
            ends.push(ends[block].saturating_add(packed));
        }
        let whole = self.first(ends[ends.len() - 1])?;
        let mut samples = Vec::new();
        for (block, ends) in ends.windows(2).enumerate() {
            let part = whole.get(ends[0]..ends[1]).unwrap_or_default();
            let place = self.start + ends[0] as u64;
            let size = sizes(block as u64);
            let out = unpacked(FORMAT, place, part, Packing::Zlib, size)?;
            samples.extend(exactly(FORMAT, place, out, size as usize)?);
        }
        exactly(FORMAT, self.start, samples, expected)
    }

    fn hold_count(&self, found: u64, expected: usize) -> Result<(), ReadError> {
        if found == expected as u64 {
            return Ok(());
        }
        let place = Place::Byte(self.start);
        Err(malformed(place, format!("a count of {expected} bytes of samples"), found.to_string()))
    }

    /// The first bytes, or all where there are fewer.
    fn first(&self, count: usize) -> Result<Cow<'_, [u8]>, ReadError> {
        Ok(match self.coding {
            Coding::Raw => Cow::Borrowed(&self.data[..self.data.len().min(count)]),
            Coding::Base64 => Cow::Owned(base64(self.data, count).map_err(|at| {
                let found = crate::error::quoted(&self.data[at..]);
                malformed(Place::Byte(self.start + at as u64), "base64".into(), found)
            })?),
        })
    }

    fn word(&self, bytes: &[u8], index: usize) -> Result<u64, ReadError> {
        let part = bytes.get(index * self.word_bytes..).unwrap_or_default();
        let part = part.get(..self.word_bytes).ok_or_else(|| {
            malformed(Place::Byte(self.start), "a count of bytes".into(), "the end".into())
        })?;
        let add = |all: u64, &byte: &u8| all << 8 | u64::from(byte);
        Ok(if self.is_big { part.iter().fold(0, add) } else { part.iter().rev().fold(0, add) })
    }
}

/// The first bytes of base64 (RFC 4648) in groups of four letters, each of which may be padded: VTK writes counts and blocks one after
/// the other. Where letters are wrong, their place.
fn base64(text: &[u8], limit: usize) -> Result<Vec<u8>, usize> {
    let mut out = Vec::new();
    let (mut bits, mut letters, mut pads) = (0_u32, 0, 0);
    for (at, &letter) in text.iter().enumerate() {
        if letter.is_ascii_whitespace() {
            continue;
        }
        if out.len() >= limit || letter == b'<' {
            break;
        }
        let value = match letter {
            b'A'..=b'Z' => letter - b'A',
            b'a'..=b'z' => letter - b'a' + 26,
            b'0'..=b'9' => letter - b'0' + 52,
            b'+' => 62,
            b'/' => 63,
            b'=' if letters >= 2 => 0,
            _ => return Err(at),
        };
        match (letter, pads) {
            (b'=', _) => pads += 1,
            (_, 0) => {}
            _ => return Err(at),
        }
        bits = bits << 6 | u32::from(value);
        letters += 1;
        if letters == 4 {
            out.extend_from_slice(&bits.to_be_bytes()[1..4 - pads]);
            (bits, letters, pads) = (0, 0, 0);
        }
    }
    out.truncate(limit);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of RFC 4648, section 10, and two of them in a row.
    #[test]
    fn base64_is_that_of_the_standard() {
        for (text, bytes) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
            ("Zm9v\n YmE=", "fooba"),
            ("Zm9vYmFy", "foobar"),
            ("Zg==Zm8=Zm9v", "ffofoo"),
        ] {
            assert_eq!(base64(text.as_bytes(), 99).unwrap(), bytes.as_bytes());
        }
        assert_eq!(base64(b"Zm9vYmFy", 4).unwrap(), b"foob");
        assert_eq!(base64(b"Zm9v?", 99), Err(4));
        assert_eq!(base64(b"Zg=v", 99), Err(3));
        assert_eq!(base64(b"=g==", 99), Err(0));
    }
}

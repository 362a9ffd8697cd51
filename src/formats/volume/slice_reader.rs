//! Volumes read slice by slice, for those that do not fit into memory.

use std::io::{self, BufRead, BufReader, Read};

use flate2::read::{MultiGzDecoder, ZlibDecoder};

use super::element::Element;
use super::header::MAX_HEADER;
use super::layout::{Layout, SamplesIn, Skip};
use super::nifti::{self, Scaling};
use super::unpack::{Packing, count_more};
use super::{Frame, Values, format_of, metaimage, nrrd, raw, stem, vol};
use crate::{Format, ReadError};

/// Most samples of a volume that is read slice by slice, 2³⁶.
pub const MAX_SLICED: u64 = 1 << 36;

/// A file opened at its start, with its length in bytes.
pub struct Stored {
    /// Its bytes.
    pub reader: Box<dyn Read + Send>,
    /// How many there are.
    pub length: u64,
}

/// Opens the file itself (`None`) or one beside it by its name without a folder, or says why it cannot.
pub type OpenFile<'a> = &'a mut dyn FnMut(Option<&str>) -> Result<Stored, String>;

/// The slices of a volume in turn.
pub struct SliceReader {
    layout: Layout,
    reader: Box<dyn Read + Send>,
    scaling: Option<Scaling>,
    next: u64,
}

impl SliceReader {
    /// Opens a volume by its header. `None` where the format does not hold its slices one after another, or is none: `.vol`, NRRD,
    /// MetaImage, NIfTI and raw samples with a TOML file do.
    ///
    /// # Errors
    ///
    /// What is wrong with the header, a size above [`MAX_SLICED`], and files that cannot be opened.
    pub fn open(name: &str, open: OpenFile<'_>) -> Result<Option<SliceReader>, ReadError> {
        let Ok(mut own) = open(None) else { return Ok(None) };
        let Ok(start) = head(&mut own.reader) else { return Ok(None) };
        let mut scaling = None;
        let (layout, is_samples) = match format_of(name, &start) {
            Some(Format::Vol) => (vol::layout(&start)?, false),
            Some(Format::MetaImage) => (metaimage::layout(&start)?, false),
            Some(Format::Nrrd) => match nrrd::layout(&start)? {
                Some(layout) => (layout, false),
                None => return Ok(None),
            },
            Some(Format::Nifti) => match nifti::by_slices(name, &start)? {
                Some((layout, scaled)) => {
                    scaling = scaled;
                    (layout, false)
                }
                None => return Ok(None),
            },
            Some(Format::Raw) => (raw::layout(name, &start)?, false),
            None => match raw_beside(name, open) {
                Some((side, header)) => (raw::layout(&side, &header)?, true),
                None => return Ok(None),
            },
            _ => return Ok(None),
        };
        layout.count(MAX_SLICED)?;
        let file = match &layout.file {
            SamplesIn::Beside(file, place) if !is_samples => {
                open(Some(file)).map_err(|why| layout.no_file(place, why))?
            }
            _ => open(None).map_err(|why| layout.no_file(&layout.size_at, why))?,
        };
        layout.check_length(file.length)?;
        let reader = layout.samples(file)?;
        Ok(Some(SliceReader { layout, reader, scaling, next: 0 }))
    }

    /// Columns, rows and slices.
    pub fn size(&self) -> [usize; 3] {
        self.layout.size.map(|side| side as usize)
    }

    /// Where the samples lie.
    pub fn frame(&self) -> Frame {
        self.layout.frame
    }

    /// The format of the file.
    pub fn format(&self) -> Format {
        self.layout.format
    }

    /// Whether samples are bytes.
    pub fn are_bytes(&self) -> bool {
        self.layout.element == Element::U8 && self.scaling.is_none()
    }

    /// The samples of the next slice, x fastest, then y; `None` behind the last one.
    ///
    /// # Errors
    ///
    /// A file that ends too soon or, where it is packed, holds more, and one whose packing is broken.
    pub fn next_slice(&mut self) -> Result<Option<Values>, ReadError> {
        let [columns, rows, slices] = self.layout.size;
        if self.next == slices {
            return Ok(None);
        }
        let count = columns * rows * self.layout.element.bytes() as u64;
        let mut bytes = Vec::new();
        let read = (&mut self.reader).take(count).read_to_end(&mut bytes);
        let found = match read {
            Ok(_) if bytes.len() as u64 == count => {
                self.next += 1;
                if self.next == slices && self.layout.packing.is_some() {
                    let more = count_more(&mut self.reader);
                    self.layout.check_no_more(slices.saturating_mul(count).saturating_add(more))?;
                }
                let values = self.layout.element.decoded(bytes, self.layout.is_big);
                return Ok(Some(match self.scaling {
                    Some(scaling) => scaling.of(&values),
                    None => values,
                }));
            }
            Ok(_) => format!("{} in slice {}", bytes.len(), self.next),
            Err(error) => format!("{error} in slice {}", self.next),
        };
        Err(ReadError::Malformed {
            format: self.layout.format,
            place: crate::Place::Byte(self.layout.start),
            expected: format!("{slices} slices of {count} bytes of samples"),
            found,
        })
    }
}

/// The first bytes of a file, as many as a header may take.
fn head(reader: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    reader.take(MAX_HEADER as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The TOML file beside raw samples.
fn raw_beside(name: &str, open: OpenFile<'_>) -> Option<(String, Vec<u8>)> {
    let side = format!("{}.toml", stem(name));
    let mut file = open(Some(&side)).ok()?;
    let bytes = head(&mut file.reader).ok()?;
    Some((side, bytes))
}

impl Layout {
    /// The samples of a file, unpacked, from the first one on.
    fn samples(&self, file: Stored) -> Result<Box<dyn Read + Send>, ReadError> {
        let fail = |error: io::Error| ReadError::Malformed {
            format: self.format,
            place: crate::Place::Byte(self.start),
            expected: "samples behind the header".into(),
            found: error.to_string(),
        };
        let mut reader = BufReader::with_capacity(1 << 18, file.reader);
        let mut before = self.start;
        skip(&mut reader, self.start).map_err(fail)?;
        for _ in 0..self.skip_lines {
            let mut line = Vec::new();
            before += reader.read_until(b'\n', &mut line).map_err(fail)? as u64;
        }
        let skipped = match self.skip {
            Skip::Bytes(skipped) => {
                if self.packing.is_none() {
                    let before = before.saturating_add(skipped);
                    self.check_no_more(file.length.saturating_sub(before))?;
                }
                skipped
            }
            Skip::AllBefore if self.packing.is_some() => return Err(self.packed_tail()),
            Skip::AllBefore => {
                let samples = self.count(MAX_SLICED)? * self.element.bytes() as u64;
                file.length.saturating_sub(before).saturating_sub(samples)
            }
        };
        let mut reader: Box<dyn Read + Send> = match self.packing {
            None => Box::new(reader),
            Some(Packing::Zlib) => Box::new(ZlibDecoder::new(reader)),
            Some(Packing::Gzip) => Box::new(MultiGzDecoder::new(reader)),
        };
        skip(&mut reader, skipped).map_err(fail)?;
        Ok(reader)
    }
}

/// Reads over bytes; a file that ends before them has no samples, which is told when they are asked for.
fn skip(reader: &mut impl Read, count: u64) -> io::Result<()> {
    io::copy(&mut reader.take(count), &mut io::sink()).map(|_| ())
}

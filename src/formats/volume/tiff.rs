//! Stacks of TIFF slices: one file with a page a slice, or a page a file.
//!
//! Source: TIFF 6.0 (Adobe, 1992) and BigTIFF, decoded by the crate `tiff`. A page holds one number a sample of 8, 16, 32 or 64 bits.
//! Pages are slices, from the first on; rows go down along y, as in ITK and ImageJ. ImageJ writes its spacing into the description of the
//! first page (`FileInfo.java`: `unit`, `spacing`), with pixels a unit as resolution. Without that there is no spacing of slices.

use std::io::Cursor;

use ::tiff::decoder::{Decoder, DecodingResult, Limits};
use ::tiff::tags::Tag;
use ::tiff::{ColorType, TiffError};

use super::{Frame, UnitKnown, Values, Volume, sample_count};
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Tiff;

/// Most that LZW, deflate and PackBits make of a byte; deflate, with 1032, makes less than LZW.
const MOST_UNPACKED: u64 = 4096;

/// Tiles may reach beyond the page, so a small page needs more than its own bytes.
const LEAST_BUFFER: usize = 1 << 22;

pub(super) fn is_tiff(bytes: &[u8]) -> bool {
    let starts: [&[u8]; 4] = [b"II\x2A\0", b"MM\0\x2A", b"II\x2B\0", b"MM\0\x2B"];
    starts.iter().any(|start| bytes.starts_with(start))
}

/// Reads a file with a page a slice.
pub(super) fn read(bytes: &[u8]) -> Result<Volume, ReadError> {
    let mut stack = Stack::default();
    let pages = stack.push(bytes)?;
    stack.check_images(pages)?;
    stack.finish()
}

/// Slices that were read so far.
#[derive(Default)]
pub(super) struct Stack {
    size: [usize; 3],
    values: Option<Values>,
    frame: Option<Frame>,
    /// Images that the description of ImageJ speaks of.
    images: Option<usize>,
}

impl Stack {
    /// Adds all pages of a file, and says how many they are.
    pub(super) fn push(&mut self, bytes: &[u8]) -> Result<usize, ReadError> {
        let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(|error| failed(1, &error))?;
        let mut pages = 0;
        loop {
            pages += 1;
            if self.frame.is_none() {
                self.describe(&mut decoder)?;
            }
            decoder = self.push_page(decoder, pages, bytes.len() as u64)?;
            if !decoder.more_images() {
                return Ok(pages);
            }
            decoder.next_image().map_err(|error| failed(pages + 1, &error))?;
        }
    }

    fn push_page<'a>(
        &mut self,
        mut decoder: Decoder<Cursor<&'a [u8]>>,
        page: usize,
        file_bytes: u64,
    ) -> Result<Decoder<Cursor<&'a [u8]>>, ReadError> {
        let size = page_size(&mut decoder, page)?;
        let slices = self.size[2] + 1;
        sample_count(FORMAT, place(page), [size[0] as u64, size[1] as u64, slices as u64])?;
        if self.size[2] > 0 && size != self.size[..2] {
            return Err(malformed(
                page,
                format!("a page of {} × {} as the first", self.size[0], self.size[1]),
                format!("{} × {}", size[0], size[1]),
            ));
        }
        let needed = needed_bytes(&mut decoder, page, size, file_bytes)?;
        let mut limits = Limits::default();
        limits.decoding_buffer_size = needed;
        limits.intermediate_buffer_size = needed.max(LEAST_BUFFER);
        decoder = decoder.with_limits(limits);
        let samples = decoder.read_image().map_err(|error| failed(page, &error))?;
        self.append(samples, page, size[0] * size[1])?;
        self.size = [size[0], size[1], slices];
        Ok(decoder)
    }

    fn append(
        &mut self,
        samples: DecodingResult,
        page: usize,
        count: usize,
    ) -> Result<(), ReadError> {
        let found = values(samples);
        if found.len() != count {
            return Err(malformed(page, format!("{count} samples"), found.len().to_string()));
        }
        match (&mut self.values, found) {
            (none @ None, found) => *none = Some(found),
            (Some(Values::Bytes(all)), Values::Bytes(more)) => all.extend(more),
            (Some(Values::Floats(all)), Values::Floats(more)) => all.extend(more),
            (Some(_), _) => {
                return Err(malformed(
                    page,
                    "samples of as many bits as those of the first page".into(),
                    "others".into(),
                ));
            }
        }
        Ok(())
    }

    /// The frame, from the first page.
    fn describe(&mut self, decoder: &mut Decoder<Cursor<&[u8]>>) -> Result<(), ReadError> {
        let text = decoder.get_tag_ascii_string(Tag::ImageDescription).unwrap_or_default();
        let mut frame = Frame::aligned([1.0; 3], UnitKnown::Missing);
        if text.starts_with("ImageJ=") {
            let value =
                |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('='));
            for key in ["channels", "frames"] {
                if let Some(count) = value(key).filter(|count| count.trim() != "1") {
                    return Err(ReadError::Unsupported {
                        format: FORMAT,
                        place: place(1),
                        expected: "one channel and one time".into(),
                        found: format!("{key}={count}"),
                    });
                }
            }
            self.images = value("images").and_then(|count| count.trim().parse().ok());
            let unit_mm = value("unit").and_then(|unit| unit_mm(unit.trim()));
            let per_unit = [Tag::XResolution, Tag::YResolution].map(|tag| ratio(decoder, tag));
            if let (Some(unit_mm), [Some(x), Some(y)]) = (unit_mm, per_unit) {
                // ImageJ leaves out a spacing of 1.
                let slices = value("spacing").map_or(Some(1.0), |text| text.trim().parse().ok());
                let steps = [1.0 / x, 1.0 / y, slices.unwrap_or(f64::NAN).abs()];
                frame = Frame::aligned(steps.map(|step| step * unit_mm), UnitKnown::Stated)
                    .checked(FORMAT, place(1))?;
            }
        }
        self.frame = Some(frame);
        Ok(())
    }

    /// Refuses a large stack of ImageJ, whose slices follow each other without pages of their own.
    pub(super) fn check_images(&self, pages: usize) -> Result<(), ReadError> {
        match self.images {
            Some(images) if images > pages => Err(malformed(
                pages,
                format!(
                    "{images} pages, as the description says (save the stack with a page a slice, or as raw samples)"
                ),
                pages.to_string(),
            )),
            _ => Ok(()),
        }
    }

    pub(super) fn finish(self) -> Result<Volume, ReadError> {
        match (self.values, self.frame) {
            (Some(values), Some(frame)) => {
                Ok(Volume { size: self.size, values, frame, format: FORMAT })
            }
            _ => Err(malformed(1, "a page".into(), "none".into())),
        }
    }
}

/// Columns and rows of a page that holds one number a sample.
fn page_size(decoder: &mut Decoder<Cursor<&[u8]>>, page: usize) -> Result<[usize; 2], ReadError> {
    let unsupported = |expected: &str, found: String| ReadError::Unsupported {
        format: FORMAT,
        place: place(page),
        expected: expected.into(),
        found,
    };
    let colour = decoder.colortype().map_err(|error| failed(page, &error))?;
    if !matches!(colour, ColorType::Gray(8 | 16 | 32 | 64)) {
        return Err(unsupported("grey values of 8, 16, 32 or 64 bits", format!("{colour:?}")));
    }
    let meaning = decoder.find_tag_unsigned::<u16>(Tag::PhotometricInterpretation);
    if meaning.map_err(|error| failed(page, &error))? == Some(0) {
        return Err(unsupported("larger values for brighter samples", "WhiteIsZero".into()));
    }
    let (columns, rows) = decoder.dimensions().map_err(|error| failed(page, &error))?;
    Ok([columns as usize, rows as usize])
}

/// Bytes of a page's samples, if what lies in the file can make as many.
fn needed_bytes(
    decoder: &mut Decoder<Cursor<&[u8]>>,
    page: usize,
    size: [usize; 2],
    file_bytes: u64,
) -> Result<usize, ReadError> {
    let fail = |error| failed(page, &error);
    let bits = match decoder.colortype().map_err(fail)? {
        ColorType::Gray(bits) => u64::from(bits),
        _ => 64,
    };
    let mut stored = 0_u64;
    for tag in [Tag::StripByteCounts, Tag::TileByteCounts] {
        let counts = decoder.find_tag_unsigned_vec::<u64>(tag).map_err(fail)?.unwrap_or_default();
        stored = counts.iter().fold(stored, |all, &one| all.saturating_add(one.min(file_bytes)));
    }
    let packing = decoder.find_tag_unsigned::<u16>(Tag::Compression).map_err(fail)?;
    let is_packed = packing.is_some_and(|packing| packing != 1);
    let most = stored.min(file_bytes).saturating_mul(if is_packed { MOST_UNPACKED } else { 1 });
    let needed = (size[0] as u64).saturating_mul(size[1] as u64).saturating_mul(bits / 8);
    if needed > most {
        return Err(malformed(page, format!("{needed} bytes of samples"), format!("{stored}")));
    }
    Ok(needed as usize)
}

fn values(samples: DecodingResult) -> Values {
    macro_rules! floats {
        ($values:expr) => {
            Values::Floats($values.into_iter().map(|value| value as f32).collect())
        };
    }
    match samples {
        DecodingResult::U8(values) => Values::Bytes(values),
        DecodingResult::U16(values) => floats!(values),
        DecodingResult::U32(values) => floats!(values),
        DecodingResult::U64(values) => floats!(values),
        DecodingResult::I8(values) => floats!(values),
        DecodingResult::I16(values) => floats!(values),
        DecodingResult::I32(values) => floats!(values),
        DecodingResult::I64(values) => floats!(values),
        DecodingResult::F16(values) => Values::Floats(values.into_iter().map(f32::from).collect()),
        DecodingResult::F32(values) => Values::Floats(values),
        DecodingResult::F64(values) => floats!(values),
    }
}

/// A resolution, samples a unit, above 0.
fn ratio(decoder: &mut Decoder<Cursor<&[u8]>>, tag: Tag) -> Option<f64> {
    use ::tiff::decoder::ifd::Value;
    let value = match decoder.find_tag(tag).ok()?? {
        Value::Rational(above, below) => f64::from(above) / f64::from(below),
        Value::Float(value) => f64::from(value),
        Value::Double(value) => value,
        _ => return None,
    };
    (value.is_finite() && value > 0.0).then_some(value)
}

/// Millimetres of a unit as ImageJ writes it; µ is an escape.
fn unit_mm(name: &str) -> Option<f64> {
    Some(match name {
        "mm" | "millimeter" => 1.0,
        "um" | "µm" | "micron" | "microns" | "micrometer" | "\\u00B5m" => 1e-3,
        "nm" | "nanometer" => 1e-6,
        "cm" | "centimeter" => 10.0,
        "m" | "meter" => 1000.0,
        "inch" | "in" => 25.4,
        _ => return None,
    })
}

fn place(page: usize) -> Place {
    Place::Page(page)
}

fn malformed(page: usize, expected: String, found: String) -> ReadError {
    ReadError::Malformed { format: FORMAT, place: place(page), expected, found }
}

fn failed(page: usize, error: &TiffError) -> ReadError {
    let expected = "a page of TIFF 6.0, unpacked or packed by LZW, deflate or PackBits";
    malformed(page, expected.into(), error.to_string())
}

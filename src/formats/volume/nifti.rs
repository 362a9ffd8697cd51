//! NIfTI-1.1 and NIfTI-2: a header of 348 or 540 bytes, then the samples.
//!
//! Sources: <https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h> and nifti2.h (offsets of fields, `xyzt_units`, the quaternion of
//! `qform`). The byte order is the one in which the size of the header is right.

use std::io::Read as _;

use flate2::read::GzDecoder;

use super::element::Element;
use super::layout::{SamplesIn, Skip};
use super::unpack::{Packing, exactly, is_gzip, unpacked};
use super::{Beside, Frame, MAX_SAMPLES, UnitKnown, Values, Volume, sample_count};
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Nifti;

pub(super) fn is_nifti(bytes: &[u8]) -> bool {
    layout(bytes).is_some()
}

/// Whether a name says that a NIfTI file is packed.
pub(super) fn is_packed_name(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.ends_with(".nii.gz") || name.ends_with(".hdr.gz")
}

/// Version and byte order.
#[derive(Clone, Copy)]
struct Layout {
    is_two: bool,
    is_big: bool,
}

fn layout(bytes: &[u8]) -> Option<Layout> {
    let size: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
    for is_big in [false, true] {
        let size = if is_big { u32::from_be_bytes(size) } else { u32::from_le_bytes(size) };
        let is_one = |magic: &[u8]| magic == b"n+1\0" || magic == b"ni1\0";
        let is_two = |magic: &[u8]| magic.starts_with(b"n+2\0") || magic.starts_with(b"ni2\0");
        if size == 348 && bytes.get(344..348).is_some_and(is_one) {
            return Some(Layout { is_two: false, is_big });
        }
        if size == 540 && bytes.len() >= 540 && is_two(&bytes[4..12]) {
            return Some(Layout { is_two: true, is_big });
        }
    }
    None
}

/// The fields of a header.
struct Fields<'a> {
    bytes: &'a [u8],
    layout: Layout,
}

macro_rules! field {
    ($name:ident, $kind:ty) => {
        /// A field at an offset; the header is long enough for all of them.
        fn $name(&self, at: usize) -> $kind {
            let mut own = [0; size_of::<$kind>()];
            own.copy_from_slice(&self.bytes[at..at + size_of::<$kind>()]);
            if self.layout.is_big {
                <$kind>::from_be_bytes(own)
            } else {
                <$kind>::from_le_bytes(own)
            }
        }
    };
}

impl Fields<'_> {
    field!(i16, i16);
    field!(i32, i32);
    field!(i64, i64);
    field!(f32, f32);
    field!(f64, f64);

    /// A number that is single in version 1 and double in version 2.
    fn number(&self, one: usize, two: usize, index: usize) -> f64 {
        if self.layout.is_two {
            self.f64(two + 8 * index)
        } else {
            f64::from(self.f32(one + 4 * index))
        }
    }

    /// `dim[index]`.
    fn dim(&self, index: usize) -> i64 {
        if self.layout.is_two {
            self.i64(16 + 8 * index)
        } else {
            i64::from(self.i16(40 + 2 * index))
        }
    }

    fn malformed(&self, at: [usize; 2], expected: &str, found: impl ToString) -> ReadError {
        let place = Place::Byte(at[usize::from(self.layout.is_two)] as u64);
        ReadError::Malformed {
            format: FORMAT,
            place,
            expected: expected.into(),
            found: found.to_string(),
        }
    }
}

pub(super) fn read(name: &str, bytes: &[u8], beside: Beside<'_>) -> Result<Volume, ReadError> {
    if is_gzip(bytes) {
        // Only what comes out is held; a file that goes on is too large.
        let limit = 8 * MAX_SAMPLES;
        let out = unpacked(FORMAT, 0, bytes, Packing::Gzip, limit)?;
        return if is_gzip(&out) { Err(wrong_magic(&out)) } else { read(name, &out, beside) };
    }
    let header = Header::of(bytes)?;
    let Header { fields, size, element, .. } = &header;
    let place = header.size_at();
    let expected = sample_count(FORMAT, place, *size)? * element.bytes();
    let start = header.offset()?;
    let elsewhere;
    let file = match header.holds_samples() {
        true => bytes,
        false => {
            elsewhere = beside(&beside_name(name)).map_err(|why| {
                fields.malformed([344, 4], "the file .img beside the header", why)
            })?;
            &elsewhere[..]
        }
    };
    let Some(data) = usize::try_from(start).ok().and_then(|start| file.get(start..)) else {
        return Err(fields.malformed([108, 168], "vox_offset within the file", start));
    };
    header.layout(name, None)?.check_no_more(data.len() as u64)?;
    let data = exactly(FORMAT, start, data.to_vec(), expected)?;
    let values = element.decoded(data, fields.layout.is_big);
    let values = scaling(fields).map_or_else(|| values.clone(), |scaling| scaling.of(&values));
    let frame = frame(fields)?;
    Ok(Volume { size: size.map(|side| side as usize), values, frame, format: FORMAT })
}

/// Where the samples of a file lie, by its first bytes, and how its values are scaled. `None` of a packed file whose first bytes hold no
/// header.
pub(super) fn by_slices(
    name: &str,
    start: &[u8],
) -> Result<Option<(super::layout::Layout, Option<Scaling>)>, ReadError> {
    let (packing, unpacked);
    let bytes = if is_gzip(start) {
        packing = Some(Packing::Gzip);
        unpacked = first_unpacked(start);
        &unpacked[..]
    } else {
        packing = None;
        start
    };
    if packing.is_some() && layout(bytes).is_none() {
        return Ok(None);
    }
    let header = Header::of(bytes)?;
    // A packed header names a file that may be packed too, or not.
    if packing.is_some() && !header.holds_samples() {
        return Ok(None);
    }
    Ok(Some((header.layout(name, packing)?, scaling(&header.fields))))
}

/// What the first bytes of a packed file unpack to, at least as far as a header goes.
fn first_unpacked(start: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    // Packed bytes end in the middle here: what came out before that counts.
    let _ = GzDecoder::new(start).take(HEADER as u64).read_to_end(&mut out);
    out
}

/// The larger header.
const HEADER: usize = 540;

/// The file of samples that belongs to a header.
fn beside_name(name: &str) -> String {
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    format!("{stem}.img")
}

/// A header whose size and type are known.
struct Header<'a> {
    fields: Fields<'a>,
    size: [u64; 3],
    element: Element,
}

impl Header<'_> {
    fn of(bytes: &[u8]) -> Result<Header<'_>, ReadError> {
        let Some(layout) = layout(bytes) else {
            return Err(wrong_magic(bytes));
        };
        let fields = Fields { bytes, layout };
        let dims = fields.dim(0);
        if !(3..=7).contains(&dims) || (4..=dims).any(|index| fields.dim(index as usize) > 1) {
            let found = (0..=dims.clamp(0, 7)).map(|index| fields.dim(index as usize).to_string());
            let found = found.collect::<Vec<_>>().join(" ");
            return Err(fields.malformed([40, 16], "dim of one volume with 3 sides", found));
        }
        let size = [1, 2, 3].map(|index| u64::try_from(fields.dim(index)).unwrap_or(0));
        let element = element(&fields)?;
        Ok(Header { fields, size, element })
    }

    fn size_at(&self) -> Place {
        Place::Byte(if self.fields.layout.is_two { 16 } else { 40 })
    }

    /// Whether the samples lie in the file of the header.
    fn holds_samples(&self) -> bool {
        let Fields { bytes, layout } = self.fields;
        let magic = if layout.is_two { &bytes[4..8] } else { &bytes[344..348] };
        magic[1] == b'+'
    }

    /// Bytes before the samples in the file that holds them.
    fn offset(&self) -> Result<u64, ReadError> {
        let is_two = self.fields.layout.is_two;
        let offset =
            if is_two { self.fields.i64(168) as f64 } else { f64::from(self.fields.f32(108)) };
        let least = match (self.holds_samples(), is_two) {
            (true, true) => 540.0,
            (true, false) => 348.0,
            (false, _) => 0.0,
        };
        if !(offset >= least && offset <= 1e18) {
            return Err(self.fields.malformed([108, 168], "vox_offset within the file", offset));
        }
        Ok(offset as u64)
    }

    /// Where the samples lie; `name` is that of the header.
    fn layout(
        &self,
        name: &str,
        packing: Option<Packing>,
    ) -> Result<super::layout::Layout, ReadError> {
        let place = Place::Byte(if self.fields.layout.is_two { 4 } else { 344 });
        Ok(super::layout::Layout {
            format: FORMAT,
            size: self.size,
            size_at: self.size_at(),
            element: self.element,
            is_big: self.fields.layout.is_big,
            frame: frame(&self.fields)?,
            file: match self.holds_samples() {
                true => SamplesIn::Own,
                false => SamplesIn::Beside(beside_name(name), place),
            },
            start: 0,
            packing,
            skip_lines: 0,
            skip: Skip::Bytes(self.offset()?),
            is_all: false,
        })
    }
}

fn wrong_magic(bytes: &[u8]) -> ReadError {
    ReadError::Malformed {
        format: FORMAT,
        place: Place::Byte(0),
        expected: "a header of 348 bytes with n+1 or ni1, or of 540 with n+2 or ni2".into(),
        found: crate::error::quoted(bytes),
    }
}

fn element(fields: &Fields<'_>) -> Result<Element, ReadError> {
    let at = if fields.layout.is_two { 12 } else { 70 };
    let code = fields.i16(at);
    let element = match code {
        2 => Element::U8,
        4 => Element::I16,
        8 => Element::I32,
        16 => Element::F32,
        64 => Element::F64,
        256 => Element::I8,
        512 => Element::U16,
        768 => Element::U32,
        1024 => Element::I64,
        1280 => Element::U64,
        _ => {
            return Err(ReadError::Unsupported {
                format: FORMAT,
                place: Place::Byte(at as u64),
                expected: "whole numbers of 8 to 64 bits, or floats of 32 or 64".into(),
                found: format!("datatype {code}"),
            });
        }
    };
    // Some programs leave bitpix 0.
    let (bits, stated) = (8 * element.bytes(), fields.i16(at + 2));
    if stated != 0 && i64::from(stated) != bits as i64 {
        let expected = format!("bitpix {bits}, as datatype {code} has");
        return Err(fields.malformed([72, 14], &expected, stated));
    }
    Ok(element)
}

/// `scl_slope` and `scl_inter`, where there is a slope.
fn scaling(fields: &Fields<'_>) -> Option<Scaling> {
    let (slope, shift) = (fields.number(112, 176, 0), fields.number(116, 184, 0));
    let is_plain = slope == 0.0 || !slope.is_finite() || (slope == 1.0 && shift == 0.0);
    (!is_plain).then_some(Scaling { slope, shift })
}

/// A factor of all values, and what is added.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaling {
    slope: f64,
    shift: f64,
}

impl Scaling {
    pub(super) fn of(self, values: &Values) -> Values {
        let of = |value: f32| (f64::from(value) * self.slope + self.shift) as f32;
        Values::Floats(values.to_floats().into_iter().map(of).collect())
    }
}

fn frame(fields: &Fields<'_>) -> Result<Frame, ReadError> {
    let two = fields.layout.is_two;
    let (units, qform, sform) = if two {
        (fields.i32(500), fields.i32(344), fields.i32(348))
    } else {
        (i32::from(fields.bytes[123]), i32::from(fields.i16(252)), i32::from(fields.i16(254)))
    };
    let (scale, unit) = match units & 7 {
        1 => (1000.0, UnitKnown::Stated),
        2 => (1.0, UnitKnown::Stated),
        3 => (1e-3, UnitKnown::Stated),
        _ => (1.0, UnitKnown::Assumed),
    };
    let spacing = [1, 2, 3].map(|index| fields.number(76, 104, index).abs() * scale);
    let mut frame = Frame::aligned(spacing, unit);
    if sform > 0 {
        for row in 0..3 {
            let number = |column| fields.number(280 + 16 * row, 400 + 32 * row, column) * scale;
            (0..3).for_each(|axis| frame.steps_mm[axis][row] = number(axis));
            frame.origin_mm[row] = number(3);
        }
    } else if qform > 0 {
        let [b, c, d] = [0, 1, 2].map(|index| fields.number(256, 352, index));
        let a = (1.0 - b * b - c * c - d * d).max(0.0).sqrt();
        // pixdim[0] is −1 where the third axis is turned over.
        let hand = if fields.number(76, 104, 0) < 0.0 { -1.0 } else { 1.0 };
        let turn = [
            [a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)],
            [2.0 * (b * c + a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d - a * b)],
            [2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a + d * d - b * b - c * c],
        ];
        let lengths = [spacing[0], spacing[1], spacing[2] * hand];
        for (axis, length) in lengths.into_iter().enumerate() {
            frame.steps_mm[axis] = [0, 1, 2].map(|row| turn[row][axis] * length);
        }
        frame.origin_mm = [0, 1, 2].map(|index| fields.number(268, 376, index) * scale);
    }
    frame.checked(FORMAT, Place::Byte(if two { 104 } else { 76 }))
}

//! NIfTI-1.1 and NIfTI-2: a header of 348 or 540 bytes, then the samples.
//!
//! Sources: <https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h> and nifti2.h (offsets of fields, `xyzt_units`, the quaternion of
//! `qform`). The byte order is the one in which the size of the header is right.

use super::element::Element;
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
    let place = Place::Byte(if layout.is_two { 16 } else { 40 });
    let count = sample_count(FORMAT, place, size)?;
    let element = element(&fields)?;
    let expected = count * element.bytes();
    let magic = if layout.is_two { &bytes[4..8] } else { &bytes[344..348] };
    let elsewhere;
    let (data, start) = if magic[1] == b'+' {
        let offset =
            if layout.is_two { fields.i64(168) as f64 } else { f64::from(fields.f32(108)) };
        let least = if layout.is_two { 540.0 } else { 348.0 };
        if !(offset >= least && offset <= bytes.len() as f64) {
            return Err(fields.malformed([108, 168], "vox_offset within the file", offset));
        }
        (&bytes[offset as usize..], offset as u64)
    } else {
        let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
        elsewhere = beside(&format!("{stem}.img"))
            .map_err(|why| fields.malformed([344, 4], "the file .img beside the header", why))?;
        (&elsewhere[..], 0)
    };
    let data = data[..data.len().min(expected)].to_vec();
    let data = exactly(FORMAT, start, data, expected)?;
    let values = scaled(&fields, element.decoded(data, layout.is_big));
    let frame = frame(&fields)?;
    Ok(Volume { size: size.map(|side| side as usize), values, frame, format: FORMAT })
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
    Ok(match code {
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
    })
}

/// The values times `scl_slope` plus `scl_inter`, where there is a slope.
fn scaled(fields: &Fields<'_>, values: Values) -> Values {
    let (slope, shift) = (fields.number(112, 176, 0), fields.number(116, 184, 0));
    let is_plain = slope == 0.0 || !slope.is_finite() || (slope == 1.0 && shift == 0.0);
    if is_plain {
        return values;
    }
    let of = |value: f32| (f64::from(value) * slope + shift) as f32;
    Values::Floats(values.to_floats().into_iter().map(of).collect())
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

//! Binary SDF: a header of 81 bytes, then the heights. Little-endian, as Gwyddion, SurfaceTopography
//! and the instruments take it; the standard names no byte order.
//!
//! ```text
//!  0 magic, 8 letters          42 NumPoints, u16       70 Zresolution, f64
//!  8 ManufacID, 10 letters     44 NumProfiles, u16     78 Compression, u8
//! 18 CreateDate, 12 letters    46 Xscale, f64          79 DataType, u8
//! 30 ModDate, 12 letters       54 Yscale, f64          80 CheckType, u8
//!                              62 Zscale, f64          81 heights
//! ```

use super::{DataType, Header, check_plain, malformed, source};
use crate::{Place, ReadError, Topography};

pub(super) fn read(bytes: &[u8]) -> Result<Topography, ReadError> {
    let Some((header, data)) = bytes.split_at_checked(HEADER_LEN) else {
        let expected = format!("a header of {HEADER_LEN} bytes");
        return Err(malformed(Place::Byte(bytes.len() as u64), &expected, bytes.len()));
    };
    if !matches!(&header[..8], b"bISO-1.0" | b"bBCR-1.0") {
        let found = crate::error::quoted(&header[..8]);
        return Err(malformed(Place::Byte(0), "bISO-1.0 or bBCR-1.0", found));
    }
    let place = |offset: usize| Place::Byte(offset as u64);
    let code = |offset: usize| u64::from(header[offset]);
    check_plain("Compression", code(COMPRESSION), place(COMPRESSION))?;
    check_plain("CheckType", code(CHECK_TYPE), place(CHECK_TYPE))?;
    let size = |offset| (u64::from(u16::from_le_bytes(at(header, offset))), place(offset));
    let scale = |offset| (f64::from_le_bytes(at(header, offset)), place(offset));
    let text = |offset: usize, len: usize| {
        let text = String::from_utf8_lossy(&header[offset..offset + len]).into_owned();
        text.trim_matches(|letter: char| letter == '\0' || letter.is_whitespace()).to_owned()
    };
    let header = Header {
        points: size(NUM_POINTS),
        profiles: size(NUM_PROFILES),
        x_scale_m: scale(X_SCALE),
        y_scale_m: scale(Y_SCALE),
        z_scale_m: scale(Z_SCALE),
        data_type: DataType::from_code(code(DATA_TYPE), place(DATA_TYPE))?,
        source: source(&text(MANUFACTURER, 10), &text(CREATE_DATE, 12)),
    };
    let samples = header.samples()?;
    let expected = samples * header.data_type.len();
    if data.len() < expected {
        let expected = format!("{expected} bytes of heights");
        return Err(malformed(place(HEADER_LEN), &expected, data.len()));
    }
    // What follows the heights is a trailer of free text.
    let stored = header.data_type.decode(&data[..expected]);
    header.into_topography(stored)
}

/// The `N` bytes at an offset inside the header.
fn at<const N: usize>(header: &[u8], offset: usize) -> [u8; N] {
    *header[offset..].first_chunk().expect("every offset below lies inside the 81 bytes")
}

impl DataType {
    /// Bytes of one height.
    fn len(self) -> usize {
        match self {
            DataType::U8 | DataType::I8 => 1,
            DataType::U16 | DataType::I16 => 2,
            DataType::U32 | DataType::I32 | DataType::F32 => 4,
            DataType::F64 => 8,
        }
    }

    fn decode(self, data: &[u8]) -> Vec<f64> {
        fn each<const N: usize>(data: &[u8], value: impl Fn([u8; N]) -> f64) -> Vec<f64> {
            data.as_chunks::<N>().0.iter().map(|&bytes| value(bytes)).collect()
        }
        match self {
            DataType::U8 => each(data, |bytes| u8::from_le_bytes(bytes).into()),
            DataType::I8 => each(data, |bytes| i8::from_le_bytes(bytes).into()),
            DataType::U16 => each(data, |bytes| u16::from_le_bytes(bytes).into()),
            DataType::I16 => each(data, |bytes| i16::from_le_bytes(bytes).into()),
            DataType::U32 => each(data, |bytes| u32::from_le_bytes(bytes).into()),
            DataType::I32 => each(data, |bytes| i32::from_le_bytes(bytes).into()),
            DataType::F32 => each(data, |bytes| f32::from_le_bytes(bytes).into()),
            DataType::F64 => each(data, f64::from_le_bytes),
        }
    }
}

const HEADER_LEN: usize = 81;
const MANUFACTURER: usize = 8;
const CREATE_DATE: usize = 18;
const NUM_POINTS: usize = 42;
const NUM_PROFILES: usize = 44;
const X_SCALE: usize = 46;
const Y_SCALE: usize = 54;
const Z_SCALE: usize = 62;
const COMPRESSION: usize = 78;
const DATA_TYPE: usize = 79;
const CHECK_TYPE: usize = 80;

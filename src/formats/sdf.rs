//! SDF surface data files, ISO 25178-71:2012, and their forerunner BCR.
//!
//! A file starts with `aISO-1.0` (text), `bISO-1.0` (binary) or, before the standard, `aBCR-1.0` or
//! `bBCR-1.0`. Both kinds carry the same header: sizes, scales in metres, and the type of the
//! stored heights. A height is the stored value times `Zscale`; profile `j` lies at y = `j` times
//! `Yscale`, its points follow each other along x.
//!
//! Missing heights are `BAD` in text and NaN in floating-point types. Stored integers mark them by
//! the smallest value of a signed and the largest of an unsigned type of 16 or 32 bits, which is
//! the practice of instruments; Gwyddion and SurfaceTopography read it the same way.
//!
//! Compressed files and files with a check sum (`Compression` and `CheckType` other than 0) are not
//! supported.

mod binary;
mod text;

use crate::scan::grid_len;
use crate::topography::joined;
use crate::{Format, HeightMap, Place, ReadError, Source, Topography};

/// Reads a text or binary SDF file.
///
/// # Errors
///
/// The first line or byte that breaks the format; more or fewer heights than the header declares;
/// scales that are not above zero; compression and check sums.
///
/// # Example
///
/// ```
/// let file = b"aISO-1.0\nNumPoints = 2\nNumProfiles = 1\nXscale = 1e-6\nYscale = 1e-6\n\
///     Zscale = 1e-9\nDataType = 7\n*\n5 BAD\n*\n";
/// let topography = asphera_formats::sdf::read(file)?;
/// assert_eq!(topography.points().next(), Some([0.0, 0.0, 5e-6]));
/// assert_eq!(topography.missing(), 1);
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Topography, ReadError> {
    let bytes = crate::scan::without_bom(bytes);
    if bytes.starts_with(b"b") { binary::read(bytes) } else { text::read(bytes) }
}

/// Whether a file starts as an SDF file does.
pub(crate) fn is_sdf(bytes: &[u8]) -> bool {
    [b"aISO-1.0", b"bISO-1.0", b"aBCR-1.0", b"bBCR-1.0"]
        .iter()
        .any(|magic| bytes.starts_with(magic.as_slice()))
}

/// The header that both kinds of file carry, with the place of each field.
struct Header {
    points: (u64, Place),
    profiles: (u64, Place),
    x_scale_m: (f64, Place),
    y_scale_m: (f64, Place),
    z_scale_m: (f64, Place),
    data_type: DataType,
    source: Source,
}

impl Header {
    /// How many heights there are.
    fn samples(&self) -> Result<usize, ReadError> {
        let ((nx, place), (ny, _)) = (&self.points, &self.profiles);
        grid_len(Format::Sdf, place.clone(), *nx, *ny)
    }

    /// The map of the stored values, of which there are as many as [`Header::samples`] says.
    fn into_topography(self, stored: Vec<f64>) -> Result<Topography, ReadError> {
        let metres = |(scale_m, place): (f64, Place), steps: u64| {
            if !(scale_m.is_finite() && scale_m > 0.0) {
                return Err(malformed(place, "a scale in metres above zero", scale_m));
            }
            if !(scale_m * MM_PER_M * steps as f64).is_finite() {
                return Err(malformed(
                    place,
                    "a scale that keeps all lengths finite in mm",
                    scale_m,
                ));
            }
            Ok(scale_m)
        };
        let z_scale_m = metres(self.z_scale_m, 1)?;
        let missing = self.data_type.missing();
        let mut z_mm = stored;
        for z in &mut z_mm {
            let z_mm = *z * z_scale_m * MM_PER_M;
            *z = if Some(*z) != missing && z_mm.is_finite() { z_mm } else { f64::NAN };
        }
        let map = HeightMap {
            nx: self.points.0 as usize,
            ny: self.profiles.0 as usize,
            dx_mm: metres(self.x_scale_m, self.points.0)? * MM_PER_M,
            dy_mm: metres(self.y_scale_m, self.profiles.0)? * MM_PER_M,
            x0_mm: 0.0,
            y0_mm: 0.0,
            z_mm,
        };
        Ok(Topography::Map(map, self.source))
    }
}

/// How the heights are stored: the codes of ISO 25178-71.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum DataType {
    U8 = 0,
    U16 = 1,
    U32 = 2,
    F32 = 3,
    I8 = 4,
    I16 = 5,
    I32 = 6,
    F64 = 7,
}

impl DataType {
    fn from_code(code: u64, place: Place) -> Result<DataType, ReadError> {
        use DataType::{F32, F64, I8, I16, I32, U8, U16, U32};
        [U8, U16, U32, F32, I8, I16, I32, F64]
            .into_iter()
            .find(|data_type| *data_type as u64 == code)
            .ok_or_else(|| malformed(place, "a DataType from 0 to 7", code))
    }

    /// The stored value that means a missing height, if the type has one.
    fn missing(self) -> Option<f64> {
        match self {
            DataType::U16 => Some(f64::from(u16::MAX)),
            DataType::U32 => Some(f64::from(u32::MAX)),
            DataType::I16 => Some(f64::from(i16::MIN)),
            DataType::I32 => Some(f64::from(i32::MIN)),
            DataType::U8 | DataType::I8 | DataType::F32 | DataType::F64 => None,
        }
    }
}

/// Source of a file made by `manufacturer` at `created`, which is `ddmmyyyyhhmm`.
fn source(manufacturer: &str, created: &str) -> Source {
    let mut source = Source::new(Format::Sdf);
    source.instrument = joined(&[manufacturer]);
    let digits = created.len() == 12 && created.bytes().all(|byte| byte.is_ascii_digit());
    source.date = if digits {
        let (day, month, year) = (&created[..2], &created[2..4], &created[4..8]);
        Some(format!("{year}-{month}-{day}T{}:{}", &created[8..10], &created[10..]))
    } else {
        joined(&[created])
    };
    source
}

/// Refuses a field that says how the data are packed or checked, unless it says they are not.
fn check_plain(name: &str, code: u64, place: Place) -> Result<(), ReadError> {
    if code == 0 {
        return Ok(());
    }
    Err(ReadError::Unsupported {
        format: Format::Sdf,
        place,
        expected: format!("{name} 0"),
        found: format!("{name} {code}"),
    })
}

fn malformed(place: Place, expected: &str, found: impl ToString) -> ReadError {
    ReadError::Malformed {
        format: Format::Sdf,
        place,
        expected: expected.into(),
        found: found.to_string(),
    }
}

const MM_PER_M: f64 = 1e3;

#[cfg(test)]
mod tests;

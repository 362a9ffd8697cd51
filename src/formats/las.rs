//! LAS 1.0 to 1.4 (ASPRS, "LAS Specification 1.4 - R15", 2019), and LAZ: the points of a scanner.
//!
//! Read is what makes points, all numbers little-endian:
//!
//! | byte | type | what |
//! |---|---|---|
//! | 0 | 4 × u8 | `LASF` |
//! | 24 | 2 × u8 | version, 1 and 0 to 4 |
//! | 94 | u16 | length of the header |
//! | 96 | u32 | where the points begin |
//! | 100 | u32 | how many records of variable length follow the header |
//! | 104 | u8 | format of the points, 0 to 10; bit 7 says that they are compressed |
//! | 105 | u16 | length of a point |
//! | 107 | u32 | how many points, up to 1.3 and in small files of 1.4 |
//! | 131 | 3 × f64 | scale of x, y, z |
//! | 155 | 3 × f64 | offset of x, y, z |
//! | 247 | u64 | how many points, from 1.4 on |
//!
//! A point begins with x, y, z as i32: a coordinate is number × scale + offset. Points that are marked as withheld are gaps.
//! Everything else (intensities, returns, classes, colours, waveforms) is passed over.
//!
//! Coordinates are metres in most files, feet in some, degrees in others, and mm in hardly any. Which one only a coordinate system
//! says that many files lack. So the unit is never assumed: the options must name it.

mod laz;

use crate::error::quoted;
use crate::lengths::{Lengths, Points, check_count};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, Topography};

/// Reads the points as a cloud, in the order of the file. `O(bytes)`.
///
/// Of `options` the units count, and must be there: one for all, or one each for x, y and z.
///
/// # Errors
///
/// No unit; a header that does not follow the specification, with its byte; fewer points than it says; more than
/// [`MAX_POINTS`](crate::MAX_POINTS) of them; a coordinate that is not finite; compressed points that cannot be unpacked, or were
/// packed by LASzip 1.
pub fn read(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let header = Header::read(bytes)?;
    if options.units.is_empty() {
        return Err(ReadError::Unclear {
            format: FORMAT,
            place: Place::Byte(SCALES as u64),
            found: "the coordinates may be metres, feet or anything else, for LAS has no unit of its own".into(),
            cure: "add `--unit` with that of the coordinates: mm, um, nm, cm, m or in".into(),
        });
    }
    let mut points = Points::new(Lengths::of(FORMAT, None, options)?);
    if header.is_compressed {
        let place = || Place::Byte(header.start as u64);
        laz::each_record(&header, bytes, |record| header.take(record, &mut points, place))?;
        return points.finish([1, 2, 3], Place::Byte(bytes.len() as u64));
    }
    let records = header.records(bytes)?;
    for (index, record) in records.chunks_exact(header.record_len).enumerate() {
        let at = header.start + index * header.record_len;
        header.take(record, &mut points, || Place::Byte(at as u64))?;
    }
    points.finish([1, 2, 3], Place::Byte(bytes.len() as u64))
}

/// Description in the header of the points.
struct Header {
    minor: u8,
    point_format: u8,
    is_compressed: bool,
    record_len: usize,
    /// Bytes of the header, after which records of variable length follow, and how many of these.
    len: usize,
    variable_records: u32,
    start: usize,
    count: u64,
    scales: [f64; 3],
    offsets: [f64; 3],
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Header, ReadError> {
        if !bytes.starts_with(MAGIC) {
            return Err(malformed(0, "LASF", quoted(bytes)));
        }
        let at = Fields(bytes);
        let [major, minor] = at.bytes(24)?;
        if major != 1 || minor > 4 {
            let expected = "version 1.0 to 1.4".into();
            let found = format!("version {major}.{minor}");
            let place = Place::Byte(24);
            return Err(ReadError::Unsupported { format: FORMAT, place, expected, found });
        }
        let needed = if minor >= 4 { LEN_1_4 } else { LEN_1_0 };
        let len = u16::from_le_bytes(at.bytes(94)?);
        if len < needed {
            let expected = format!("a header of at least {needed} bytes");
            return Err(malformed(94, &expected, format!("{len}")));
        }
        let start = u32::from_le_bytes(at.bytes(96)?);
        if start < u32::from(len) {
            let expected = format!("points that begin after the header of {len} bytes");
            return Err(malformed(96, &expected, format!("at {start}")));
        }
        let [point_format] = at.bytes(104)?;
        let is_compressed = point_format & COMPRESSED != 0;
        let point_format = point_format & !COMPRESSED;
        let Some(&shortest) = SHORTEST.get(usize::from(point_format)) else {
            let expected = "a format of points from 0 to 10";
            return Err(malformed(104, expected, format!("{point_format}")));
        };
        let record_len = u16::from_le_bytes(at.bytes(105)?);
        if record_len < shortest {
            let expected = format!("points of at least {shortest} bytes, of format {point_format}");
            return Err(malformed(105, &expected, format!("{record_len}")));
        }
        let short_count = u64::from(u32::from_le_bytes(at.bytes(107)?));
        let (count, count_at) = match minor {
            4.. => match u64::from_le_bytes(at.bytes(247)?) {
                0 => (short_count, 107),
                count => (count, 247),
            },
            _ => (short_count, 107),
        };
        check_count(FORMAT, count, || Place::Byte(count_at))?;
        let scales = at.numbers(SCALES)?;
        if scales.contains(&0.0) {
            return Err(malformed(SCALES, "scales other than 0", format!("{scales:?}")));
        }
        Ok(Header {
            minor,
            point_format,
            is_compressed,
            len: usize::from(len),
            variable_records: u32::from_le_bytes(at.bytes(100)?),
            record_len: usize::from(record_len),
            start: start as usize,
            count,
            scales,
            offsets: at.numbers(SCALES + 24)?,
        })
    }

    /// The bytes of all points.
    fn records<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8], ReadError> {
        let rest = bytes.get(self.start..).unwrap_or_default();
        // At most 10⁸ points of 65,535 bytes.
        let len = self.count * self.record_len as u64;
        usize::try_from(len).ok().and_then(|len| rest.get(..len)).ok_or_else(|| {
            let expected = format!("{} points of {} bytes", self.count, self.record_len);
            malformed(self.start, &expected, format!("{}", rest.len() / self.record_len))
        })
    }

    /// Takes one point; one that is withheld is a gap.
    fn take(
        &self,
        record: &[u8],
        points: &mut Points,
        place: impl Fn() -> Place,
    ) -> Result<(), ReadError> {
        if self.is_withheld(record) {
            points.skip();
            return Ok(());
        }
        let mut point = [0.0; 3];
        let (numbers, _) = record.as_chunks::<4>();
        for (axis, (coordinate, number)) in point.iter_mut().zip(numbers).enumerate() {
            let number = f64::from(i32::from_le_bytes(*number));
            *coordinate = number * self.scales[axis] + self.offsets[axis];
        }
        points.push(point, place)
    }

    /// Byte 15 has the mark: bit 7 up to format 5, bit 2 from format 6 on. LAS 1.0 has none.
    fn is_withheld(&self, record: &[u8]) -> bool {
        let mark = match (self.minor, self.point_format) {
            (0, _) => 0,
            (_, ..=5) => 0x80,
            _ => 0x04,
        };
        record.get(15).is_some_and(|flags| flags & mark != 0)
    }
}

/// Numbers of the header at their bytes.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn bytes<const N: usize>(&self, at: usize) -> Result<[u8; N], ReadError> {
        let found = self.0.get(at..).and_then(|rest| rest.first_chunk::<N>());
        found.copied().ok_or_else(|| {
            malformed(at, "a header of at least 227 bytes", format!("{} bytes", self.0.len()))
        })
    }

    fn numbers(&self, at: usize) -> Result<[f64; 3], ReadError> {
        let mut numbers = [0.0; 3];
        for (index, number) in numbers.iter_mut().enumerate() {
            *number = f64::from_le_bytes(self.bytes(at + 8 * index)?);
        }
        if numbers.iter().all(|number| number.is_finite()) {
            return Ok(numbers);
        }
        Err(malformed(at, "three finite numbers", format!("{numbers:?}")))
    }
}

fn malformed(at: usize, expected: &str, found: String) -> ReadError {
    let place = Place::Byte(at as u64);
    ReadError::Malformed { format: FORMAT, place, expected: expected.into(), found }
}

/// How every file begins.
pub(crate) const MAGIC: &[u8] = b"LASF";
const FORMAT: Format = Format::Las;
/// Bytes of the header up to 1.2, and of 1.4.
const LEN_1_0: u16 = 227;
const LEN_1_4: u16 = 375;
/// Where the scales are; the offsets follow.
const SCALES: usize = 131;
/// The bit that marks compressed points.
const COMPRESSED: u8 = 0x80;
/// Bytes of a point of each format.
const SHORTEST: [u16; 11] = [20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67];

#[cfg(test)]
mod tests;

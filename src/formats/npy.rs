//! Arrays of NumPy, `.npy` (NumPy Enhancement Proposal 1, and `numpy.lib.format`; versions 1.0, 2.0 and 3.0).
//!
//! ```text
//! 0x93 NUMPY, major, minor            2 bytes of version
//! length of the header                u16, from 2.0 on u32, little-endian
//! {'descr': '<f8', 'fortran_order': False, 'shape': (100, 3), }
//! the numbers                         in the order of C or Fortran
//! ```
//!
//! What an array means follows from its shape, as the columns of a text do:
//!
//! | array | meaning |
//! |---|---|
//! | n × 3 | points x, y, z |
//! | n × 4 | points x, y, z with the standard uncertainty of z |
//! | n × 2 | a profile x, z, or x, slope, by the units in the options |
//! | n × any, with a pitch | a matrix of heights, the top row first |
//! | n records with fields x, y, z | points; a field `u_z` is the uncertainty, and `x_um` is in µm |
//!
//! Numbers are whole ones of 1 to 8 bytes or floating point of 4 or 8. NaN is a missing height. The format has no unit: it is taken
//! from the options, or is mm. [`TextOptions::columns`] names other columns.

mod dtype;
mod literal;

use crate::error::quoted;
use crate::lengths::check_count;
use crate::xyz::{By, TextOptions, map_of_heights, rows_of_array, unit_of_heights};
use crate::{Format, Place, ReadError, Source, Topography};
use dtype::Item;
use literal::Literal;

/// Reads an array as points, a profile or a matrix of heights. `O(bytes)`.
///
/// # Errors
///
/// A header that does not follow the specification; other types of numbers; a shape that is none of the above; more or fewer
/// bytes than the shape asks for; a number that is infinite, with its row; more than [`MAX_POINTS`](crate::MAX_POINTS) points.
pub fn read(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let header = Header::read(bytes)?;
    let Header { item, shape, is_fortran, start } = &header;
    let data = &bytes[*start..];
    let width = shape.get(1).copied().unwrap_or(1);
    let [rows, width] = match (item, &shape[..]) {
        (Item::Number(_), [_, _]) | (Item::Record { .. }, [_]) => [shape[0], width],
        (Item::Number(_), _) => {
            let expected = "an array of two dimensions, as n × 3 for x, y, z";
            return Err(malformed(*start, expected, header.shape_words()));
        }
        (Item::Record { .. }, _) => {
            let expected = "records in one dimension";
            return Err(malformed(*start, expected, header.shape_words()));
        }
    };
    let place = || Place::Byte(*start as u64);
    let samples = if options.pitch_mm.is_some() { rows.saturating_mul(width) } else { rows };
    check_count(FORMAT, samples, place)?;
    header.check_len(data)?;
    if samples == 0 {
        return Err(malformed(*start, "at least one point", header.shape_words()));
    }
    // Bounded by MAX_POINTS and by the bytes of the file.
    let [rows, width] = [rows as usize, width as usize];
    let topography = match item {
        Item::Number(number) => {
            let value = |row: usize, column: usize| {
                let index = if *is_fortran { column * rows + row } else { row * width + column };
                number.at(data, index * number.size())
            };
            match options.pitch_mm {
                Some(pitch_mm) => heights([rows, width], pitch_mm, options, value),
                None => points([rows, width], options, value),
            }
        }
        Item::Record { size, fields } => {
            if options.pitch_mm.is_some() {
                return Err(ReadError::Unclear {
                    format: FORMAT,
                    place: place(),
                    found: "records with named fields are no matrix of heights".into(),
                    cure: "leave out `--pitch`".into(),
                });
            }
            let names: Vec<String> = fields.iter().map(|field| field.name.clone()).collect();
            rows_of_array(&names, [rows, fields.len()], options, |row, column| {
                let field = &fields[column];
                field.number.at(data, row * size + field.at)
            })
        }
    };
    topography.map(relabelled).map_err(|error| error.in_array(FORMAT))
}

/// Whether a file begins as one.
pub(crate) fn is_npy(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

fn points(
    [rows, width]: [usize; 2],
    options: &TextOptions,
    value: impl Fn(usize, usize) -> f64,
) -> Result<Topography, ReadError> {
    let is_uncertain = width == 4 && options.columns.is_empty();
    let names = if is_uncertain { &["x", "y", "z", "u_z"][..] } else { &[] };
    let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
    let mut topography = rows_of_array(&names, [rows, width], options, value)?;
    if let Topography::Cloud(_, Source { taken: Some(taken), .. }) = &mut topography
        && is_uncertain
    {
        taken.named_by = By::Default;
    }
    Ok(topography)
}

fn heights(
    [rows, width]: [usize; 2],
    pitch_mm: [f64; 2],
    options: &TextOptions,
    value: impl Fn(usize, usize) -> f64,
) -> Result<Topography, ReadError> {
    let unit = unit_of_heights(options)?;
    let mut heights_mm = Vec::with_capacity(rows * width);
    for row in 0..rows {
        for column in 0..width {
            let height_mm = unit.scaled(value(row, column));
            if height_mm.is_infinite() {
                return Err(ReadError::Malformed {
                    format: FORMAT,
                    place: Place::Row { row: row + 1, column: column + 1 },
                    expected: format!("a height in {unit}, or NaN"),
                    found: height_mm.to_string(),
                });
            }
            heights_mm.push(height_mm);
        }
    }
    Ok(map_of_heights(&heights_mm, [width, rows], pitch_mm, unit, false, options))
}

/// A topography as read from a file of this format.
fn relabelled(mut topography: Topography) -> Topography {
    let (Topography::Map(_, source) | Topography::Cloud(_, source)) = &mut topography;
    source.format = FORMAT;
    topography
}

struct Header {
    item: Item,
    shape: Vec<u64>,
    is_fortran: bool,
    /// Where the numbers begin.
    start: usize,
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Header, ReadError> {
        let Some(rest) = bytes.strip_prefix(MAGIC) else {
            return Err(malformed(0, "\\x93NUMPY", quoted(bytes)));
        };
        let version = || ("version 1.0, 2.0 or 3.0", quoted(&rest[..rest.len().min(2)]));
        let (len, start) = match rest {
            [1, 0, a, b, ..] => (usize::from(u16::from_le_bytes([*a, *b])), 10),
            [2 | 3, 0, a, b, c, d, ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, 12),
            _ => {
                let (expected, found) = version();
                return Err(malformed(6, expected, found));
            }
        };
        let Some(text) = bytes[start..].get(..len) else {
            let found = format!("{} bytes", bytes.len() - start);
            return Err(malformed(start, &format!("a header of {len} bytes"), found));
        };
        let text = crate::scan::decoded(text);
        let expected = "a dictionary of descr, fortran_order and shape";
        let wrong = || malformed(start, expected, quoted(text.as_bytes()));
        let entries = literal::dictionary(&text).ok_or_else(wrong)?;
        let entry = |name: &str| {
            entries.iter().find(|(key, _)| key == name).map(|(_, value)| value).ok_or_else(wrong)
        };
        let Literal::Flag(is_fortran) = *entry("fortran_order")? else { return Err(wrong()) };
        let Literal::List(sizes) = entry("shape")? else { return Err(wrong()) };
        let sizes = sizes.iter().map(|size| match size {
            Literal::Whole(size) => Some(*size),
            _ => None,
        });
        let shape = sizes.collect::<Option<Vec<u64>>>().ok_or_else(wrong)?;
        let item = dtype::item(entry("descr")?).map_err(|found| ReadError::Unsupported {
            format: FORMAT,
            place: Place::Byte(start as u64),
            expected: "whole numbers of 1 to 8 bytes or floating point of 4 or 8, or records of fields such as x, y, z"
                .into(),
            found,
        })?;
        Ok(Header { item, shape, is_fortran, start: start + len })
    }

    /// As many bytes must follow as the shape asks for.
    fn check_len(&self, data: &[u8]) -> Result<(), ReadError> {
        let size = match &self.item {
            Item::Number(number) => number.size(),
            Item::Record { size, .. } => *size,
        };
        let whole = self.shape.iter().try_fold(1_u64, |product, size| product.checked_mul(*size));
        let needed = whole.and_then(|whole| whole.checked_mul(size as u64));
        if needed == Some(data.len() as u64) {
            return Ok(());
        }
        let needed = needed.map_or_else(|| "more than 2⁶⁴".into(), |needed| needed.to_string());
        let expected = format!("{needed} bytes of numbers for the shape {}", self.shape_words());
        let whole = data.len() / size.max(1);
        let found = format!("{}, which is {whole} whole items", data.len());
        Err(malformed(self.start, &expected, found))
    }

    fn shape_words(&self) -> String {
        let sizes: Vec<String> = self.shape.iter().map(u64::to_string).collect();
        format!("({})", sizes.join(", "))
    }
}

fn malformed(at: usize, expected: &str, found: String) -> ReadError {
    let place = Place::Byte(at as u64);
    ReadError::Malformed { format: FORMAT, place, expected: expected.into(), found }
}

const FORMAT: Format = Format::Npy;
const MAGIC: &[u8] = b"\x93NUMPY";

#[cfg(test)]
mod tests;

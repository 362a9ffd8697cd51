//! `.xyz` files: a point a line, x y z in mm, as columns of text.
//!
//! There is no standard for these files. What is read here:
//!
//! - A line holds at least three columns; further columns (intensity, quality) are passed over, but for one
//!   named `u_z`: the standard uncertainty of z, in mm.
//!   Columns are separated by white space, or by one comma, or by one semicolon, each with or
//!   without white space around it. One line uses one kind of separator.
//! - `#`, `%` and `//` start a comment that ends with the line. Empty lines are passed over. A
//!   semicolon never starts a comment, because it separates columns.
//! - One line of column names may stand before the first point: none of its first three columns
//!   starts as a number does. A unit in it, `[…]` or `(…)`, must be mm.
//! - A point whose z is `NaN`, `BAD`, asterisks or empty was not measured: it is counted in
//!   [`Cloud::missing`]. x and y must be numbers. A number that stands for a missing height, such
//!   as -9999, cannot be told from a height and is taken as one.
//! - Lines end with LF, CR LF or CR. A UTF-8 byte order mark is passed over; one of UTF-16 says that the text is UTF-16.
//! - The decimal separator is a point. A comma that is or may be one is an error with a hint,
//!   because guessing wrong would shift columns in silence. Only where commas without white space
//!   separate columns and decimals alike, as in `1,5,2,5,3,5`, nothing tells them apart: that line
//!   has six whole numbers.

use crate::error::quoted;
use crate::scan::{decoded, finite, is_utf16, lines, says_missing, without_bom};
use crate::{Cloud, Format, MAX_POINTS, Place, ReadError, Source, Topography};

/// Reads columns of text as a cloud, in the order of the lines.
///
/// # Errors
///
/// The first line that does not follow the rules above, with its line and column; a file without
/// any point; more than [`MAX_POINTS`] lines of points.
///
/// # Example
///
/// ```
/// let file = b"x y z\n0 0 1.5\n0.1 0 NaN\n";
/// let topography = asphera_formats::xyz::read(file)?;
/// assert_eq!(topography.points().collect::<Vec<_>>(), [[0.0, 0.0, 1.5]]);
/// assert_eq!(topography.missing(), 1);
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Topography, ReadError> {
    let decoded = is_utf16(bytes).then(|| decoded(bytes));
    let text = decoded.as_deref().map_or_else(|| without_bom(bytes), str::as_bytes);
    let mut cloud = Cloud::default();
    let mut header_allowed = true;
    let mut columns = Vec::with_capacity(8);
    let mut uncertainty = None;
    for (line, content) in lines(text) {
        let content = without_comment(content).trim_ascii();
        if content.is_empty() {
            continue;
        }
        let header_may_stand_here = std::mem::take(&mut header_allowed);
        if header_may_stand_here && content.starts_with(b"Zygo") {
            return Err(unsupported(line, "columns x, y, z in mm", "a Zygo ASCII data file"));
        }
        let separator = split(content, &mut columns);
        if header_may_stand_here && is_header(&columns) {
            check_units(line, &columns)?;
            uncertainty = columns.iter().position(|name| is_uncertainty(name));
            continue;
        }
        if let Some(found) = separator.doubt(content, &columns) {
            return Err(malformed(line, 0, DECIMAL_HINT, found));
        }
        match point(line, &columns)? {
            Some(point_mm) => {
                cloud.points_mm.push(point_mm);
                if let Some(column) = uncertainty {
                    let u_mm = columns.get(column).copied().and_then(finite);
                    cloud.uncertainties_mm.push(u_mm.unwrap_or(f64::NAN));
                }
            }
            None => cloud.missing += 1,
        }
        let count = (cloud.points_mm.len() + cloud.missing) as u64;
        if count > MAX_POINTS {
            return Err(ReadError::TooLarge {
                format: Format::Xyz,
                place: Place::Line { line, column: 0 },
                unit: "points",
                limit: MAX_POINTS,
                found: count,
            });
        }
    }
    if cloud.points_mm.is_empty() && cloud.missing == 0 {
        return Err(malformed(1, 0, "at least one line with x, y and z", "none".into()));
    }
    Ok(Topography::Cloud(cloud, Source::new(Format::Xyz)))
}

const DECIMAL_HINT: &str =
    "one kind of separator and decimal points (write 1.5 where a decimal comma says 1,5)";

/// How the columns of one line are separated.
#[derive(Clone, Copy, Default)]
struct Separators {
    spaces: bool,
    commas: bool,
    semicolons: bool,
    /// Some comma has white space beside it.
    spaced_commas: bool,
    /// Some comma stands between two letters or digits.
    tight_commas: bool,
}

impl Separators {
    /// What makes the commas of a line doubtful, as an error shows it.
    fn doubt(self, content: &[u8], columns: &[&[u8]]) -> Option<String> {
        let mixed =
            usize::from(self.spaces) + usize::from(self.commas) + usize::from(self.semicolons) > 1;
        // `1,5, 2,5, 3,5` would give six whole columns, unless points show what the decimals are.
        let uneven = self.spaced_commas
            && self.tight_commas
            && !columns.iter().all(|column| column.contains(&b'.'));
        (mixed || uneven).then(|| quoted(content))
    }
}

/// Cuts a line into columns. Between two separators that are not white space stands an empty one.
fn split<'a>(content: &'a [u8], columns: &mut Vec<&'a [u8]>) -> Separators {
    columns.clear();
    let mut separators = Separators::default();
    let is_separator = |byte: u8| byte.is_ascii_whitespace() || byte == b',' || byte == b';';
    let mut rest = content;
    loop {
        let end = rest.iter().position(|&byte| is_separator(byte)).unwrap_or(rest.len());
        columns.push(&rest[..end]);
        if end == rest.len() {
            return separators;
        }
        let after = rest[end..].trim_ascii_start();
        let space_before = rest.len() - end - after.len();
        rest = match after.first() {
            Some(mark @ (b',' | b';')) => {
                let next = after[1..].trim_ascii_start();
                let spaced = space_before > 0 || next.len() + 1 < after.len();
                if *mark == b';' {
                    separators.semicolons = true;
                } else {
                    separators.commas = true;
                    separators.spaced_commas |= spaced;
                    separators.tight_commas |= !spaced;
                }
                next
            }
            _ => {
                separators.spaces = true;
                after
            }
        };
    }
}

fn without_comment(content: &[u8]) -> &[u8] {
    let slashes = || content.windows(2).position(|pair| pair == b"//");
    let mark = content.iter().position(|byte| matches!(byte, b'#' | b'%'));
    let end = match content.contains(&b'/').then(slashes).flatten() {
        Some(slashes) => mark.map_or(slashes, |mark| mark.min(slashes)),
        None => mark.unwrap_or(content.len()),
    };
    &content[..end]
}

/// Whether a line names columns: three or more, the first three starting with a letter or a
/// bracket and none of them meaning a missing number.
fn is_header(columns: &[&[u8]]) -> bool {
    columns.len() >= 3
        && columns[..3].iter().all(|name| {
            let starts = name.first().is_some_and(|&byte| {
                byte.is_ascii_alphabetic() || matches!(byte, b'[' | b'(' | b'"')
            });
            starts && !says_missing(name)
        })
}

/// Whether a column is named `u_z`, with or without its unit.
fn is_uncertainty(name: &[u8]) -> bool {
    let end = name.iter().position(|byte| matches!(byte, b'[' | b'(')).unwrap_or(name.len());
    name[..end].eq_ignore_ascii_case(b"u_z")
}

/// Refuses column names with another unit than mm.
fn check_units(line: usize, columns: &[&[u8]]) -> Result<(), ReadError> {
    for (index, name) in columns.iter().enumerate().take(6) {
        let Some(open) = name.iter().position(|byte| matches!(byte, b'[' | b'(')) else {
            continue;
        };
        let unit = &name[open + 1..];
        let close = unit.iter().position(|byte| matches!(byte, b']' | b')')).unwrap_or(unit.len());
        let unit = unit[..close].trim_ascii();
        if !unit.is_empty() && unit != b"mm" {
            return Err(ReadError::Unsupported {
                format: Format::Xyz,
                place: Place::Line { line, column: index + 1 },
                expected: "the unit mm".into(),
                found: format!("the unit {}", quoted(unit)),
            });
        }
    }
    Ok(())
}

/// The point of a line, or `None` where its height is missing.
fn point(line: usize, columns: &[&[u8]]) -> Result<Option<[f64; 3]>, ReadError> {
    let [x, y, z, ..] = columns else {
        return Err(malformed(line, 0, "at least 3 columns", columns.len().to_string()));
    };
    let number = |column: usize, text: &[u8], expected: &str| {
        finite(text).ok_or_else(|| malformed(line, column, expected, quoted(text)))
    };
    let x_mm = number(1, x, "x in mm")?;
    let y_mm = number(2, y, "y in mm")?;
    if z.is_empty() || says_missing(z) {
        return Ok(None);
    }
    Ok(Some([x_mm, y_mm, number(3, z, "z in mm, or NaN, BAD or *** where nothing was measured")?]))
}

fn malformed(line: usize, column: usize, expected: &str, found: String) -> ReadError {
    ReadError::Malformed {
        format: Format::Xyz,
        place: Place::Line { line, column },
        expected: expected.into(),
        found,
    }
}

fn unsupported(line: usize, expected: &str, found: &str) -> ReadError {
    ReadError::Unsupported {
        format: Format::Xyz,
        place: Place::Line { line, column: 0 },
        expected: expected.into(),
        found: found.into(),
    }
}

#[cfg(test)]
mod tests;

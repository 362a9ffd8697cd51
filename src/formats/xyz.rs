//! `.xyz` files: a point a line, as columns of text.
//!
//! There is no standard for these files. What is read here:
//!
//! - **Columns.** A line of names before the points says which columns hold x, y, z, and perhaps the standard uncertainty
//!   `u_z` of z; others are passed over. A comment may name them, too. Two columns x and z are a profile at y = 0, as are
//!   x and slope, and r and z. Three columns without names are x, y, z, unless they are alike as those of a matrix of heights.
//!   More of them without names, and names that do not tell x, are refused, as is every line with another number of columns.
//! - **Text** before the points that names neither columns nor units is passed over and counted in [`Taken::passed_over`].
//! - **Units.** A name holds its unit as `x_um`, `x [µm]`, `X (mm)` or `x/mm`; a line below the names or a comment such as
//!   `# x y z in metres` may hold it. Without any, lengths are mm. Where some columns have a unit and others none, the file is
//!   refused.
//! - **Options.** [`TextOptions`] name columns and units where the file does not. Where it says otherwise it is refused.
//! - **Separators.** White space, tabs, commas or semicolons, the same in every line of points. A decimal comma is read where
//!   something else separates columns; all numbers of a file have the same decimal mark. Where commas may be either, the
//!   file is refused. Only `1,5,2,5,3,5` cannot be told from six whole numbers.
//! - **Comments.** `#` and `%` at the start of a line or after white space or a separator, and `//`. Empty lines are passed over.
//! - **Missing heights.** A point whose z is `NaN`, `BAD`, asterisks or empty was not measured: it is counted in
//!   [`Cloud::missing`](crate::Cloud::missing). x and y must be numbers, unless they are missing with z. A number
//!   that programs write for a missing height, such as -9999, counts as missing where it lies far from all other heights, with a
//!   caution. [`Taken::cautions`] names other heights beyond the size of the part, too.
//! - **Slopes** dz/dx of a profile are integrated by the trapezoidal rule, from z = 0 at the first; [`Cloud::slopes`](crate::Cloud::slopes) keeps them.
//! - Lines end with LF, CR LF or CR. A UTF-8 byte order mark is passed over; one of UTF-16 says that the text is UTF-16.

mod dialect;
mod head;
mod layout;
mod matrix;
mod no_data;
mod rows;
mod stated_units;
mod unit;

pub use layout::{By, Column, Taken, TakenColumn, TextOptions};
pub use unit::Unit;

pub(crate) use head::unit_in_comment;
pub(crate) use matrix::{map_of_heights, unit_of_heights};

use dialect::{Dialect, Field, fields};
use head::Role;
use layout::{Layout, Line};
use rows::Rows;

use crate::error::quoted;
use crate::scan::{decoded, finite, is_utf16, lines, says_missing, without_bom};
use crate::{Format, MAX_POINTS, Place, ReadError, Topography};

/// Reads columns of text as a cloud, in the order of the lines.
///
/// # Errors
///
/// The first line that does not follow the rules above, with its line and column; a file without
/// any point; more than [`MAX_POINTS`] lines of points; columns or units that cannot be told.
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
    read_with(bytes, &TextOptions::default())
}

/// Reads with columns and units that the user names. With a pitch it reads a matrix of heights.
///
/// # Errors
///
/// As [`read`]; where options and file contradict each other.
pub fn read_with(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    read_beside(bytes, options, None)
}

/// Reads as [`read_with`], with the numbers of one more column, a number a point, in the unit of the file. Columns count from 1.
///
/// # Errors
///
/// As [`read_with`]; a file without the column, with no number there beside a point, or read as a matrix.
///
/// # Example
///
/// ```
/// let file = b"x y z T\n0 0 1.5 20.1\n0.1 0 NaN 20.2\n0.2 0 1.6 20.3\n";
/// let (_, values) = asphera_formats::xyz::read_with_column(file, &Default::default(), 4)?;
/// assert_eq!(values, [20.1, 20.3]);
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read_with_column(
    bytes: &[u8],
    options: &TextOptions,
    column: usize,
) -> Result<(Topography, Vec<f64>), ReadError> {
    let mut beside = Beside { column, values: Vec::new() };
    let topography = read_beside(bytes, options, Some(&mut beside))?;
    Ok((topography, beside.values))
}

/// The numbers of a column beside the points.
struct Beside {
    /// Counted from 1.
    column: usize,
    values: Vec<f64>,
}

impl Beside {
    /// Takes the number beside a point of a line with these columns.
    fn take(
        &mut self,
        line: usize,
        columns: &[&[u8]],
        number: impl FnOnce(&[u8]) -> Field,
    ) -> Result<(), ReadError> {
        let text = self.column.checked_sub(1).and_then(|at| columns.get(at));
        let Some(text) = text else {
            let expected = format!("column {}, counted from 1", self.column);
            return Err(malformed(line, 0, &expected, format!("{} columns", columns.len())));
        };
        match number(text) {
            Field::Number(value) => self.values.push(value),
            Field::Missing | Field::Unreadable => {
                let expected = "a number beside every point; leave the line out otherwise";
                return Err(malformed(line, self.column, expected, text.shown()));
            }
        }
        Ok(())
    }
}

fn read_beside(
    bytes: &[u8],
    options: &TextOptions,
    beside: Option<&mut Beside>,
) -> Result<Topography, ReadError> {
    let decoded = is_utf16(bytes).then(|| decoded(bytes));
    let text = decoded.as_deref().map_or_else(|| without_bom(bytes), str::as_bytes);
    let mut before: Vec<Line> = Vec::new();
    let mut lines = lines(text).skip(options.skip_lines);
    for (number, line) in lines.by_ref() {
        let (content, comment) = parted(line);
        if !content.trim_ascii().is_empty() {
            if before.is_empty() && content.starts_with(b"Zygo") {
                let found = "a Zygo ASCII data file".into();
                return Err(unsupported(number, "columns x, y, z", found));
            }
            if !is_text(content) {
                return points(&before, (number, content), lines, options, beside);
            }
            before.push(Line { text: words(content), is_comment: false });
        } else if let Some(comment) = comment {
            before.push(Line { text: words(comment), is_comment: true });
        }
    }
    Err(malformed(1, 0, "at least one line with x, y and z", "none".into()))
}

/// Reads all from the first line of points on.
fn points<'a>(
    before: &[Line],
    (first, content): (usize, &'a [u8]),
    after: impl Iterator<Item = (usize, &'a [u8])>,
    options: &TextOptions,
    mut beside: Option<&mut Beside>,
) -> Result<Topography, ReadError> {
    let mut dialect = Dialect::of(content.trim_ascii())
        .map_err(|found| malformed(first, 0, DECIMAL_HINT, found))?;
    let mut columns = Vec::with_capacity(8);
    fields(content, dialect.separator, &mut columns);
    let after = after.map(|(line, content)| (line, parted(content).0));
    let rows = std::iter::once((first, content)).chain(after);
    let mut rows = rows.filter(|(_, content)| !content.trim_ascii().is_empty());
    if let Some(pitch_mm) = options.pitch_mm {
        if let Some(Beside { column, .. }) = beside {
            let found = format!("a matrix of heights has no column {column} beside its points");
            return Err(unclear(first, found, "leave `--pitch` out, or take another function"));
        }
        return matrix::read(&mut rows, &mut dialect, pitch_mm, options);
    }
    // A separator at the end of a line makes no column.
    let has_end = columns.len() > 3 && columns.last().is_some_and(|last| last.is_empty());
    let width = columns.len() - usize::from(has_end);
    let layout = Layout::of(before, first, width, options)?;
    let mut taken = Rows::new(&layout, width);
    for (line, content) in rows {
        fields(content, dialect.separator, &mut columns);
        let fits = columns.len() == width
            || columns.len() == width + 1 && columns[width].is_empty()
            || columns.len() > width && layout.may_be_longer;
        if !fits {
            let expected = format!("{width} columns as in line {first}");
            return Err(malformed(line, 0, &expected, columns.len().to_string()));
        }
        let count = taken.points();
        taken.row(line, &layout, |column| columns[column], |text| dialect.number(text))?;
        if let Some(beside) = beside.as_deref_mut().filter(|_| taken.points() > count) {
            beside.take(line, &columns, |text| dialect.number(text))?;
        }
    }
    let beside = beside.map(|beside| &mut beside.values);
    taken.finish(first, &layout, dialect.has_decimal_commas(), beside)
}

/// Reads the rows of an array as lines of text with these names; without any they are told by their number, as in a text.
/// `value` gives the number in a row and column, both from 0.
///
/// # Errors
///
/// As of a text whose first line is the first row.
pub(crate) fn rows_of_array(
    names: &[String],
    [rows, width]: [usize; 2],
    options: &TextOptions,
    value: impl Fn(usize, usize) -> f64,
) -> Result<Topography, ReadError> {
    let head = Line { text: names.join("\t"), is_comment: false };
    let before = if names.is_empty() { &[][..] } else { std::slice::from_ref(&head) };
    let layout = Layout::of(before, 1, width, options)?;
    let mut taken = Rows::new(&layout, width);
    for row in 0..rows {
        let field = |number: f64| match number {
            number if number.is_nan() => Field::Missing,
            number if number.is_finite() => Field::Number(number),
            _ => Field::Unreadable,
        };
        taken.row(row + 1, &layout, |column| value(row, column), field)?;
    }
    taken.finish(1, &layout, false, None)
}

/// A line before the first point: it begins with a letter, a bracket or a quote about one, and holds a number at most. Points
/// may have names.
fn is_text(content: &[u8]) -> bool {
    let bare = content.trim_ascii();
    let end = bare.iter().position(|byte| byte.is_ascii_whitespace() || b",;".contains(byte));
    let word = &bare[..end.unwrap_or(bare.len())];
    let word = word.strip_prefix(b"\"").unwrap_or(word);
    let word = word.strip_suffix(b"\"").unwrap_or(word);
    let starts = word.first().is_some_and(|&byte| {
        byte.is_ascii_alphabetic() || byte >= 0x80 || matches!(byte, b'[' | b'(' | b'"')
    });
    // An index has no name in some heads.
    let is_unnamed = word.is_empty() && bare.iter().any(u8::is_ascii_alphabetic);
    (starts || is_unnamed) && !says_missing(word) && finite_fields(bare) < 2
}

fn finite_fields(content: &[u8]) -> usize {
    content.split(|byte| b",;\t ".contains(byte)).filter(|field| finite(field).is_some()).count()
}

/// A line up to its comment, and the comment.
fn parted(content: &[u8]) -> (&[u8], Option<&[u8]>) {
    let is_mark = |at: usize| {
        let before = at.checked_sub(1).map(|before| content[before]);
        let begins = before.is_none_or(|byte| byte.is_ascii_whitespace() || b",;".contains(&byte));
        // Alone behind other columns it is per cent in a line of units.
        let is_unit = || {
            let follows = content.get(at + 1).is_none_or(|byte| b",;\t\r".contains(byte));
            follows && !content[..at].trim_ascii().is_empty()
        };
        match content[at] {
            b'#' => begins,
            b'%' => begins && !is_unit(),
            b'/' => content.get(at + 1) == Some(&b'/'),
            _ => false,
        }
    };
    match (0..content.len()).find(|&at| is_mark(at)) {
        Some(at) => (&content[..at], Some(&content[at..])),
        None => (content, None),
    }
}

/// Text without the marks of a comment; what is not UTF-8 is Latin-1. Tabs at its ends stay: columns beside them are empty.
fn words(content: &[u8]) -> String {
    let start = content.iter().position(|byte| !b"#%/ ".contains(byte)).unwrap_or(content.len());
    decoded(&content[start..]).trim_matches([' ', '\r', '\n']).to_owned()
}

/// A value as an error shows it.
trait Shown {
    fn shown(&self) -> String;
}

impl Shown for &[u8] {
    fn shown(&self) -> String {
        quoted(self)
    }
}

impl Shown for f64 {
    fn shown(&self) -> String {
        self.to_string()
    }
}

const DECIMAL_HINT: &str =
    "one kind of separator and decimal points (write 1.5 where a decimal comma says 1,5)";

fn unreadable(line: usize, slot: &layout::Slot, text: &impl Shown) -> ReadError {
    let (name, unit) = (slot.name, slot.unit);
    let expected = match slot.role {
        Role::Z => format!("{name} in {unit}, or NaN, BAD or *** where nothing was measured"),
        _ => format!("{name} in {unit}"),
    };
    malformed(line, slot.column + 1, &expected, text.shown())
}

fn too_large(line: usize, found: u64) -> ReadError {
    let place = Place::Line { line, column: 0 };
    ReadError::TooLarge { format: Format::Xyz, place, unit: "points", limit: MAX_POINTS, found }
}

fn malformed(line: usize, column: usize, expected: &str, found: String) -> ReadError {
    ReadError::Malformed {
        format: Format::Xyz,
        place: Place::Line { line, column },
        expected: expected.into(),
        found,
    }
}

fn unsupported(line: usize, expected: &str, found: String) -> ReadError {
    ReadError::Unsupported {
        format: Format::Xyz,
        place: Place::Line { line, column: 0 },
        expected: expected.into(),
        found,
    }
}

fn unclear(line: usize, found: impl Into<String>, cure: impl Into<String>) -> ReadError {
    ReadError::Unclear {
        format: Format::Xyz,
        place: Place::Line { line, column: 0 },
        found: found.into(),
        cure: cure.into(),
    }
}

#[cfg(test)]
mod tests;

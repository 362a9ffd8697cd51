//! Grid sag of Zemax OpticStudio: heights on a grid as text, `.DAT` of a sequential lens and `.GRD` of a part.
//!
//! What is read is what the manual says under Grid Sag (ZEMAX manual, sequential surfaces; OpticStudio's help, 2024 R2):
//!
//! ```text
//! nx ny delx dely unitflag xdec ydec
//! z dz/dx dz/dy d2z/dxdy nodata         nx·ny lines
//! ```
//!
//! - `delx` and `dely` count without their sign; `unitflag` is the unit of all lengths: 0 mm, 1 cm, 2 inch, 3 m.
//! - The first height is that of the corner at -x and +y. The next ones follow towards +x, row after row towards -y.
//! - The middle of the grid lies at `xdec`, `ydec`.
//! - `nodata` may be missing, as may be the derivatives; where it is not 0 there is no height, whatever the line says. A height
//!   `NaN` is none either.
//! - A line that begins with `!` is a comment; empty lines are passed over. The text may be UTF-16.
//!
//! Derivatives must be numbers and are passed over: they are those of the program's own interpolation between the heights.

use crate::error::quoted;
use crate::scan::{decoded, finite, grid_len, lines, says_missing};
use crate::{Format, HeightMap, Place, ReadError, Source, Topography};

/// Reads a grid sag file as a height map; rows are turned round, so that they run towards +y. `O(bytes)`.
///
/// # Errors
///
/// A first line or a height that does not follow the rules above, with its line and column; fewer or more heights than nx·ny.
///
/// # Example
///
/// ```
/// let mut file = "5 5 0.5 0.5 0 0 0\n".to_owned();
/// file += &"1e-3 0 0 0 0\n".repeat(25);
/// let topography = asphera_formats::grid_sag::read(file.as_bytes())?;
/// assert_eq!(topography.points().next(), Some([-1.0, -1.0, 1e-3]));
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8]) -> Result<Topography, ReadError> {
    let text = decoded(bytes);
    let mut data = data_lines(text.as_bytes());
    let (line, first) = data.next().unwrap_or((1, b""));
    let header = Header::read(line, first)?;
    let place = Place::Line { line, column: 1 };
    let samples = grid_len(FORMAT, place, header.nx as u64, header.ny as u64)?;
    // Not more than the file can hold: a height takes two bytes at least.
    let mut z_mm = Vec::with_capacity(samples.min(bytes.len() / 2));
    let mut last = line;
    for (line, content) in data {
        if z_mm.len() == samples {
            return Err(malformed(line, 0, "no more than nx times ny heights", quoted(content)));
        }
        z_mm.push(height_mm(line, content, header.unit_mm)?);
        last = line;
    }
    if z_mm.len() < samples {
        let expected = format!("{samples} heights, as nx times ny");
        return Err(malformed(last, 0, &expected, format!("{}", z_mm.len())));
    }
    let z_mm = z_mm.chunks(header.nx).rev().flatten().copied().collect();
    let half_mm = |count: usize, step_mm: f64| 0.5 * (count - 1) as f64 * step_mm;
    let map = HeightMap {
        nx: header.nx,
        ny: header.ny,
        dx_mm: header.dx_mm,
        dy_mm: header.dy_mm,
        x0_mm: header.x_mm - half_mm(header.nx, header.dx_mm),
        y0_mm: header.y_mm - half_mm(header.ny, header.dy_mm),
        z_mm,
    };
    Ok(Topography::Map(map, Source::new(FORMAT)))
}

/// Whether a file begins as one: its first line can be read, and the next one holds no more than a height with its derivatives.
pub(crate) fn is_grid_sag(bytes: &[u8]) -> bool {
    const LOOKED_AT: usize = 4096;
    let text = decoded(&bytes[..bytes.len().min(LOOKED_AT)]);
    let mut data = data_lines(text.as_bytes());
    let first = data.next().is_some_and(|(line, first)| Header::read(line, first).is_ok());
    first && data.next().is_some_and(|(_, next)| fields(next).count() <= MOST_FIELDS)
}

/// The first line.
struct Header {
    nx: usize,
    ny: usize,
    dx_mm: f64,
    dy_mm: f64,
    x_mm: f64,
    y_mm: f64,
    unit_mm: f64,
}

impl Header {
    fn read(line: usize, content: &[u8]) -> Result<Header, ReadError> {
        let found: Vec<&[u8]> = fields(content).collect();
        let Ok([nx, ny, dx, dy, unit, x, y]) = <[&[u8]; 7]>::try_from(found) else {
            let expected = "seven numbers: nx ny delx dely unitflag xdec ydec";
            return Err(malformed(line, 0, expected, quoted(content)));
        };
        let count = |column, field: &[u8]| {
            let number = finite(field).filter(|number| number.fract() == 0.0 && *number >= FEWEST);
            // Whole, and bounded by the number of samples later on.
            number.map(|number| number as usize).ok_or_else(|| {
                malformed(line, column, "a whole number of at least 5", quoted(field))
            })
        };
        let unit_mm = match finite(unit) {
            Some(0.0) => 1.0,
            Some(1.0) => 10.0,
            Some(2.0) => 25.4,
            Some(3.0) => 1000.0,
            _ => {
                let expected = "a unit: 0 for mm, 1 for cm, 2 for inch, 3 for m";
                return Err(malformed(line, 5, expected, quoted(unit)));
            }
        };
        let place_mm = |column, field: &[u8]| length_mm(line, column, field, unit_mm);
        let step_mm = |column, field: &[u8]| {
            let step_mm = place_mm(column, field)?.abs();
            if step_mm > 0.0 {
                return Ok(step_mm);
            }
            Err(malformed(line, column, "a distance that is not 0", quoted(field)))
        };
        Ok(Header {
            nx: count(1, nx)?,
            ny: count(2, ny)?,
            dx_mm: step_mm(3, dx)?,
            dy_mm: step_mm(4, dy)?,
            x_mm: place_mm(6, x)?,
            y_mm: place_mm(7, y)?,
            unit_mm,
        })
    }
}

/// The height of a line, NaN where it says there is none.
fn height_mm(line: usize, content: &[u8], unit_mm: f64) -> Result<f64, ReadError> {
    let found: Vec<&[u8]> = fields(content).collect();
    if found.len() > MOST_FIELDS {
        let expected = "at most z dz/dx dz/dy d2z/dxdy nodata";
        return Err(malformed(line, 0, expected, quoted(content)));
    }
    let number = |index: usize| {
        let field = found.get(index).copied().unwrap_or(b"0");
        finite(field).ok_or_else(|| malformed(line, index + 1, "a number", quoted(field)))
    };
    for index in 1..MOST_FIELDS {
        number(index)?;
    }
    if number(4)? != 0.0 || found.first().is_some_and(|field| says_missing(field)) {
        return Ok(f64::NAN);
    }
    length_mm(line, 1, found.first().copied().unwrap_or_default(), unit_mm)
}

fn length_mm(line: usize, column: usize, field: &[u8], unit_mm: f64) -> Result<f64, ReadError> {
    let length_mm = finite(field).map(|length| length * unit_mm).filter(|mm| mm.is_finite());
    length_mm.ok_or_else(|| malformed(line, column, "a number", quoted(field)))
}

/// The lines that hold numbers.
fn data_lines(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    lines(text)
        .map(|(line, content)| (line, content.trim_ascii()))
        .filter(|(_, content)| !content.is_empty() && !content.starts_with(b"!"))
}

fn fields(content: &[u8]) -> impl Iterator<Item = &[u8]> {
    content.split(u8::is_ascii_whitespace).filter(|field| !field.is_empty())
}

fn malformed(line: usize, column: usize, expected: &str, found: String) -> ReadError {
    let place = Place::Line { line, column };
    ReadError::Malformed { format: FORMAT, place, expected: expected.into(), found }
}

const FORMAT: Format = Format::GridSag;
/// A height, three derivatives and a flag.
const MOST_FIELDS: usize = 5;
/// Nodes along a side, by the help.
const FEWEST: f64 = 5.0;

#[cfg(test)]
mod tests;

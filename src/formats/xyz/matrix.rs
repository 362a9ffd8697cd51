//! Matrices of heights: a row a line, of a pitch that the user states.

use super::dialect::{Dialect, Field, fields};
use super::layout::{By, Taken, TakenColumn, TextOptions};
use super::no_data::{NoData, outliers};
use super::{Unit, malformed, too_large, unclear};
use crate::error::quoted;
use crate::{Format, HeightMap, MAX_POINTS, ReadError, Source, Topography};

/// Reads lines of heights as a map. The first line is the top row, as in an image; x begins at 0, and y at 0 in the last line.
pub(super) fn read(
    rows: &mut dyn Iterator<Item = (usize, &[u8])>,
    dialect: &mut Dialect,
    [dx_mm, dy_mm]: [f64; 2],
    options: &TextOptions,
) -> Result<Topography, ReadError> {
    let mut heights_mm: Vec<f64> = Vec::new();
    let (mut nx, mut ny, mut first) = (0, 0, 1);
    let mut columns = Vec::new();
    let unit = unit_of_heights(options)?;
    for (line, content) in rows {
        fields(content, dialect.separator, &mut columns);
        if columns.last().is_some_and(|last| last.is_empty()) && (ny == 0 || columns.len() > nx) {
            columns.pop();
        }
        if ny == 0 {
            (nx, first) = (columns.len(), line);
        }
        if nx == 0 {
            return Err(malformed(line, 0, "a row of heights", "nothing".to_owned()));
        }
        if columns.len() != nx {
            let expected = format!("{nx} heights as in line {first}");
            return Err(malformed(line, 0, &expected, columns.len().to_string()));
        }
        if (heights_mm.len() + nx) as u64 > MAX_POINTS {
            return Err(too_large(line, (heights_mm.len() + nx) as u64));
        }
        for (column, text) in columns.iter().enumerate() {
            let height_mm = match dialect.number(text) {
                Field::Number(value) => Some(unit.scaled(value)).filter(|mm| mm.is_finite()),
                Field::Missing => Some(f64::NAN),
                Field::Unreadable => None,
            };
            heights_mm.push(height_mm.ok_or_else(|| {
                let expected = format!("a height in {unit}, or NaN, BAD or ***");
                malformed(line, column + 1, &expected, quoted(text))
            })?);
        }
        ny += 1;
    }
    let has_commas = dialect.has_decimal_commas();
    Ok(map_of_heights(&heights_mm, [nx, ny], [dx_mm, dy_mm], unit, has_commas, options))
}

/// The unit of a matrix of heights, which the options must name.
pub(crate) fn unit_of_heights(options: &TextOptions) -> Result<Unit, ReadError> {
    match &options.units[..] {
        [unit] if !unit.is_slope() && options.columns.is_empty() => Ok(*unit),
        _ => {
            let found = "a matrix of heights has one unit of length, and no columns";
            let cure = "add `--unit` with that of the heights, and no `--columns`";
            Err(unclear(1, found, cure))
        }
    }
}

/// The map of rows of heights, the top row first; NaN where there is none. `nx` columns, `ny` rows.
pub(crate) fn map_of_heights(
    heights_mm: &[f64],
    [nx, ny]: [usize; 2],
    [dx_mm, dy_mm]: [f64; 2],
    unit: Unit,
    has_decimal_commas: bool,
    options: &TextOptions,
) -> Topography {
    let no_data = NoData::of(heights_mm.iter().copied(), unit, options.keeps_marks);
    let height_mm = |&mm: &f64| if no_data.is_mark(mm) { f64::NAN } else { mm };
    let z_mm = heights_mm.chunks(nx.max(1)).rev().flatten().map(height_mm).collect();
    let map = HeightMap { nx, ny, dx_mm, dy_mm, x0_mm: 0.0, y0_mm: 0.0, z_mm };
    let mut cautions = no_data.cautions;
    cautions.extend(outliers(|| map.points()));
    let taken = Taken {
        columns: vec![TakenColumn { name: "z", number: 1, unit }],
        named_by: By::Options,
        units_by: By::Options,
        has_decimal_commas,
        passed_over: 0,
        cautions,
    };
    Topography::Map(map, Source { taken: Some(taken), ..Source::new(Format::Xyz) })
}

//! `error_table` of an axis in `[kinematics]`: a file of positions and errors.
//!
//! ```text
//! # C axis, autocollimator and polygon, 2026-11-20
//! position[deg],error[arcsec]
//! 0,0.0
//! 180,1.4
//! 360,0.0
//! ```

use std::cell::RefCell;
use std::path::Path;

use asphera_calibrate::{AxisErrors, AxisErrorsError};
use asphera_formats::xyz::Unit;
use asphera_settings::Section;

use super::attached::{embedded, text_of};
use crate::station::ErrorTable;

/// Tables of a station, found from its folder.
pub(super) struct ErrorTables<'a> {
    folder: &'a Path,
    /// Axis and text of each file that was read.
    texts: RefCell<Vec<(String, String)>>,
}

impl<'a> ErrorTables<'a> {
    pub(super) fn new(folder: &'a Path) -> ErrorTables<'a> {
        ErrorTables { folder, texts: RefCell::default() }
    }

    /// Reads the table that an axis names; `None` where it names none, or one that cannot be used.
    pub(super) fn read(&self, axis: &Section<'_>, name: &str, rotary: bool) -> Option<ErrorTable> {
        let (file, text) = text_of(axis, KEY, self.folder, "a text file in UTF-8")?;
        match parse(&text, rotary) {
            Ok(errors) => {
                self.texts.borrow_mut().push((name.to_owned(), text));
                Some(ErrorTable { file, errors })
            }
            Err(Mistake { line, expected, found }) => {
                axis.problem(KEY, format!("in line {line} of {file} {expected}"), found);
                None
            }
        }
    }

    /// The configuration with the texts of the files in it, so that a recording holds what its axes were corrected by.
    pub(super) fn embedded(&self, text: &str) -> String {
        let texts = self.texts.borrow();
        texts.iter().fold(text.to_owned(), |text, (axis, content)| {
            embedded(&text, &format!("kinematics.{axis}"), KEY, content)
        })
    }
}

const KEY: &str = "error_table";

/// Mistake in a file: where, what would do, what is there.
struct Mistake {
    line: usize,
    expected: String,
    found: String,
}

/// Reads the text of a file. Lines count from 1; empty ones and comments are passed over.
fn parse(text: &str, rotary: bool) -> Result<AxisErrors, Mistake> {
    let lines = text.trim_start_matches('\u{feff}').lines().zip(1..);
    let mut lines = lines.filter(|(line, _)| !line.trim().is_empty() && !line.starts_with('#'));
    let Some((head, line)) = lines.next() else {
        return Err(Mistake { line: 1, expected: head_of(rotary), found: "nothing".to_owned() });
    };
    let columns = units(head, rotary).ok_or_else(|| Mistake {
        line,
        expected: head_of(rotary),
        found: format!("{head:?}"),
    })?;
    let wanted = match columns.len() {
        2 => ["two numbers", "position and error"],
        _ => ["three numbers", "position, error and u"],
    };
    let (mut rows, mut uncertainties, mut places) = (Vec::new(), Vec::new(), Vec::new());
    for (row, line) in lines {
        let numbers: Option<Vec<f64>> =
            fields(row).map(|field| field.parse::<f64>().ok()).collect();
        let Some(numbers) = numbers.filter(|numbers| numbers.len() >= columns.len()) else {
            let expected = wanted.join(", with a decimal point: ");
            return Err(Mistake { line, expected, found: format!("{row:?}") });
        };
        if numbers.len() > columns.len() {
            return Err(Mistake { line, expected: wanted.join(": "), found: format!("{row:?}") });
        }
        let scaled = |column: usize| columns[column].scaled(numbers[column]);
        rows.push([scaled(0), scaled(1)]);
        uncertainties.extend((columns.len() == 3).then(|| scaled(2)));
        places.push((line, row));
    }
    let errors = if rotary { AxisErrors::rotary(rows) } else { AxisErrors::linear(rows) };
    let with_u = |errors: AxisErrors| match uncertainties.is_empty() {
        true => Ok(errors),
        false => errors.with_uncertainties(uncertainties),
    };
    errors.and_then(with_u).map_err(|error| mistake(error, &places, line))
}

/// A mistake of the rows, with the line of the file. `places` are line and text of each row.
fn mistake(error: AxisErrorsError, places: &[(usize, &str)], head_line: usize) -> Mistake {
    let (row, expected) = match error {
        AxisErrorsError::TooFew { found } => {
            let found = if found == 1 { "one row" } else { "no row" }.to_owned();
            let expected = "two rows of position and error or more below it".to_owned();
            return Mistake { line: head_line, expected, found };
        }
        AxisErrorsError::NotFinite { row } => (row, "finite numbers"),
        AxisErrorsError::NotRising { row, .. } => {
            (row, "a position above that of the row before: sort the rows, one for each position")
        }
        AxisErrorsError::TooSteep { row, .. } => {
            (row, "an error that changes less than the position: check the units of the head")
        }
        AxisErrorsError::BeyondTurn { row, .. } => {
            (row, "positions within one turn: every turn has the same errors")
        }
        AxisErrorsError::Uncertainty { row } => (row, "a standard uncertainty of 0 or more"),
        AxisErrorsError::OpenTurn { row, .. } => {
            (row, "the error of the first row, which is a whole turn before")
        }
    };
    let (line, text) = places.get(row).copied().unwrap_or((head_line, ""));
    Mistake { line, expected: expected.to_owned(), found: format!("{text:?}") }
}

/// Unit of a column.
#[derive(Clone, Copy)]
enum Column {
    Degree,
    Of(Unit),
}

impl Column {
    /// A value in mm or rad.
    fn scaled(self, value: f64) -> f64 {
        match self {
            Column::Degree => value.to_radians(),
            Column::Of(unit) => unit.scaled(value),
        }
    }
}

/// The units of a head like `position[mm],error[nm]`, with `,u[nm]` after it where uncertainties are stated; `None` of another
/// text, and of units that the axis has not.
fn units(head: &str, rotary: bool) -> Option<Vec<Column>> {
    let columns: Vec<&str> = fields(head).collect();
    if !(2..=NAMES.len()).contains(&columns.len()) {
        return None;
    }
    let unit = |(column, name): (&&str, &&str)| {
        let unit = column.strip_prefix(name)?.trim().strip_prefix('[')?.strip_suffix(']')?;
        if rotary && matches!(unit.trim(), "deg" | "°") {
            return Some(Column::Degree);
        }
        Unit::from_word(unit).filter(|unit| unit.is_slope() == rotary).map(Column::Of)
    };
    columns.iter().zip(&NAMES).map(unit).collect()
}

/// Columns of a table; the last may be absent.
const NAMES: [&str; 3] = ["position", "error", "u"];

/// Fields of a line between commas, semicolons or tabs.
fn fields(line: &str) -> impl Iterator<Item = &str> {
    line.split([',', ';', '\t']).map(str::trim)
}

fn head_of(rotary: bool) -> String {
    match rotary {
        true => {
            "the head position[rad],error[urad], with units out of rad, mrad, urad, arcsec, deg; then ,u[urad] where it is known"
        }
        false => "the head position[mm],error[nm], with units out of nm, um, mm, cm, m, in; then ,u[nm] where it is known",
    }
    .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn said(text: &str, rotary: bool) -> String {
        let Err(Mistake { line, expected, found }) = parse(text, rotary) else {
            panic!("a table without a mistake: {text}");
        };
        format!("{line}: {expected}, found {found}")
    }

    #[test]
    fn a_table_has_the_units_of_its_head() {
        let table = parse("\u{feff}# X\n\nposition[mm],error[nm]\n-10,-500\n10,1500\n", false);
        let corrected = table.ok().and_then(|errors| errors.corrected(0.0));
        assert!((corrected.unwrap() + 500e-6).abs() < 1e-18);
        let table = parse("position [deg];\terror[arcsec]\r\n0; 0\r\n90; 3.6\r\n", true);
        assert!(table.is_err(), "an empty field");
        let table = parse("position [deg]; error[arcsec]\r\n0; 0\r\n90; 3.6\r\n", true);
        let corrected = table.ok().and_then(|errors| errors.corrected(PI / 4.0));
        assert!((corrected.unwrap() - (45.0 - 0.0005) * PI / 180.0).abs() < 1e-15);
        let table = parse("position[rad]\terror[µrad]\n0\t0\n1\t2\n", true);
        let corrected = table.ok().and_then(|errors| errors.corrected(0.5));
        assert!((corrected.unwrap() - (0.5 - 1e-6)).abs() < 1e-15);
    }

    #[test]
    fn a_third_column_holds_the_uncertainties() {
        let table = parse("position[mm],error[nm],u[nm]\n-10,-500,20\n10,1500,40\n", false);
        let table = table.ok().unwrap();
        assert!((table.uncertain_error_at(0, 0.0) - 30e-6).abs() < 1e-18);
        assert!((table.corrected(0.0).unwrap() + 500e-6).abs() < 1e-18);
        let head = "position[mm],error[nm],u[nm]\n";
        for (rows, expected) in [
            ("0,0,1\n1,5\n", "3: three numbers, with a decimal point: position, error and u"),
            ("0,0,1\n1,5,-1\n", "3: a standard uncertainty of 0 or more"),
        ] {
            let said = said(&format!("{head}{rows}"), false);
            assert!(said.starts_with(expected), "{rows:?}: {said}");
        }
    }

    #[test]
    fn mistakes_have_line_and_cure() {
        let head = "position[mm],error[nm]\n";
        for (rows, expected) in [
            ("", "1: two rows of position and error or more below it, found no row"),
            ("0,0\n", "1: two rows of position and error or more below it, found one row"),
            ("0,0\n1,nan\n", "3: finite numbers, found \"1,nan\""),
            ("0,0\n\n0,1\n", "4: a position above that of the row before: sort the rows"),
            ("0,0\n-1,1\n", "3: a position above"),
            ("0,0\n1,1e6\n", "3: an error that changes less than the position: check the units"),
            ("0,0\n1\n", "3: two numbers, with a decimal point"),
            ("0,0\n1,5,5\n", "3: two numbers: position and error, found \"1,5,5\""),
            ("0,0\n1,a\n", "3: two numbers"),
        ] {
            let said = said(&format!("{head}{rows}"), false);
            assert!(said.starts_with(expected), "{rows:?}: {said}");
        }
        for head in ["", "0,0\n", "position,error\n", "position[mm],error[furlong]\n"] {
            let said = said(&format!("{head}0,0\n1,1\n"), false);
            assert!(said.starts_with("1: the head position[mm],error[nm]"), "{head}: {said}");
        }
        for head in
            ["position[rad],error[nm]", "position[mm],error[urad]", "position[mm],error[nm],x"]
        {
            assert!(said(&format!("{head}\n0,0\n1,1\n"), false).contains("the head"), "{head}");
        }
        let turn = "position[deg],error[urad]\n0,1\n";
        assert!(said(&format!("{turn}400,1\n"), true).starts_with("3: positions within one turn"));
        assert!(said(&format!("{turn}360,2\n"), true).starts_with("3: the error of the first row"));
        assert!(said("", true).starts_with("1: the head position[rad],error[urad]"));
    }
}

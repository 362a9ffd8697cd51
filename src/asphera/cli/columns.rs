//! Points written as columns of text.

use std::ffi::OsStr;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::output::Failure;
use super::usage::misused;
use crate::whole_file::{CannotWrite, write_whole};

/// How columns are separated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    Spaces,
    Commas,
}

impl Style {
    /// The style that the name of a file asks for.
    pub(super) fn of(path: &Path) -> Result<Style, Failure> {
        Style::by_name(path).ok_or_else(|| unknown_style(path, ".xyz, .txt, .asc or .csv"))
    }

    /// The same; `None` for a name of no text file.
    pub(super) fn by_name(path: &Path) -> Option<Style> {
        let extension = path.extension().map(OsStr::to_ascii_lowercase);
        match extension.as_ref().and_then(|extension| extension.to_str()) {
            Some("xyz" | "txt" | "asc") => Some(Style::Spaces),
            Some("csv") => Some(Style::Commas),
            _ => None,
        }
    }

    /// The text between two columns.
    pub(super) fn separator(self) -> &'static str {
        match self {
            Style::Spaces => " ",
            Style::Commas => ",",
        }
    }
}

/// What is said of a name that says no format.
pub(super) fn unknown_style(path: &Path, expected: &str) -> Failure {
    misused(format!("cannot write {}: expected a name ending in {expected}", path.display()))
}

/// Writes a file of columns, whole or not at all.
pub(super) fn whole(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), CannotWrite> {
    let failed = |source| CannotWrite { path: path.to_owned(), source };
    write_whole(path, |writer| fill(writer).map_err(failed))
}

/// Writes `remarks` as comments and a line of names with their units, as `x[mm]`.
pub(super) fn head(
    writer: &mut impl Write,
    style: Style,
    remarks: &[String],
    names: &[&str],
) -> io::Result<()> {
    for remark in remarks {
        // A name may hold anything, but a comment ends with its line.
        writeln!(writer, "# {}", remark.replace(['\n', '\r'], " "))?;
    }
    writeln!(writer, "{}", names.join(style.separator()))
}

/// Writes a line of numbers with as many digits as it takes to read the same numbers back.
pub(super) fn row(writer: &mut impl Write, style: Style, numbers: &[f64]) -> io::Result<()> {
    for (index, number) in numbers.iter().enumerate() {
        let separator = if index == 0 { "" } else { style.separator() };
        write!(writer, "{separator}{number}")?;
    }
    writeln!(writer)
}

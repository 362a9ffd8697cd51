//! Points written as columns of text.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use thiserror::Error;

/// How columns are separated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    Spaces,
    Commas,
}

/// Why points cannot be written.
#[derive(Debug, Error)]
pub(super) enum FileError {
    /// Its name says no format.
    #[error("cannot write {}: expected a name ending in {expected}", path.display())]
    Style { path: PathBuf, expected: &'static str },
    /// The file system refused.
    #[error("cannot write {}", path.display())]
    File { path: PathBuf, source: io::Error },
}

impl Style {
    /// The style that the name of a file asks for.
    pub(super) fn of(path: &Path) -> Result<Style, FileError> {
        Style::by_name(path).ok_or_else(|| FileError::Style {
            path: path.to_owned(),
            expected: ".xyz, .txt, .asc or .csv",
        })
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

/// Writes a file that appears whole or not at all.
pub(super) fn whole(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), FileError> {
    let failed = |source| FileError::File { path: path.to_owned(), source };
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let written = File::create(&beside).and_then(|file| {
        let mut writer = BufWriter::new(file);
        fill(&mut writer)?;
        writer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data()
    });
    let moved = written.and_then(|()| fs::rename(&beside, path));
    if moved.is_err() {
        // What is left of it is of no use to anyone; if it cannot be removed, the first error counts.
        let _ = fs::remove_file(&beside);
    }
    moved.map_err(failed)
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

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

/// What the lines hold, in mm.
pub(super) enum Columns {
    /// x, y, z.
    Points(Vec<[f64; 3]>),
    /// x, y, z and the standard uncertainty of z.
    WithUncertainty(Vec<[f64; 4]>),
}

/// Why points cannot be written.
#[derive(Debug, Error)]
pub(super) enum FileError {
    /// Its name says no format.
    #[error("cannot write {}: expected a name ending in .xyz, .txt, .asc or .csv", .0.display())]
    Style(PathBuf),
    /// The file system refused.
    #[error("cannot write {}", path.display())]
    File { path: PathBuf, source: io::Error },
}

impl Style {
    /// The style that the name of a file asks for.
    pub(super) fn of(path: &Path) -> Result<Style, FileError> {
        let extension = path.extension().map(OsStr::to_ascii_lowercase);
        match extension.as_ref().and_then(|extension| extension.to_str()) {
            Some("xyz" | "txt" | "asc") => Ok(Style::Spaces),
            Some("csv") => Ok(Style::Commas),
            _ => Err(FileError::Style(path.to_owned())),
        }
    }

    fn separator(self) -> &'static str {
        match self {
            Style::Spaces => " ",
            Style::Commas => ",",
        }
    }
}

/// Writes `remarks` as comments, a line of names, and the numbers with as many digits as it takes to read the
/// same numbers back. The file appears whole or not at all.
pub(super) fn write(
    path: &Path,
    style: Style,
    remarks: &[String],
    columns: &Columns,
) -> Result<(), FileError> {
    let failed = |source| FileError::File { path: path.to_owned(), source };
    let mut beside = path.as_os_str().to_owned();
    beside.push(".part");
    let beside = PathBuf::from(beside);
    let written = fill(&beside, style, remarks, columns);
    let moved = written.and_then(|()| fs::rename(&beside, path));
    if moved.is_err() {
        // What is left of it is of no use to anyone; if it cannot be removed, the first error counts.
        let _ = fs::remove_file(&beside);
    }
    moved.map_err(failed)
}

fn fill(path: &Path, style: Style, remarks: &[String], columns: &Columns) -> io::Result<()> {
    let mut writer = BufWriter::new(File::create(path)?);
    for remark in remarks {
        // A name may hold anything, but a comment ends with its line.
        writeln!(writer, "# {}", remark.replace(['\n', '\r'], " "))?;
    }
    let separator = style.separator();
    match columns {
        Columns::Points(points) => {
            writeln!(writer, "{}", ["x[mm]", "y[mm]", "z[mm]"].join(separator))?;
            for [x, y, z] in points {
                writeln!(writer, "{x}{separator}{y}{separator}{z}")?;
            }
        }
        Columns::WithUncertainty(points) => {
            writeln!(writer, "{}", ["x[mm]", "y[mm]", "z[mm]", "u_z[mm]"].join(separator))?;
            for [x, y, z, u] in points {
                writeln!(writer, "{x}{separator}{y}{separator}{z}{separator}{u}")?;
            }
        }
    }
    writer.into_inner().map_err(io::IntoInnerError::into_error)?.sync_data()
}

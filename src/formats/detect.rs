//! Which format a file has: its content decides, its extension only where the content cannot.

use crate::error::quoted;
use crate::scan::{is_utf16, without_bom};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, Topography, grid_sag, metropro, sdf, x3p, xyz};

/// Reads a file whose format is not known beforehand.
///
/// The first bytes decide: `PK` is [`x3p`], a MetroPro magic number is [`metropro`], `aISO-1.0`,
/// `bISO-1.0`, `aBCR-1.0` and `bBCR-1.0` are [`sdf`]; a line of seven numbers that can be the first of a [`grid_sag`] file, before
/// one of at most five, is that. Only a file that starts otherwise is judged
/// by the extension of `name`: text with the extension `xyz`, `txt`, `asc`, `csv`, `tsv`, `pts`,
/// `dat` or none is [`xyz`]. `name` is used for nothing else and may hold any path.
///
/// # Errors
///
/// [`ReadError::Unknown`] where neither content nor extension tell the format, otherwise what the
/// reader of the format reports.
pub fn read(name: &str, bytes: &[u8]) -> Result<Topography, ReadError> {
    read_with(name, bytes, &TextOptions::default())
}

/// The same with columns and units of a text file.
///
/// # Errors
///
/// As [`read`]; options for a file that is no text.
pub fn read_with(name: &str, bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let format = format(name, bytes)?;
    if format != Format::Xyz && *options != TextOptions::default() {
        return Err(ReadError::Unclear {
            format,
            place: Place::Byte(0),
            found: "the file states its columns and units itself".into(),
            cure: "leave out `--columns`, `--unit`, `--skip-lines` and `--pitch`".into(),
        });
    }
    match format {
        Format::X3p => x3p::read(bytes),
        Format::MetroPro => metropro::read(bytes),
        Format::Sdf => sdf::read(bytes),
        Format::GridSag => grid_sag::read(bytes),
        Format::Xyz => xyz::read_with(bytes, options),
    }
}

fn format(name: &str, bytes: &[u8]) -> Result<Format, ReadError> {
    if bytes.starts_with(x3p::MAGIC) {
        return Ok(Format::X3p);
    }
    if metropro::is_metropro(bytes) {
        return Ok(Format::MetroPro);
    }
    if sdf::is_sdf(without_bom(bytes)) {
        return Ok(Format::Sdf);
    }
    if grid_sag::is_grid_sag(bytes) {
        return Ok(Format::GridSag);
    }
    let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
    let extension = file.rsplit_once('.').map_or("", |(_, extension)| extension);
    let promised = |format, expected: &str| {
        Err(ReadError::Malformed {
            format,
            place: Place::Byte(0),
            expected: expected.into(),
            found: quoted(bytes),
        })
    };
    match extension.to_ascii_lowercase().as_str() {
        "x3p" => promised(Format::X3p, "a zip archive starting with PK"),
        "sdf" => promised(Format::Sdf, "aISO-1.0, bISO-1.0, aBCR-1.0 or bBCR-1.0"),
        "dat" if !is_text(bytes) => {
            promised(Format::MetroPro, "a magic number 881B036F, 881B0370 or 881B0371")
        }
        "xyz" | "txt" | "asc" | "csv" | "tsv" | "pts" | "dat" | ""
            if is_text(bytes) || is_utf16(bytes) =>
        {
            Ok(Format::Xyz)
        }
        _ => Err(ReadError::Unknown { name: name.into(), start: quoted(bytes) }),
    }
}

/// Whether the start of a file looks like text of one byte a letter: no control characters but
/// those that lay out text.
fn is_text(bytes: &[u8]) -> bool {
    const LOOKED_AT: usize = 4096;
    bytes
        .iter()
        .take(LOOKED_AT)
        .all(|&byte| byte >= b' ' || matches!(byte, b'\t' | b'\n' | b'\r' | b'\x0C'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_goes_before_extension() {
        assert_eq!(format("a.xyz", b"PK\x03\x04rest"), Ok(Format::X3p));
        assert_eq!(format("a.txt", b"aISO-1.0\n"), Ok(Format::Sdf));
        assert_eq!(format("a.xyz", b"\x88\x1B\x03\x6F"), Ok(Format::MetroPro));
        assert_eq!(
            format("a.DAT", b"! sag\r\n5 5 1 1 0 0 0\r\n0 0 0 0 0\r\n"),
            Ok(Format::GridSag)
        );
    }

    #[test]
    fn extension_decides_for_text() {
        for name in ["a.xyz", "A.TXT", "dir.sdf/points", "c:\\dir.x3p\\a.dat", ".asc"] {
            assert_eq!(format(name, b"1 2 3\r\n"), Ok(Format::Xyz), "{name}");
        }
    }

    #[test]
    fn broken_promises_and_strangers_are_named() {
        let message = |name, bytes: &[u8]| format(name, bytes).unwrap_err().to_string();
        assert_eq!(
            message("a.x3p", b"1 2 3"),
            "X3P file, byte 0: expected a zip archive starting with PK, found \"1 2 3\""
        );
        assert_eq!(
            message("part.stl", b"solid"),
            "part.stl: expected an XYZ, X3P, MetroPro, SDF or Zemax grid sag file, found one starting with \"solid\""
        );
        assert!(message("a.dat", b"\0\0").starts_with("MetroPro file, byte 0: expected a magic"));
        assert!(message("a.xyz", b"1 2 3\0").starts_with("a.xyz: expected an XYZ"));
    }
}

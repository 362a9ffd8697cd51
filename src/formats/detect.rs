//! Which format a file has: its content decides, its extension only where the content cannot.

use crate::error::quoted;
use crate::scan::{is_utf16, without_bom};
use crate::xyz::TextOptions;
use crate::{
    Format, Place, ReadError, Topography, grid_sag, las, metropro, npy, obj, off, ply, sdf, stl,
    volume, x3p, xyz, zemax,
};

/// Reads a file whose format is not known beforehand.
///
/// The content decides: `PK` is [`x3p`], a MetroPro magic number is [`metropro`], `aISO-1.0`,
/// `bISO-1.0`, `aBCR-1.0` and `bBCR-1.0` are [`sdf`], `ply` alone on the first line is [`ply`], `LASF` is [`las`], `0x93 NUMPY` is
/// [`npy`]; a file as long as its number of triangles asks for, or one that begins with `solid` before `facet`, is [`stl`];
/// a line of seven numbers that can be the first of a [`grid_sag`] file, before
/// one of at most five, is that; lines with keywords of [`obj`], one of them a vertex, are that. Only a file that starts otherwise is
/// judged by the extension of `name`: text with the extension `xyz`, `txt`, `asc`, `csv`, `tsv`, `pts`,
/// `dat` or none is [`xyz`]. `name` is used for nothing else and may hold any path.
///
/// # Errors
///
/// [`ReadError::Unknown`] where neither content nor extension tell the format, [`ReadError::Lens`] of a lens file,
/// [`ReadError::Volume`] of a volume, otherwise what
/// the reader of the format reports.
pub fn read(name: &str, bytes: &[u8]) -> Result<Topography, ReadError> {
    read_with(name, bytes, &TextOptions::default())
}

/// [`read`] with columns and units that the user names for a text file.
///
/// # Errors
///
/// As [`read`]; options for a file that is no text.
pub fn read_with(name: &str, bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let format = format(name, bytes)?;
    check(format, options)?;
    match format {
        Format::X3p => x3p::read(bytes),
        Format::MetroPro => metropro::read(bytes),
        Format::Sdf => sdf::read(bytes),
        Format::GridSag => grid_sag::read(bytes),
        Format::Xyz => xyz::read_with(bytes, options),
        Format::Ply => ply::read(bytes, options),
        Format::Stl => stl::read(bytes, options),
        Format::Obj => obj::read(bytes, options),
        Format::Off => off::read(bytes, options),
        Format::Las => las::read(bytes, options),
        Format::Npy => npy::read(bytes, options),
        Format::Vol
        | Format::Nrrd
        | Format::MetaImage
        | Format::Nifti
        | Format::Tiff
        | Format::Vti
        | Format::Raw
        | Format::Vgi => Err(ReadError::Volume { name: name.into() }),
        // Lines and images are no points; nothing detects them here.
        Format::Svg | Format::Dxf | Format::Png => Err(ReadError::Unknown {
            name: name.into(),
            start: quoted(&bytes[..bytes.len().min(16)]),
        }),
    }
}

/// Reads a text file as [`read_with`] does, with the numbers of one more column: [`xyz::read_with_column`].
///
/// # Errors
///
/// As these; a file that is no text.
pub fn read_with_column(
    name: &str,
    bytes: &[u8],
    options: &TextOptions,
    column: usize,
) -> Result<(Topography, Vec<f64>), ReadError> {
    match format(name, bytes)? {
        Format::Xyz => xyz::read_with_column(bytes, options, column),
        format => Err(ReadError::Unsupported {
            format,
            place: Place::Byte(0),
            expected: "columns of text (.xyz, .csv)".into(),
            found: format!("a column {column} of the file"),
        }),
    }
}

/// Refuses options that a format has no use for.
pub(crate) fn check(format: Format, options: &TextOptions) -> Result<(), ReadError> {
    // What fits: columns, unit, lines to be skipped, pitch, marks that are heights.
    let fits = match format {
        Format::Xyz => [true; 5],
        Format::X3p | Format::MetroPro | Format::Sdf | Format::GridSag => [false; 5],
        // What is wrong with a volume is that it is one.
        Format::Vol
        | Format::Nrrd
        | Format::MetaImage
        | Format::Nifti
        | Format::Tiff
        | Format::Vti
        | Format::Raw
        | Format::Vgi
        | Format::Svg
        | Format::Dxf
        | Format::Png => [true; 5],
        Format::Ply | Format::Stl | Format::Obj | Format::Off | Format::Las => {
            [false, true, false, false, false]
        }
        Format::Npy => [true, true, false, true, true],
    };
    let given = [
        !options.columns.is_empty(),
        !options.units.is_empty(),
        options.skip_lines > 0,
        options.pitch_mm.is_some(),
        options.keeps_marks,
    ];
    if given.iter().zip(fits).all(|(given, fits)| !given || fits) {
        return Ok(());
    }
    let listed = |wanted: bool| {
        let options = ["`--columns`", "`--unit`", "`--skip-lines`", "`--pitch`", "`--keep-marks`"];
        let named = options.into_iter().zip(fits).filter(|(_, fits)| *fits == wanted);
        let named: Vec<&str> = named.map(|(name, _)| name).collect();
        match &named[..] {
            [] => "none".to_owned(),
            [only] => (*only).to_owned(),
            [first @ .., last] => format!("{} and {last}", first.join(", ")),
        }
    };
    let found = if fits[1] {
        "the file states where its coordinates are"
    } else {
        "the file states its columns and units itself"
    };
    let cure = match listed(true).as_str() {
        "none" => format!("leave out {}", listed(false)),
        fitting => format!("leave out {}; of these options it takes {fitting}", listed(false)),
    };
    let place = Place::Byte(0);
    Err(ReadError::Unclear { format, place, found: found.into(), cure })
}

/// The format of a file.
pub(crate) fn format(name: &str, bytes: &[u8]) -> Result<Format, ReadError> {
    if bytes.starts_with(x3p::MAGIC) {
        return Ok(Format::X3p);
    }
    if metropro::is_metropro(bytes) {
        return Ok(Format::MetroPro);
    }
    if sdf::is_sdf(without_bom(bytes)) {
        return Ok(Format::Sdf);
    }
    if let Some(format) = by_start(bytes) {
        return Ok(format);
    }
    if let Some(format) = volume::format_of(name, bytes) {
        return Ok(format);
    }
    if zemax::is_zemax(bytes) {
        return Err(ReadError::Lens { name: name.into() });
    }
    if grid_sag::is_grid_sag(bytes) {
        return Ok(Format::GridSag);
    }
    if obj::is_obj(bytes) {
        return Ok(Format::Obj);
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
        "ply" => promised(Format::Ply, "the word ply, alone on its line"),
        "las" | "laz" => promised(Format::Las, "LASF"),
        "npy" => promised(Format::Npy, "\\x93NUMPY"),
        // Their readers say what is missing.
        "stl" => Ok(Format::Stl),
        "obj" if is_text(bytes) => Ok(Format::Obj),
        "off" => Ok(Format::Off),
        "dat" if !is_text(bytes) => {
            promised(Format::MetroPro, "a magic number 881B036F, 881B0370 or 881B0371")
        }
        "xyz" | "xy" | "txt" | "asc" | "csv" | "tsv" | "pts" | "dat" | ""
            if is_text(bytes) || is_utf16(bytes) =>
        {
            Ok(Format::Xyz)
        }
        _ => Err(ReadError::Unknown { name: name.into(), start: quoted(bytes) }),
    }
}

/// The formats of points and triangles that their first bytes tell, or their length.
fn by_start(bytes: &[u8]) -> Option<Format> {
    if ply::is_ply(bytes) {
        return Some(Format::Ply);
    }
    if bytes.starts_with(las::MAGIC) {
        return Some(Format::Las);
    }
    if npy::is_npy(bytes) {
        return Some(Format::Npy);
    }
    if off::is_off(bytes) {
        return Some(Format::Off);
    }
    (stl::is_binary(bytes) || stl::is_ascii(bytes)).then_some(Format::Stl)
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
    fn meshes_scans_and_arrays_are_told_by_their_content() {
        let mut binary = b"solid by its first word".to_vec();
        binary.resize(84 + 50, 0);
        binary[80] = 1;
        let cases: [(&[u8], Format); 8] = [
            (b"ply\r\nformat ascii 1.0\r\n", Format::Ply),
            (b"LASF\0\0", Format::Las),
            (b"\x93NUMPY\x01\0", Format::Npy),
            (b"solid\n facet normal 0 0 1\n", Format::Stl),
            (&binary, Format::Stl),
            (b"# Blender\nmtllib a.mtl\no Part\nv 0 0 1\n", Format::Obj),
            (b"v 0 0 1 0.5 0.5 0.5\n", Format::Obj),
            (b"v w x\n0 0 1\n", Format::Xyz),
        ];
        for (bytes, expected) in cases {
            assert_eq!(format("a.txt", bytes), Ok(expected), "{}", bytes.escape_ascii());
        }
        // Files that are cut are still taken for what their names say.
        assert_eq!(format("a.stl", &binary[..100]), Ok(Format::Stl));
        assert_eq!(format("a.obj", b"# nothing\n"), Ok(Format::Obj));
    }

    #[test]
    fn options_that_do_not_fit_are_refused_with_those_that_do() {
        let options = TextOptions { skip_lines: 1, ..TextOptions::default() };
        let said = |format| check(format, &options).unwrap_err().to_string();
        assert_eq!(
            said(Format::Stl),
            "STL file, byte 0: the file states where its coordinates are: leave out `--columns`, `--skip-lines`, \
             `--pitch` and `--keep-marks`; of these options it takes `--unit`"
        );
        assert!(
            said(Format::Npy)
                .ends_with("it takes `--columns`, `--unit`, `--pitch` and `--keep-marks`")
        );
        assert!(said(Format::Sdf).ends_with(
            "leave out `--columns`, `--unit`, `--skip-lines`, `--pitch` and `--keep-marks`"
        ));
        assert_eq!(check(Format::Xyz, &options), Ok(()));
        assert_eq!(check(Format::Sdf, &TextOptions::default()), Ok(()));
    }

    #[test]
    fn lens_files_are_named_whatever_their_encoding() {
        let text = "VERS 140124 258 36214\r\nMODE SEQ\r\nUNIT MM X W X CM MR CPMM\r\nSURF 0\r\n  TYPE STANDARD\r\n";
        let wide: Vec<u8> =
            [0xFEFF].into_iter().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        let bare = wide[2..].to_vec();
        for bytes in [text.as_bytes(), &wide, &bare] {
            for name in ["lens.zmx", "lens.txt", "lens"] {
                let message = format(name, bytes).unwrap_err().to_string();
                let expected = format!("{name}: a Zemax lens file, which holds surfaces");
                assert!(message.starts_with(&expected), "{message}");
                assert!(message.contains("`asphera nominal"), "{message}");
            }
        }
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
            message("part.step", b"ISO-10303-21"),
            "part.step: expected a file of text (.xyz, .csv), X3P, MetroPro .dat, SDF, Zemax grid sag, PLY, STL, OBJ, OFF, LAS, \
             LAZ or NumPy .npy; found one starting with \"ISO-10303-21\""
        );
        for (name, expected) in [
            ("a.ply", "PLY file, byte 0: expected the word ply"),
            ("a.LAZ", "LAS file, byte 0: expected LASF"),
            ("a.npy", "NumPy file, byte 0: expected \\x93NUMPY"),
        ] {
            assert!(message(name, b"1 2 3").starts_with(expected), "{}", message(name, b"1 2 3"));
        }
        assert!(message("a.dat", b"\0\0").starts_with("MetroPro file, byte 0: expected a magic"));
        assert!(message("a.xyz", b"1 2 3\0").starts_with("a.xyz: expected a file of text"));
    }
}

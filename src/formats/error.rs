//! Why a file cannot be read or written.

use std::borrow::Cow;
use std::fmt;
use std::io;

use thiserror::Error;

/// Most points one file may declare, 10⁸: 0.8 GB of heights. The largest maps of today's
/// instruments have some 10⁷ points.
pub const MAX_POINTS: u64 = 100_000_000;

/// The kinds of files of points, in words.
pub const KINDS: &str = "text (.xyz, .csv), X3P, MetroPro .dat, SDF, Zemax grid sag, PLY, STL, OBJ, OFF, LAS, LAZ or NumPy .npy";

/// The kinds of files of volumes, in words.
pub const VOLUME_KINDS: &str =
    ".vol, NRRD, MetaImage, NIfTI, TIFF stack, .vti, or raw samples with .toml or .vgi beside them";

/// File formats this crate knows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Columns of text.
    Xyz,
    /// ISO 25178-72.
    X3p,
    /// Zygo MetroPro `.dat`.
    MetroPro,
    /// ISO 25178-71.
    Sdf,
    /// Grid sag of Zemax, `.DAT` and `.GRD`.
    GridSag,
    /// Stanford PLY.
    Ply,
    /// STL, binary and ASCII.
    Stl,
    /// Wavefront OBJ.
    Obj,
    /// OFF of Geomview.
    Off,
    /// LAS and LAZ of the ASPRS.
    Las,
    /// Arrays of NumPy, `.npy`.
    Npy,
    /// Volumes of DGtal, `.vol`.
    Vol,
    /// Volumes of teem, `.nrrd` and `.nhdr`.
    Nrrd,
    /// Volumes of ITK, `.mha` and `.mhd`.
    MetaImage,
    /// NIfTI-1 and NIfTI-2.
    Nifti,
    /// Stacks of TIFF slices.
    Tiff,
    /// Images of VTK, `.vti`.
    Vti,
    /// Raw samples with a TOML file beside them.
    Raw,
    /// Headers of Volume Graphics, `.vgi`.
    Vgi,
    /// Drawings of the W3C, `.svg`.
    Svg,
    /// Drawings of AutoCAD, `.dxf`.
    Dxf,
    /// Images, `.png`.
    Png,
}

impl Format {
    /// Name as reports write it.
    pub const fn name(self) -> &'static str {
        match self {
            Format::Xyz => "XYZ",
            Format::X3p => "X3P",
            Format::MetroPro => "MetroPro",
            Format::Sdf => "SDF",
            Format::GridSag => "Zemax grid sag",
            Format::Ply => "PLY",
            Format::Stl => "STL",
            Format::Obj => "OBJ",
            Format::Off => "OFF",
            Format::Las => "LAS",
            Format::Npy => "NumPy",
            Format::Vol => "VOL",
            Format::Nrrd => "NRRD",
            Format::MetaImage => "MetaImage",
            Format::Nifti => "NIfTI",
            Format::Tiff => "TIFF",
            Format::Vti => "VTK image",
            Format::Raw => "raw volume",
            Format::Vgi => "VGI",
            Format::Svg => "SVG",
            Format::Dxf => "DXF",
            Format::Png => "PNG",
        }
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// Offset from the start of the file in bytes.
    Byte(u64),
    /// Line and column of a text; both count from 1, columns are those of the table, not letters.
    Line {
        /// Line of the file.
        line: usize,
        /// Column of the table, or 0 for the whole line.
        column: usize,
    },
    /// Row and column of an array, both from 1; column 0 for the whole row.
    Row {
        /// Row of the array.
        row: usize,
        /// Column of the array, or 0.
        column: usize,
    },
    /// Path of an XML element below the root of `main.xml`.
    Element(String),
    /// Name of an entry of a zip archive.
    Entry(String),
    /// Page of a TIFF file, from 1.
    Page(usize),
    /// Name of a slice of a volume, in a folder of them.
    Slice(String),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Byte(offset) => write!(f, "byte {offset}"),
            Place::Line { line, column: 0 } => write!(f, "line {line}"),
            Place::Line { line, column } => write!(f, "line {line}, column {column}"),
            Place::Row { row, column: 0 } => write!(f, "row {row}"),
            Place::Row { row, column } => write!(f, "row {row}, column {column}"),
            Place::Element(path) => write!(f, "element {}", shown(path)),
            Place::Entry(name) => write!(f, "zip entry {}", shown(name)),
            Place::Page(page) => write!(f, "page {page}"),
            Place::Slice(name) if name.is_empty() => f.write_str("its folder"),
            Place::Slice(name) => write!(f, "slice {}", shown(name)),
        }
    }
}

/// Why a file cannot be read.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum ReadError {
    /// The content belongs to no format known here.
    #[error("{name}: expected a file of {KINDS}; found one starting with {start}")]
    Unknown {
        /// Name of the file as given.
        name: String,
        /// Its first bytes, quoted.
        start: String,
    },
    /// A lens file, which holds surfaces and no points.
    #[error(
        "{name}: a Zemax lens file, which holds surfaces and no points: make a nominal of one with `asphera nominal {name} \
         --surface N --out NOMINAL.toml`"
    )]
    Lens {
        /// Name of the file as given.
        name: String,
    },
    /// The content is no volume.
    #[error("{name}: expected a volume, {VOLUME_KINDS}; found a file starting with {start}")]
    NoVolume {
        /// Name of the file as given.
        name: String,
        /// Its first bytes, quoted.
        start: String,
    },
    /// A volume where points are expected.
    #[error(
        "{name}: a volume, where points are expected: `asphera volume {name} --mesh MESH.ply` makes a surface of it, and `asphera measure` takes the face of a nominal from it"
    )]
    Volume {
        /// Name of the file as given.
        name: String,
    },
    /// The content breaks the rules of its format.
    #[error("{format} file, {place}: expected {}, found {}", shown(.expected), shown(.found))]
    Malformed {
        /// Format of the file.
        format: Format,
        /// Where.
        place: Place,
        /// Content that the format asks for there.
        expected: String,
        /// Content found there.
        found: String,
    },
    /// The content may well be right, but this crate does not read it.
    #[error("{format} file, {place}: {} is not supported, expected {}", shown(.found), shown(.expected))]
    Unsupported {
        /// Format of the file.
        format: Format,
        /// Where.
        place: Place,
        /// Content that is read.
        expected: String,
        /// Content found there.
        found: String,
    },
    /// The content may mean several things; what to add decides.
    #[error("{format} file, {place}: {}: {}", shown(.found), shown(.cure))]
    Unclear {
        /// Format of the file.
        format: Format,
        /// Where.
        place: Place,
        /// Property that cannot be told.
        found: String,
        /// Cure.
        cure: String,
    },
    /// The content was changed after its checksum was taken.
    #[error("{format} file, {place}: expected the MD5 checksum {expected}, found {found}")]
    Checksum {
        /// Format of the file.
        format: Format,
        /// Bytes that the checksum covers.
        place: Place,
        /// The checksum that the file states, 32 hexadecimal digits.
        expected: String,
        /// The checksum of the content, 32 hexadecimal digits.
        found: String,
    },
    /// The content is larger than this crate reads.
    #[error("{format} file, {place}: expected at most {limit} {unit}, found {found}")]
    TooLarge {
        /// Format of the file.
        format: Format,
        /// Where.
        place: Place,
        /// Unit of the count: `points`, `bytes`.
        unit: &'static str,
        /// How many are read.
        limit: u64,
        /// How many there are, or are said to be.
        found: u64,
    },
}

/// Why something cannot be written.
#[derive(Debug, Error)]
pub enum WriteError {
    /// The destination failed.
    #[error("cannot write {what}")]
    Io {
        /// Part being written.
        what: &'static str,
        /// Error of the destination.
        source: io::Error,
    },
    /// The values do not make what is to be written.
    #[error("cannot write {what}: expected {expected}, found {found}")]
    Invalid {
        /// The value at fault.
        what: String,
        /// Value that would do.
        expected: String,
        /// Value given.
        found: String,
    },
}

impl ReadError {
    /// Whether the message names the file itself.
    pub fn names_file(&self) -> bool {
        matches!(
            self,
            ReadError::Unknown { .. }
                | ReadError::Lens { .. }
                | ReadError::NoVolume { .. }
                | ReadError::Volume { .. }
        )
    }

    /// Error in a slice of a volume.
    pub(crate) fn in_slice(mut self, name: &str) -> ReadError {
        if let ReadError::Malformed { place, .. }
        | ReadError::Unsupported { place, .. }
        | ReadError::TooLarge { place, .. } = &mut self
        {
            *place = Place::Slice(name.into());
        }
        self
    }

    /// This error in another format, its lines being rows of an array.
    pub(crate) fn in_array(mut self, of: Format) -> ReadError {
        if let ReadError::Malformed { format, place, .. }
        | ReadError::Unsupported { format, place, .. }
        | ReadError::Unclear { format, place, .. }
        | ReadError::Checksum { format, place, .. }
        | ReadError::TooLarge { format, place, .. } = &mut self
        {
            *format = of;
            if let Place::Line { line, column } = *place {
                *place = Place::Row { row: line, column };
            }
        }
        self
    }
}

impl WriteError {
    pub(crate) fn invalid(
        what: impl Into<String>,
        expected: impl Into<String>,
        found: impl fmt::Display,
    ) -> WriteError {
        WriteError::Invalid {
            what: what.into(),
            expected: expected.into(),
            found: found.to_string(),
        }
    }
}

/// A text that may hold words of a file, as a message shows it: signs that move a terminal are escaped, and the middle of a text
/// beyond 400 signs is left out.
pub(crate) fn shown(text: &str) -> Cow<'_, str> {
    let is_long = text.len() > LONGEST_SHOWN;
    if !is_long && !text.contains(char::is_control) {
        return Cow::Borrowed(text);
    }
    let mut signs: Vec<char> = text.chars().collect();
    if is_long && signs.len() > LONGEST_SHOWN {
        signs.splice(LONGEST_SHOWN / 2..signs.len() - LONGEST_SHOWN / 4, " … ".chars());
    }
    let escaped = signs.into_iter().map(|sign| match sign.is_control() {
        true => sign.escape_default().to_string(),
        false => sign.to_string(),
    });
    Cow::Owned(escaped.collect())
}

/// Most signs of a text that a message shows whole.
const LONGEST_SHOWN: usize = 400;

/// Bytes of a file as an error message shows them: at most 24, quoted, with what is not printable
/// ASCII escaped.
pub(crate) fn quoted(bytes: &[u8]) -> String {
    const SHOWN: usize = 24;
    let shown = bytes[..bytes.len().min(SHOWN)].escape_ascii();
    format!("\"{shown}{}\"", if bytes.len() > SHOWN { "…" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_name_format_place_expected_and_found() {
        let error = ReadError::Malformed {
            format: Format::Xyz,
            place: Place::Line { line: 3, column: 2 },
            expected: "a number".into(),
            found: quoted(b"1,5"),
        };
        assert_eq!(
            error.to_string(),
            "XYZ file, line 3, column 2: expected a number, found \"1,5\""
        );
    }

    #[test]
    fn words_of_a_file_move_no_terminal_and_are_not_repeated_without_end() {
        assert_eq!(shown("x [mm]"), "x [mm]");
        assert_eq!(shown("x\u{1b}[2J\0µ"), "x\\u{1b}[2J\\u{0}µ");
        let long = shown(&"µ".repeat(1_000_000)).into_owned();
        assert!(long.chars().count() < 310 && long.contains(" … "), "{long}");
    }

    #[test]
    fn quoted_bytes_are_short_and_printable() {
        assert_eq!(quoted(b"a\"\x00\xFF"), r#""a\"\x00\xff""#);
        assert_eq!(quoted(&[b'a'; 30]), format!("\"{}…\"", "a".repeat(24)));
    }
}

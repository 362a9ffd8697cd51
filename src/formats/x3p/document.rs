//! What `main.xml` says, checked: axes, place, size, where the points are, and where they come from.

use super::CHECKSUM_FILE;
use super::archive::checksum;
use super::xml::{Elements, at};
use crate::error::quoted;
use crate::scan::{finite, grid_len};
use crate::topography::joined;
use crate::{Format, Place, ReadError, Source};

/// A checked `main.xml`.
pub(super) struct Document {
    /// The axes CX, CY and CZ.
    pub(super) axes: [Axis; 3],
    /// R of `global = R · (I · stored) + O`, row after row, or `None` where it turns nothing.
    pub(super) rotation: Option<[[f64; 3]; 3]>,
    pub(super) layout: Layout,
    pub(super) storage: Storage,
    pub(super) checksum_file: String,
    pub(super) source: Source,
}

/// One axis of `Record1`.
#[derive(Clone, Copy)]
pub(super) struct Axis {
    /// How values are stored, or `None` for an incremental axis, which stores none.
    pub(super) stored: Option<DataType>,
    /// Metres per stored unit or per index; finite, above zero.
    pub(super) increment_m: f64,
    /// Offset in metres; finite.
    pub(super) offset_m: f64,
}

/// How a stored value is coded, little-endian.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum DataType {
    /// `I`
    I16,
    /// `L`
    I32,
    /// `F`
    F32,
    /// `D`
    F64,
}

/// How the points are arranged.
#[derive(Clone, Copy)]
pub(super) enum Layout {
    /// Columns and rows of a surface.
    Matrix { nx: usize, ny: usize },
    /// Points of a point cloud.
    List { len: usize },
}

/// Where the stored values are.
pub(super) enum Storage {
    /// A line of text for each point.
    Text(String),
    /// Binary files.
    Binary { points: Linked, valid: Option<Linked> },
}

/// A binary file in the archive.
pub(super) struct Linked {
    pub(super) name: String,
    /// 32 lower-case hexadecimal digits, where the file states them.
    pub(super) md5: Option<String>,
}

impl Document {
    pub(super) fn parse(main: &[u8]) -> Result<Document, ReadError> {
        let mut elements = Elements::parse(main)?;
        let is_list = feature_is_list(&elements)?;
        let axes = [
            axis(&elements, "Record1/Axes/CX")?,
            axis(&elements, "Record1/Axes/CY")?,
            axis(&elements, "Record1/Axes/CZ")?,
        ];
        for (axis, name) in axes.iter().zip(["CX", "CY", "CZ"]) {
            if axis.stored.is_none() && (is_list || name == "CZ") {
                let path = format!("Record1/Axes/{name}/AxisType");
                return Err(at(&path, "A: this axis must be absolute", "I"));
            }
        }
        Ok(Document {
            axes,
            rotation: rotation(&elements)?,
            layout: layout(&elements, is_list)?,
            storage: storage(&mut elements)?,
            checksum_file: elements.get("Record4/ChecksumFile").unwrap_or(CHECKSUM_FILE).to_owned(),
            source: source(&elements),
        })
    }
}

impl Layout {
    /// How many points there are.
    pub(super) fn len(self) -> usize {
        match self {
            Layout::Matrix { nx, ny } => nx * ny,
            Layout::List { len } => len,
        }
    }
}

impl DataType {
    /// Bytes of one value.
    pub(super) fn len(self) -> usize {
        match self {
            DataType::I16 => 2,
            DataType::I32 | DataType::F32 => 4,
            DataType::F64 => 8,
        }
    }

    /// The range of an integer type.
    pub(super) fn integers(self) -> Option<(f64, f64)> {
        match self {
            DataType::I16 => Some((i16::MIN.into(), i16::MAX.into())),
            DataType::I32 => Some((i32::MIN.into(), i32::MAX.into())),
            DataType::F32 | DataType::F64 => None,
        }
    }
}

/// Whether the points are a list (`PCL`) or a matrix (`SUR`).
fn feature_is_list(elements: &Elements) -> Result<bool, ReadError> {
    const FEATURE: &str = "Record1/FeatureType";
    match elements.required(FEATURE)? {
        "SUR" => Ok(false),
        "PCL" => Ok(true),
        "PRF" => {
            Err(unsupported(FEATURE, "a surface (SUR) or a point cloud (PCL)", "a profile (PRF)"))
        }
        other => Err(at(FEATURE, "SUR, PCL or PRF", quoted(other.as_bytes()))),
    }
}

fn axis(elements: &Elements, path: &str) -> Result<Axis, ReadError> {
    let below = |name: &str| format!("{path}/{name}");
    let absolute = match elements.required(&below("AxisType"))? {
        "A" => true,
        "I" => false,
        other => return Err(at(&below("AxisType"), "I or A", quoted(other.as_bytes()))),
    };
    let stored = if absolute {
        Some(match elements.required(&below("DataType"))? {
            "I" => DataType::I16,
            "L" => DataType::I32,
            "F" => DataType::F32,
            "D" => DataType::F64,
            other => return Err(at(&below("DataType"), "I, L, F or D", quoted(other.as_bytes()))),
        })
    } else {
        None
    };
    let increment_m = match number(elements, &below("Increment"))? {
        Some(increment_m) if increment_m > 0.0 => increment_m,
        // An absolute axis without increment stores metres.
        None if absolute => 1.0,
        found => {
            let found = found.map_or("none".into(), |found| found.to_string());
            return Err(at(&below("Increment"), "metres above zero", found));
        }
    };
    let offset_m = number(elements, &below("Offset"))?.unwrap_or(0.0);
    Ok(Axis { stored, increment_m, offset_m })
}

/// The finite number that an element holds, if it is there.
fn number(elements: &Elements, path: &str) -> Result<Option<f64>, ReadError> {
    let Some(text) = elements.get(path) else {
        return Ok(None);
    };
    let number = finite(text.as_bytes());
    number.map(Some).ok_or_else(|| at(path, "a finite number", quoted(text.as_bytes())))
}

/// The rotation, which must be orthonormal and right-handed; `None` for the identity.
fn rotation(elements: &Elements) -> Result<Option<[[f64; 3]; 3]>, ReadError> {
    const PATH: &str = "Record1/Axes/Rotation";
    if !elements.contains(PATH) {
        return Ok(None);
    }
    let mut matrix = [[0.0; 3]; 3];
    for (row, values) in matrix.iter_mut().enumerate() {
        for (column, value) in values.iter_mut().enumerate() {
            let path = format!("{PATH}/r{}{}", row + 1, column + 1);
            *value =
                number(elements, &path)?.ok_or_else(|| at(&path, "a finite number", "none"))?;
        }
    }
    let [a, b, c] = matrix;
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    // Rows of length 1 at right angles, the third being the cross product of the others.
    let errors = [
        dot(a, a) - 1.0,
        dot(b, b) - 1.0,
        dot(c, c) - 1.0,
        dot(a, b),
        dot(b, c),
        dot(c, a),
        dot(cross(a, b), c) - 1.0,
    ];
    let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
    if worst > ROTATION_TOLERANCE {
        let expected = format!("a right-handed rotation within {ROTATION_TOLERANCE:e}");
        return Err(at(PATH, &expected, format!("a matrix off by {worst:.2e}")));
    }
    let identity = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    Ok((matrix != identity).then_some(matrix))
}

/// How far a matrix written with few digits may be from a rotation; what x3pio allows as well.
const ROTATION_TOLERANCE: f64 = 1e-6;

fn layout(elements: &Elements, is_list: bool) -> Result<Layout, ReadError> {
    const LIST: &str = "Record3/ListDimension";
    const MATRIX: &str = "Record3/MatrixDimension";
    let (there, other) = if is_list { (LIST, MATRIX) } else { (MATRIX, LIST) };
    if elements.contains(other) {
        return Err(at(other, &format!("{there} for this FeatureType"), "this element"));
    }
    let place = || Place::Element(there.into());
    if is_list {
        let len = whole(elements, LIST)?;
        return Ok(Layout::List { len: grid_len(Format::X3p, place(), len, 1)? });
    }
    let [nx, ny, nz] = [
        whole(elements, "Record3/MatrixDimension/SizeX")?,
        whole(elements, "Record3/MatrixDimension/SizeY")?,
        whole(elements, "Record3/MatrixDimension/SizeZ")?,
    ];
    if nz != 1 {
        let found = format!("a surface of {nz} layers");
        return Err(unsupported("Record3/MatrixDimension/SizeZ", "one layer", &found));
    }
    // Within the limit of points, both fit a usize.
    grid_len(Format::X3p, place(), nx, ny)?;
    Ok(Layout::Matrix { nx: nx as usize, ny: ny as usize })
}

fn whole(elements: &Elements, path: &str) -> Result<u64, ReadError> {
    let text = elements.required(path)?;
    text.parse().map_err(|_| at(path, "a whole number", quoted(text.as_bytes())))
}

fn storage(elements: &mut Elements) -> Result<Storage, ReadError> {
    const LINK: &str = "Record3/DataLink";
    let linked = |elements: &Elements, name: &str, md5: &str| {
        let Some(file) = elements.get(&format!("{LINK}/{name}")) else {
            return Ok(None);
        };
        let path = format!("{LINK}/{md5}");
        let md5 = match elements.get(&path) {
            None => None,
            Some(text) => Some(
                checksum(text)
                    .ok_or_else(|| at(&path, "32 hexadecimal digits", quoted(text.as_bytes())))?,
            ),
        };
        Ok(Some(Linked { name: file.to_owned(), md5 }))
    };
    let points = linked(elements, "PointDataLink", "MD5ChecksumPointData")?;
    match (points, elements.take_data()) {
        (Some(points), None) => {
            let valid = linked(elements, "ValidPointsLink", "MD5ChecksumValidPoints")?;
            Ok(Storage::Binary { points, valid })
        }
        (None, Some(text)) => Ok(Storage::Text(text)),
        (Some(_), Some(_)) => Err(at("Record3", "either DataLink or DataList", "both")),
        (None, None) => Err(at("Record3", "DataLink/PointDataLink or DataList", "neither")),
    }
}

fn source(elements: &Elements) -> Source {
    let text = |path: &str| elements.get(path).unwrap_or_default();
    let mut source = Source::new(Format::X3p);
    source.instrument = joined(&[
        text("Record2/Instrument/Manufacturer"),
        text("Record2/Instrument/Model"),
        text("Record2/Instrument/Serial"),
    ]);
    source.date = joined(&[text("Record2/Date")]);
    source.comment = joined(&[text("Record2/Comment")]);
    source
}

fn unsupported(path: &str, expected: &str, found: &str) -> ReadError {
    ReadError::Unsupported {
        format: Format::X3p,
        place: Place::Element(path.into()),
        expected: expected.into(),
        found: found.into(),
    }
}

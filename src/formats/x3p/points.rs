//! From stored values to a map or a cloud.

use super::archive::Archive;
use super::document::{Axis, DataType, Document, Layout, Storage};
use super::xml::at;
use crate::error::quoted;
use crate::scan::{finite, says_missing};
use crate::{Cloud, Format, HeightMap, Place, ReadError, Topography};

/// The topography of a checked document.
pub(super) fn topography(
    document: Document,
    archive: &mut Archive<'_>,
) -> Result<Topography, ReadError> {
    let stored = Stored::load(&document, archive)?;
    match (document.layout, &document.axes) {
        (Layout::Matrix { nx, ny }, [Axis { stored: None, .. }, Axis { stored: None, .. }, _])
            if document.rotation.is_none() =>
        {
            Ok(Topography::Map(height_map(nx, ny, &document.axes, &stored), document.source))
        }
        _ => Ok(Topography::Cloud(cloud(&document, &stored)?, document.source)),
    }
}

/// The values of the absolute axes as the file stores them.
enum Stored {
    Text(Vec<[f64; 3]>),
    Binary {
        /// The absolute axes, numbered x 0, y 1, z 2, in the order in which a record holds them.
        codings: Vec<(usize, DataType)>,
        record_len: usize,
        data: Vec<u8>,
        /// A bit for each point, where there is a validity file.
        valid: Option<Vec<u8>>,
    },
}

impl Stored {
    fn load(document: &Document, archive: &mut Archive<'_>) -> Result<Stored, ReadError> {
        let (points, valid) = match &document.storage {
            Storage::Text(text) => return from_text(text, document).map(Stored::Text),
            Storage::Binary { points, valid } => (points, valid),
        };
        let len = document.layout.len();
        let codings: Vec<_> = absolute(&document.axes).collect();
        let record_len = codings.iter().map(|(_, coding)| coding.len()).sum();
        // Within the limit of points, the product is small.
        let data = archive.binary(&points.name, len * record_len, points.md5.as_deref())?;
        let valid = match valid {
            None => None,
            Some(file) => Some(archive.binary(&file.name, len.div_ceil(8), file.md5.as_deref())?),
        };
        Ok(Stored::Binary { codings, record_len, data, valid })
    }

    /// x, y, z of a point as numbers, before increments; 0 on incremental axes, NaN in z where the
    /// point is missing.
    fn point(&self, index: usize) -> [f64; 3] {
        let (codings, record_len, data, valid) = match self {
            Stored::Text(points) => return points[index],
            Stored::Binary { codings, record_len, data, valid } => {
                (codings, *record_len, data, valid)
            }
        };
        let mut point = [0.0; 3];
        let mut rest = &data[index * record_len..][..record_len];
        for &(axis, coding) in codings {
            let (value, after) = rest.split_at(coding.len());
            point[axis] = decode(coding, value);
            rest = after;
        }
        let is_valid = valid.as_ref().is_none_or(|bits| bits[index / 8] >> (index % 8) & 1 == 1);
        if !(is_valid && point[0].is_finite() && point[1].is_finite()) {
            point[2] = f64::NAN;
        }
        point
    }
}

/// Number and coding of the absolute axes, in the order in which they are stored.
fn absolute(axes: &[Axis; 3]) -> impl Iterator<Item = (usize, DataType)> + '_ {
    axes.iter().enumerate().filter_map(|(index, axis)| Some((index, axis.stored?)))
}

fn decode(coding: DataType, bytes: &[u8]) -> f64 {
    fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
        *bytes.first_chunk().expect("a value is cut to the length of its coding")
    }
    match coding {
        DataType::I16 => i16::from_le_bytes(array(bytes)).into(),
        DataType::I32 => i32::from_le_bytes(array(bytes)).into(),
        DataType::F32 => f32::from_le_bytes(array(bytes)).into(),
        DataType::F64 => f64::from_le_bytes(array(bytes)),
    }
}

fn from_text(text: &str, document: &Document) -> Result<Vec<[f64; 3]>, ReadError> {
    const DATUM: &str = "Record3/DataList/Datum";
    let wanted = document.layout.len();
    let mut stored = Vec::new();
    for datum in text.lines() {
        let index = stored.len();
        if index == wanted {
            let expected = format!("{wanted} of them for the points declared");
            return Err(at(DATUM, &expected, "more"));
        }
        let bad = |expected: &str| {
            let found = quoted(datum.as_bytes());
            at(&format!("{DATUM}[{}]", index + 1), expected, found)
        };
        let mut point = [0.0, 0.0, f64::NAN];
        if !datum.is_empty() {
            let mut values = datum.split(';').map(str::trim);
            for (axis, coding) in absolute(&document.axes) {
                let value = values.next().ok_or_else(|| bad("a value for each absolute axis"))?;
                point[axis] = coded(coding, value).ok_or_else(|| {
                    bad(if coding.integers().is_some() {
                        "whole numbers that fit the DataType, separated by semicolons"
                    } else {
                        "numbers separated by semicolons"
                    })
                })?;
            }
            if values.next().is_some() {
                return Err(bad("no more values than absolute axes"));
            }
            if !(point[0].is_finite() && point[1].is_finite()) {
                point[2] = f64::NAN;
            }
        }
        stored.push(point);
    }
    if stored.len() < wanted {
        let expected = format!("{wanted} of them for the points declared");
        return Err(at(DATUM, &expected, stored.len()));
    }
    Ok(stored)
}

/// A value of a `Datum`: a number that its coding can hold, or NaN for a missing one.
fn coded(coding: DataType, text: &str) -> Option<f64> {
    match coding.integers() {
        Some((least, most)) => {
            let is_held = |value: &f64| value.fract() == 0.0 && (least..=most).contains(value);
            finite(text.as_bytes()).filter(is_held)
        }
        None if says_missing(text.as_bytes()) => Some(f64::NAN),
        None => finite(text.as_bytes()),
    }
}

fn height_map(nx: usize, ny: usize, axes: &[Axis; 3], stored: &Stored) -> HeightMap {
    let [x, y, z] = axes;
    let height = |index| {
        let z_mm = (stored.point(index)[2] * z.increment_m + z.offset_m) * MM_PER_M;
        if z_mm.is_finite() { z_mm } else { f64::NAN }
    };
    HeightMap {
        nx,
        ny,
        dx_mm: x.increment_m * MM_PER_M,
        dy_mm: y.increment_m * MM_PER_M,
        x0_mm: x.offset_m * MM_PER_M,
        y0_mm: y.offset_m * MM_PER_M,
        z_mm: (0..nx * ny).map(height).collect(),
    }
}

/// `global = R · (I · stored) + O` of every point, the stored value of an incremental axis being the
/// index of column or row, counted from 0.
fn cloud(document: &Document, stored: &Stored) -> Result<Cloud, ReadError> {
    let columns = match document.layout {
        Layout::Matrix { nx, .. } => nx,
        Layout::List { len } => len,
    };
    let mut cloud = Cloud::default();
    for index in 0..document.layout.len() {
        let point = stored.point(index);
        if !point[2].is_finite() {
            cloud.missing += 1;
            continue;
        }
        let indices = [(index % columns) as f64, (index / columns) as f64, 0.0];
        let mut view_m = [0.0; 3];
        for (axis, value) in view_m.iter_mut().enumerate() {
            let Axis { stored, increment_m, .. } = document.axes[axis];
            *value = increment_m * if stored.is_some() { point[axis] } else { indices[axis] };
        }
        let turned_m = match &document.rotation {
            None => view_m,
            Some(rows) => {
                rows.map(|row| row[0] * view_m[0] + row[1] * view_m[1] + row[2] * view_m[2])
            }
        };
        let mut point_mm = [0.0; 3];
        for (axis, value) in point_mm.iter_mut().enumerate() {
            *value = (turned_m[axis] + document.axes[axis].offset_m) * MM_PER_M;
        }
        if !point_mm.iter().all(|value| value.is_finite()) {
            return Err(ReadError::Malformed {
                format: Format::X3p,
                place: Place::Element("Record1/Axes".into()),
                expected: "increments and offsets that keep the points finite".into(),
                found: format!("{point_mm:?} at point {}", index + 1),
            });
        }
        cloud.points_mm.push(point_mm);
    }
    Ok(cloud)
}

const MM_PER_M: f64 = 1e3;

//! Writing X3P: the edition that most software reads, ISO 5436-2:2000, which ISO 25178-72:2017 took
//! over.
//!
//! Coordinates are stored as float64 in metres with the increment 1, because not every reader
//! multiplies by the increment of z. Division by 1000 and back may therefore change the last bit of
//! a value in mm. Missing heights are NaN, for which the standard needs no validity file.

use std::io::{Cursor, Write};

use quick_xml::escape::escape;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use super::archive::md5_hex;
use super::{CHECKSUM_FILE, MAIN_XML};
use crate::{HeightMap, WriteError};

/// `Record2` of an X3P file: where the data come from.
#[derive(Clone, Copy, Debug)]
pub struct Metadata<'a> {
    /// Date and time of the measurement as `xsd:dateTime`: `2026-01-31T12:00:00.0+01:00`.
    pub date: &'a str,
    /// Date and time of the last calibration of the instrument, in the same form.
    pub calibration_date: &'a str,
    /// Who measured.
    pub creator: Option<&'a str>,
    /// Maker of the instrument.
    pub manufacturer: &'a str,
    /// Model of the instrument.
    pub model: &'a str,
    /// Serial number of the instrument.
    pub serial: &'a str,
    /// Versions of hardware and software.
    pub version: &'a str,
    /// Kind of probe.
    pub probing: Probing,
    /// Which probe: lens, tip, settings.
    pub probe: &'a str,
    /// Free text.
    pub comment: Option<&'a str>,
}

/// How a surface was probed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Probing {
    /// By a tip.
    Contacting,
    /// By light or another field.
    NonContacting,
    /// Not at all: computed.
    Software,
}

/// Writes a height map as a surface (`SUR`) with incremental x and y. A height that is not finite is
/// missing. The same arguments give the same bytes.
///
/// # Errors
///
/// [`WriteError::Invalid`] where the map breaks the rules of [`HeightMap`] or a text of the metadata
/// cannot stand in the file; [`WriteError::Io`] where the destination fails.
///
/// # Example
///
/// ```
/// use asphera_formats::{HeightMap, x3p};
///
/// let map = HeightMap {
///     nx: 2, ny: 1, dx_mm: 0.5, dy_mm: 0.5, x0_mm: 0.0, y0_mm: 0.0, z_mm: vec![1.0, f64::NAN],
/// };
/// let metadata = x3p::Metadata {
///     date: "2026-01-31T12:00:00.0Z",
///     calibration_date: "2026-01-01T00:00:00.0Z",
///     creator: None,
///     manufacturer: "asphera",
///     model: "station",
///     serial: "1",
///     version: "0.1.0",
///     probing: x3p::Probing::NonContacting,
///     probe: "chromatic sensor",
///     comment: None,
/// };
/// let mut file = Vec::new();
/// x3p::write_map(&mut file, &map, &metadata)?;
/// assert_eq!(x3p::read(&file).unwrap().missing(), 1);
/// # Ok::<(), asphera_formats::WriteError>(())
/// ```
pub fn write_map(
    w: impl Write,
    map: &HeightMap,
    metadata: &Metadata<'_>,
) -> Result<(), WriteError> {
    write_turned_map(w, map, 0.0, metadata)
}

/// As [`write_map`], with x and y of the map turned about the origin by an angle from x towards y: the file has it as
/// `Rotation`. Read back, such a map is a [`crate::Cloud`].
///
/// # Errors
///
/// As [`write_map`], and where the angle is not finite.
pub fn write_turned_map(
    w: impl Write,
    map: &HeightMap,
    turn_rad: f64,
    metadata: &Metadata<'_>,
) -> Result<(), WriteError> {
    if !turn_rad.is_finite() {
        return Err(WriteError::invalid("turn_rad", "a finite angle", turn_rad));
    }
    let samples = map.nx.checked_mul(map.ny).filter(|&samples| samples > 0);
    if samples != Some(map.z_mm.len()) {
        let expected = format!("{} × {} heights, at least one", map.nx, map.ny);
        return Err(WriteError::invalid("height map", expected, map.z_mm.len()));
    }
    let axes = [("dx_mm", map.dx_mm, map.x0_mm), ("dy_mm", map.dy_mm, map.y0_mm)];
    for (name, increment_mm, offset_mm) in axes {
        let is_increment = increment_mm.is_finite() && increment_mm / MM_PER_M > 0.0;
        if !(is_increment && offset_mm.is_finite()) {
            let found = format!("{increment_mm} at offset {offset_mm}");
            return Err(WriteError::invalid(name, "a length above zero, a finite offset", found));
        }
    }
    let (sin, cos) = turn_rad.sin_cos();
    // Offsets are not turned.
    let [x0_mm, y0_mm] = [cos * map.x0_mm - sin * map.y0_mm, sin * map.x0_mm + cos * map.y0_mm];
    let axis = |increment_mm: f64, offset_mm: f64| {
        axis_xml("I", increment_mm / MM_PER_M, offset_mm / MM_PER_M)
    };
    let axes = [axis(map.dx_mm, x0_mm), axis(map.dy_mm, y0_mm), axis_xml("A", 1.0, 0.0)];
    let turned = if turn_rad == 0.0 { String::new() } else { rotation_xml(sin, cos) };
    let data: Vec<u8> = map
        .z_mm
        .iter()
        .map(|&z_mm| if z_mm.is_finite() { z_mm / MM_PER_M } else { f64::NAN })
        .flat_map(f64::to_le_bytes)
        .collect();
    let record1 = record1("SUR", &axes, &turned);
    let size = format!(
        "<MatrixDimension><SizeX>{}</SizeX><SizeY>{}</SizeY><SizeZ>1</SizeZ></MatrixDimension>",
        map.nx, map.ny
    );
    write_archive(w, &record1, metadata, &size, &data)
}

/// Writes points, x y z in mm, as a point cloud (`PCL`). The same arguments give the same bytes.
///
/// # Errors
///
/// [`WriteError::Invalid`] where there is no point, a coordinate is not finite, or a text of the
/// metadata cannot stand in the file; [`WriteError::Io`] where the destination fails.
pub fn write_cloud(
    w: impl Write,
    points_mm: &[[f64; 3]],
    metadata: &Metadata<'_>,
) -> Result<(), WriteError> {
    if points_mm.is_empty() {
        return Err(WriteError::invalid("point cloud", "at least one point", "none"));
    }
    if let Some(index) = points_mm.iter().position(|point| !point.iter().all(|v| v.is_finite())) {
        let found = format!("{:?}", points_mm[index]);
        return Err(WriteError::invalid(format!("point {index}"), "finite coordinates", found));
    }
    let data: Vec<u8> =
        points_mm.iter().flatten().flat_map(|mm| (mm / MM_PER_M).to_le_bytes()).collect();
    let axes = ["A"; 3].map(|axis_type| axis_xml(axis_type, 1.0, 0.0));
    let size = format!("<ListDimension>{}</ListDimension>", points_mm.len());
    write_archive(w, &record1("PCL", &axes, ""), metadata, &size, &data)
}

fn axis_xml(axis_type: &str, increment_m: f64, offset_m: f64) -> String {
    format!(
        "<AxisType>{axis_type}</AxisType><DataType>D</DataType>\
         <Increment>{increment_m:e}</Increment><Offset>{offset_m:e}</Offset>"
    )
}

/// A turn about z.
fn rotation_xml(sin: f64, cos: f64) -> String {
    format!(
        "<Rotation><r11>{cos:e}</r11><r12>{:e}</r12><r13>0</r13><r21>{sin:e}</r21><r22>{cos:e}</r22>\
         <r23>0</r23><r31>0</r31><r32>0</r32><r33>1</r33></Rotation>",
        -sin
    )
}

fn record1(feature: &str, [x, y, z]: &[String; 3], rotation: &str) -> String {
    format!(
        "<Record1><Revision>ISO5436 - 2000</Revision><FeatureType>{feature}</FeatureType>\
         <Axes><CX>{x}</CX><CY>{y}</CY><CZ>{z}</CZ>{rotation}</Axes></Record1>"
    )
}

fn record2(metadata: &Metadata<'_>) -> Result<String, WriteError> {
    let optional = |name: &str, text: Option<&str>| match text {
        None => Ok(String::new()),
        Some(text) => Ok(format!("<{name}>{}</{name}>", plain(name, text)?)),
    };
    let probing = match metadata.probing {
        Probing::Contacting => "Contacting",
        Probing::NonContacting => "NonContacting",
        Probing::Software => "Software",
    };
    Ok(format!(
        "<Record2><Date>{}</Date>{}<Instrument><Manufacturer>{}</Manufacturer><Model>{}</Model>\
         <Serial>{}</Serial><Version>{}</Version></Instrument>\
         <CalibrationDate>{}</CalibrationDate><ProbingSystem><Type>{probing}</Type>\
         <Identification>{}</Identification></ProbingSystem>{}</Record2>",
        date("Date", metadata.date)?,
        optional("Creator", metadata.creator)?,
        plain("Manufacturer", metadata.manufacturer)?,
        plain("Model", metadata.model)?,
        plain("Serial", metadata.serial)?,
        plain("Version", metadata.version)?,
        date("CalibrationDate", metadata.calibration_date)?,
        plain("Identification", metadata.probe)?,
        optional("Comment", metadata.comment)?,
    ))
}

/// A text as XML, refused where XML 1.0 has no way to write it.
fn plain(name: &str, text: &str) -> Result<String, WriteError> {
    let is_allowed = |letter: char| matches!(letter, '\t' | '\n' | ' '..='\u{D7FF}' | '\u{E000}'..='\u{FFFD}' | '\u{10000}'..);
    match text.chars().find(|&letter| !is_allowed(letter)) {
        None => Ok(escape(text).into_owned()),
        Some(letter) => {
            Err(WriteError::invalid(name, "text without control characters", letter.escape_debug()))
        }
    }
}

/// A text of the form `YYYY-MM-DDThh:mm:ss`, with or without decimals and time zone.
fn date<'a>(name: &str, text: &'a str) -> Result<&'a str, WriteError> {
    let invalid =
        || WriteError::invalid(name, "a date as 2026-01-31T12:00:00.0+01:00", text.escape_debug());
    let matches = |pattern: &[u8], text: &[u8]| {
        pattern.len() == text.len()
            && pattern.iter().zip(text).all(|(&wanted, &byte)| match wanted {
                b'0' => byte.is_ascii_digit(),
                b'+' => matches!(byte, b'+' | b'-'),
                _ => byte == wanted,
            })
    };
    let (start, rest) = text.as_bytes().split_at_checked(19).ok_or_else(invalid)?;
    let zone_start = rest.iter().position(|byte| matches!(byte, b'Z' | b'+' | b'-'));
    let (decimals, zone) = rest.split_at(zone_start.unwrap_or(rest.len()));
    let decimals_fit = decimals.is_empty()
        || (decimals.len() > 1
            && decimals[0] == b'.'
            && decimals[1..].iter().all(u8::is_ascii_digit));
    let zone_fits = matches!(zone, b"" | b"Z") || matches(b"+00:00", zone);
    if matches(b"0000-00-00T00:00:00", start) && decimals_fit && zone_fits {
        Ok(text)
    } else {
        Err(invalid())
    }
}

fn write_archive(
    mut w: impl Write,
    record1: &str,
    metadata: &Metadata<'_>,
    size: &str,
    data: &[u8],
) -> Result<(), WriteError> {
    let main = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <p:ISO5436_2 xmlns:p=\"{NAMESPACE}\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"{NAMESPACE} {NAMESPACE}/ISO5436_2.xsd\">{record1}{}\
         <Record3>{size}<DataLink><PointDataLink>{DATA_FILE}</PointDataLink>\
         <MD5ChecksumPointData>{}</MD5ChecksumPointData></DataLink></Record3>\
         <Record4><ChecksumFile>{CHECKSUM_FILE}</ChecksumFile></Record4></p:ISO5436_2>\n",
        record2(metadata)?,
        md5_hex(data),
    );
    let checksum = format!("{} *{MAIN_XML}\n", md5_hex(main.as_bytes()));
    let archive = zipped(&[
        (MAIN_XML, main.as_bytes()),
        (CHECKSUM_FILE, checksum.as_bytes()),
        (DATA_FILE, data),
    ])
    .map_err(|source| WriteError::Io { what: "X3P archive", source })?;
    w.write_all(&archive)
        .and_then(|()| w.flush())
        .map_err(|source| WriteError::Io { what: "X3P file", source })
}

/// A zip archive that depends on nothing but its entries: no clock, no operating system.
fn zipped(entries: &[(&str, &[u8])]) -> std::io::Result<Vec<u8>> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .compression_level(Some(6))
        .last_modified_time(DateTime::default())
        .system(System::Unix)
        .unix_permissions(0o644);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries {
        // From 4 GiB on, sizes need the fields of ZIP64.
        let large = content.len() as u64 > u64::from(u32::MAX);
        zip.start_file(*name, options.large_file(large))?;
        zip.write_all(content)?;
    }
    Ok(zip.finish()?.into_inner())
}

const NAMESPACE: &str = "http://www.opengps.eu/2008/ISO5436_2";
const DATA_FILE: &str = "bindata/data.bin";
const MM_PER_M: f64 = 1e3;

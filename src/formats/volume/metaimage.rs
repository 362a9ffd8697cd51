//! MetaImage of ITK: lines `Key = value`, the last of them names the samples.
//!
//! Source: MetaIO documentation, <https://itk.org/Wiki/MetaIO/Documentation>. Lengths have no unit; mm is the custom.

use super::element::Element;
use super::header::{Entry, Header, has_key, lines_with_ends};
use super::unpack::{Packing, exactly, unpacked};
use super::{Beside, Frame, UnitKnown, Volume, sample_count};
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::MetaImage;

pub(super) fn is_metaimage(bytes: &[u8]) -> bool {
    has_key(bytes, "NDims", '=') && has_key(bytes, "DimSize", '=')
}

pub(super) fn read(bytes: &[u8], beside: Beside<'_>) -> Result<Volume, ReadError> {
    let mut header = Header { format: FORMAT, entries: Vec::new() };
    let mut start = bytes.len();
    for (line, text, end) in lines_with_ends(bytes) {
        let Some((key, value)) = text.split_once('=') else {
            return Err(ReadError::Malformed {
                format: FORMAT,
                place: Place::Line { line, column: 0 },
                expected: "a line Key = value".into(),
                found: crate::error::quoted(text.as_bytes()),
            });
        };
        let key = key.trim().to_owned();
        let is_last = key == "ElementDataFile";
        header.entries.push(Entry { key, value: value.trim().into(), line });
        if is_last {
            start = end;
            break;
        }
    }
    let dims = header.require(&["NDims"])?;
    if dims.value != "3" {
        return Err(header.unsupported(dims, "3 dimensions"));
    }
    if let Some(entry) = header.find(&["ElementNumberOfChannels"])
        && entry.value != "1"
    {
        return Err(header.unsupported(entry, "one number a sample"));
    }
    let sizes = header.require(&["DimSize"])?;
    let size: [u64; 3] = header.wholes(sizes)?;
    let count = sample_count(FORMAT, Place::Line { line: sizes.line, column: 0 }, size)?;
    let element = element(&header)?;
    let expected = count * element.bytes();
    let frame = frame(&header)?;
    let source = header.require(&["ElementDataFile"])?;
    let elsewhere;
    let (data, place) = if source.value.eq_ignore_ascii_case("LOCAL") {
        (&bytes[start..], start as u64)
    } else if source.value.starts_with("LIST") || source.value.contains('%') {
        return Err(header.unsupported(source, "LOCAL or the name of one file"));
    } else {
        let file = source.value.rsplit(['/', '\\']).next().unwrap_or_default();
        elsewhere = beside(file).map_err(|why| ReadError::Malformed {
            format: FORMAT,
            place: Place::Line { line: source.line, column: 0 },
            expected: "the file with the samples beside the header".into(),
            found: why,
        })?;
        (&elsewhere[..], 0)
    };
    let bytes = if header.flag(&["CompressedData"])? {
        unpacked(FORMAT, place, data, Packing::Zlib, expected as u64)?
    } else {
        let skip = match header.find(&["HeaderSize"]) {
            None => 0,
            Some(entry) if entry.value == "-1" => data.len().saturating_sub(expected),
            Some(entry) => usize::try_from(header.wholes::<1>(entry)?[0]).unwrap_or(usize::MAX),
        };
        let data = data.get(skip..).unwrap_or_default();
        data[..data.len().min(expected)].to_vec()
    };
    let bytes = exactly(FORMAT, place, bytes, expected)?;
    let is_big = header.flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"])?;
    let values = element.decoded(bytes, is_big);
    Ok(Volume { size: size.map(|side| side as usize), values, frame, format: FORMAT })
}

fn element(header: &Header) -> Result<Element, ReadError> {
    let entry = header.require(&["ElementType"])?;
    Ok(match entry.value.as_str() {
        "MET_CHAR" => Element::I8,
        "MET_UCHAR" => Element::U8,
        "MET_SHORT" => Element::I16,
        "MET_USHORT" => Element::U16,
        "MET_INT" => Element::I32,
        "MET_UINT" => Element::U32,
        "MET_LONG_LONG" => Element::I64,
        "MET_ULONG_LONG" => Element::U64,
        "MET_FLOAT" => Element::F32,
        "MET_DOUBLE" => Element::F64,
        _ => return Err(header.unsupported(entry, "MET_UCHAR, MET_SHORT, MET_FLOAT or the like")),
    })
}

fn frame(header: &Header) -> Result<Frame, ReadError> {
    let spacing = header.find(&["ElementSpacing", "ElementSize"]);
    let (spacing_mm, unit, line) = match spacing {
        Some(entry) => (header.numbers::<3>(entry)?, UnitKnown::Assumed, entry.line),
        None => ([1.0; 3], UnitKnown::Missing, 1),
    };
    let mut frame = Frame::aligned(spacing_mm, unit);
    if let Some(entry) = header.find(&["TransformMatrix", "Orientation", "Rotation"]) {
        let turn: [f64; 9] = header.numbers(entry)?;
        for axis in 0..3 {
            frame.steps_mm[axis] = [0, 1, 2].map(|at| turn[3 * axis + at] * spacing_mm[axis]);
        }
    }
    if let Some(entry) = header.find(&["Offset", "Position", "Origin"]) {
        frame.origin_mm = header.numbers(entry)?;
    }
    frame.checked(FORMAT, Place::Line { line, column: 0 })
}

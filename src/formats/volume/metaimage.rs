//! MetaImage of ITK: lines `Key = value`, the last of them names the samples.
//!
//! Source: MetaIO documentation, <https://itk.org/Wiki/MetaIO/Documentation>. Lengths have no unit; mm is the custom.

use super::element::Element;
use super::header::{Entry, Header, has_key, lines_with_ends};
use super::layout::{Layout, SamplesIn, Skip};
use super::unpack::Packing;
use super::{Frame, UnitKnown};
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::MetaImage;

pub(super) fn is_metaimage(bytes: &[u8]) -> bool {
    has_key(bytes, "NDims", '=') && has_key(bytes, "DimSize", '=')
}

pub(super) fn layout(bytes: &[u8]) -> Result<Layout, ReadError> {
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
    let source = header.require(&["ElementDataFile"])?;
    let file = if source.value.eq_ignore_ascii_case("LOCAL") {
        SamplesIn::Own
    } else if source.value.starts_with("LIST") || source.value.contains('%') {
        return Err(header.unsupported(source, "LOCAL or the name of one file"));
    } else {
        let file = source.value.rsplit(['/', '\\']).next().unwrap_or_default();
        SamplesIn::Beside(file.to_owned(), Place::Line { line: source.line, column: 0 })
    };
    let mut layout = Layout {
        format: FORMAT,
        size,
        size_at: Place::Line { line: sizes.line, column: 0 },
        element: element(&header)?,
        is_big: header.flag(&["BinaryDataByteOrderMSB", "ElementByteOrderMSB"])?,
        frame: frame(&header)?,
        start: if file == SamplesIn::Own { start as u64 } else { 0 },
        file,
        packing: None,
        skip_lines: 0,
        skip: Skip::Bytes(0),
        is_all: false,
    };
    if header.flag(&["CompressedData"])? {
        layout.packing = Some(Packing::Zlib);
    } else if let Some(entry) = header.find(&["HeaderSize"]) {
        layout.skip = if entry.value == "-1" {
            Skip::AllBefore
        } else {
            Skip::Bytes(header.wholes::<1>(entry)?[0])
        };
    }
    Ok(layout)
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

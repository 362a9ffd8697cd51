//! `.vol` of DGtal and the tools about it: lines `Key: value`, a line with a dot, then one byte a sample.
//!
//! Source: DGtal 2.x, `io/readers/VolReader.h`: version 2 holds the bytes as they are, version 3 packs them by zlib. There is no unit of
//! length.

use super::element::Element;
use super::header::{Entry, Header, has_key, lines_with_ends};
use super::layout::{Layout, SamplesIn, Skip};
use super::unpack::Packing;
use super::{Frame, UnitKnown};
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Vol;

pub(super) fn is_vol(bytes: &[u8]) -> bool {
    ["X", "Y", "Z"].iter().all(|key| has_key(bytes, key, ':'))
        && lines_with_ends(bytes).any(|(_, line, _)| line == ".")
}

pub(super) fn layout(bytes: &[u8]) -> Result<Layout, ReadError> {
    let mut header = Header { format: FORMAT, entries: Vec::new() };
    let mut start = None;
    for (line, text, end) in lines_with_ends(bytes) {
        if text == "." {
            start = Some(end);
            break;
        }
        let Some((key, value)) = text.split_once(':') else {
            return Err(ReadError::Malformed {
                format: FORMAT,
                place: Place::Line { line, column: 0 },
                expected: "a line Key: value, or a dot at the end of the header".into(),
                found: crate::error::quoted(text.as_bytes()),
            });
        };
        header.entries.push(Entry { key: key.trim().into(), value: value.trim().into(), line });
    }
    let start = start.ok_or_else(|| ReadError::Malformed {
        format: FORMAT,
        place: Place::Byte(0),
        expected: "a line with a dot at the end of the header".into(),
        found: "none".into(),
    })?;
    let mut size = [0; 3];
    for (side, key) in size.iter_mut().zip(["X", "Y", "Z"]) {
        [*side] = header.wholes(header.require(&[key])?)?;
    }
    let size_at = Place::Line { line: header.require(&["X"])?.line, column: 0 };
    let packing = match header.find(&["Version"]) {
        None => None,
        Some(entry) => match entry.value.as_str() {
            "1" | "2" => None,
            "3" => Some(Packing::Zlib),
            _ => return Err(header.unsupported(entry, "version 2 or 3")),
        },
    };
    Ok(Layout {
        format: FORMAT,
        size,
        size_at,
        element: Element::U8,
        is_big: false,
        frame: Frame::aligned([1.0; 3], UnitKnown::Missing),
        file: SamplesIn::Own,
        start: start as u64,
        packing,
        skip_lines: 0,
        skip: Skip::Bytes(0),
        is_all: false,
    })
}

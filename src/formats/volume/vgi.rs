//! `.vgi` of Volume Graphics and Nikon: sections of lines `key = value` that say what the raw samples beside it are.
//!
//! Sources: headers as VGStudio and Nikon write them. `[file1]` says what the file holds, and `[representation]` may say another type.
//! `[geometry]` gives the spacing. Samples are little-endian, x fastest. The pose of the part in a scene is left out.

use super::element::Element;
use super::header::{Entry, Header, lines_with_ends};
use super::{Beside, Frame, UnitKnown, Volume, sample_count};
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Vgi;

pub(super) fn is_vgi(bytes: &[u8]) -> bool {
    let mut lines = lines_with_ends(bytes).map(|(_, line, _)| line.trim().to_ascii_lowercase());
    let starts = lines.by_ref().find(|line| !line.is_empty());
    starts.is_some_and(|line| line.starts_with('{') && line.ends_with('}'))
        && lines.any(|line| line == "[file1]")
}

/// Reads the samples that a header describes; `samples` are those, where the caller has them already.
pub(super) fn read(
    bytes: &[u8],
    samples: Option<&[u8]>,
    beside: Beside<'_>,
) -> Result<Volume, ReadError> {
    let header = parsed(bytes)?;
    let sizes = header.require(&["file1.size"])?;
    let size: [u64; 3] = header.wholes(sizes)?;
    let count = sample_count(FORMAT, Place::Line { line: sizes.line, column: 0 }, size)?;
    if let Some(entry) = header.find(&["file1.fileformat"])
        && !entry.value.eq_ignore_ascii_case("raw")
    {
        return Err(header.unsupported(entry, "raw samples"));
    }
    if let Some(entry) = header.find(&["file1.mirror"])
        && header.wholes::<3>(entry)? != [0; 3]
    {
        return Err(header.unsupported(entry, "Mirror = 0 0 0"));
    }
    if let Some(entry) = header.find(&["file2.name", "file2.size"]) {
        return Err(header.unsupported(entry, "one file with the samples"));
    }
    let element = element(&header)?;
    let frame = frame(&header)?;
    let skip = match header.find(&["file1.skipheader"]) {
        Some(entry) => header.wholes::<1>(entry)?[0],
        None => 0,
    };
    let fetched;
    let samples = match samples {
        Some(samples) => samples,
        None => {
            let entry = header.require(&["file1.name"])?;
            if !super::is_beside(&entry.value) {
                return Err(header.malformed(
                    entry,
                    "the name of a file in this folder, without a path (or give the file with the samples itself)",
                ));
            }
            fetched = beside(&entry.value).map_err(|why| ReadError::Malformed {
                format: FORMAT,
                place: Place::Line { line: entry.line, column: 0 },
                expected: "the file with the samples beside the header".into(),
                found: why,
            })?;
            &fetched[..]
        }
    };
    let expected = skip.saturating_add((count * element.bytes()) as u64);
    if samples.len() as u64 != expected {
        return Err(header.malformed(
            sizes,
            format!("a size that fits the {} bytes of the file with the samples; this one needs {expected}", samples.len()),
        ));
    }
    let values = element.decoded(samples[skip as usize..].to_vec(), false);
    Ok(Volume { size: size.map(|side| side as usize), values, frame, format: FORMAT })
}

/// Entries with keys `section.key`, in small letters.
fn parsed(bytes: &[u8]) -> Result<Header, ReadError> {
    let mut header = Header { format: FORMAT, entries: Vec::new() };
    let (mut section, mut volumes) = (String::new(), 0);
    for (line, text, _) in lines_with_ends(bytes) {
        let text = text.trim();
        let name = text.to_ascii_lowercase();
        if let Some(inner) = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')) {
            section = inner.trim().to_owned();
            volumes += usize::from(section == "file1");
        } else if let Some((key, value)) = text.split_once('=') {
            let key = format!("{section}.{}", key.trim().to_ascii_lowercase());
            header.entries.push(Entry { key, value: value.trim().into(), line });
        }
    }
    if volumes == 1 {
        return Ok(header);
    }
    Err(ReadError::Unsupported {
        format: FORMAT,
        place: Place::Line { line: 1, column: 0 },
        expected: "one volume, with one section [file1]".into(),
        found: format!("{volumes}"),
    })
}

fn element(header: &Header) -> Result<Element, ReadError> {
    let kind = header.require(&["file1.datatype"])?;
    let bits = header.require(&["file1.bitsperelement"])?;
    Ok(match (kind.value.to_ascii_lowercase().as_str(), header.wholes::<1>(bits)?[0]) {
        ("unsigned integer", 8) => Element::U8,
        ("unsigned integer", 16) => Element::U16,
        ("unsigned integer", 32) => Element::U32,
        ("signed integer" | "integer", 8) => Element::I8,
        ("signed integer" | "integer", 16) => Element::I16,
        ("signed integer" | "integer", 32) => Element::I32,
        ("float", 32) => Element::F32,
        ("unsigned integer" | "signed integer" | "integer" | "float", _) => {
            return Err(header.unsupported(bits, "8, 16 or 32 bits, of a float 32"));
        }
        _ => return Err(header.unsupported(kind, "unsigned integer, signed integer or float")),
    })
}

fn frame(header: &Header) -> Result<Frame, ReadError> {
    let Some(entry) = header.find(&["geometry.resolution"]) else {
        return Ok(Frame::aligned([1.0; 3], UnitKnown::Missing));
    };
    let (scale, unit) = match header.find(&["geometry.unit"]) {
        None => (1.0, UnitKnown::Assumed),
        Some(unit) => match unit.value.to_ascii_lowercase().as_str() {
            "mm" => (1.0, UnitKnown::Stated),
            "um" | "µm" => (1e-3, UnitKnown::Stated),
            "nm" => (1e-6, UnitKnown::Stated),
            "cm" => (10.0, UnitKnown::Stated),
            "m" => (1000.0, UnitKnown::Stated),
            _ => return Err(header.unsupported(unit, "mm, um, nm, cm or m")),
        },
    };
    let spacing: [f64; 3] = header.numbers(entry)?;
    Frame::aligned(spacing.map(|side| side * scale), unit)
        .checked(FORMAT, Place::Line { line: entry.line, column: 0 })
}

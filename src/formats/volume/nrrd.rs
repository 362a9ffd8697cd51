//! NRRD, the nearly raw raster data of teem.
//!
//! Source: Definition of NRRD file format, <https://teem.sourceforge.net/nrrd/format.html>: fields `name: value` up to an empty line,
//! then the samples, or a field that names the file with them.

use super::element::Element;
use super::header::{Entry, Header, MAX_HEADER, lines_with_ends};
use super::layout::{Layout, SamplesIn, Skip};
use super::unpack::Packing;
use super::{Beside, Frame, MAX_SAMPLES, UnitKnown, Values, Volume};
use crate::scan::says_missing;
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Nrrd;

pub(super) fn is_nrrd(bytes: &[u8]) -> bool {
    bytes.starts_with(b"NRRD000")
}

pub(super) fn read(bytes: &[u8], beside: Beside<'_>) -> Result<Volume, ReadError> {
    let (header, attached) = header(bytes)?;
    let layout = layout_of(&header, attached, bytes.len())?;
    if !is_text(&header)? {
        return layout.volume(bytes, beside);
    }
    let count = layout.count(MAX_SAMPLES)? as usize;
    let elsewhere;
    let text = match &layout.file {
        SamplesIn::Own => bytes,
        SamplesIn::Beside(name, place) => {
            elsewhere = beside(name).map_err(|why| layout.no_file(place, why))?;
            &elsewhere[..]
        }
    };
    let text = layout.behind_lines(text);
    let skip = match layout.skip {
        Skip::Bytes(skip) => usize::try_from(skip).unwrap_or(usize::MAX),
        Skip::AllBefore => 0,
    };
    let last_line = header.entries.last().map_or(1, |last| last.line);
    let values = text_samples(text.get(skip..).unwrap_or_default(), count, last_line)?;
    let size = layout.size.map(|side| side as usize);
    Ok(Volume { size, values, frame: layout.frame, format: FORMAT })
}

/// What the header says; `None` of samples as text.
pub(super) fn layout(bytes: &[u8]) -> Result<Option<Layout>, ReadError> {
    let (header, attached) = header(bytes)?;
    let layout = layout_of(&header, attached, bytes.len())?;
    Ok((!is_text(&header)?).then_some(layout))
}

fn layout_of(header: &Header, attached: Option<usize>, end: usize) -> Result<Layout, ReadError> {
    let dimension = header.require(&["dimension"])?;
    if dimension.value != "3" {
        return Err(header.unsupported(dimension, "3 dimensions of one number each"));
    }
    let sizes = header.require(&["sizes"])?;
    let size_at = Place::Line { line: sizes.line, column: 0 };
    let (file, start) = match (header.find(&["data file", "datafile"]), attached) {
        (None, Some(start)) => (SamplesIn::Own, start),
        (None, None) => {
            return Err(ReadError::Malformed {
                format: FORMAT,
                place: Place::Byte(end as u64),
                expected: "an empty line and samples, or a field data file".into(),
                found: "neither".into(),
            });
        }
        (Some(entry), _) => {
            if entry.value.starts_with("LIST") || entry.value.contains('%') {
                return Err(header.unsupported(entry, "the name of one file"));
            }
            let file = entry.value.rsplit(['/', '\\']).next().unwrap_or_default();
            (SamplesIn::Beside(file.into(), Place::Line { line: entry.line, column: 0 }), 0)
        }
    };
    let element = element(header)?;
    let [skip_lines] =
        header.find(&["line skip", "lineskip"]).map_or(Ok([0]), |entry| header.wholes(entry))?;
    let skip = match header.find(&["byte skip", "byteskip"]) {
        None => Skip::Bytes(0),
        Some(entry) if entry.value == "-1" => Skip::AllBefore,
        Some(entry) => Skip::Bytes(header.wholes::<1>(entry)?[0]),
    };
    let encoding = header.require(&["encoding"])?;
    let packing = match encoding.value.to_ascii_lowercase().as_str() {
        "gzip" | "gz" if skip == Skip::AllBefore => {
            return Err(header.unsupported(encoding, "raw samples where byte skip is -1"));
        }
        "gzip" | "gz" => Some(Packing::Gzip),
        _ => None,
    };
    let is_big = match header.find(&["endian"]) {
        _ if element.bytes() == 1 || is_text(header)? => false,
        Some(entry) => match entry.value.as_str() {
            "little" => false,
            "big" => true,
            _ => return Err(header.malformed(entry, "little or big")),
        },
        None => {
            header.require(&["endian"])?;
            false
        }
    };
    Ok(Layout {
        format: FORMAT,
        size: header.wholes(sizes)?,
        size_at,
        element,
        is_big,
        frame: frame(header)?,
        file,
        start: start as u64,
        packing,
        skip_lines,
        skip,
        is_all: false,
    })
}

/// Whether the samples are written as text.
fn is_text(header: &Header) -> Result<bool, ReadError> {
    let encoding = header.require(&["encoding"])?;
    match encoding.value.to_ascii_lowercase().as_str() {
        "ascii" | "text" | "txt" => Ok(true),
        "raw" | "gzip" | "gz" => Ok(false),
        _ => Err(header.unsupported(encoding, "raw, gzip or ascii")),
    }
}

/// The fields, and where what follows the empty line begins.
fn header(bytes: &[u8]) -> Result<(Header, Option<usize>), ReadError> {
    let mut header = Header { format: FORMAT, entries: Vec::new() };
    for (line, text, end) in lines_with_ends(bytes) {
        if line == 1 || text.starts_with('#') {
            continue;
        }
        if text.is_empty() {
            return Ok((header, Some(end)));
        }
        // `key:=value` are the user's own pairs.
        if text.contains(":=") {
            continue;
        }
        let Some((key, value)) = text.split_once(':') else {
            return Err(ReadError::Malformed {
                format: FORMAT,
                place: Place::Line { line, column: 0 },
                expected: "a field name: value, or an empty line at the end of the header".into(),
                found: crate::error::quoted(text.as_bytes()),
            });
        };
        let key = key.trim().to_ascii_lowercase();
        header.entries.push(Entry { key, value: value.trim().into(), line });
    }
    if bytes.len() > MAX_HEADER {
        return Err(ReadError::TooLarge {
            format: FORMAT,
            place: Place::Byte(0),
            unit: "bytes of header",
            limit: MAX_HEADER as u64,
            found: bytes.len() as u64,
        });
    }
    Ok((header, None))
}

fn element(header: &Header) -> Result<Element, ReadError> {
    let entry = header.require(&["type"])?;
    Ok(match entry.value.as_str() {
        "signed char" | "int8" | "int8_t" => Element::I8,
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => Element::U8,
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => {
            Element::I16
        }
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => Element::U16,
        "int" | "signed int" | "int32" | "int32_t" => Element::I32,
        "uint" | "unsigned int" | "uint32" | "uint32_t" => Element::U32,
        "longlong"
        | "long long"
        | "long long int"
        | "signed long long"
        | "signed long long int"
        | "int64"
        | "int64_t" => Element::I64,
        "ulonglong" | "unsigned long long" | "unsigned long long int" | "uint64" | "uint64_t" => {
            Element::U64
        }
        "float" => Element::F32,
        "double" => Element::F64,
        _ => return Err(header.unsupported(entry, "a type of whole numbers, float or double")),
    })
}

fn frame(header: &Header) -> Result<Frame, ReadError> {
    let units = header.find(&["space units", "units"]);
    let scale = match units {
        None => None,
        Some(entry) => {
            let names: Vec<&str> =
                entry.value.split(['"', ' ']).filter(|name| !name.is_empty()).collect();
            let first = names.first().copied().unwrap_or_default();
            if names.iter().any(|name| *name != first) {
                return Err(header.unsupported(entry, "one unit for all axes"));
            }
            match first {
                "mm" | "millimeter" | "millimeters" | "millimetre" => Some(1.0),
                "um" | "µm" | "micron" | "microns" | "micrometer" => Some(1e-3),
                "nm" | "nanometer" => Some(1e-6),
                "cm" | "centimeter" => Some(10.0),
                "m" | "meter" => Some(1000.0),
                _ => return Err(header.unsupported(entry, "mm, um, nm, cm or m")),
            }
        }
    };
    let unit = if scale.is_some() { UnitKnown::Stated } else { UnitKnown::Assumed };
    let scale = scale.unwrap_or(1.0);
    let frame = if let Some(entry) = header.find(&["space directions"]) {
        let numbers: [f64; 9] = header.numbers(entry)?;
        let mut frame = Frame::aligned([1.0; 3], unit);
        for (axis, step) in numbers.chunks_exact(3).enumerate() {
            frame.steps_mm[axis] = [0, 1, 2].map(|at| step[at] * scale);
        }
        if let Some(entry) = header.find(&["space origin"]) {
            frame.origin_mm = header.numbers::<3>(entry)?.map(|at| at * scale);
        }
        frame
    } else if let Some(entry) = header.find(&["spacings"]) {
        Frame::aligned(spacings(header, entry)?.map(|step| step * scale), unit)
    } else {
        Frame::aligned([1.0; 3], UnitKnown::Missing)
    };
    let line = header.find(&["space directions", "spacings"]).map_or(1, |entry| entry.line);
    frame.checked(FORMAT, Place::Line { line, column: 0 })
}

/// Three spacings, each above 0. NaN stands for one that is not known.
fn spacings(header: &Header, entry: &Entry) -> Result<[f64; 3], ReadError> {
    let known = header.numbers::<3>(entry).ok();
    known.filter(|spacings| spacings.iter().all(|step| *step > 0.0)).ok_or_else(|| {
        header.malformed(
            entry,
            "spacings: 3 numbers above 0; leave the line out where they are not known, and state flipped axes by space directions",
        )
    })
}

/// Samples as text, parted by anything that is no number.
fn text_samples(bytes: &[u8], count: usize, header_lines: usize) -> Result<Values, ReadError> {
    let mut values = Vec::new();
    let place = |line: usize| Place::Line { line: header_lines + 1 + line, column: 0 };
    // How many there are too many, and where the first of them is.
    let (mut more, mut at) = (0, 1);
    for (number, line) in crate::scan::lines(bytes) {
        for word in line.split(|byte| byte.is_ascii_whitespace() || *byte == b',') {
            if word.is_empty() {
                continue;
            }
            if values.len() == count {
                more += 1;
                at = if more == 1 { number } else { at };
                continue;
            }
            let value = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f32>().ok());
            let value = if says_missing(word) { Some(f32::NAN) } else { value };
            values.push(value.ok_or_else(|| ReadError::Malformed {
                format: FORMAT,
                place: place(number),
                expected: "numbers".into(),
                found: crate::error::quoted(word),
            })?);
        }
    }
    if values.len() == count && more == 0 {
        return Ok(Values::Floats(values));
    }
    let cure = if more > 0 { ": the sizes in the header may be wrong" } else { "" };
    Err(ReadError::Malformed {
        format: FORMAT,
        place: place(at),
        expected: format!("{count} samples"),
        found: format!("{}{cure}", values.len() + more),
    })
}

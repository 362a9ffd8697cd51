//! `.vti` of VTK: an image as XML, its samples in text, base64 or raw behind the XML.
//!
//! Source: VTK File Formats, "XML File Formats", ImageData; `vtkXMLImageDataReader`, `vtkXMLDataReader`. One piece, one number a sample.
//! Samples lie at the points. Where only cells have numbers, the samples are the middles of the cells. There is no unit of length; mm is
//! assumed.

mod blocks;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use self::blocks::{Coding, Packed};
use super::element::Element;
use super::{Frame, UnitKnown, Values, Volume, sample_count};
use crate::error::quoted;
use crate::scan::says_missing;
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Vti;

/// Whether the file begins as an image of VTK.
pub(super) fn is_vti(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(4096)];
    let find = |text: &[u8]| start.windows(text.len()).any(|part| part == text);
    start.trim_ascii_start().starts_with(b"<") && find(b"<VTKFile") && find(b"ImageData")
}

/// Attributes of an element.
#[derive(Clone, Debug)]
struct Tag {
    name: String,
    attributes: Vec<(String, String)>,
    /// Where its content begins.
    content: usize,
}

impl Tag {
    fn get(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }

    fn place(&self) -> Place {
        Place::Element(self.name.clone())
    }

    fn malformed(&self, key: &str, expected: &str) -> ReadError {
        malformed(
            self.place(),
            format!("{key}: {expected}"),
            self.get(key).map_or("none".into(), |value| quoted(value.as_bytes())),
        )
    }

    fn unsupported(&self, key: &str, expected: &str) -> ReadError {
        ReadError::Unsupported {
            format: FORMAT,
            place: self.place(),
            expected: format!("{key}: {expected}"),
            found: self.get(key).map_or("none".into(), |value| quoted(value.as_bytes())),
        }
    }

    fn numbers<const N: usize>(&self, key: &str, default: [f64; N]) -> Result<[f64; N], ReadError> {
        let Some(text) = self.get(key) else { return Ok(default) };
        let numbers: Option<Vec<f64>> =
            text.split_whitespace().map(|word| crate::scan::finite(word.as_bytes())).collect();
        numbers
            .and_then(|numbers| numbers.try_into().ok())
            .ok_or_else(|| self.malformed(key, &format!("{N} numbers")))
    }
}

/// Elements that matter.
#[derive(Debug, Default)]
struct Parts {
    file: Option<Tag>,
    image: Option<Tag>,
    pieces: Vec<Tag>,
    /// `PointData` and `CellData`, each with its arrays.
    groups: Vec<(Tag, Vec<Tag>)>,
    appended: Option<Tag>,
}

pub(super) fn read(bytes: &[u8]) -> Result<Volume, ReadError> {
    let parts = Parts::of(bytes)?;
    let absent =
        |name: &str| malformed(Place::Byte(0), format!("an element {name}"), "none".into());
    let file = parts.file.as_ref().ok_or_else(|| absent("VTKFile"))?;
    let image = parts.image.as_ref().ok_or_else(|| absent("ImageData"))?;
    let [piece] = &parts.pieces[..] else {
        return Err(ReadError::Unsupported {
            format: FORMAT,
            place: image.place(),
            expected: "one piece".into(),
            found: parts.pieces.len().to_string(),
        });
    };
    let whole = extent(image, "WholeExtent")?;
    if extent(piece, "Extent")? != whole {
        return Err(piece.unsupported("Extent", "that of the whole image"));
    }
    let (array, is_cells) = parts.samples()?;
    let points = [0, 1, 2].map(|axis| (whole[2 * axis + 1] - whole[2 * axis]) as u64 + 1);
    let size = if is_cells { points.map(|side| side - 1) } else { points };
    let count = sample_count(FORMAT, image.place(), size)?;
    let frame = frame(image, &whole, is_cells)?;
    let values = values(file, array, parts.appended.as_ref(), bytes, count)?;
    Ok(Volume { size: size.map(|side| side as usize), values, frame, format: FORMAT })
}

impl Parts {
    /// Walks the XML up to the appended samples, which may be no XML.
    fn of(bytes: &[u8]) -> Result<Parts, ReadError> {
        let mut parts = Parts::default();
        let mut reader = Reader::from_reader(bytes);
        let mut depth = 0_usize;
        loop {
            let event = reader.read_event().map_err(|error| {
                malformed(
                    Place::Byte(reader.error_position()),
                    "well-formed XML".into(),
                    error.to_string(),
                )
            })?;
            let content = reader.buffer_position() as usize;
            match event {
                Event::Start(start) => {
                    depth += 1;
                    if parts.add(tag(&start, content)?) {
                        return Ok(parts);
                    }
                }
                Event::Empty(start) => {
                    parts.add(tag(&start, content)?);
                }
                Event::End(_) => depth = depth.saturating_sub(1),
                Event::DocType(_) => {
                    let place = Place::Byte(content as u64);
                    return Err(malformed(place, "no document type".into(), "one".into()));
                }
                // Numbers of a file that is cut would be cut, too.
                Event::Eof if depth > 0 => {
                    let place = Place::Byte(content as u64);
                    return Err(malformed(
                        place,
                        "the end of VTKFile".into(),
                        "the end of the file".into(),
                    ));
                }
                Event::Eof => return Ok(parts),
                _ => {}
            }
        }
    }

    /// Adds an element, and says whether the samples follow it.
    fn add(&mut self, tag: Tag) -> bool {
        match tag.name.as_str() {
            "VTKFile" => self.file = Some(tag),
            "ImageData" => self.image = Some(tag),
            "Piece" => self.pieces.push(tag),
            "PointData" | "CellData" | "FieldData" => self.groups.push((tag, Vec::new())),
            "DataArray" => {
                if let Some((_, arrays)) = self.groups.last_mut() {
                    arrays.push(tag);
                }
            }
            "AppendedData" => {
                self.appended = Some(tag);
                return true;
            }
            _ => {}
        }
        false
    }

    /// The array with the samples, and whether cells have them.
    fn samples(&self) -> Result<(&Tag, bool), ReadError> {
        let is_scalar =
            |array: &&Tag| array.get("NumberOfComponents").is_none_or(|count| count == "1");
        for name in ["PointData", "CellData"] {
            let groups = self.groups.iter().filter(|(group, _)| group.name == name);
            for (group, arrays) in groups {
                let scalars: Vec<&Tag> = arrays.iter().filter(is_scalar).collect();
                let active = group.get("Scalars").filter(|name| !name.is_empty());
                let chosen = match (active, &scalars[..]) {
                    (_, []) => continue,
                    (None, [only]) => Some(*only),
                    (None, _) => None,
                    (Some(active), _) => {
                        scalars.iter().copied().find(|array| array.get("Name") == Some(active))
                    }
                };
                let names: Vec<&str> =
                    scalars.iter().filter_map(|array| array.get("Name")).collect();
                return chosen.map(|array| (array, name == "CellData")).ok_or_else(|| {
                    ReadError::Unclear {
                        format: FORMAT,
                        place: group.place(),
                        found: format!("arrays {}", names.join(", ")),
                        cure: "name the one with the samples as its Scalars".into(),
                    }
                });
            }
        }
        Err(malformed(
            Place::Element("Piece".into()),
            "an array with one number a point or a cell".into(),
            "none".into(),
        ))
    }
}

fn tag(start: &BytesStart<'_>, content: usize) -> Result<Tag, ReadError> {
    let name = start.local_name().into_inner().to_owned();
    let mut attributes = Vec::new();
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|error| {
            malformed(Place::Element(name.clone()), "attributes".into(), error.to_string())
        })?;
        attributes.push((attribute.key.into_inner().to_owned(), attribute.value.into_owned()));
    }
    Ok(Tag { name, attributes, content })
}

/// First and last point along x, y and z.
fn extent(tag: &Tag, key: &str) -> Result<[i64; 6], ReadError> {
    let words = tag.get(key).unwrap_or_default().split_whitespace();
    let numbers: Option<Vec<i64>> =
        words.map(|word| word.parse::<i32>().ok().map(i64::from)).collect();
    numbers
        .and_then(|numbers| <[i64; 6]>::try_from(numbers).ok())
        .filter(|all| all.chunks_exact(2).all(|ends| ends[0] <= ends[1]))
        .ok_or_else(|| tag.malformed(key, "six whole numbers, none of the ends before its start"))
}

fn frame(image: &Tag, whole: &[i64; 6], is_cells: bool) -> Result<Frame, ReadError> {
    let unit = if image.get("Spacing").is_some() { UnitKnown::Assumed } else { UnitKnown::Missing };
    let spacing: [f64; 3] = image.numbers("Spacing", [1.0; 3])?;
    let turn: [f64; 9] =
        image.numbers("Direction", [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0])?;
    let mut frame = Frame::aligned(spacing, unit);
    // The columns of the matrix are the axes.
    for axis in 0..3 {
        frame.steps_mm[axis] = [0, 1, 2].map(|row| turn[3 * row + axis] * spacing[axis]);
    }
    frame.origin_mm = image.numbers("Origin", [0.0; 3])?;
    let half = if is_cells { 0.5 } else { 0.0 };
    frame.origin_mm = frame.place_mm([0, 1, 2].map(|axis| whole[2 * axis] as f64 + half));
    frame.checked(FORMAT, image.place())
}

fn values(
    file: &Tag,
    array: &Tag,
    appended: Option<&Tag>,
    bytes: &[u8],
    count: usize,
) -> Result<Values, ReadError> {
    let element = element(array)?;
    let content = bytes.get(array.content..).unwrap_or_default();
    let inside = &content[..content.iter().position(|&byte| byte == b'<').unwrap_or(content.len())];
    let (coding, data, start) = match array.get("format") {
        Some("ascii") => return text_values(array, element, inside, count),
        Some("binary") => (Coding::Base64, inside, array.content),
        Some("appended") => {
            let appended = appended.ok_or_else(|| {
                malformed(array.place(), "an element AppendedData".into(), "none".into())
            })?;
            let coding = match appended.get("encoding") {
                Some("raw") => Coding::Raw,
                Some("base64") => Coding::Base64,
                _ => return Err(appended.unsupported("encoding", "raw or base64")),
            };
            let offset: usize = array
                .get("offset")
                .and_then(|offset| offset.parse().ok())
                .ok_or_else(|| array.malformed("offset", "a whole number"))?;
            let tail = bytes.get(appended.content..).unwrap_or_default();
            let mark = tail.iter().position(|byte| !byte.is_ascii_whitespace());
            let mark = mark.filter(|&at| tail[at] == b'_').ok_or_else(|| {
                malformed(appended.place(), "an underscore before the samples".into(), quoted(tail))
            })?;
            let at = appended.content.saturating_add(mark + 1).saturating_add(offset);
            (coding, bytes.get(at..).unwrap_or_default(), at)
        }
        _ => return Err(array.unsupported("format", "ascii, binary or appended")),
    };
    let is_big = match file.get("byte_order") {
        Some("BigEndian") => true,
        Some("LittleEndian") => false,
        _ => return Err(file.malformed("byte_order", "LittleEndian or BigEndian")),
    };
    let word_bytes = match file.get("header_type") {
        None | Some("UInt32") => 4,
        Some("UInt64") => 8,
        _ => return Err(file.unsupported("header_type", "UInt32 or UInt64")),
    };
    let is_zlib = match file.get("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        _ => return Err(file.unsupported("compressor", "none, or vtkZLibDataCompressor")),
    };
    let packed = Packed { coding, data, start: start as u64, word_bytes, is_big };
    let samples = packed.samples(is_zlib, count * element.bytes())?;
    Ok(element.decoded(samples, is_big))
}

fn element(array: &Tag) -> Result<Element, ReadError> {
    Ok(match array.get("type") {
        Some("Int8") => Element::I8,
        Some("UInt8") => Element::U8,
        Some("Int16") => Element::I16,
        Some("UInt16") => Element::U16,
        Some("Int32") => Element::I32,
        Some("UInt32") => Element::U32,
        Some("Int64") => Element::I64,
        Some("UInt64") => Element::U64,
        Some("Float32") => Element::F32,
        Some("Float64") => Element::F64,
        _ => return Err(array.unsupported("type", "Int8 to UInt64, Float32 or Float64")),
    })
}

/// Samples as text.
fn text_values(
    array: &Tag,
    element: Element,
    text: &[u8],
    count: usize,
) -> Result<Values, ReadError> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let number = |word: &[u8]| -> Option<f64> {
        if says_missing(word) {
            Some(f64::NAN)
        } else {
            std::str::from_utf8(word).ok()?.parse().ok()
        }
    };
    let (mut bytes, mut floats) = (Vec::new(), Vec::new());
    for word in words {
        let value =
            number(word).ok_or_else(|| malformed(array.place(), "numbers".into(), quoted(word)))?;
        if element != Element::U8 {
            floats.push(value as f32);
        } else if (0.0..=255.0).contains(&value) && value.fract() == 0.0 {
            bytes.push(value as u8);
        } else {
            return Err(malformed(array.place(), "whole numbers 0 to 255".into(), quoted(word)));
        }
    }
    let values = if element == Element::U8 { Values::Bytes(bytes) } else { Values::Floats(floats) };
    if values.len() != count {
        return Err(malformed(array.place(), format!("{count} samples"), values.len().to_string()));
    }
    Ok(values)
}

fn malformed(place: Place, expected: String, found: String) -> ReadError {
    ReadError::Malformed { format: FORMAT, place, expected, found }
}

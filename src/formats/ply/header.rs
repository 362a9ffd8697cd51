//! The header of a PLY file.

use crate::error::quoted;
use crate::lengths::words;
use crate::xyz::{Unit, unit_in_comment};
use crate::{Format, Place, ReadError};

/// How the numbers are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// A type of number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Property {
    Number { kind: Kind, name: Vec<u8> },
    List { count: Kind, item: Kind, name: Vec<u8> },
}

/// An element: `count` records of these properties.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: Vec<u8>,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// The unit that comments state.
    pub(super) unit: Option<Unit>,
    /// How many bytes the header has, and how many lines.
    pub(super) bytes: usize,
    pub(super) lines: usize,
}

impl Kind {
    fn of(word: &[u8]) -> Option<Kind> {
        Some(match word {
            b"char" | b"int8" => Kind::I8,
            b"uchar" | b"uint8" => Kind::U8,
            b"short" | b"int16" => Kind::I16,
            b"ushort" | b"uint16" => Kind::U16,
            b"int" | b"int32" => Kind::I32,
            b"uint" | b"uint32" => Kind::U32,
            b"float" | b"float32" => Kind::F32,
            b"double" | b"float64" => Kind::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) const fn size(self) -> usize {
        match self {
            Kind::I8 | Kind::U8 => 1,
            Kind::I16 | Kind::U16 => 2,
            Kind::I32 | Kind::U32 | Kind::F32 => 4,
            Kind::F64 => 8,
        }
    }

    const fn is_whole(self) -> bool {
        !matches!(self, Kind::F32 | Kind::F64)
    }
}

impl Header {
    pub(super) fn read(bytes: &[u8]) -> Result<Header, ReadError> {
        if !super::is_ply(bytes) {
            return Err(malformed(1, "the word ply, alone", quoted(bytes)));
        }
        // Numbers that follow a header may begin with the byte of a line feed: all lines end as the first one does.
        let ending: &[u8] = match &bytes[super::MAGIC.len()..] {
            [b'\r', b'\n', ..] => b"\r\n",
            [b'\r', ..] => b"\r",
            _ => b"\n",
        };
        let mut header = Header {
            encoding: Encoding::Ascii,
            elements: Vec::new(),
            unit: None,
            bytes: 0,
            lines: 0,
        };
        let mut encoding = None;
        loop {
            let rest = &bytes[header.bytes..];
            let found = rest.windows(ending.len()).position(|window| window == ending);
            header.lines += 1;
            let Some(end) = found else {
                return Err(malformed(
                    header.lines,
                    "a line end_header",
                    "the end of the file".into(),
                ));
            };
            header.bytes += end + ending.len();
            let line = &rest[..end];
            let found: Vec<&[u8]> = words(line).collect();
            match found[..] {
                [b"ply"] if header.lines == 1 => {}
                [] | [b"obj_info", ..] => {}
                [b"comment", ..] => header.remark(line)?,
                [b"format", word, b"1.0"] => {
                    let stated = match word {
                        b"ascii" => Encoding::Ascii,
                        b"binary_little_endian" => Encoding::Little,
                        b"binary_big_endian" => Encoding::Big,
                        _ => return Err(malformed(header.lines, FORMATS, quoted(line))),
                    };
                    encoding = Some(stated);
                }
                [b"format", ..] => return Err(malformed(header.lines, FORMATS, quoted(line))),
                [b"element", name, count] => {
                    let count = std::str::from_utf8(count).ok().and_then(|word| word.parse().ok());
                    let Some(count) = count else {
                        return Err(malformed(header.lines, "element NAME COUNT", quoted(line)));
                    };
                    let element = Element { name: name.to_vec(), count, properties: Vec::new() };
                    header.elements.push(element);
                }
                [b"property", ref of @ ..] => header.property(line, of)?,
                [b"end_header"] => break,
                _ => {
                    let expected = "comment, element, property or end_header";
                    return Err(malformed(header.lines, expected, quoted(line)));
                }
            }
        }
        header.encoding =
            encoding.ok_or_else(|| malformed(header.lines, FORMATS, "no line format".into()))?;
        Ok(header)
    }

    fn property(&mut self, line: &[u8], of: &[&[u8]]) -> Result<(), ReadError> {
        let number = self.lines;
        let property = match of {
            [b"list", count, item, name] => Kind::of(count)
                .filter(|kind| kind.is_whole())
                .zip(Kind::of(item))
                .map(|(count, item)| Property::List { count, item, name: name.to_vec() }),
            [kind, name] => {
                Kind::of(kind).map(|kind| Property::Number { kind, name: name.to_vec() })
            }
            _ => None,
        };
        let expected = "property TYPE NAME or property list TYPE TYPE NAME after an element, the type char, uchar, \
                        short, ushort, int, uint, float or double";
        match (property, self.elements.last_mut()) {
            (Some(property), Some(element)) => element.properties.push(property),
            _ => return Err(malformed(number, expected, quoted(line))),
        }
        Ok(())
    }

    /// Takes the unit from a comment, if it states one.
    fn remark(&mut self, line: &[u8]) -> Result<(), ReadError> {
        let Some(unit) = unit_in_comment(&String::from_utf8_lossy(line)) else { return Ok(()) };
        if let Some(other) = self.unit.replace(unit)
            && other != unit
        {
            let expected = format!("one unit of lengths in all comments, {other} as before");
            return Err(malformed(self.lines, &expected, quoted(line)));
        }
        Ok(())
    }
}

/// An error at a line.
pub(super) fn malformed(line: usize, expected: &str, found: String) -> ReadError {
    let place = Place::Line { line, column: 0 };
    ReadError::Malformed { format: Format::Ply, place, expected: expected.into(), found }
}

const FORMATS: &str = "format ascii 1.0, binary_little_endian 1.0 or binary_big_endian 1.0";

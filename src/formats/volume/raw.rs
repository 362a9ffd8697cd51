//! Raw samples with a TOML file beside them that says what they are.
//!
//! | key | value |
//! |---|---|
//! | `size` | columns, rows and slices, x fastest |
//! | `type` | `u8`, `i8`, `u16`, `i16`, `u32`, `i32`, `u64`, `i64`, `f32` or `f64` |
//! | `byte_order` | `little` or `big`; only a type of one byte may go without |
//! | `spacing_mm` | distance of samples, one number or three; without it the caller must say |
//! | `origin_mm` | place of the first sample, three numbers; default 0 |
//! | `header_bytes` | bytes before the samples; default 0 |
//! | `file` | the samples, beside this file; default its name with `.raw` |

use toml_edit::{DocumentMut, Item, Value};

use super::element::Element;
use super::layout::{Layout, SamplesIn, Skip};
use super::{Frame, UnitKnown};
use crate::error::quoted;
use crate::{Format, Place, ReadError};

const FORMAT: Format = Format::Raw;

const KEYS: [&str; 7] =
    ["size", "type", "byte_order", "spacing_mm", "origin_mm", "header_bytes", "file"];

/// A TOML file that says what raw samples are: by its extension and its two keys.
pub(super) fn is_side_file(name: &str, bytes: &[u8]) -> bool {
    let is_toml = name.len() > 5 && name.to_ascii_lowercase().ends_with(".toml");
    let has = |key: &str| super::header::has_key(bytes, key, '=');
    is_toml && has("size") && has("type")
}

/// What a TOML file named `name` says; its own name for the samples, or that of the file beside it.
pub(super) fn layout(name: &str, bytes: &[u8]) -> Result<Layout, ReadError> {
    let text = std::str::from_utf8(bytes)
        .map_err(|_| malformed("", "text in UTF-8".into(), quoted(bytes)))?;
    let document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| {
        let line = error.span().map_or(1, |span| {
            text.as_bytes()[..span.start.min(text.len())]
                .iter()
                .filter(|&&byte| byte == b'\n')
                .count()
                + 1
        });
        ReadError::Malformed {
            format: FORMAT,
            place: Place::Line { line, column: 0 },
            expected: "TOML".into(),
            found: error.message().to_owned(),
        }
    })?;
    let header = Header { document: &document };
    header.check_keys()?;
    let size = header.size()?;
    let element = header.element()?;
    let file_at = Place::Element("file".into());
    Ok(Layout {
        format: FORMAT,
        size,
        size_at: Place::Element("size".into()),
        element,
        is_big: header.is_big(element)?,
        frame: header.frame()?,
        file: SamplesIn::Beside(header.file(name)?, file_at),
        start: 0,
        packing: None,
        skip_lines: 0,
        skip: Skip::Bytes(header.whole("header_bytes")?.unwrap_or(0)),
        is_all: true,
    })
}

/// The keys of the TOML file.
struct Header<'a> {
    document: &'a DocumentMut,
}

impl Header<'_> {
    fn check_keys(&self) -> Result<(), ReadError> {
        match self.document.iter().find(|(key, _)| !KEYS.contains(key)) {
            Some((key, _)) => {
                Err(malformed(key, format!("one of the keys {}", KEYS.join(", ")), key.into()))
            }
            None => Ok(()),
        }
    }

    fn wrong(&self, key: &str, expected: &str) -> ReadError {
        let found =
            self.document.get(key).map_or("none".into(), |item| item.to_string().trim().to_owned());
        malformed(key, expected.into(), found)
    }

    fn size(&self) -> Result<[u64; 3], ReadError> {
        let sides: Option<Vec<u64>> =
            self.document.get("size").and_then(Item::as_array).and_then(|sides| {
                sides.iter().map(|side| u64::try_from(side.as_integer()?).ok()).collect()
            });
        sides
            .and_then(|sides| sides.try_into().ok())
            .ok_or_else(|| self.wrong("size", "[columns, rows, slices]"))
    }

    fn element(&self) -> Result<Element, ReadError> {
        Ok(match self.document.get("type").and_then(Item::as_str) {
            Some("u8") => Element::U8,
            Some("i8") => Element::I8,
            Some("u16") => Element::U16,
            Some("i16") => Element::I16,
            Some("u32") => Element::U32,
            Some("i32") => Element::I32,
            Some("u64") => Element::U64,
            Some("i64") => Element::I64,
            Some("f32") => Element::F32,
            Some("f64") => Element::F64,
            _ => {
                let types = "\"u8\", \"i8\", \"u16\", \"i16\", \"u32\", \"i32\", \"u64\", \"i64\", \"f32\" or \"f64\"";
                return Err(self.wrong("type", types));
            }
        })
    }

    fn is_big(&self, element: Element) -> Result<bool, ReadError> {
        match self.document.get("byte_order").map(Item::as_str) {
            Some(Some("little")) => Ok(false),
            Some(Some("big")) => Ok(true),
            None if element.bytes() == 1 => Ok(false),
            _ => Err(self.wrong("byte_order", "\"little\" or \"big\"")),
        }
    }

    fn frame(&self) -> Result<Frame, ReadError> {
        let mut frame = match self.document.get("spacing_mm") {
            None => Frame::aligned([1.0; 3], UnitKnown::Missing),
            Some(item) => {
                let one = item.as_value().and_then(number).map(|side| [side; 3]);
                let spacing =
                    one.or_else(|| three(item)).filter(|all| all.iter().all(|&one| one > 0.0));
                let spacing = spacing
                    .ok_or_else(|| self.wrong("spacing_mm", "one length or three, mm, above 0"))?;
                Frame::aligned(spacing, UnitKnown::Stated)
            }
        };
        if let Some(item) = self.document.get("origin_mm") {
            frame.origin_mm =
                three(item).ok_or_else(|| self.wrong("origin_mm", "three lengths, mm"))?;
        }
        frame.checked(FORMAT, Place::Element("spacing_mm".into()))
    }

    fn whole(&self, key: &str) -> Result<Option<u64>, ReadError> {
        let Some(item) = self.document.get(key) else { return Ok(None) };
        let number = item.as_integer().and_then(|number| u64::try_from(number).ok());
        number.map(Some).ok_or_else(|| self.wrong(key, "a whole number from 0"))
    }

    /// The name of the file with the samples.
    fn file(&self, name: &str) -> Result<String, ReadError> {
        match self.document.get("file") {
            None => Ok(format!("{}.raw", super::stem(name))),
            Some(item) => {
                item.as_str().filter(|file| super::is_beside(file)).map(str::to_owned).ok_or_else(
                    || self.wrong("file", "the name of a file in this folder, without a path"),
                )
            }
        }
    }
}

fn number(value: &Value) -> Option<f64> {
    let whole = value.as_integer().map(|number| number as f64);
    value.as_float().or(whole).filter(|number| number.is_finite())
}

fn three(item: &Item) -> Option<[f64; 3]> {
    let numbers: Option<Vec<f64>> = item.as_array()?.iter().map(number).collect();
    numbers?.try_into().ok()
}

fn malformed(key: &str, expected: String, found: String) -> ReadError {
    ReadError::Malformed { format: FORMAT, place: Place::Element(key.into()), expected, found }
}

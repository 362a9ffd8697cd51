//! `main.xml` as texts by path: `Record1/Axes/CX/AxisType`.

use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesRef, Event};

use super::MAIN_XML;
use crate::error::quoted;
use crate::scan::without_bom;
use crate::{Format, Place, ReadError};

/// The elements of `main.xml` that hold text, without the names of the root and of name spaces.
#[derive(Debug, Default)]
pub(super) struct Elements {
    texts: BTreeMap<String, String>,
    /// Texts of the `Datum` elements, each ended by a line feed. One string instead of one a point
    /// keeps the memory in proportion to the file.
    data: Option<String>,
}

impl Elements {
    pub(super) fn parse(main: &[u8]) -> Result<Elements, ReadError> {
        let text = std::str::from_utf8(without_bom(main)).map_err(|error| {
            let at = error.valid_up_to();
            malformed("UTF-8", format!("{} at byte {at}", quoted(&main[at..])))
        })?;
        let mut reader = Reader::from_str(text);
        let mut elements = Elements::default();
        // Invariant: the path of the element being read, without the root; `None` outside the root.
        let mut path: Option<Vec<String>> = None;
        let mut text = String::new();
        let mut ended = false;
        loop {
            let event = reader.read_event().map_err(|error| {
                let found = format!("{error} at byte {}", reader.error_position());
                malformed("well-formed XML", found)
            })?;
            match event {
                Event::Start(start) => {
                    let name = start.local_name().into_inner().to_owned();
                    open(&mut path, name, ended)?;
                    text.clear();
                }
                Event::Empty(start) => {
                    let name = start.local_name().into_inner().to_owned();
                    open(&mut path, name, ended)?;
                    text.clear();
                    elements.close(&mut path, &mut text, &mut ended)?;
                }
                Event::End(_) => elements.close(&mut path, &mut text, &mut ended)?,
                Event::Text(part) => text.push_str(&part.xml10_content()),
                Event::CData(part) => text.push_str(&part.xml10_content()),
                Event::GeneralRef(reference) => text.push_str(&resolved(&reference)?),
                Event::DocType(_) => {
                    return Err(malformed("no document type", "one".into()));
                }
                Event::Eof => break,
                Event::Decl(_) | Event::PI(_) | Event::Comment(_) => {}
            }
        }
        if ended {
            Ok(elements)
        } else {
            Err(malformed(&format!("a complete {ROOT}"), "the end of the file".into()))
        }
    }

    /// The trimmed text of an element, or `None` where it is absent or empty.
    pub(super) fn get(&self, path: &str) -> Option<&str> {
        self.texts.get(path).map(|text| text.trim()).filter(|text| !text.is_empty())
    }

    /// The text of an element that must be there.
    pub(super) fn required(&self, path: &str) -> Result<&str, ReadError> {
        self.get(path).ok_or_else(|| at(path, "a text", "none"))
    }

    /// Whether there is an element at or below a path.
    pub(super) fn contains(&self, path: &str) -> bool {
        let below = format!("{path}/");
        self.texts.keys().any(|known| known == path || known.starts_with(&below))
    }

    /// The texts of the `Datum` elements, a line each, if there is a `DataList`.
    pub(super) fn take_data(&mut self) -> Option<String> {
        self.data.take()
    }

    fn close(
        &mut self,
        path: &mut Option<Vec<String>>,
        text: &mut String,
        ended: &mut bool,
    ) -> Result<(), ReadError> {
        let names = path.as_mut().ok_or_else(|| malformed(ROOT, "an end without start".into()))?;
        let joined = names.join("/");
        if joined == "Record3/DataList/Datum" {
            let data = self.data.get_or_insert_default();
            // A line feed inside a Datum would look like the start of the next one.
            data.extend(text.trim().chars().map(|c| if c == '\n' || c == '\r' { ' ' } else { c }));
            data.push('\n');
        } else if joined == "Record3/DataList" {
            self.data.get_or_insert_default();
        } else if !joined.is_empty() {
            if self.texts.len() == MAX_ELEMENTS {
                return Err(malformed(&format!("at most {MAX_ELEMENTS} elements"), "more".into()));
            }
            let known = self.texts.insert(joined.clone(), std::mem::take(text));
            if known.is_some() && (joined.starts_with("Record1/") || joined.starts_with("Record3/"))
            {
                return Err(at(&joined, "one element of this name", "a second one"));
            }
        }
        text.clear();
        if names.pop().is_none() {
            *path = None;
            *ended = true;
        }
        Ok(())
    }
}

/// Enters an element.
fn open(path: &mut Option<Vec<String>>, name: String, ended: bool) -> Result<(), ReadError> {
    match path {
        Some(names) if names.len() < MAX_DEPTH => names.push(name),
        Some(names) => {
            let expected = format!("at most {MAX_DEPTH} levels of elements");
            return Err(at(&names.join("/"), &expected, "another"));
        }
        None if name == ROOT && !ended => *path = Some(Vec::new()),
        None => {
            let expected = format!("the root element {ROOT}");
            return Err(malformed(&expected, quoted(name.as_bytes())));
        }
    }
    Ok(())
}

fn resolved(reference: &BytesRef<'_>) -> Result<String, ReadError> {
    let unknown = || malformed("a predefined entity", quoted(reference.as_bytes()));
    match reference.resolve_char_ref() {
        Ok(Some(letter)) => Ok(letter.into()),
        Ok(None) => resolve_predefined_entity(reference).map(str::to_owned).ok_or_else(unknown),
        Err(_) => Err(unknown()),
    }
}

/// An error at an element.
pub(super) fn at(path: &str, expected: &str, found: impl ToString) -> ReadError {
    ReadError::Malformed {
        format: Format::X3p,
        place: Place::Element(path.into()),
        expected: expected.into(),
        found: found.to_string(),
    }
}

fn malformed(expected: &str, found: String) -> ReadError {
    ReadError::Malformed {
        format: Format::X3p,
        place: Place::Entry(MAIN_XML.into()),
        expected: expected.into(),
        found,
    }
}

const ROOT: &str = "ISO5436_2";

/// Most elements other than `Datum` that are kept; the standard has some 60. Without a limit, small
/// elements would take many times the memory of the file.
const MAX_ELEMENTS: usize = 4096;

/// Deepest nesting read; the standard needs 4.
const MAX_DEPTH: usize = 16;

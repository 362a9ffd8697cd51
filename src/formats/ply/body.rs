//! The records behind the header of a PLY file, as text or as bytes.

use super::header::{Element, Encoding, Header, Kind, Property, malformed};
use crate::error::quoted;
use crate::lengths::{number, words};
use crate::{Format, Place, ReadError};

/// What a record is read for.
pub(super) enum Wanted<'a> {
    Nothing,
    /// The numbers of three properties.
    Numbers([usize; 3], &'a mut [f64; 3]),
    /// All that the list of one property holds.
    List(usize, &'a mut Vec<f64>),
}

impl Wanted<'_> {
    fn take(&mut self, property: usize, value: f64) {
        if let Wanted::Numbers(slots, numbers) = self {
            for (slot, number) in slots.iter().zip(numbers.iter_mut()) {
                if *slot == property {
                    *number = value;
                }
            }
        }
    }

    /// The list, if it is that of this property.
    fn list(&mut self, property: usize) -> Option<&mut Vec<f64>> {
        match self {
            Wanted::List(slot, list) if *slot == property => Some(list),
            _ => None,
        }
    }
}

/// The records of a file, read one after the other.
pub(super) enum Body<'a> {
    Text(Words<'a>),
    Bytes(Numbers<'a>),
}

impl<'a> Body<'a> {
    /// What follows a header.
    pub(super) fn new(bytes: &'a [u8], header: &Header) -> Body<'a> {
        match header.encoding {
            Encoding::Ascii => Body::Text(Words {
                rest: &bytes[header.bytes..],
                line: header.lines + 1,
                may_be_cut: false,
            }),
            Encoding::Little | Encoding::Big => {
                let is_big = header.encoding == Encoding::Big;
                Body::Bytes(Numbers { bytes, at: header.bytes, is_big })
            }
        }
    }

    /// Does something for every record that holds anything. A count of records without properties costs nothing.
    pub(super) fn each(
        &mut self,
        element: &Element,
        mut take: impl FnMut(&mut Body<'a>, u64) -> Result<(), ReadError>,
    ) -> Result<(), ReadError> {
        let count = if element.properties.is_empty() { 0 } else { element.count };
        (0..count).try_for_each(|index| take(self, index))
    }

    /// Reads a record, and gives its place: the line on which it ends, or the byte at which it begins.
    pub(super) fn record(
        &mut self,
        element: &Element,
        index: u64,
        wanted: Wanted<'_>,
    ) -> Result<Place, ReadError> {
        match self {
            Body::Text(words) => words.record(element, index, wanted)?,
            Body::Bytes(numbers) => {
                let at = numbers.at;
                numbers.record(element, index, wanted)?;
                return Ok(Place::Byte(at as u64));
            }
        }
        Ok(self.place())
    }

    /// Passes over all records of an element.
    pub(super) fn pass_over(&mut self, element: &Element) -> Result<(), ReadError> {
        match (self, fixed_size(element)) {
            (Body::Bytes(numbers), Some(size)) => numbers.skip(element, size),
            (body, _) => body.each(element, |body, index| {
                body.record(element, index, Wanted::Nothing).map(|_| ())
            }),
        }
    }

    /// The place that was reached.
    pub(super) fn place(&self) -> Place {
        match self {
            Body::Text(words) => Place::Line { line: words.line, column: 0 },
            Body::Bytes(numbers) => Place::Byte(numbers.at as u64),
        }
    }

    /// Fails where the last number may be cut short: it looks like another one then.
    pub(super) fn end(&self) -> Result<(), ReadError> {
        match self {
            Body::Text(words) if words.may_be_cut => {
                let expected =
                    "a line end after the last number, without which the file may be cut";
                Err(malformed(words.line, expected, "the end of the file".into()))
            }
            _ => Ok(()),
        }
    }

    /// Fails where anything lies behind the last element.
    pub(super) fn finish(&mut self, last: &Element) -> Result<(), ReadError> {
        let (place, found) = match self {
            Body::Text(words) => match words.row() {
                Some(row) => (Place::Line { line: words.line, column: 0 }, quoted(row)),
                None => return Ok(()),
            },
            Body::Bytes(numbers) => match numbers.bytes.len() - numbers.at {
                0 => return Ok(()),
                more => (Place::Byte(numbers.at as u64), format!("{more} more bytes")),
            },
        };
        Err(goes_on(last, place, &found))
    }
}

/// The error of a file that goes on behind its last element.
pub(super) fn goes_on(last: &Element, place: Place, found: &str) -> ReadError {
    ReadError::Malformed {
        format: Format::Ply,
        place,
        expected: format!("the end of the file after {}", expected(last)),
        found: format!("{found}: {CURE}"),
    }
}

/// A property that lacks moves the numbers as a wrong count does.
const CURE: &str = "a count or a property in the header may be wrong";

/// Bytes of a record without lists.
pub(super) fn fixed_size(element: &Element) -> Option<usize> {
    let sizes = element.properties.iter().map(|property| match property {
        Property::Number { kind, .. } => Some(kind.size()),
        Property::List { .. } => None,
    });
    sizes.sum()
}

/// Numbers as text: a line is a record, and empty lines are none.
pub(super) struct Words<'a> {
    rest: &'a [u8],
    line: usize,
    /// Whether the last word ends where the file does.
    may_be_cut: bool,
}

impl<'a> Words<'a> {
    /// The next line that holds anything.
    fn row(&mut self) -> Option<&'a [u8]> {
        while let [first, rest @ ..] = self.rest
            && first.is_ascii_whitespace()
        {
            self.line +=
                usize::from(*first == b'\n' || *first == b'\r' && !rest.starts_with(b"\n"));
            self.rest = rest;
        }
        let found = self.rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
        let (row, rest) = self.rest.split_at(found.unwrap_or(self.rest.len()));
        self.may_be_cut = rest.is_empty() && !row.ends_with(b" ") && !row.ends_with(b"\t");
        self.rest = rest;
        (!row.is_empty()).then_some(row)
    }

    fn number(&self, word: &[u8]) -> Result<f64, ReadError> {
        number(word).ok_or_else(|| malformed(self.line, "a number", quoted(word)))
    }

    fn record(
        &mut self,
        element: &Element,
        index: u64,
        mut wanted: Wanted<'_>,
    ) -> Result<(), ReadError> {
        let row = self.row().ok_or_else(|| self.ended(element, index))?;
        let mut left = words(row);
        let mut asked = element.properties.len() as u64;
        for (place, property) in element.properties.iter().enumerate() {
            let word = left.next().ok_or_else(|| self.wrong_row(element, index, asked, row))?;
            match property {
                Property::Number { .. } => wanted.take(place, self.number(word)?),
                Property::List { .. } => {
                    let count = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
                    let Some(count) = count else {
                        let expected = "the length of a list, a whole number";
                        return Err(malformed(self.line, expected, quoted(word)));
                    };
                    let count: u64 = count;
                    asked = asked.saturating_add(count);
                    for _ in 0..count {
                        let word = left
                            .next()
                            .ok_or_else(|| self.wrong_row(element, index, asked, row))?;
                        if let Some(list) = wanted.list(place) {
                            list.push(self.number(word)?);
                        }
                    }
                }
            }
        }
        match left.next() {
            Some(_) => Err(self.wrong_row(element, index, asked, row)),
            None => Ok(()),
        }
    }

    /// The error of a line with more or fewer numbers than its element has; the last one of a file may be cut.
    fn wrong_row(&self, element: &Element, index: u64, asked: u64, row: &[u8]) -> ReadError {
        let found = words(row).count() as u64;
        if found < asked && self.rest.trim_ascii().is_empty() {
            return self.ended(element, index);
        }
        let expected = format!("{asked} numbers in row {} of {}", index + 1, expected(element));
        malformed(self.line, &expected, format!("{found}: {CURE}"))
    }

    fn ended(&self, element: &Element, index: u64) -> ReadError {
        malformed(
            self.line,
            &expected(element),
            format!("the end of the file in number {}", index + 1),
        )
    }
}

/// Numbers as bytes.
pub(super) struct Numbers<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

impl<'a> Numbers<'a> {
    pub(super) fn new(bytes: &'a [u8], is_big: bool) -> Numbers<'a> {
        Numbers { bytes, at: 0, is_big }
    }

    /// Passes over `len` bytes; `None` where the file has fewer.
    fn take(&mut self, len: usize) -> Option<&'a [u8]> {
        let end = self.at.checked_add(len)?;
        let taken = self.bytes.get(self.at..end)?;
        self.at = end;
        Some(taken)
    }

    fn skip(&mut self, element: &Element, size: usize) -> Result<(), ReadError> {
        let room = (self.bytes.len() - self.at) as u64;
        if element.count.saturating_mul(size as u64) > room {
            return Err(self.ended(element, room / size.max(1) as u64));
        }
        // Not more than the bytes that are there.
        self.at += element.count as usize * size;
        Ok(())
    }

    fn number(&mut self, kind: Kind) -> Option<f64> {
        let is_big = self.is_big;
        let taken = self.take(kind.size())?;
        let mut little = [0; 8];
        for (byte, place) in taken.iter().zip(0..) {
            let place: usize = if is_big { taken.len() - 1 - place } else { place };
            little[place] = *byte;
        }
        let [a, b, c, d, ..] = little;
        Some(match kind {
            Kind::I8 => f64::from(i8::from_le_bytes([a])),
            Kind::U8 => f64::from(a),
            Kind::I16 => f64::from(i16::from_le_bytes([a, b])),
            Kind::U16 => f64::from(u16::from_le_bytes([a, b])),
            Kind::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Kind::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Kind::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Kind::F64 => f64::from_le_bytes(little),
        })
    }

    fn record(
        &mut self,
        element: &Element,
        index: u64,
        mut wanted: Wanted<'_>,
    ) -> Result<(), ReadError> {
        for (place, property) in element.properties.iter().enumerate() {
            let found = match property {
                Property::Number { kind, .. } => {
                    self.number(*kind).map(|value| wanted.take(place, value))
                }
                Property::List { count, item, .. } => match self.number(*count) {
                    Some(count) if count < 0.0 => {
                        return Err(
                            self.malformed("the length of a list, 0 or more", format!("{count}"))
                        );
                    }
                    // A whole number of at most 32 bits.
                    Some(count) => self.list(count as usize, *item, wanted.list(place)),
                    None => None,
                },
            };
            found.ok_or_else(|| self.ended(element, index))?;
        }
        Ok(())
    }

    /// Passes over a list, and takes its numbers where they are wanted; `None` where the file has fewer.
    fn list(&mut self, count: usize, item: Kind, wanted: Option<&mut Vec<f64>>) -> Option<()> {
        let (start, len) = (self.at, count.checked_mul(item.size())?);
        self.take(len)?;
        if let Some(list) = wanted {
            self.at = start;
            for _ in 0..count {
                list.push(self.number(item)?);
            }
        }
        Some(())
    }

    fn ended(&self, element: &Element, index: u64) -> ReadError {
        let found = format!("the end of the file in number {}", index + 1);
        self.malformed(&expected(element), found)
    }

    fn malformed(&self, expected: &str, found: String) -> ReadError {
        let place = Place::Byte(self.at as u64);
        ReadError::Malformed { format: Format::Ply, place, expected: expected.into(), found }
    }
}

fn expected(element: &Element) -> String {
    format!("{} of element {}", element.count, element.name.escape_ascii())
}

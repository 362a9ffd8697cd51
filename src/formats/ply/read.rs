//! The vertices of a PLY file as points.

use super::header::{Element, Encoding, Header, Kind, Property, malformed};
use crate::error::quoted;
use crate::lengths::{Lengths, Points, check_count, number};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, Topography};

/// Reads the vertices as a cloud. `O(bytes)`.
///
/// Of `options` the units count: one for all, or one each for x, y and z.
///
/// # Errors
///
/// A header that does not follow the specification, with its line; no vertices, or vertices without x, y or z; a file that ends too
/// early, with the place; a coordinate that is infinite; more than [`MAX_POINTS`](crate::MAX_POINTS) vertices; a unit other than the
/// one that the file states.
///
/// # Example
///
/// ```
/// let file = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n\
///     property float z\nend_header\n0 0.5 1\n";
/// let topography = asphera_formats::ply::read(file, &Default::default())?;
/// assert_eq!(topography.points().next(), Some([0.0, 0.5, 1.0]));
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let header = Header::read(bytes)?;
    let points = Points::new(Lengths::of(Format::Ply, header.unit, options)?);
    let Some(at) = header.elements.iter().position(|element| element.name == b"vertex") else {
        return Err(malformed(header.lines, "an element vertex", "none".into()));
    };
    let (before, vertices) = (&header.elements[..at], &header.elements[at]);
    let slots = slots(vertices, header.lines)?;
    let body = &bytes[header.bytes..];
    check_count(Format::Ply, vertices.count, || Place::Line { line: header.lines, column: 0 })?;
    match header.encoding {
        Encoding::Ascii => {
            let body = Words { rest: body, line: header.lines + 1, may_be_cut: false };
            ascii(body, before, vertices, slots, points)
        }
        Encoding::Little | Encoding::Big => {
            let body =
                Numbers { bytes, at: header.bytes, is_big: header.encoding == Encoding::Big };
            binary(body, before, vertices, slots, points)
        }
    }
}

/// Where x, y and z stand among the properties of a vertex.
fn slots(vertices: &Element, line: usize) -> Result<[usize; 3], ReadError> {
    let find = |wanted: &str| {
        let is_wanted = |property: &Property| matches!(property, Property::Number { name, .. } if name == wanted.as_bytes());
        let mut places =
            (0..vertices.properties.len()).filter(|&place| is_wanted(&vertices.properties[place]));
        match (places.next(), places.next()) {
            (Some(place), None) => Ok(place),
            (found, _) => {
                let found = if found.is_some() { "two" } else { "none" };
                let expected = format!("one property {wanted} of the element vertex");
                Err(malformed(line, &expected, found.into()))
            }
        }
    };
    Ok([find("x")?, find("y")?, find("z")?])
}

fn ascii(
    mut body: Words<'_>,
    before: &[Element],
    vertices: &Element,
    slots: [usize; 3],
    mut points: Points,
) -> Result<Topography, ReadError> {
    for element in before {
        each(element, |index| body.record(element, index, None))?;
    }
    each(vertices, |index| {
        let mut point = [0.0; 3];
        body.record(vertices, index, Some((slots, &mut point)))?;
        let line = body.line;
        points.push(point, || Place::Line { line, column: 0 })
    })?;
    if body.may_be_cut {
        // A number that is cut short looks like another one.
        let expected = "a line end after the last number, without which the file may be cut";
        return Err(malformed(body.line, expected, "the end of the file".into()));
    }
    points.finish(slots.map(|slot| slot + 1), Place::Line { line: body.line, column: 0 })
}

fn binary(
    mut body: Numbers<'_>,
    before: &[Element],
    vertices: &Element,
    slots: [usize; 3],
    mut points: Points,
) -> Result<Topography, ReadError> {
    for element in before {
        match fixed_size(element) {
            Some(size) => body.skip(element, size)?,
            None => each(element, |index| body.record(element, index, None))?,
        }
    }
    each(vertices, |index| {
        let (at, mut point) = (body.at, [0.0; 3]);
        body.record(vertices, index, Some((slots, &mut point)))?;
        points.push(point, || Place::Byte(at as u64))
    })?;
    points.finish(slots.map(|slot| slot + 1), Place::Byte(body.at as u64))
}

/// Does something for every record that holds anything. A count of records without properties costs nothing.
fn each(
    element: &Element,
    mut record: impl FnMut(u64) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let count = if element.properties.is_empty() { 0 } else { element.count };
    (0..count).try_for_each(&mut record)
}

/// Bytes of a record without lists.
fn fixed_size(element: &Element) -> Option<usize> {
    let sizes = element.properties.iter().map(|property| match property {
        Property::Number { kind, .. } => Some(kind.size()),
        Property::List { .. } => None,
    });
    sizes.sum()
}

/// Where to put the numbers of three properties.
type Wanted<'a> = Option<([usize; 3], &'a mut [f64; 3])>;

fn keep(wanted: &mut Wanted<'_>, place: usize, value: f64) {
    if let Some((slots, point)) = wanted {
        for (slot, coordinate) in slots.iter().zip(point.iter_mut()) {
            if *slot == place {
                *coordinate = value;
            }
        }
    }
}

/// Numbers as text, separated by white space and lines.
struct Words<'a> {
    rest: &'a [u8],
    line: usize,
    /// Whether the last word ends where the file does.
    may_be_cut: bool,
}

impl<'a> Words<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        while let [first, rest @ ..] = self.rest
            && first.is_ascii_whitespace()
        {
            self.line +=
                usize::from(*first == b'\n' || *first == b'\r' && !rest.starts_with(b"\n"));
            self.rest = rest;
        }
        let found = self.rest.iter().position(u8::is_ascii_whitespace);
        self.may_be_cut = found.is_none();
        let (word, rest) = self.rest.split_at(found.unwrap_or(self.rest.len()));
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }

    fn record(
        &mut self,
        element: &Element,
        index: u64,
        mut wanted: Wanted<'_>,
    ) -> Result<(), ReadError> {
        for (place, property) in element.properties.iter().enumerate() {
            let word = self.next().ok_or_else(|| self.ended(element, index))?;
            match property {
                Property::Number { .. } => {
                    let value = number(word)
                        .ok_or_else(|| malformed(self.line, "a number", quoted(word)))?;
                    keep(&mut wanted, place, value);
                }
                Property::List { .. } => {
                    let count = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
                    let Some(count) = count else {
                        let expected = "the length of a list, a whole number";
                        return Err(malformed(self.line, expected, quoted(word)));
                    };
                    let count: u64 = count;
                    for _ in 0..count {
                        self.next().ok_or_else(|| self.ended(element, index))?;
                    }
                }
            }
        }
        Ok(())
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
struct Numbers<'a> {
    bytes: &'a [u8],
    at: usize,
    is_big: bool,
}

impl Numbers<'_> {
    /// Passes over `len` bytes; `None` where the file has fewer.
    fn take(&mut self, len: usize) -> Option<&[u8]> {
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
                    self.number(*kind).map(|value| keep(&mut wanted, place, value))
                }
                Property::List { count, item } => match self.number(*count) {
                    Some(count) if count < 0.0 => {
                        return Err(
                            self.malformed("the length of a list, 0 or more", format!("{count}"))
                        );
                    }
                    // A whole number of at most 32 bits.
                    Some(count) => {
                        let len = (count as usize).checked_mul(item.size());
                        len.and_then(|len| self.take(len)).map(|_| ())
                    }
                    None => None,
                },
            };
            found.ok_or_else(|| self.ended(element, index))?;
        }
        Ok(())
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

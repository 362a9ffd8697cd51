//! Scalable vector graphics (W3C SVG 1.1): the outlines of paths and basic shapes.
//!
//! Lines come in the order of the file, with all transforms done. y is turned: it points down in the file and up here. A unit of the
//! picture is what width and viewBox of the root say where the width has a unit (mm, cm, in, pt, pc); elsewhere it is 1 mm. What lies in
//! `defs`, clip paths, masks, markers, patterns and symbols is not drawn, so it is passed over. Texts, images and copies by `use` are drawn, but
//! not read: they are counted. So are shapes that are not shown. Nothing is clipped.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::affine::Affine;
use super::arc::Arc;
use super::style::{Shown, StyleSheet};
use super::{DrawnLine, LeftOut, PlaceMm, count_hidden, path, viewport};
use crate::error::quoted;
use crate::scan::decoded;
use crate::{Format, Place, ReadError};

/// Reads the lines of a drawing.
///
/// # Errors
///
/// No XML, no element `svg`, or a path, a number or a transform that is not understood, with its element. A drawing without a line is
/// not refused: it has none.
pub fn read(bytes: &[u8]) -> Result<Vec<DrawnLine>, ReadError> {
    read_and_count(bytes).map(|(lines, _)| lines)
}

/// The lines of a drawing, and how many elements of each name are drawn and were left out.
///
/// # Errors
///
/// As [`read`].
pub fn read_and_count(bytes: &[u8]) -> Result<(Vec<DrawnLine>, LeftOut), ReadError> {
    let text = decoded(bytes);
    let mut drawing = Drawing { sheet: StyleSheet::parse(&style(&text)?)?, ..Drawing::default() };
    each(&text, |event| {
        match event {
            Event::Start(start) => drawing.open(&start, true)?,
            Event::Empty(start) => drawing.open(&start, false)?,
            Event::End(_) => {
                drawing.open.pop();
            }
            _ => {}
        }
        Ok(())
    })?;
    match drawing.has_root {
        true => Ok((drawing.lines, drawing.left_out)),
        false => Err(malformed(Place::Byte(0), "an element svg", "none".to_owned())),
    }
}

/// Does something for every event of a text.
fn each(
    text: &str,
    mut take: impl FnMut(Event<'_>) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let mut reader = Reader::from_str(text);
    loop {
        let event = reader.read_event().map_err(|error| {
            let at = reader.error_position();
            malformed(Place::Byte(at), "well-formed XML", error.to_string())
        })?;
        match event {
            Event::Eof => return Ok(()),
            event => take(event)?,
        }
    }
}

/// The text of all elements `style`: their rules hold of shapes before them, too.
fn style(text: &str) -> Result<String, ReadError> {
    let mut style = String::new();
    let mut is_within = false;
    each(text, |event| {
        match event {
            Event::Start(start) => is_within = start.local_name().into_inner() == "style",
            Event::End(_) => is_within = false,
            Event::Text(part) if is_within => style.push_str(&part.xml10_content()),
            Event::CData(part) if is_within => style.push_str(&part.xml10_content()),
            // A sign such as `&gt;` is of no selector that is read.
            Event::GeneralRef(_) if is_within => style.push('&'),
            _ => {}
        }
        Ok(())
    })?;
    Ok(style)
}

/// What was read so far.
#[derive(Default)]
struct Drawing {
    lines: Vec<DrawnLine>,
    left_out: LeftOut,
    sheet: StyleSheet,
    /// The elements that are open.
    open: Vec<Open>,
    has_root: bool,
}

/// An open element.
#[derive(Clone, Copy)]
struct Open {
    /// Its map to mm; `None` within one that is not drawn.
    map: Option<Affine>,
    shown: Shown,
}

/// Elements whose content is not drawn where it stands.
const NOT_DRAWN: [&str; 8] =
    ["defs", "clipPath", "mask", "marker", "pattern", "symbol", "metadata", "text"];

/// Elements that are drawn, and whose lines are not read.
const NOT_READ: [&str; 4] = ["use", "text", "image", "foreignObject"];

/// Elements that have lines.
const SHAPES: [&str; 7] = ["path", "line", "polyline", "polygon", "circle", "ellipse", "rect"];

impl Drawing {
    fn open(&mut self, start: &BytesStart<'_>, stays_open: bool) -> Result<(), ReadError> {
        let tag = Tag::new(start)?;
        let outer = match self.open.last() {
            Some(outer) => *outer,
            None => Open { map: Some(tag.root_map()?), shown: Shown::ALL },
        };
        let name = tag.name.as_str();
        let is_nested = name == "svg" && self.has_root;
        self.has_root |= name == "svg";
        let shown = outer.shown.within(&tag, &self.sheet);
        if outer.map.is_some() && shown.are_lines() && NOT_READ.contains(&name) {
            *self.left_out.entry(name.to_owned()).or_default() += 1;
        }
        let map = match outer.map.filter(|_| !NOT_DRAWN.contains(&name)) {
            Some(outer) if is_nested => {
                Some(outer.after(tag.transform()?).after(tag.viewport_map()?))
            }
            Some(outer) => Some(outer.after(tag.transform()?)),
            None => None,
        };
        match map.filter(|_| SHAPES.contains(&name)) {
            Some(map) if shown.are_lines() => {
                let lines = tag.lines()?;
                self.lines.extend(lines.into_iter().map(|line| line.mapped(|place| map.of(place))));
            }
            Some(_) => count_hidden(&mut self.left_out, name),
            None => {}
        }
        if stays_open {
            self.open.push(Open { map, shown });
        }
        Ok(())
    }
}

/// An element with its attributes.
pub(super) struct Tag {
    pub(super) name: String,
    attributes: Vec<(String, String)>,
}

impl Tag {
    fn new(start: &BytesStart<'_>) -> Result<Tag, ReadError> {
        let name = start.local_name().into_inner().to_owned();
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| {
                malformed(Place::Element(name.clone()), "attributes", error.to_string())
            })?;
            attributes.push((attribute.key.into_inner().to_owned(), attribute.value.into_owned()));
        }
        Ok(Tag { name, attributes })
    }

    pub(super) fn get(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str())
    }

    fn malformed(&self, expected: &str, found: &str) -> ReadError {
        malformed(Place::Element(self.name.clone()), expected, quoted(found.as_bytes()))
    }

    /// A length in units of the picture; 0 where there is none.
    fn length(&self, key: &str) -> Result<f64, ReadError> {
        let Some(text) = self.get(key) else { return Ok(0.0) };
        let number = text.trim().trim_end_matches("px").parse::<f64>();
        let number = number.ok().filter(|value| value.is_finite());
        number.ok_or_else(|| self.malformed(&format!("a number as {key}"), text))
    }

    fn transform(&self) -> Result<Affine, ReadError> {
        let Some(text) = self.get("transform") else { return Ok(Affine::NONE) };
        Affine::parse(text).ok_or_else(|| self.malformed("a transform", text))
    }

    /// The map of the root from its units to mm, y up.
    fn root_map(&self) -> Result<Affine, ReadError> {
        let scale = match (self.get("width").and_then(absolute_mm), self.view_box()) {
            (Some(width_mm), Some(view_box)) => width_mm / view_box?[2],
            // Without a viewBox a unit is a pixel of CSS.
            (Some(_), None) => 25.4 / 96.0,
            (None, _) => 1.0,
        };
        Ok(Affine([scale, 0.0, 0.0, -scale, 0.0, 0.0]))
    }

    /// The map from the units of an `svg` within another to those about it.
    fn viewport_map(&self) -> Result<Affine, ReadError> {
        let place = [self.length("x")?, self.length("y")?];
        let Some(view_box) = self.view_box().transpose()? else {
            return Ok(Affine([1.0, 0.0, 0.0, 1.0, place[0], place[1]]));
        };
        let size = [self.length("width")?, self.length("height")?];
        if size.iter().any(|side| *side <= 0.0) {
            let found = self.get("viewBox").unwrap_or_default();
            return Err(self.malformed("width and height above 0 beside a viewBox", found));
        }
        let ratio = self.get("preserveAspectRatio").unwrap_or_default();
        viewport::map(place, size, view_box, ratio)
            .ok_or_else(|| self.malformed("a preserveAspectRatio", ratio))
    }

    /// Left, top, width and height of the viewBox.
    fn view_box(&self) -> Option<Result<[f64; 4], ReadError>> {
        let text = self.get("viewBox")?;
        let words = text.split([',', ' ', '\t', '\n', '\r']).filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words.map(|word| word.parse().ok()).collect();
        let numbers: Option<[f64; 4]> = numbers.and_then(|numbers| numbers.try_into().ok());
        let numbers = numbers.filter(|all| {
            all.iter().all(|value| value.is_finite()) && all[2] > 0.0 && all[3] > 0.0
        });
        Some(numbers.ok_or_else(|| self.malformed("a viewBox of four numbers", text)))
    }

    /// The lines of a shape in its own units.
    fn lines(&self) -> Result<Vec<DrawnLine>, ReadError> {
        Ok(match self.name.as_str() {
            "path" => {
                let data = self.get("d").unwrap_or_default();
                path::lines(data).map_err(|found| self.malformed("path data", &found))?
            }
            "line" => {
                let [p, q] = [["x1", "y1"], ["x2", "y2"]];
                let place = |keys: [&str; 2]| -> Result<PlaceMm, ReadError> {
                    Ok([self.length(keys[0])?, self.length(keys[1])?])
                };
                DrawnLine::through(&[place(p)?, place(q)?], false).into_iter().collect()
            }
            "polyline" | "polygon" => {
                let text = self.get("points").unwrap_or_default();
                let words = text.split([',', ' ', '\t', '\n', '\r']);
                let numbers: Option<Vec<f64>> =
                    words.filter(|word| !word.is_empty()).map(|word| word.parse().ok()).collect();
                let numbers = numbers
                    .filter(|it| it.len().is_multiple_of(2) && it.iter().all(|it| it.is_finite()))
                    .ok_or_else(|| self.malformed("pairs of numbers as points", text))?;
                let corners: Vec<PlaceMm> = numbers.chunks(2).map(|it| [it[0], it[1]]).collect();
                DrawnLine::through(&corners, self.name == "polygon").into_iter().collect()
            }
            "circle" => {
                let radius = self.length("r")?;
                self.round([radius, radius])?
            }
            "ellipse" => self.round([self.length("rx")?, self.length("ry")?])?,
            "rect" => self.rectangle()?,
            _ => Vec::new(),
        })
    }

    fn round(&self, radii: [f64; 2]) -> Result<Vec<DrawnLine>, ReadError> {
        let centre = [self.length("cx")?, self.length("cy")?];
        if radii.iter().any(|radius| *radius <= 0.0) {
            return Ok(Vec::new());
        }
        let mut pieces =
            Arc { centre, radii, turn: 0.0, from: 0.0, sweep: std::f64::consts::TAU }.pieces();
        let first = pieces[0][0];
        if let Some(last) = pieces.last_mut() {
            last[3] = first;
        }
        Ok(vec![DrawnLine { pieces, closed: true }])
    }

    fn rectangle(&self) -> Result<Vec<DrawnLine>, ReadError> {
        let [x, y] = [self.length("x")?, self.length("y")?];
        let [w, h] = [self.length("width")?, self.length("height")?];
        let given = |key: &str| self.get(key).map(|_| self.length(key)).transpose();
        let (rx, ry) = match (given("rx")?, given("ry")?) {
            (Some(rx), Some(ry)) => (rx, ry),
            (Some(both), None) | (None, Some(both)) => (both, both),
            (None, None) => (0.0, 0.0),
        };
        if w <= 0.0 || h <= 0.0 {
            return Ok(Vec::new());
        }
        let (rx, ry) = (rx.clamp(0.0, 0.5 * w), ry.clamp(0.0, 0.5 * h));
        if rx == 0.0 || ry == 0.0 {
            let corners = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
            return Ok(DrawnLine::through(&corners, true).into_iter().collect());
        }
        let (r, t) = (x + w, y + h);
        let arc = format!("A{rx} {ry} 0 0 1 ");
        let data = format!(
            "M{} {y}H{}{arc}{r} {}V{}{arc}{} {t}H{}{arc}{x} {}V{}{arc}{} {y}Z",
            x + rx,
            r - rx,
            y + ry,
            t - ry,
            r - rx,
            x + rx,
            t - ry,
            y + ry,
            x + rx
        );
        path::lines(&data).map_err(|found| self.malformed("a rectangle", &found))
    }
}

/// A length with an absolute unit in mm.
fn absolute_mm(text: &str) -> Option<f64> {
    let units = [("mm", 1.0), ("cm", 10.0), ("in", 25.4), ("pt", 25.4 / 72.0), ("pc", 25.4 / 6.0)];
    let text = text.trim();
    units.iter().find_map(|(unit, mm)| {
        let value = text.strip_suffix(unit)?.trim().parse::<f64>().ok()? * mm;
        (value.is_finite() && value > 0.0).then_some(value)
    })
}

fn malformed(place: Place, expected: &str, found: String) -> ReadError {
    ReadError::Malformed { format: Format::Svg, place, expected: expected.to_owned(), found }
}

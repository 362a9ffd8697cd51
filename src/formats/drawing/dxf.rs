//! Drawing exchange format of AutoCAD, ASCII: LINE, ARC, CIRCLE, POLYLINE with VERTEX, LWPOLYLINE, with bulges.
//!
//! Source: Autodesk, DXF Reference, "Entities section". Lines and arcs that meet within a millionth of the drawing's extent are joined. The unit
//! is that of `$INSUNITS` (inches, mm, cm, m); without it a unit is 1 mm. Other entities are refused by name, but for texts, points and
//! dimensions, which are no lines. Entities that are invisible, or on a layer that is off or frozen, are counted, and not read.
//!
//! All but LINE have coordinates of their own ("Object coordinate systems"). They are those of the drawing where the extrusion direction
//! is (0, 0, 1), and have x turned over where it is (0, 0, −1), as it is after MIRROR.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use super::arc::Arc;
use super::{DrawnLine, LeftOut, PlaceMm, count_hidden, straight};
use crate::error::quoted;
use crate::scan::{decoded, finite, lines};
use crate::{Format, Place, ReadError};

/// Reads the lines of a drawing.
///
/// # Errors
///
/// A group without a code or a value, a number that is none, an entity that is not read, with the line of the file.
pub fn read(bytes: &[u8]) -> Result<Vec<DrawnLine>, ReadError> {
    read_and_count(bytes).map(|(lines, _)| lines)
}

/// The lines of a drawing, and how many entities of each name are not shown and were left out.
///
/// # Errors
///
/// As [`read`].
pub fn read_and_count(bytes: &[u8]) -> Result<(Vec<DrawnLine>, LeftOut), ReadError> {
    if bytes.starts_with(b"AutoCAD Binary DXF") {
        return Err(ReadError::Unsupported {
            format: Format::Dxf,
            place: Place::Byte(0),
            expected: "DXF as text".to_owned(),
            found: "binary DXF".to_owned(),
        });
    }
    let text = decoded(bytes);
    let groups = groups(text.as_bytes())?;
    let unit_mm = unit_mm(&groups);
    let unseen = unseen_layers(&groups)?;
    let (mut found, mut left_out) = (Vec::new(), LeftOut::new());
    let mut section = "";
    let mut index = 0;
    while index < groups.len() {
        let group = &groups[index];
        let mut end = end_of(&groups, index);
        let fields = &groups[index + 1..end];
        match (group.code, group.value.as_str()) {
            (0, "SECTION") => section = fields.first().map_or("", |field| field.value.as_str()),
            (0, "ENDSEC") => section = "",
            (0, "EOF") => break,
            (0, name) if section == "ENTITIES" => {
                let line;
                let is_shown = is_shown(fields, &unseen)?;
                (line, end) = match name {
                    "POLYLINE" => polyline(&groups, index, fields)?,
                    _ if is_shown => (entity(name, group.line, fields)?, end),
                    _ => (None, end),
                };
                match is_shown {
                    true => found.extend(line.map(|line| placed(line, group, fields)).transpose()?),
                    false if NO_LINES.contains(&name) => {}
                    false => count_hidden(&mut left_out, name),
                }
            }
            _ => {}
        }
        index = end;
    }
    let scaled =
        found.into_iter().map(|line: DrawnLine| line.mapped(|[x, y]| [unit_mm * x, unit_mm * y]));
    Ok((joined(scaled.collect()), left_out))
}

/// Where the group after one begins that begins something: an entity, a section.
fn end_of(groups: &[Group], index: usize) -> usize {
    let next = groups[index + 1..].iter().position(|group| group.code == 0);
    next.map_or(groups.len(), |next| index + 1 + next)
}

/// The layers that are off or frozen, in small letters.
fn unseen_layers(groups: &[Group]) -> Result<BTreeSet<String>, ReadError> {
    let mut unseen = BTreeSet::new();
    for (index, group) in groups.iter().enumerate() {
        if group.code != 0 || group.value != "LAYER" {
            continue;
        }
        let fields = &groups[index + 1..end_of(groups, index)];
        let (is_off, is_frozen) = (value(fields, 62)? < 0.0, has_bit(fields, FROZEN)?);
        if is_off || is_frozen {
            let name = fields.iter().find(|field| field.code == 2);
            unseen.extend(name.map(|name| name.value.to_lowercase()));
        }
    }
    Ok(unseen)
}

/// Whether an entity is shown, and its layer is.
fn is_shown(fields: &[Group], unseen: &BTreeSet<String>) -> Result<bool, ReadError> {
    let layer = fields.iter().find(|field| field.code == 8);
    let is_unseen = layer.is_some_and(|layer| unseen.contains(&layer.value.to_lowercase()));
    Ok(!is_unseen && value(fields, 60)? != 1.0)
}

/// A line of an entity in the coordinates of the drawing.
fn placed(line: DrawnLine, entity: &Group, fields: &[Group]) -> Result<DrawnLine, ReadError> {
    let is_in_space = entity.value == "POLYLINE" && has_bit(fields, IN_SPACE)?;
    if entity.value == "LINE" || is_in_space {
        return Ok(line);
    }
    let [x, y] = [value(fields, 210)?, value(fields, 220)?];
    let z = value_or(fields, 230, 1.0)?;
    if x.abs().max(y.abs()) > SAME_DIRECTION * z.abs() || z == 0.0 {
        return Err(ReadError::Unsupported {
            format: Format::Dxf,
            place: Place::Line { line: entity.line, column: 0 },
            expected: "0, 0, 1 or 0, 0, -1: draw it in the plane x, y".to_owned(),
            found: format!("{} with the extrusion direction {x}, {y}, {z}", entity.value),
        });
    }
    // The arbitrary axis algorithm gives (−1, 0, 0) and (0, 1, 0) as axes of (0, 0, −1).
    Ok(if z < 0.0 { line.mapped(|[x, y]| [-x, y]) } else { line })
}

/// Bits of the flags, group 70: a polyline that is closed, one in space with the coordinates of the drawing; a layer that is frozen.
const CLOSED: i64 = 1;
const IN_SPACE: i64 = 8;
const FROZEN: i64 = 1;

/// Directions that differ by less are one: numbers of a file are rounded.
const SAME_DIRECTION: f64 = 1e-9;

/// A code and its value.
struct Group {
    code: i32,
    value: String,
    /// Line of the value in the file.
    line: usize,
}

impl Group {
    fn number(&self) -> Result<f64, ReadError> {
        finite(self.value.as_bytes()).ok_or_else(|| malformed(self.line, "a number", &self.value))
    }
}

fn groups(text: &[u8]) -> Result<Vec<Group>, ReadError> {
    let mut groups = Vec::new();
    let mut all = lines(text).filter(|(_, line)| !line.is_empty() || !groups_end(text, line));
    while let Some((number, code)) = all.next() {
        let word = code.trim_ascii();
        if word.is_empty() {
            continue;
        }
        let parsed = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let Some(code) = parsed else {
            return Err(malformed(number, "a group code", &quoted(word)));
        };
        let Some((line, value)) = all.next() else {
            return Err(malformed(number, "a value after the group code", "the end of the file"));
        };
        let value = String::from_utf8_lossy(value.trim_ascii()).into_owned();
        groups.push(Group { code, value, line });
    }
    Ok(groups)
}

/// Whether an empty line is the one after the last line feed.
fn groups_end(text: &[u8], line: &[u8]) -> bool {
    std::ptr::eq(line.as_ptr(), text.as_ptr_range().end)
}

/// The unit of `$INSUNITS` in mm.
fn unit_mm(groups: &[Group]) -> f64 {
    let named = groups.iter().position(|group| group.code == 9 && group.value == "$INSUNITS");
    match named.and_then(|at| groups.get(at + 1)).map(|group| group.value.as_str()) {
        Some("1") => 25.4,
        Some("5") => 10.0,
        Some("6") => 1000.0,
        _ => 1.0,
    }
}

/// The last value of a code among fields, or 0.
fn value(fields: &[Group], code: i32) -> Result<f64, ReadError> {
    value_or(fields, code, 0.0)
}

fn value_or(fields: &[Group], code: i32, default: f64) -> Result<f64, ReadError> {
    fields.iter().rev().find(|field| field.code == code).map_or(Ok(default), Group::number)
}

/// Whether the flags, group 70, have a bit.
fn has_bit(fields: &[Group], bit: i64) -> Result<bool, ReadError> {
    Ok(value(fields, 70)? as i64 & bit != 0)
}

/// Entities that are no lines.
const NO_LINES: [&str; 10] = [
    "TEXT",
    "MTEXT",
    "POINT",
    "DIMENSION",
    "LEADER",
    "ATTRIB",
    "ATTDEF",
    "VIEWPORT",
    "SEQEND",
    "HATCH",
];

fn entity(name: &str, line: usize, fields: &[Group]) -> Result<Option<DrawnLine>, ReadError> {
    let place =
        |x: i32| -> Result<PlaceMm, ReadError> { Ok([value(fields, x)?, value(fields, x + 10)?]) };
    let arc = |from_deg: f64, sweep_deg: f64| -> Result<Option<DrawnLine>, ReadError> {
        let radius = value(fields, 40)?;
        if radius <= 0.0 {
            return Err(malformed(line, "a radius above 0", &radius.to_string()));
        }
        let (from, sweep) = (from_deg.to_radians(), sweep_deg.to_radians());
        let arc = Arc { centre: place(10)?, radii: [radius; 2], turn: 0.0, from, sweep };
        let mut pieces = arc.pieces();
        let closed = sweep == TAU;
        let first = pieces[0][0];
        if let Some(last) = pieces.last_mut().filter(|_| closed) {
            last[3] = first;
        }
        Ok(Some(DrawnLine { pieces, closed }))
    };
    match name {
        "LINE" => Ok(DrawnLine::through(&[place(10)?, place(11)?], false)),
        "CIRCLE" => arc(0.0, 360.0),
        "ARC" => {
            let [from, to] = [value(fields, 50)?, value(fields, 51)?];
            let sweep = (to - from).rem_euclid(360.0);
            arc(from, if sweep == 0.0 { 360.0 } else { sweep })
        }
        "LWPOLYLINE" => {
            let mut corners: Vec<(PlaceMm, f64)> = Vec::new();
            for field in fields {
                match (field.code, corners.last_mut()) {
                    (10, _) => corners.push(([field.number()?, 0.0], 0.0)),
                    (20, Some(corner)) => corner.0[1] = field.number()?,
                    (42, Some(corner)) => corner.1 = field.number()?,
                    _ => {}
                }
            }
            Ok(bulged(&corners, has_bit(fields, CLOSED)?))
        }
        name if NO_LINES.contains(&name) => Ok(None),
        name => Err(ReadError::Unsupported {
            format: Format::Dxf,
            place: Place::Line { line, column: 0 },
            expected: "LINE, ARC, CIRCLE, POLYLINE or LWPOLYLINE".to_owned(),
            found: quoted(name.as_bytes()),
        }),
    }
}

/// A POLYLINE with its VERTEX entities, and the group after them.
fn polyline(
    groups: &[Group],
    start: usize,
    fields: &[Group],
) -> Result<(Option<DrawnLine>, usize), ReadError> {
    let is_closed = has_bit(fields, CLOSED)?;
    let mut corners = Vec::new();
    let mut index = start + 1 + fields.len();
    while let Some(group) = groups.get(index) {
        let end = end_of(groups, index);
        let fields = &groups[index + 1..end];
        index = end;
        match group.value.as_str() {
            "VERTEX" => {
                corners.push(([value(fields, 10)?, value(fields, 20)?], value(fields, 42)?));
            }
            "SEQEND" => break,
            found => return Err(malformed(group.line, "VERTEX or SEQEND", found)),
        }
    }
    Ok((bulged(&corners, is_closed), index))
}

/// The line through corners, each with the tangent of a quarter of the angle of the arc to the next.
fn bulged(corners: &[(PlaceMm, f64)], closed: bool) -> Option<DrawnLine> {
    let count = corners.len();
    let sides = if closed { count } else { count.saturating_sub(1) };
    let mut pieces = Vec::new();
    for index in 0..sides {
        let ((p, bulge), (q, _)) = (corners[index], corners[(index + 1) % count]);
        if p == q {
            continue;
        }
        if bulge == 0.0 {
            pieces.push(straight(p, q));
            continue;
        }
        // Bulge b: sagitta over half the chord, above 0 where the arc runs counter-clockwise.
        let radius = 0.25 * (p[0] - q[0]).hypot(p[1] - q[1]) * (1.0 / bulge + bulge).abs();
        let flags = [bulge.abs() > 1.0, bulge > 0.0];
        let Some(arc) = Arc::between(p, q, [radius; 2], 0.0, flags) else { continue };
        let mut round = arc.pieces();
        round[0][0] = p;
        if let Some(last) = round.last_mut() {
            last[3] = q;
        }
        pieces.extend(round);
    }
    (!pieces.is_empty()).then_some(DrawnLine { pieces, closed })
}

/// Open lines joined where their ends meet, in the order in which they came.
fn joined(lines: Vec<DrawnLine>) -> Vec<DrawnLine> {
    let places = lines.iter().flat_map(|line| line.pieces.iter().flatten());
    let extent = places.flatten().fold(0.0_f64, |most, value| most.max(value.abs()));
    let meets = |p: PlaceMm, q: PlaceMm| (p[0] - q[0]).hypot(p[1] - q[1]) <= 1e-6 * extent;
    let (mut done, mut open): (Vec<DrawnLine>, Vec<DrawnLine>) =
        lines.into_iter().partition(|line| line.closed);
    open.reverse();
    while let Some(mut line) = open.pop() {
        let start = line.pieces[0][0];
        while let Some(end) = line.pieces.last().map(|piece| piece[3]) {
            if meets(end, start) {
                line.closed = true;
                if let Some(last) = line.pieces.last_mut() {
                    last[3] = start;
                }
                break;
            }
            let next = open.iter().rposition(|other| {
                let last = other.pieces.last().map_or(other.pieces[0][0], |piece| piece[3]);
                meets(end, other.pieces[0][0]) || meets(end, last)
            });
            let Some(next) = next else { break };
            let mut other = open.remove(next);
            if !meets(end, other.pieces[0][0]) {
                other.pieces.reverse();
                other.pieces.iter_mut().for_each(|piece| piece.reverse());
            }
            other.pieces[0][0] = end;
            line.pieces.extend(other.pieces);
        }
        done.push(line);
    }
    done
}

fn malformed(line: usize, expected: &str, found: &str) -> ReadError {
    ReadError::Malformed {
        format: Format::Dxf,
        place: Place::Line { line, column: 0 },
        expected: expected.to_owned(),
        found: found.to_owned(),
    }
}

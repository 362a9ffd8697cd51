//! OFF: the vertices of a model as points (Geomview Manual, "OFF: Polyhedra"; Princeton Shape Benchmark, "OFF file format").
//!
//! The word `OFF`, the numbers of vertices, faces and edges, then a line `x y z` for each vertex. Colours, normals and texture
//! coordinates may follow on a line (`COFF`, `NOFF`, `STOFF` and so on) and are passed over. `#` begins a comment. The numbers may
//! stand on the line of the word. A vertex with a coordinate that is NaN is a gap. Then a line `n i j k …` for each face, with the
//! numbers of its corners, from 0; it is read where triangles are asked for.
//!
//! The format has no unit: it is taken from the options, or is mm. Homogeneous coordinates (`4OFF`), other dimensions (`nOFF`) and
//! the binary form are refused.

use crate::error::quoted;
use crate::lengths::{Lengths, Points, check_count, three_numbers, words};
use crate::scan::{lines, without_bom};
use crate::triangles::{Gathered, TooFar, Triangles};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, Topography};

/// Reads the vertices as a cloud, in the order of the file. `O(bytes)`.
///
/// Of `options` the units count: one for all, or one each for x, y and z.
///
/// # Errors
///
/// A header that is none or of another kind; fewer vertices or faces than it tells, or more lines; a vertex without three numbers, or with one that is
/// infinite, with its line; no vertex; more than [`MAX_POINTS`](crate::MAX_POINTS) of them.
///
/// # Example
///
/// ```
/// let file = b"OFF\n1 0 0\n0 0.5 1\n";
/// let topography = asphera_formats::off::read(file, &Default::default())?;
/// assert_eq!(topography.points().next(), Some([0.0, 0.5, 1.0]));
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let mut points = Points::new(Lengths::of(FORMAT, None, options)?);
    let mut lines = content(without_bom(bytes)).peekable();
    let counts = counted(&mut lines)?;
    let last =
        vertices(&mut lines, counts[0], |point, place| points.push(point, || place.clone()))?;
    faces(&mut lines, counts, last, |_, _, _| Ok(()))?;
    points.finish([1, 2, 3], Place::Line { line: last, column: 0 })
}

/// Reads the faces as triangles, in the order of the file; `None` where it has no faces. `O(bytes)`.
///
/// Arguments as of [`read`].
///
/// # Errors
///
/// Those of [`read`]; a face without the number and the numbers of its corners, or with one that
/// the file does not have, with its line.
pub fn read_triangles(bytes: &[u8], options: &TextOptions) -> Result<Option<Triangles>, ReadError> {
    let mut mesh = Gathered::new(Lengths::of(FORMAT, None, options)?);
    let mut lines = content(without_bom(bytes)).peekable();
    let counts = counted(&mut lines)?;
    let last =
        vertices(&mut lines, counts[0], |point, place| mesh.corner(point, || place.clone()))?;
    faces(&mut lines, counts, last, |read, line, content| {
        let corners = corners(content).ok_or_else(|| {
            let expected =
                format!("number and numbers of the corners of face {read} of {}", counts[1]);
            malformed(line, expected, quoted(content))
        })?;
        mesh.polygon(&corners).map_err(|TooFar { corner, expected }| {
            malformed(line, expected, format!("corner {}", corners[corner]))
        })
    })?;
    Ok(mesh.finish())
}

/// Goes through the lines of the faces, each with its number from 1 and that of its line, up to the end of the file. `last` is the line
/// of the last vertex.
fn faces<'a>(
    lines: &mut impl Iterator<Item = (usize, &'a [u8])>,
    [vertices, faces]: [u64; 2],
    mut last: usize,
    mut take: impl FnMut(u64, usize, &'a [u8]) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    for read in 0..faces {
        let Some((line, content)) = lines.next() else {
            let found = format!("the end of the file after {read}");
            return Err(malformed(last, format!("{faces} faces"), found));
        };
        last = line;
        take(read + 1, line, content)?;
    }
    let Some((line, content)) = lines.next() else { return Ok(()) };
    let expected = format!("the end of the file after {vertices} vertices and {faces} faces");
    let found = format!("{}: the numbers in the header may be wrong", quoted(content));
    Err(malformed(line, expected, found))
}

/// Reads `count` vertices and gives the line of the last one.
fn vertices<'a>(
    lines: &mut impl Iterator<Item = (usize, &'a [u8])>,
    count: u64,
    mut take: impl FnMut([f64; 3], &Place) -> Result<(), ReadError>,
) -> Result<usize, ReadError> {
    let mut last = 1;
    for read in 0..count {
        let Some((line, content)) = lines.next() else {
            let found = format!("the end of the file after {read}");
            return Err(malformed(last, format!("{count} vertices"), found));
        };
        last = line;
        let point = three_numbers(words(content)).ok_or_else(|| {
            malformed(line, format!("x y z of vertex {} of {count}", read + 1), quoted(content))
        })?;
        take(point, &Place::Line { line, column: 0 })?;
    }
    Ok(last)
}

/// The corners of a face: as many as the first number of its line tells. Colours may follow.
fn corners(content: &[u8]) -> Option<Vec<i64>> {
    let mut numbers =
        words(content).map(|word| std::str::from_utf8(word).ok()?.parse::<i64>().ok());
    let count = usize::try_from(numbers.next()??).ok()?;
    let corners: Option<Vec<i64>> = numbers.take(count).collect();
    corners.filter(|corners| corners.len() == count)
}

/// Whether a file begins as one: with its word.
pub(crate) fn is_off(bytes: &[u8]) -> bool {
    let text = without_bom(bytes);
    let first = content(&text[..text.len().min(LOOKED_AT)]).next();
    let word = first.and_then(|(_, line)| words(line).next());
    word.is_some_and(|word| word.ends_with(b"OFF") && is_known(word))
}

/// The numbers of vertices and faces, from the header.
fn counted<'a>(
    lines: &mut std::iter::Peekable<impl Iterator<Item = (usize, &'a [u8])>>,
) -> Result<[u64; 2], ReadError> {
    let expected = || "OFF, alone or with the numbers of vertices, faces and edges".to_owned();
    let (line, first) =
        lines.next().ok_or_else(|| malformed(1, expected(), "no line".to_owned()))?;
    let mut after = words(first);
    let word = after.next().unwrap_or_default();
    if !word.ends_with(b"OFF") || !is_known(word) {
        return Err(malformed(line, expected(), quoted(first)));
    }
    let after: Vec<&[u8]> = after.collect();
    let is_plain = !word.iter().any(|byte| matches!(byte, b'4' | b'n'));
    if !is_plain || after.first() == Some(&&b"BINARY"[..]) {
        let expected = "OFF as text with three coordinates a vertex; save it as such".to_owned();
        return Err(malformed(line, expected, quoted(first)));
    }
    // A name may stand there instead of numbers.
    if let Some(counts) = counts(&after) {
        return check(line, counts);
    }
    let (line, second) = lines
        .next()
        .ok_or_else(|| malformed(line, NUMBERS.to_owned(), "the end of the file".to_owned()))?;
    match counts(&words(second).collect::<Vec<_>>()) {
        Some(counts) => check(line, counts),
        None => Err(malformed(line, NUMBERS.to_owned(), quoted(second))),
    }
}

fn check(line: usize, counts: [u64; 2]) -> Result<[u64; 2], ReadError> {
    check_count(FORMAT, counts[0], || Place::Line { line, column: 0 })?;
    Ok(counts)
}

/// The first two of two or three whole numbers.
fn counts(words: &[&[u8]]) -> Option<[u64; 2]> {
    let mut numbers = words.iter().map(|word| std::str::from_utf8(word).ok()?.parse::<u64>().ok());
    let count = numbers.next()??;
    let others: Option<Vec<u64>> = numbers.collect();
    match others?[..] {
        [faces] | [faces, _] => Some([count, faces]),
        _ => None,
    }
}

/// Whether all letters before `OFF` are those of the format: ST, C, N, 4, n.
fn is_known(word: &[u8]) -> bool {
    let mut rest = &word[..word.len().saturating_sub(3)];
    for part in [&b"ST"[..], b"C", b"N", b"4", b"n"] {
        rest = rest.strip_prefix(part).unwrap_or(rest);
    }
    rest.is_empty()
}

/// Lines without comments that are not empty, with their numbers.
fn content(text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    lines(text)
        .map(|(number, line)| {
            let end = line.iter().position(|&byte| byte == b'#').unwrap_or(line.len());
            (number, line[..end].trim_ascii())
        })
        .filter(|(_, line)| !line.is_empty())
}

fn malformed(line: usize, expected: String, found: String) -> ReadError {
    let place = Place::Line { line, column: 0 };
    ReadError::Malformed { format: FORMAT, place, expected, found }
}

const FORMAT: Format = Format::Off;
const NUMBERS: &str = "the numbers of vertices, faces and edges";
const LOOKED_AT: usize = 4096;

#[cfg(test)]
mod tests;

//! Wavefront OBJ: the vertices of a model as points (Alias|Wavefront, "Advanced Visualizer", appendix B1, "Object files").
//!
//! A line `v x y z` is a vertex. A weight or colours may follow and are passed over, as are all other lines: normals, groups,
//! materials, and faces but where triangles are asked for. `#` begins a comment. A line that ends with `\` goes on in the next one. A vertex with a coordinate that is NaN is a
//! gap.
//!
//! The format has no unit: it is taken from the options, or is mm. Nothing says how many vertices there are, so a file that was cut
//! between two lines cannot be told from a whole one.

use std::borrow::Cow;

use crate::error::quoted;
use crate::lengths::{Lengths, Points, three_numbers, words};
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
/// A vertex without three numbers, or with one that is infinite, with its line; no vertex; more than
/// [`MAX_POINTS`](crate::MAX_POINTS) of them.
///
/// # Example
///
/// ```
/// let file = b"# one vertex\nv 0 0.5 1\n";
/// let topography = asphera_formats::obj::read(file, &Default::default())?;
/// assert_eq!(topography.points().next(), Some([0.0, 0.5, 1.0]));
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let mut points = Points::new(Lengths::of(FORMAT, None, options)?);
    let mut last = 1;
    for (line, content) in logical_lines(without_bom(bytes)) {
        last = line;
        if let Some(point) = vertex(line, &content)? {
            points.push(point, || Place::Line { line, column: 0 })?;
        }
    }
    points.finish([1, 2, 3], Place::Line { line: last, column: 0 })
}

/// Reads the faces as triangles, in the order of the file; `None` where it has no faces. `O(bytes)`.
///
/// A line `f i j k …` is a face: the numbers of its vertices, from 1, or below 0 counted back from the last one before the line.
/// Numbers behind slashes are passed over. Arguments as of [`read`].
///
/// # Errors
///
/// Those of [`read`], but that a file may have no vertex; a face with fewer than three corners, or with one that the file does not
/// have, with its line.
pub fn read_triangles(bytes: &[u8], options: &TextOptions) -> Result<Option<Triangles>, ReadError> {
    let mut mesh = Gathered::new(Lengths::of(FORMAT, None, options)?);
    // Faces may stand before the vertices that they name.
    let mut faces: Vec<(usize, Vec<i64>)> = Vec::new();
    for (line, content) in logical_lines(without_bom(bytes)) {
        if let Some(point) = vertex(line, &content)? {
            mesh.corner(point, || Place::Line { line, column: 0 })?;
        } else if words(&content).next() == Some(b"f") {
            let corners = corners(&content, mesh.corners())
                .ok_or_else(|| malformed(line, FACE.into(), quoted(&content)))?;
            faces.push((line, corners));
        }
    }
    for (line, corners) in faces {
        mesh.polygon(&corners).map_err(|TooFar { corner, expected }| {
            let found = format!("corner {}, counted from 1", corners[corner] + 1);
            malformed(line, expected, found)
        })?;
    }
    Ok(mesh.finish())
}

/// The vertex of a line, if it is one.
fn vertex(line: usize, content: &[u8]) -> Result<Option<[f64; 3]>, ReadError> {
    let mut found = words(content);
    if found.next() != Some(b"v") {
        return Ok(None);
    }
    match three_numbers(found) {
        Some(point) => Ok(Some(point)),
        None => Err(malformed(line, "v and three numbers".into(), quoted(content))),
    }
}

/// The corners of a face, from 0; `count` vertices stand before it.
fn corners(content: &[u8], count: usize) -> Option<Vec<i64>> {
    let corner = |word: &[u8]| {
        let number = word.split(|&byte| byte == b'/').next()?;
        let number: i64 = std::str::from_utf8(number).ok()?.parse().ok()?;
        // No corner has the number 0.
        Some(if number < 0 { count as i64 + number } else { number - 1 })
    };
    let corners: Option<Vec<i64>> = words(content).skip(1).map(corner).collect();
    corners.filter(|corners| corners.len() >= 3)
}

fn malformed(line: usize, expected: String, found: String) -> ReadError {
    let place = Place::Line { line, column: 0 };
    ReadError::Malformed { format: FORMAT, place, expected, found }
}

/// Whether a file begins as one: with lines of its keywords, of which one is a vertex.
pub(crate) fn is_obj(bytes: &[u8]) -> bool {
    const LOOKED_AT: usize = 65_536;
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    for (_, content) in logical_lines(without_bom(start)) {
        let mut found = words(&content);
        match found.next() {
            None => {}
            Some(b"v") => return three_numbers(found).is_some(),
            Some(word) if KEYWORDS.contains(&word) => {}
            Some(_) => return false,
        }
    }
    false
}

/// Lines without comments, those joined that go on; each with the number of its first line. Empty where nothing is left.
fn logical_lines(text: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, [u8]>)> {
    let mut lines = lines(text);
    std::iter::from_fn(move || {
        let (number, first) = lines.next()?;
        let mut content = Cow::Borrowed(without_comment(first));
        while content.ends_with(b"\\") {
            let Some((_, next)) = lines.next() else { break };
            let joined = content.to_mut();
            joined.pop();
            joined.push(b' ');
            joined.extend_from_slice(without_comment(next));
        }
        Some((number, content))
    })
}

fn without_comment(line: &[u8]) -> &[u8] {
    let end = line.iter().position(|&byte| byte == b'#').unwrap_or(line.len());
    line[..end].trim_ascii_end()
}

const FORMAT: Format = Format::Obj;
const FACE: &str = "f and the numbers of three vertices or more";
/// Words that may stand before the first vertex.
const KEYWORDS: [&[u8]; 12] =
    [b"mtllib", b"o", b"g", b"s", b"usemtl", b"vn", b"vt", b"vp", b"mg", b"cstype", b"deg", b"lod"];

#[cfg(test)]
mod tests;

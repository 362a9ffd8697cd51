//! Wavefront OBJ: the vertices of a model as points (Alias|Wavefront, "Advanced Visualizer", appendix B1, "Object files").
//!
//! A line `v x y z` is a vertex. A weight or colours may follow and are passed over, as are all other lines: normals, faces, groups,
//! materials. `#` begins a comment. A line that ends with `\` goes on in the next one. A vertex with a coordinate that is NaN is a
//! gap.
//!
//! The format has no unit: it is taken from the options, or is mm. Nothing says how many vertices there are, so a file that was cut
//! between two lines cannot be told from a whole one.

use std::borrow::Cow;

use crate::error::quoted;
use crate::lengths::{Lengths, Points, three_numbers, words};
use crate::scan::{lines, without_bom};
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
        let place = || Place::Line { line, column: 0 };
        last = line;
        let mut found = words(&content);
        if found.next() != Some(b"v") {
            continue;
        }
        let point = three_numbers(found).ok_or_else(|| ReadError::Malformed {
            format: FORMAT,
            place: place(),
            expected: "v and three numbers".into(),
            found: quoted(&content),
        })?;
        points.push(point, place)?;
    }
    points.finish([1, 2, 3], Place::Line { line: last, column: 0 })
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
/// Words that may stand before the first vertex.
const KEYWORDS: [&[u8]; 12] =
    [b"mtllib", b"o", b"g", b"s", b"usemtl", b"vn", b"vt", b"vp", b"mg", b"cstype", b"deg", b"lod"];

#[cfg(test)]
mod tests;

//! STL, binary and ASCII (3D Systems, "StereoLithography Interface Specification", 1988): the corners of triangles as points.
//!
//! ```text
//! 80 bytes of any content            solid NAME
//! n as u32                             facet normal nx ny nz
//! n times 50 bytes:                      outer loop
//!   normal, 3 × f32                        vertex x y z        three times
//!   three corners, 9 × f32               endloop
//!   2 bytes of attributes              endfacet
//!                                    endsolid NAME
//! ```
//!
//! All numbers are little-endian. Binary files may begin with the word `solid`, too: a file of 84 + 50 n bytes is binary.
//!
//! Triangles share corners. Each place is taken once, where it first appears; places are the same where all three coordinates are
//! equal. A corner with a coordinate that is NaN is a gap. Normals and attributes are passed over.
//!
//! The format has no unit: it is taken from the options, or is mm.

mod pieces;
mod write;

pub use pieces::MeshPieces;
pub use write::write_mesh;

use std::collections::{HashMap, HashSet};

use crate::error::quoted;
use crate::lengths::{Lengths, Points, three_numbers, words};
use crate::scan::lines;
use crate::triangles::{Gathered, TooFar, Triangles};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, Topography};

/// Reads the corners of all triangles as a cloud, each place once. `O(bytes)`.
///
/// Of `options` the units count: one for all, or one each for x, y and z.
///
/// # Errors
///
/// A file that is neither text of the form above nor of the length that its number of triangles asks for; no triangles; a
/// coordinate that is infinite; more than [`MAX_POINTS`](crate::MAX_POINTS) corners.
///
/// # Example
///
/// ```
/// let mut file = vec![0; 84 + 50];
/// file[80] = 1;
/// file[84 + 12..][..4].copy_from_slice(&0.5f32.to_le_bytes());
/// let topography = asphera_formats::stl::read(&file, &Default::default())?;
/// let expected = [[0.5, 0.0, 0.0], [0.0, 0.0, 0.0]];
/// assert_eq!(topography.points().collect::<Vec<_>>(), expected);
/// # Ok::<(), asphera_formats::ReadError>(())
/// ```
pub fn read(bytes: &[u8], options: &TextOptions) -> Result<Topography, ReadError> {
    let points = Points::new(Lengths::of(FORMAT, None, options)?);
    let mut corners = Corners { points, seen: HashSet::new() };
    let end = each(bytes, |corner, place| corners.take(corner, place))?;
    corners.points.finish([1, 2, 3], end)
}

/// Reads the triangles, in the order of the file. Corners at one place are one. `O(bytes)`.
///
/// Arguments as of [`read`].
///
/// # Errors
///
/// Those of [`read`]; a triangle with a corner that is a gap, with its place.
pub fn read_triangles(bytes: &[u8], options: &TextOptions) -> Result<Triangles, ReadError> {
    let mut mesh = Gathered::new(Lengths::of(FORMAT, None, options)?);
    // Asked by place alone, so its order reaches nothing.
    let mut numbers: HashMap<[u64; 3], i64> = HashMap::new();
    let mut face = Vec::new();
    let end = each(bytes, |corner, place| {
        let next = numbers.len() as i64;
        let number = *numbers.entry(key(corner)).or_insert(next);
        if number == next {
            mesh.corner(corner, || place.clone())?;
        }
        face.push(number);
        if face.len() < 3 {
            return Ok(());
        }
        let done = mesh.polygon(&face).map_err(|TooFar { expected, .. }| {
            malformed(place.clone(), &expected, "one that is NaN".into())
        });
        face.clear();
        done
    })?;
    mesh.finish().ok_or_else(|| malformed(end, "at least one triangle", "none".into()))
}

/// Does something for the three corners of every triangle, and gives the place of the end.
fn each(
    bytes: &[u8],
    take: impl FnMut([f64; 3], &Place) -> Result<(), ReadError>,
) -> Result<Place, ReadError> {
    // Of a binary file that was cut the length does not fit, but text holds no byte 0.
    let is_text = begins_solid(bytes) && !bytes.iter().take(2 * HEADER).any(|&byte| byte == 0);
    if !is_binary(bytes) && is_text { ascii(bytes, take) } else { binary(bytes, take) }
}

/// Whether the length is that of a binary file with as many triangles as it says.
pub(crate) fn is_binary(bytes: &[u8]) -> bool {
    triangles(bytes).is_some_and(|count| count > 0 && expected_len(count) == bytes.len() as u64)
}

/// Whether a file begins as an ASCII file does: with the word `solid`, and before long the word `facet`.
pub(crate) fn is_ascii(bytes: &[u8]) -> bool {
    const LOOKED_AT: usize = 4096;
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    begins_solid(bytes) && words(start).any(|word| word.eq_ignore_ascii_case(b"facet"))
}

fn begins_solid(bytes: &[u8]) -> bool {
    words(&bytes[..bytes.len().min(HEADER)])
        .next()
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// The corners taken so far.
struct Corners {
    points: Points,
    seen: HashSet<[u64; 3]>,
}

impl Corners {
    fn take(&mut self, corner: [f64; 3], place: &Place) -> Result<(), ReadError> {
        if self.seen.insert(key(corner)) {
            self.points.push(corner, || place.clone())?;
        }
        Ok(())
    }
}

/// Bits that are the same of the same place: -0 and 0 are one.
fn key(corner: [f64; 3]) -> [u64; 3] {
    corner.map(|value| (value + 0.0).to_bits())
}

fn binary(
    bytes: &[u8],
    mut take: impl FnMut([f64; 3], &Place) -> Result<(), ReadError>,
) -> Result<Place, ReadError> {
    let len = bytes.len() as u64;
    let Some(count) = triangles(bytes) else {
        let expected = "solid, or 80 bytes and the number of triangles";
        return Err(malformed(Place::Byte(len), expected, format!("{len} bytes")));
    };
    if expected_len(count) != len {
        let expected = format!("{} bytes for {count} triangles", expected_len(count));
        let whole = len.saturating_sub(HEADER as u64 + 4) / RECORD as u64;
        let found = format!("{len}, with room for {whole}");
        return Err(malformed(Place::Byte(HEADER as u64), &expected, found));
    }
    for (index, record) in bytes[HEADER + 4..].chunks_exact(RECORD).enumerate() {
        // The first three numbers are the normal; after the twelfth come attributes.
        let (numbers, _) = record.as_chunks::<4>();
        let (triples, _) = numbers.as_chunks::<3>();
        for (which, corner) in triples.iter().enumerate().skip(1) {
            let corner = corner.map(|number| f64::from(f32::from_le_bytes(number)));
            let at = HEADER + 4 + index * RECORD + 12 * which;
            take(corner, &Place::Byte(at as u64))?;
        }
    }
    Ok(Place::Byte(len))
}

/// The number of triangles that a binary file says it has.
fn triangles(bytes: &[u8]) -> Option<u32> {
    bytes.get(HEADER..)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

fn expected_len(count: u32) -> u64 {
    HEADER as u64 + 4 + RECORD as u64 * u64::from(count)
}

/// Token expected next in an ASCII file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Next {
    /// A solid, or the end of the file after one.
    Solid {
        is_first: bool,
    },
    Facet,
    Loop,
    /// This many corners of the triangle were read.
    Vertex(u8),
    EndFacet,
}

impl Next {
    const fn expected(self) -> &'static str {
        match self {
            Next::Solid { .. } => "solid",
            Next::Facet => "facet or endsolid",
            Next::Loop => "outer loop",
            Next::Vertex(3) => "endloop after three corners",
            Next::Vertex(_) => "vertex with three numbers",
            Next::EndFacet => "endfacet",
        }
    }
}

fn ascii(
    bytes: &[u8],
    mut take: impl FnMut([f64; 3], &Place) -> Result<(), ReadError>,
) -> Result<Place, ReadError> {
    let mut next = Next::Solid { is_first: true };
    let mut last = 1;
    for (line, content) in lines(bytes) {
        let Some(word) = words(content).next() else { continue };
        let place = || Place::Line { line, column: 0 };
        last = line;
        next = match (next, word.to_ascii_lowercase().as_slice()) {
            (Next::Solid { .. }, b"solid") => Next::Facet,
            (Next::Facet, b"facet") => Next::Loop,
            (Next::Facet, b"endsolid") => Next::Solid { is_first: false },
            (Next::Loop, b"outer") => Next::Vertex(0),
            (Next::Vertex(read @ 0..3), b"vertex") => {
                let corner = three_numbers(words(content).skip(1))
                    .ok_or_else(|| malformed(place(), next.expected(), quoted(content)))?;
                take(corner, &place())?;
                Next::Vertex(read + 1)
            }
            (Next::Vertex(3), b"endloop") => Next::EndFacet,
            (Next::EndFacet, b"endfacet") => Next::Facet,
            _ => return Err(malformed(place(), next.expected(), quoted(content))),
        };
    }
    let end = Place::Line { line: last, column: 0 };
    if next != (Next::Solid { is_first: false }) {
        return Err(malformed(end, next.expected(), "the end of the file".into()));
    }
    Ok(end)
}

fn malformed(place: Place, expected: &str, found: String) -> ReadError {
    ReadError::Malformed { format: FORMAT, place, expected: expected.into(), found }
}

const FORMAT: Format = Format::Stl;
/// Bytes before the number of triangles.
const HEADER: usize = 80;
/// Bytes of a triangle.
const RECORD: usize = 50;

#[cfg(test)]
mod tests;

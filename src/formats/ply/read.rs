//! The vertices of a PLY file as points, and its faces as triangles.

use super::body::{Body, Wanted};
use super::header::{Element, Header, Property, malformed};
use crate::lengths::{Lengths, Points, check_count};
use crate::triangles::{Gathered, TooFar, Triangles};
use crate::xyz::TextOptions;
use crate::{Format, Place, ReadError, Topography};

/// Reads the vertices as a cloud. `O(bytes)`.
///
/// Of `options` the units count: one for all, or one each for x, y and z.
///
/// # Errors
///
/// A header that does not follow the specification, with its line; no vertices, or vertices without x, y or z; a file that ends too
/// early or goes on behind its last element, or a line with more or fewer numbers than its element has, with the place; a coordinate that is infinite; more than [`MAX_POINTS`](crate::MAX_POINTS) vertices; a unit other than the
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
    let mut points = Points::new(Lengths::of(Format::Ply, header.unit, options)?);
    let (at, slots) = vertices(&header)?;
    let (before, after) = header.elements.split_at(at);
    let (vertices, after) = (&after[0], &after[1..]);
    let mut body = Body::new(bytes, &header);
    before.iter().try_for_each(|element| body.pass_over(element))?;
    body.each(vertices, |body, index| {
        let mut point = [0.0; 3];
        let place = body.record(vertices, index, Wanted::Numbers(slots, &mut point))?;
        points.push(point, || place.clone())
    })?;
    body.end()?;
    let place = body.place();
    after.iter().try_for_each(|element| body.pass_over(element))?;
    body.finish(after.last().unwrap_or(vertices))?;
    points.finish(slots.map(|slot| slot + 1), place)
}

/// Reads the faces as triangles, in the order of the file; `None` where it has no faces. `O(bytes)`.
///
/// Faces are the lists `vertex_indices` or `vertex_index` of the element `face`. Arguments as of [`read`].
///
/// # Errors
///
/// Those of [`read`]; a face with a corner that the file does not have, or that is a gap, with its place.
pub fn read_triangles(bytes: &[u8], options: &TextOptions) -> Result<Option<Triangles>, ReadError> {
    let header = Header::read(bytes)?;
    let mut mesh = Gathered::new(Lengths::of(Format::Ply, header.unit, options)?);
    let (at, slots) = vertices(&header)?;
    let Some((faces, list)) = faces(&header.elements) else { return Ok(None) };
    let mut body = Body::new(bytes, &header);
    // Faces may stand before the vertices that they name.
    let mut waiting: Vec<(Vec<f64>, Place)> = Vec::new();
    for (number, element) in header.elements.iter().enumerate() {
        if number == at {
            body.each(element, |body, index| {
                let mut point = [0.0; 3];
                let place = body.record(element, index, Wanted::Numbers(slots, &mut point))?;
                mesh.corner(point, || place.clone())
            })?;
            waiting.drain(..).try_for_each(|(face, place)| take(&mut mesh, &face, place))?;
        } else if number == faces {
            let mut face = Vec::new();
            body.each(element, |body, index| {
                face.clear();
                let place = body.record(element, index, Wanted::List(list, &mut face))?;
                match faces < at {
                    true => waiting.push((face.clone(), place)),
                    false => take(&mut mesh, &face, place)?,
                }
                Ok(())
            })?;
        } else {
            body.pass_over(element)?;
        }
        if number == at.max(faces) {
            body.end()?;
        }
    }
    header.elements.last().map_or(Ok(()), |last| body.finish(last))?;
    Ok(mesh.finish())
}

fn take(mesh: &mut Gathered, face: &[f64], place: Place) -> Result<(), ReadError> {
    // What is no index is behind every vertex.
    let index = |&value: &f64| if value.fract() == 0.0 { value as i64 } else { -1 };
    let indices: Vec<i64> = face.iter().map(index).collect();
    mesh.polygon(&indices).map_err(|TooFar { corner, expected }| {
        let found = format!("{}", face[corner]);
        ReadError::Malformed { format: Format::Ply, place, expected, found }
    })
}

/// The number of the element that holds vertices, and where x, y and z stand among the properties of one.
pub(super) fn vertices(header: &Header) -> Result<(usize, [usize; 3]), ReadError> {
    let Some(at) = header.elements.iter().position(|element| element.name == b"vertex") else {
        return Err(malformed(header.lines, "an element vertex", "none".into()));
    };
    let vertices = &header.elements[at];
    let slots = slots(vertices, header.lines)?;
    check_count(Format::Ply, vertices.count, || Place::Line { line: header.lines, column: 0 })?;
    Ok((at, slots))
}

/// The number of the element that holds faces, and of its property that lists their vertices.
fn faces(elements: &[Element]) -> Option<(usize, usize)> {
    let at = elements.iter().position(|element| element.name == b"face" && element.count > 0)?;
    let is_wanted = |property: &Property| matches!(property, Property::List { name, .. } if name == b"vertex_indices" || name == b"vertex_index");
    Some((at, elements[at].properties.iter().position(is_wanted)?))
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

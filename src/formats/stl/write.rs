//! Triangle meshes written as binary STL.

use std::io::{self, Write};

use crate::WriteError;

/// Writes a triangle mesh as binary STL: 80 bytes of header, a count, 50 bytes a triangle (StereoLithography Interface
/// Specification, 3D Systems, 1989).
///
/// `points_mm` are the vertices, x y z in mm; the file itself knows no unit and holds single precision. `triangles` are indices of
/// vertices, counted from 0, counter-clockwise seen from outside. The same arguments give the same bytes. `w` should be buffered.
///
/// # Errors
///
/// [`WriteError::Invalid`], before a byte is written, where a coordinate is not finite in single precision, an index names no
/// vertex, or there are more triangles than the file can count. [`WriteError::Io`] where `w` fails.
pub fn write_mesh(
    mut w: impl Write,
    points_mm: &[[f64; 3]],
    triangles: &[[u32; 3]],
) -> Result<(), WriteError> {
    let is_finite = |point: &[f64; 3]| point.iter().all(|value| (*value as f32).is_finite());
    if let Some(index) = points_mm.iter().position(|point| !is_finite(point)) {
        let found = format!("{:?}", points_mm[index]);
        let expected = "coordinates that are finite in single precision";
        return Err(WriteError::invalid(format!("STL vertex {index}"), expected, found));
    }
    let count = points_mm.len();
    let names_none = |corners: &[u32; 3]| corners.iter().any(|&corner| corner as usize >= count);
    if let Some(index) = triangles.iter().position(names_none) {
        let found = format!("{:?}", triangles[index]);
        let expected = format!("indices below {count}");
        return Err(WriteError::invalid(format!("STL triangle {index}"), expected, found));
    }
    let Ok(number) = u32::try_from(triangles.len()) else {
        return Err(WriteError::invalid("STL triangles", "at most 2³² − 1", triangles.len()));
    };
    write(&mut w, points_mm, triangles, number)
        .map_err(|source| WriteError::Io { what: "STL file", source })
}

fn write(
    w: &mut impl Write,
    points_mm: &[[f64; 3]],
    triangles: &[[u32; 3]],
    number: u32,
) -> io::Result<()> {
    w.write_all(&header(number))?;
    for corners in triangles {
        w.write_all(&record(corners.map(|corner| points_mm[corner as usize])))?;
    }
    w.flush()
}

/// The header of a file of so many triangles.
pub(super) fn header(number: u32) -> [u8; 84] {
    // It must not begin with `solid`, which text does.
    let mut header = [b' '; 84];
    header[..HEADER.len()].copy_from_slice(HEADER);
    header[80..].copy_from_slice(&number.to_le_bytes());
    header
}

/// The record of a triangle.
pub(super) fn record([a, b, c]: [[f64; 3]; 3]) -> [u8; 50] {
    let [u, v] = [b, c].map(|p| [0, 1, 2].map(|axis| p[axis] - a[axis]));
    let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let length = normal.iter().map(|side| side * side).sum::<f64>().sqrt();
    // Of a triangle without area there is no normal; readers take the corners then.
    let unit = normal.map(|side| if length > 0.0 { side / length } else { 0.0 });
    let mut record = [0; 50];
    let numbers = [unit, a, b, c].into_iter().flatten();
    for (place, value) in record[..48].chunks_exact_mut(4).zip(numbers) {
        place.copy_from_slice(&(value as f32).to_le_bytes());
    }
    record
}

const HEADER: &[u8] = b"binary STL by asphera, lengths in mm";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::xyz::TextOptions;

    #[test]
    fn meshes_are_read_back() {
        let points = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.5], [0.0, 1.0, 0.5], [9.0, 9.0, 9.0]];
        let mut file = Vec::new();
        write_mesh(&mut file, &points, &[[0, 1, 2]]).unwrap();
        assert_eq!(file.len(), 84 + 50);
        assert_eq!(file[84..96], [0_f32, 0.0, 1.0].map(f32::to_le_bytes).concat());
        let found = super::super::read(&file, &TextOptions::default()).unwrap();
        let found: Vec<[f64; 3]> = found.points().collect();
        assert_eq!(found, points[..3]);
    }

    #[test]
    fn what_makes_no_mesh_is_refused() {
        let message = |points: &[[f64; 3]], triangles: &[[u32; 3]]| {
            let mut file = Vec::new();
            let error = write_mesh(&mut file, points, triangles).unwrap_err();
            assert!(file.is_empty());
            error.to_string()
        };
        assert!(message(&[[0.0; 3]], &[[0, 0, 1]]).contains("expected indices below 1"));
        assert!(message(&[[1e300, 0.0, 0.0]], &[]).contains("finite in single precision"));
    }
}

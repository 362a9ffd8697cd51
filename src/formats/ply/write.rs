//! Triangle meshes written, binary little-endian.

use std::io::{self, Write};

use crate::WriteError;

/// Writes a triangle mesh.
///
/// `points_mm` are the vertices, x y z in mm; the file itself knows no unit, so a comment should
/// name it. `triangles` are indices of vertices, counted from 0. `scalar` is the name and the values
/// of one more number a vertex; NaN means that there is none and is written as NaN, never as zero.
/// `comments` are lines of the header. The same arguments give the same bytes. Time and size grow
/// with vertices plus triangles; nothing is buffered but single records, so `w` should be.
///
/// # Errors
///
/// [`WriteError::Invalid`], before a byte is written, where a coordinate is not finite, an index
/// names no vertex, there are not as many values as vertices, the name of the scalar is not made of
/// ASCII letters, digits and underscores or is x, y or z, a comment is not one line of printable
/// ASCII, or there are more vertices than an i32 counts. [`WriteError::Io`] where `w` fails.
///
/// # Example
///
/// ```
/// let points_mm = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [0.0, 1.0, f64::MIN_POSITIVE]];
/// let deviation_mm = [1e-6, -1e-6, f64::NAN];
/// let mut file = Vec::new();
/// asphera_formats::ply::write_mesh(
///     &mut file,
///     &points_mm,
///     &[[0, 1, 2]],
///     Some(("deviation_mm", &deviation_mm)),
///     &["lengths in mm"],
/// )?;
/// assert!(file.starts_with(b"ply\nformat binary_little_endian 1.0\ncomment lengths in mm\n"));
/// # Ok::<(), asphera_formats::WriteError>(())
/// ```
pub fn write_mesh(
    mut w: impl Write,
    points_mm: &[[f64; 3]],
    triangles: &[[u32; 3]],
    scalar: Option<(&str, &[f64])>,
    comments: &[&str],
) -> Result<(), WriteError> {
    check_mesh(points_mm, triangles)?;
    check_scalar(points_mm, scalar)?;
    for comment in comments {
        if !comment.bytes().all(|byte| matches!(byte, b' '..=b'~')) {
            let found = comment.escape_default();
            return Err(WriteError::invalid("PLY comment", "one line of printable ASCII", found));
        }
    }
    write(&mut w, points_mm, triangles, scalar, comments)
        .map_err(|source| WriteError::Io { what: "PLY file", source })
}

fn check_mesh(points_mm: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<(), WriteError> {
    let count = points_mm.len();
    if i32::try_from(count).is_err() {
        return Err(WriteError::invalid("PLY vertices", format!("at most {}", i32::MAX), count));
    }
    if let Some(index) = points_mm.iter().position(|point| !point.iter().all(|v| v.is_finite())) {
        let found = format!("{:?}", points_mm[index]);
        return Err(WriteError::invalid(
            format!("PLY vertex {index}"),
            "finite coordinates",
            found,
        ));
    }
    let names_none = |corners: &[u32; 3]| corners.iter().any(|&corner| corner as usize >= count);
    if let Some(index) = triangles.iter().position(names_none) {
        let found = format!("{:?}", triangles[index]);
        let expected = format!("indices below {count}");
        return Err(WriteError::invalid(format!("PLY triangle {index}"), expected, found));
    }
    Ok(())
}

fn check_scalar(points_mm: &[[f64; 3]], scalar: Option<(&str, &[f64])>) -> Result<(), WriteError> {
    let Some((name, values)) = scalar else {
        return Ok(());
    };
    let is_name = !name.is_empty()
        && !name.starts_with(|first: char| first.is_ascii_digit())
        && name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
        && !matches!(name, "x" | "y" | "z");
    if !is_name {
        let expected = "ASCII letters, digits and underscores, other than x, y and z";
        return Err(WriteError::invalid("PLY property name", expected, name.escape_debug()));
    }
    if values.len() != points_mm.len() {
        let expected = format!("{} values, one a vertex", points_mm.len());
        return Err(WriteError::invalid(format!("PLY property {name}"), expected, values.len()));
    }
    Ok(())
}

fn write(
    w: &mut impl Write,
    points_mm: &[[f64; 3]],
    triangles: &[[u32; 3]],
    scalar: Option<(&str, &[f64])>,
    comments: &[&str],
) -> io::Result<()> {
    writeln!(w, "ply\nformat binary_little_endian 1.0")?;
    for comment in comments {
        writeln!(w, "comment {comment}")?;
    }
    writeln!(w, "element vertex {}", points_mm.len())?;
    writeln!(w, "property double x\nproperty double y\nproperty double z")?;
    if let Some((name, _)) = scalar {
        writeln!(w, "property double {name}")?;
    }
    writeln!(w, "element face {}", triangles.len())?;
    writeln!(w, "property list uchar int vertex_indices\nend_header")?;

    for (index, point) in points_mm.iter().enumerate() {
        w.write_all(&vertex(point))?;
        if let Some((_, values)) = scalar {
            w.write_all(&values[index].to_le_bytes())?;
        }
    }
    triangles.iter().try_for_each(|corners| w.write_all(&face(corners)))?;
    w.flush()
}

/// The record of a vertex.
pub(super) fn vertex(point: &[f64; 3]) -> [u8; 24] {
    let mut record = [0; 24];
    for (bytes, number) in record.as_chunks_mut::<8>().0.iter_mut().zip(point) {
        *bytes = number.to_le_bytes();
    }
    record
}

/// The record of a triangle.
pub(super) fn face(corners: &[u32; 3]) -> [u8; 13] {
    let mut record = [3; 13];
    for (bytes, corner) in record[1..].as_chunks_mut::<4>().0.iter_mut().zip(corners) {
        *bytes = corner.to_le_bytes();
    }
    record
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, -2.0], [0.0, 1.0, 0.5]];

    #[test]
    fn bytes_follow_the_header() {
        let mut file = Vec::new();
        let scalar = [1.0, f64::NAN, -1.0];
        write_mesh(&mut file, &TRIANGLE, &[[0, 1, 2]], Some(("d", &scalar)), &["a b"]).unwrap();
        let header = "ply\nformat binary_little_endian 1.0\ncomment a b\nelement vertex 3\n\
            property double x\nproperty double y\nproperty double z\nproperty double d\n\
            element face 1\nproperty list uchar int vertex_indices\nend_header\n";
        let body = file.strip_prefix(header.as_bytes()).unwrap();
        assert_eq!(body.len(), 3 * 32 + 13);
        // IEEE 754: 1.0 is 3FF0…, -2.0 is C000…, the quiet NaN 7FF8….
        assert_eq!(body[32..40], [0, 0, 0, 0, 0, 0, 0xF0, 0x3F]);
        assert_eq!(body[48..56], [0, 0, 0, 0, 0, 0, 0, 0xC0]);
        assert_eq!(body[56..64], [0, 0, 0, 0, 0, 0, 0xF8, 0x7F]);
        assert_eq!(body[96..], [3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
    }

    #[test]
    fn an_empty_mesh_is_a_header() {
        let mut file = Vec::new();
        write_mesh(&mut file, &[], &[], None, &[]).unwrap();
        assert!(
            file.ends_with(b"element face 0\nproperty list uchar int vertex_indices\nend_header\n")
        );
    }

    #[test]
    fn what_cannot_be_written_is_refused_before_a_byte() {
        type Case<'a> =
            (&'a [[f64; 3]], &'a [[u32; 3]], Option<(&'a str, &'a [f64])>, &'a [&'a str], &'a str);
        let cases: [Case<'_>; 7] = [
            (&[[0.0, f64::NAN, 0.0]], &[], None, &[], "PLY vertex 0: expected finite"),
            (&TRIANGLE, &[[0, 1, 3]], None, &[], "PLY triangle 0: expected indices below 3"),
            (&TRIANGLE, &[], Some(("d", &[0.0])), &[], "PLY property d: expected 3 values"),
            (&TRIANGLE, &[], Some(("x", &[0.0; 3])), &[], "PLY property name: expected ASCII"),
            (&TRIANGLE, &[], Some(("a b", &[0.0; 3])), &[], "PLY property name: expected ASCII"),
            (&TRIANGLE, &[], None, &["a\nelement face 9"], "PLY comment: expected one line"),
            (&TRIANGLE, &[], None, &["µm"], "PLY comment: expected one line"),
        ];
        for (points, triangles, scalar, comments, expected) in cases {
            let mut file = Vec::new();
            let error = write_mesh(&mut file, points, triangles, scalar, comments).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
            assert!(file.is_empty());
        }
    }

    #[test]
    fn a_full_destination_is_an_io_error() {
        let mut room = [0; 40];
        let error = write_mesh(&mut room[..], &TRIANGLE, &[], None, &[]).unwrap_err();
        assert!(matches!(error, WriteError::Io { what: "PLY file", .. }));
    }
}

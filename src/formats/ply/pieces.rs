//! Triangle meshes written as PLY piece by piece, for those that do not fit into memory.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use super::write::{face, vertex};
use crate::WriteError;

/// A file that grows at two places: its vertices, and its triangles behind the room that these take.
///
/// It is the file of [`write_mesh`](super::write_mesh) but for spaces behind the comment `lengths in mm`, which keep the length of the
/// header while the number of triangles is not known yet.
pub struct MeshPieces<W: Write + Seek> {
    vertices: BufWriter<W>,
    triangles: BufWriter<W>,
    /// Vertices there will be.
    count: u32,
    vertices_written: u64,
    triangles_written: u64,
}

impl<W: Write + Seek> MeshPieces<W> {
    /// Begins a file of `count` vertices. `vertices` and `triangles` write into the same file, each with a place of its own.
    ///
    /// # Errors
    ///
    /// [`WriteError::Invalid`] of more vertices than the file can number; [`WriteError::Io`] where the file fails.
    pub fn new(vertices: W, triangles: W, count: u32) -> Result<MeshPieces<W>, WriteError> {
        if i32::try_from(count).is_err() {
            return Err(WriteError::invalid(
                "PLY vertices",
                format!("at most {}", i32::MAX),
                count,
            ));
        }
        let mut pieces = MeshPieces {
            vertices: BufWriter::with_capacity(1 << 16, vertices),
            triangles: BufWriter::with_capacity(1 << 16, triangles),
            count,
            vertices_written: 0,
            triangles_written: 0,
        };
        let header = header(count, 0);
        let behind = header.len() as u64 + 24 * u64::from(count);
        written(pieces.vertices.write_all(header.as_bytes()))?;
        written(pieces.triangles.seek(SeekFrom::Start(behind)))?;
        Ok(pieces)
    }

    /// Adds vertices, x y z in mm, and triangles of vertices by number.
    ///
    /// # Errors
    ///
    /// [`WriteError::Io`] where the file fails.
    pub fn add(
        &mut self,
        points_mm: &[[f64; 3]],
        triangles: &[[u32; 3]],
    ) -> Result<(), WriteError> {
        self.vertices_written += points_mm.len() as u64;
        self.triangles_written += triangles.len() as u64;
        written(points_mm.iter().try_for_each(|point| self.vertices.write_all(&vertex(point))))?;
        written(triangles.iter().try_for_each(|corners| self.triangles.write_all(&face(corners))))
    }

    /// Ends the file.
    ///
    /// # Errors
    ///
    /// [`WriteError::Invalid`] where other than the announced number of vertices came; [`WriteError::Io`] where the file fails.
    pub fn finish(mut self) -> Result<(), WriteError> {
        if self.vertices_written != u64::from(self.count) {
            let expected = format!("{}, as announced", self.count);
            return Err(WriteError::invalid("PLY vertices", expected, self.vertices_written));
        }
        written(self.triangles.flush())?;
        let header = header(self.count, self.triangles_written);
        written(self.vertices.seek(SeekFrom::Start(0)))?;
        written(self.vertices.write_all(header.as_bytes()))?;
        written(self.vertices.flush())
    }
}

fn written<T>(result: io::Result<T>) -> Result<T, WriteError> {
    result.map_err(|source| WriteError::Io { what: "PLY file", source })
}

/// The header, of one length whatever the number of triangles.
fn header(vertices: u32, triangles: u64) -> String {
    let digits = triangles.to_string();
    let spaces = " ".repeat(20 - digits.len());
    format!(
        "ply\nformat binary_little_endian 1.0\ncomment lengths in mm{spaces}\nelement vertex {vertices}\n\
         property double x\nproperty double y\nproperty double z\nelement face {digits}\n\
         property list uchar int vertex_indices\nend_header\n"
    )
}

#[cfg(test)]
mod tests {
    use std::fs::OpenOptions;

    use super::*;
    use crate::ply::write_mesh;

    #[test]
    fn pieces_are_the_mesh_written_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        let points: Vec<[f64; 3]> =
            (0..7).map(|at| [f64::from(at), -0.5, f64::from(at * at)]).collect();
        let triangles: Vec<[u32; 3]> = (0..5).map(|at| [at, at + 2, at + 1]).collect();
        let open = || OpenOptions::new().write(true).create(true).truncate(false).open(&path);
        let mut pieces = MeshPieces::new(open().unwrap(), open().unwrap(), 7).unwrap();
        pieces.add(&points[..3], &triangles[..2]).unwrap();
        pieces.add(&points[3..], &[]).unwrap();
        pieces.add(&[], &triangles[2..]).unwrap();
        pieces.finish().unwrap();
        let found = std::fs::read(&path).unwrap();
        let mut whole = Vec::new();
        write_mesh(&mut whole, &points, &triangles, None, &["lengths in mm"]).unwrap();
        let spaces = " ".repeat(19);
        let padded = [b"comment lengths in mm", spaces.as_bytes()].concat();
        let at = found.windows(padded.len()).position(|part| part == padded).unwrap();
        let end = at + padded.len();
        let without = [&found[..end - 19], &found[end..]].concat();
        assert_eq!(without, whole);
    }

    #[test]
    fn vertices_that_lack_are_told() {
        let folder = tempfile::tempdir().unwrap();
        let open = |name: &str| std::fs::File::create(folder.path().join(name)).unwrap();
        let mut pieces = MeshPieces::new(open("a"), open("b"), 2).unwrap();
        pieces.add(&[[0.0; 3]], &[]).unwrap();
        let message = pieces.finish().unwrap_err().to_string();
        assert!(message.contains("expected 2, as announced, found 1"), "{message}");
    }
}

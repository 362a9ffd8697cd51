//! Triangle meshes written as binary STL triangle by triangle, for those that do not fit into memory.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};

use super::write::{header, record};
use crate::WriteError;

/// A file of [`write_mesh`](super::write_mesh) that grows; its head gets the number of triangles at the end.
pub struct MeshPieces<W: Write + Seek> {
    file: BufWriter<W>,
    count: u64,
}

impl<W: Write + Seek> MeshPieces<W> {
    /// Begins a file.
    ///
    /// # Errors
    ///
    /// [`WriteError::Io`] where the file fails.
    pub fn new(file: W) -> Result<MeshPieces<W>, WriteError> {
        let mut file = BufWriter::with_capacity(1 << 16, file);
        written(file.write_all(&header(0)))?;
        Ok(MeshPieces { file, count: 0 })
    }

    /// Adds a triangle by its corners, x y z in mm, counter-clockwise seen from outside.
    ///
    /// # Errors
    ///
    /// [`WriteError::Io`] where the file fails.
    pub fn add(&mut self, corners_mm: [[f64; 3]; 3]) -> Result<(), WriteError> {
        self.count += 1;
        written(self.file.write_all(&record(corners_mm)))
    }

    /// Ends the file.
    ///
    /// # Errors
    ///
    /// [`WriteError::Invalid`] of more triangles than the file can count; [`WriteError::Io`] where the file fails.
    pub fn finish(mut self) -> Result<(), WriteError> {
        let Ok(number) = u32::try_from(self.count) else {
            return Err(WriteError::invalid("STL triangles", "at most 2³² − 1", self.count));
        };
        written(self.file.seek(SeekFrom::Start(0)))?;
        written(self.file.write_all(&header(number)))?;
        written(self.file.flush())
    }
}

fn written<T>(result: io::Result<T>) -> Result<T, WriteError> {
    result.map_err(|source| WriteError::Io { what: "STL file", source })
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;
    use crate::stl::write_mesh;

    #[test]
    fn pieces_are_the_mesh_written_at_once() {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, -2.0], [0.0, 1.0, 0.5], [3.0, 3.0, 3.0]];
        let triangles = [[0, 1, 2], [1, 3, 2]];
        let mut whole = Vec::new();
        write_mesh(&mut whole, &points, &triangles).unwrap();
        let mut file = Vec::new();
        let mut pieces = MeshPieces::new(Cursor::new(&mut file)).unwrap();
        for corners in triangles {
            pieces.add(corners.map(|corner: u32| points[corner as usize])).unwrap();
        }
        pieces.finish().unwrap();
        assert_eq!(file, whole);
    }
}

//! How a cell is cut into triangles.

use crate::codes::facts;
use crate::scan::Scan;
use crate::table::{Table, hole};

/// How a mixed cell is cut.
pub(crate) trait Cuts: Sync {
    /// The triangles of a code, where nothing else decides them.
    fn plain(&self, code: u8) -> Option<&[[u8; 3]]>;

    /// Adds the triangles of a cell. Neighbours must leave the same segments on their common face, or close what lies
    /// between. Nothing lies between a cell and one near missing samples.
    fn cut(&self, scan: Scan<'_>, place: [usize; 3], code: u8, mesh: &mut CellMesh);
}

/// Triangles of one cell. Their corners are edges of the cell, and from 12 on its own vertices.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellMesh {
    /// Counter-clockwise seen from the background.
    pub(crate) triangles: Vec<[u8; 3]>,
    /// Vertices within the cell, each coordinate from 0 to 1.
    pub(crate) vertices: Vec<[f64; 3]>,
}

impl CellMesh {
    /// Adds a vertex within the cell, and gives its number.
    pub(crate) fn add(&mut self, vertex: [f64; 3]) -> u8 {
        self.vertices.push(vertex);
        12 + (self.vertices.len() - 1) as u8
    }
}

impl Cuts for Table {
    fn plain(&self, code: u8) -> Option<&[[u8; 3]]> {
        let is_plain = facts()[usize::from(code)].c1_faces == 0 || self.joins(code);
        is_plain.then(|| Table::cut(self, code).triangles.as_slice())
    }

    fn cut(&self, scan: Scan<'_>, place: [usize; 3], code: u8, mesh: &mut CellMesh) {
        mesh.triangles.extend_from_slice(&Table::cut(self, code).triangles);
        let mut faces = facts()[usize::from(code)].c1_faces;
        if self.joins(code) {
            return;
        }
        while faces != 0 {
            let face = faces.trailing_zeros() as usize;
            faces &= faces - 1;
            let other = beyond(place, face);
            if self.joins(scan.samples.code(other)) && !scan.is_in_gap(other) {
                let [a, b, c, d] = hole(code, face).map(|edge| edge as u8);
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
}

/// The cell across a face. A C1 face has foreground samples, so there is one.
fn beyond(cell: [usize; 3], face: usize) -> [usize; 3] {
    let mut other = cell;
    other[face / 2] = if face % 2 == 1 { cell[face / 2] + 1 } else { cell[face / 2] - 1 };
    other
}

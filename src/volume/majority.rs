//! Majority interpolation: a grid of half the spacing whose voxels are well-composed for every volume.

use crate::cell::{EDGES, FACES};
use crate::refine::{CellBits, MAX_REFINE, refined};
use crate::{Samples, SizeError};

/// Which majority decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Majority {
    /// New samples are inside where most of what surrounds them is: thinner than the part (definition 17 of the source).
    Foreground,
    /// The complement of majority interpolation of the complement: thicker than the part.
    Complement,
}

/// The finer volume of majority interpolation. Its sample (x, y, z) lies at x/2 − 1, y/2 − 1, z/2 − 1 of the given one.
///
/// A sample between two is inside if both are; one in the middle of a cell's face if at least 4 of its 4 + 4 neighbours are; one in the
/// centre of a cell if at least 12 of its 8 + 12 + 6 neighbours are. The result is well-composed for every volume (theorem 18).
///
/// # Errors
///
/// [`SizeError`] where the finer volume would have too many samples.
pub fn majority(samples: &Samples, which: Majority) -> Result<Samples, SizeError> {
    refined(samples, 2, |_, code| cell_bits(code, which), true)
}

fn cell_bits(code: u8, which: Majority) -> CellBits {
    let cell = SplitCell::of(code, which);
    let mut bits = [[0; MAX_REFINE]; MAX_REFINE];
    // The lower half of the 27 samples belongs to the cell: its lowest corner, and what begins there.
    for (z, slice) in bits.iter_mut().enumerate().take(2) {
        for (y, row) in slice.iter_mut().enumerate().take(2) {
            *row = u8::from(cell.at([0, y, z])) | u8::from(cell.at([1, y, z])) << 1;
        }
    }
    bits
}

/// The 27 samples of a cell on the finer grid.
pub(crate) struct SplitCell {
    code: u8,
    edges: [bool; 12],
    faces: [bool; 6],
    centre: bool,
}

impl SplitCell {
    pub(crate) fn of(code: u8, which: Majority) -> SplitCell {
        let is_inside = |corner: usize| code >> corner & 1 == 1;
        // The complement's thresholds: 1 of 2 for 2 of 2, 5 of 8 for 4 of 8, 15 of 26 for 12 of 26.
        let (edge_least, face_least, centre_least) = match which {
            Majority::Foreground => (2, 4, 12),
            Majority::Complement => (1, 5, 15),
        };
        let edges = EDGES.map(|edge| edge.iter().filter(|&&c| is_inside(c)).count() >= edge_least);
        let faces = FACES.map(|face| {
            let corners = face.iter().filter(|&&corner| is_inside(corner)).count();
            let of_face = |edge: &[usize; 2]| edge.iter().all(|corner| face.contains(corner));
            let sides = EDGES.iter().zip(edges).filter(|(edge, inside)| of_face(edge) && *inside);
            corners + sides.count() >= face_least
        });
        let count = |of: &[bool]| of.iter().filter(|&&inside| inside).count();
        let around = code.count_ones() as usize + count(&edges) + count(&faces);
        SplitCell { code, edges, faces, centre: around >= centre_least }
    }

    /// Whether a sample is inside; coordinates 0, 1 and 2.
    fn at(&self, place: [usize; 3]) -> bool {
        let odd = place.map(|coordinate| coordinate == 1);
        let corner: usize = (0..3).map(|axis| (place[axis] / 2) << axis).sum();
        match odd {
            [false, false, false] => self.code >> corner & 1 == 1,
            [true, true, true] => self.centre,
            [true, false, false] => self.edges[place[1] / 2 + place[2]],
            [false, true, false] => self.edges[4 + place[0] / 2 + place[2]],
            [false, false, true] => self.edges[8 + place[0] / 2 + place[1]],
            [false, true, true] => self.faces[place[0] / 2],
            [true, false, true] => self.faces[2 + place[1] / 2],
            [true, true, false] => self.faces[4 + place[2] / 2],
        }
    }

    /// The share of the cell that its samples' voxels fill, a whole number of 64ths.
    pub(crate) fn share(&self) -> f64 {
        let count = |of: &[bool]| of.iter().filter(|&&inside| inside).count() as f64;
        // A voxel of the finer grid has ⅛ of the volume; a corner sees ⅛ of it, an edge ¼, a face ½.
        let sum = f64::from(self.code.count_ones())
            + 2.0 * count(&self.edges)
            + 4.0 * count(&self.faces)
            + 8.0 * f64::from(u8::from(self.centre));
        sum / 64.0
    }
}

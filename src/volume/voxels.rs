//! The faces of voxels as a surface.

use std::collections::BTreeMap;

use crate::cells::{mixed_codes, mixed_edges, mixed_words};
use crate::table::{Ambiguity, Table};
use crate::{Samples, Surface};

/// The surface of the union of all foreground voxels, made a 2-manifold: the digital reconstruction of the source.
///
/// Every voxel face is two triangles. Where the union is no manifold, foreground stands apart: an edge whose two foreground voxels
/// are diagonal (C1) and a corner in which voxels meet only there (C2) are doubled, once for each side. So the mesh is a closed
/// oriented 2-manifold for every volume, and lies exactly on the faces of the voxels. Faces beside a doubled edge have a
/// vertex in its middle and one in their own, so that no side belongs to four triangles.
pub fn voxel_surface(samples: &Samples) -> Surface {
    let [nx, ny, nz] = samples.size();
    let table = Table::of(Ambiguity::Apart);
    let columns = samples.words_per_row() * 64;
    let places = columns * (ny + 2);
    let mut weaver = Weaver {
        samples,
        table,
        columns,
        layers: [vec![0; places], vec![0; places]],
        middles: BTreeMap::new(),
        surface: Surface::default(),
    };
    debug_assert!(columns > nx + 1);
    for z in 0..=nz {
        weaver.number_layer(z);
        mixed_edges(samples, z, false, |axis, y, word, bits| {
            weaver.faces(axis, [word, y, z], bits);
        });
        mixed_edges(samples, z, true, |axis, y, word, bits| weaver.faces(axis, [word, y, z], bits));
        let middles_above = |(face, _): &([usize; 3], [usize; 3]), _: &mut u32| face[2] > 2 * z;
        weaver.middles.retain(middles_above);
    }
    weaver.surface
}

struct Weaver<'a> {
    samples: &'a Samples,
    table: &'static Table,
    columns: usize,
    /// Number of the first vertex of each mixed cell, of the layer before and of this one, by the parity of the layer.
    layers: [Vec<u32>; 2],
    /// Vertices in the middle of doubled edges, by twice the centre of the face between cells and the foreground sample.
    middles: BTreeMap<([usize; 3], [usize; 3]), u32>,
    surface: Surface,
}

impl Weaver<'_> {
    /// A vertex for every loop of every mixed cell, at the centre of the cell.
    fn number_layer(&mut self, z: usize) {
        let Weaver { samples, table, columns, layers, surface, .. } = self;
        mixed_words(samples, z, |y, word, corners, mixed| {
            mixed_codes(word, corners, mixed, |x, code| {
                layers[z % 2][y * *columns + x] = surface.vertices.len() as u32;
                let centre = [x, y, z].map(|place| place as f64 - 0.5);
                surface.vertices.extend((0..table.cut(code).loops).map(|_| centre));
            });
        });
    }

    /// The voxel faces across the mixed edges of one word of samples.
    fn faces(&mut self, axis: usize, [word, y, z]: [usize; 3], mut bits: u64) {
        while bits != 0 {
            self.face(axis, [word * 64 + bits.trailing_zeros() as usize, y, z]);
            bits &= bits - 1;
        }
    }

    /// The voxel face between a sample and its neighbour along an axis.
    fn face(&mut self, axis: usize, from: [usize; 3]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let to = moved(from, axis, 1);
        // The four cells about the edge, counter-clockwise about the axis, and the way to the face behind each.
        let ring = [([-1, -1], (v, -1)), ([0, -1], (u, 1)), ([0, 0], (v, 1)), ([-1, 0], (u, -1))];
        let is_upward = self.inside(from);
        let foreground = if is_upward { from } else { to };
        let mut corners = Vec::with_capacity(8);
        let mut has_middles = false;
        for ([du, dv], (side, step)) in ring {
            let cell = moved(moved(from, u, du), v, dv);
            corners.push(self.vertex_of(cell, axis, from));
            let others = [moved(from, side, step), moved(to, side, step)];
            // Diagonal foreground: the neighbour of the background sample is inside, that of the foreground sample is not.
            let [near, far] = if is_upward { [0, 1] } else { [1, 0] };
            if !self.inside(others[near]) && self.inside(others[far]) {
                has_middles = true;
                corners.push(self.middle(from, axis, side, step, foreground));
            }
        }
        if !is_upward {
            corners.reverse();
        }
        if !has_middles {
            let [a, b, c, d] = [corners[0], corners[1], corners[2], corners[3]];
            self.surface.triangles.extend([[a, b, c], [a, c, d]]);
            return;
        }
        let centre = self.add(from, |place| place[axis] += 0.5);
        for (index, &corner) in corners.iter().enumerate() {
            let next = corners[(index + 1) % corners.len()];
            self.surface.triangles.push([centre, corner, next]);
        }
    }

    fn inside(&self, [x, y, z]: [usize; 3]) -> bool {
        self.samples.padded_bit(x, y, z)
    }

    /// The vertex of a cell whose loop passes the edge from `from` along `axis`.
    fn vertex_of(&self, cell: [usize; 3], axis: usize, from: [usize; 3]) -> u32 {
        let local: [usize; 3] = std::array::from_fn(|at| from[at] - cell[at]);
        let edge = match axis {
            0 => local[1] + 2 * local[2],
            1 => 4 + local[0] + 2 * local[2],
            _ => 8 + local[0] + 2 * local[1],
        };
        let first = self.layers[cell[2] % 2][cell[1] * self.columns + cell[0]];
        let cut = self.table.cut(self.samples.code(cell));
        first + u32::from(cut.loop_of_edge[edge])
    }

    /// The vertex in the middle of a doubled voxel edge, on the side of a foreground sample.
    fn middle(
        &mut self,
        from: [usize; 3],
        axis: usize,
        side: usize,
        step: i8,
        foreground: [usize; 3],
    ) -> u32 {
        let mut face = from.map(|place| 2 * place);
        face[axis] += 1;
        face = moved(face, side, step);
        if let Some(&known) = self.middles.get(&(face, foreground)) {
            return known;
        }
        let new = self.add(from, |place| {
            place[axis] += 0.5;
            place[side] += f64::from(step) / 2.0;
        });
        self.middles.insert((face, foreground), new);
        new
    }

    /// A new vertex near a sample of the padded volume.
    fn add(&mut self, from: [usize; 3], place: impl Fn(&mut [f64; 3])) -> u32 {
        let mut vertex = from.map(|coordinate| coordinate as f64 - 1.0);
        place(&mut vertex);
        self.surface.vertices.push(vertex);
        self.surface.vertices.len() as u32 - 1
    }
}

/// A place moved by one step along an axis. Mixed edges lie off the rim of the padded volume.
fn moved(mut place: [usize; 3], axis: usize, step: i8) -> [usize; 3] {
    place[axis] = place[axis].wrapping_add_signed(isize::from(step));
    place
}

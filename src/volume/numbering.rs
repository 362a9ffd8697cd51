//! Numbers of vertices and triangles before any of them is made: so threads write them where they belong.

use rayon::prelude::*;

use crate::Samples;
use crate::cell::EDGES;
use crate::cells::mixed_codes;
use crate::cuts::{CellMesh, Cuts};
use crate::scan::Scan;

/// What lies before a slice and the layer of cells above it. That behind the last one is all.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Starts {
    /// The first vertex on an edge of the slice.
    pub(crate) of_slice: u32,
    /// The first vertex on an edge to the next slice.
    pub(crate) to_next: u32,
    /// Vertices within cells before this layer.
    pub(crate) within_cells: u32,
    /// Triangles before this layer.
    pub(crate) triangles: usize,
}

impl Starts {
    /// Vertices on the grid, vertices within cells, and triangles.
    pub(crate) fn numbers(self) -> [usize; 3] {
        [self.of_slice as usize, self.within_cells as usize, self.triangles]
    }
}

/// The starts of every slice but the last, which is a layer around the volume, and behind them. Counted by slices in the caller's
/// pool.
///
/// # Panics
///
/// Where there are 2³² vertices or more.
pub(crate) fn starts(scan: Scan<'_>, cuts: &impl Cuts) -> Vec<Starts> {
    let layers = scan.samples.size()[2] + 1;
    let plain = std::array::from_fn(|code| cuts.plain(code as u8).map(|cut| cut.len() as u8));
    let counts: Vec<Counts> =
        (0..layers).into_par_iter().map(|z| counts(scan, cuts, &plain, z)).collect();
    let mut all = Vec::with_capacity(layers + 1);
    let (mut next, mut vertices) = (Starts::default(), 0_u64);
    for Counts { edges: [of_slice, to_next], within_cells, triangles } in counts {
        vertices += u64::from(of_slice) + u64::from(to_next) + u64::from(within_cells);
        assert!(vertices < u64::from(u32::MAX), "a surface has below 2^32 vertices");
        next.to_next = next.of_slice + of_slice;
        all.push(next);
        next = Starts {
            of_slice: next.to_next + to_next,
            to_next: 0,
            within_cells: next.within_cells + within_cells,
            triangles: next.triangles + triangles,
        };
    }
    all.push(Starts { to_next: next.of_slice, ..next });
    all
}

/// What one slice and the layer above it hold.
struct Counts {
    edges: [u32; 2],
    within_cells: u32,
    triangles: usize,
}

/// Counts a slice. `plain` has the numbers of triangles of those codes that alone decide them.
fn counts(scan: Scan<'_>, cuts: &impl Cuts, plain: &[Option<u8>; 256], z: usize) -> Counts {
    let edges = [false, true].map(|is_upward| {
        let mut count = 0;
        scan.mixed_edges(z, is_upward, |_, _, _, bits| count += bits.count_ones());
        count
    });
    let (mut within_cells, mut triangles) = (0, 0);
    let mut mesh = CellMesh::default();
    scan.mixed_words(z, |y, word, corners, mixed| {
        mixed_codes(word, corners, mixed, |x, code| {
            triangles += plain[usize::from(code)].map_or_else(
                || {
                    mesh.triangles.clear();
                    mesh.vertices.clear();
                    cuts.cut(scan, [x, y, z], code, &mut mesh);
                    within_cells += mesh.vertices.len() as u32;
                    mesh.triangles.len()
                },
                usize::from,
            );
        });
    });
    Counts { edges, within_cells, triangles }
}

/// Numbers of the vertices of two slices, by direction and place.
pub(crate) struct Numbers {
    columns: usize,
    places: usize,
    of: Vec<u32>,
    /// Which half of the numbers is the lower slice.
    lower: usize,
}

impl Numbers {
    pub(crate) fn new(samples: &Samples) -> Numbers {
        let columns = samples.words_per_row() * 64;
        let places = columns * (samples.size()[1] + 2);
        Numbers { columns, places, of: vec![0; 5 * places], lower: 0 }
    }

    fn start(&self, is_upper: bool, direction: usize) -> usize {
        // Edges to the next slice are those between the two.
        let array =
            if direction == 2 { 4 } else { (self.lower ^ usize::from(is_upper)) * 2 + direction };
        array * self.places
    }

    /// Where the number of each edge of a cell lies, counted from the place of the cell.
    pub(crate) fn offsets(&self) -> [usize; 12] {
        std::array::from_fn(|edge| {
            let corner = EDGES[edge][0];
            let start = self.start(corner >> 2 & 1 == 1, edge / 4);
            start + (corner >> 1 & 1) * self.columns + (corner & 1)
        })
    }

    /// Numbers the edges of a slice from `next`, within it or to the one above, and calls `visit(place, direction)` for each in turn.
    /// Entries of other edges keep what was there before; none of them is read.
    pub(crate) fn fill(
        &mut self,
        scan: Scan<'_>,
        z: usize,
        [is_upper, is_upward]: [bool; 2],
        mut next: u32,
        mut visit: impl FnMut([usize; 3], usize),
    ) {
        let starts = [0, 1, 2].map(|direction| self.start(is_upper, direction));
        scan.mixed_edges(z, is_upward, |direction, y, word, mut bits| {
            let start = starts[direction] + y * self.columns;
            let row = &mut self.of[start..start + self.columns];
            while bits != 0 {
                let x = word * 64 + bits.trailing_zeros() as usize;
                row[x] = next;
                next += 1;
                visit([x, y, z], direction);
                bits &= bits - 1;
            }
        });
    }

    /// What lies from the place of a cell on.
    pub(crate) fn of_cell(&self, x: usize, y: usize) -> &[u32] {
        &self.of[y * self.columns + x..]
    }

    /// Makes the upper slice the lower one.
    pub(crate) fn swap(&mut self) {
        self.lower ^= 1;
    }
}

//! Marching cubes over a volume: one vertex a mixed edge, the triangles of a table.

use std::ops::Range;

use rayon::prelude::*;

use crate::cells::mixed_codes;
use crate::cuts::{CellMesh, Cuts};
use crate::numbering::{Numbers, Starts, starts};
use crate::scan::{Gaps, Scan};
use crate::table::{Ambiguity, Table};
use crate::{Samples, Surface};

/// Where the surface crosses the edges of the grid.
pub trait Crossings: Sync {
    /// The place on the edge from sample `from` to its neighbour along `axis` (0, 1, 2 for x, y, z), as a share of the edge: 0 at
    /// `from`, 1 at the neighbour. Samples of the layer around the volume have −1 or the size as a coordinate.
    fn share(&self, from: [i64; 3], axis: usize) -> f64;
}

/// Crossings at the middles of the edges.
#[derive(Clone, Copy, Debug)]
pub struct Middles;

impl Crossings for Middles {
    fn share(&self, _: [i64; 3], _: usize) -> f64 {
        0.5
    }
}

/// Grey values and their threshold: crossings where the values, interpolated along the edge, reach it.
///
/// Foreground must be what is at the threshold or above. Crossings keep [`GREY_MARGIN`] from the samples, so that grey values move
/// vertices but never change a triangle. An edge to the layer around the volume, or to a value that is not finite, is cut in
/// its middle.
#[derive(Clone, Copy, Debug)]
pub struct Grey<'a> {
    /// One value a sample, x fastest, then y, then z.
    pub values: &'a [f32],
    /// Columns, rows and slices.
    pub size: [usize; 3],
    /// The value of the surface.
    pub threshold: f32,
}

/// The least distance of a crossing of grey values from a sample.
pub const GREY_MARGIN: f64 = 0.01;

impl Grey<'_> {
    /// The value of a sample; none beyond the volume and where it is not finite.
    pub(crate) fn value(&self, place: [i64; 3]) -> Option<f64> {
        let is_within =
            |axis: usize| place[axis] >= 0 && (place[axis] as u64) < self.size[axis] as u64;
        let [x, y, z] = place.map(|coordinate| coordinate as usize);
        if !(0..3).all(is_within) {
            return None;
        }
        let value = self.values[(z * self.size[1] + y) * self.size[0] + x];
        value.is_finite().then(|| f64::from(value))
    }

    /// How far the value of a sample lies above the threshold.
    pub(crate) fn above_threshold(&self, place: [i64; 3]) -> Option<f64> {
        self.value(place).map(|value| value - f64::from(self.threshold))
    }
}

impl Crossings for Grey<'_> {
    fn share(&self, from: [i64; 3], axis: usize) -> f64 {
        let mut to = from;
        to[axis] += 1;
        match (self.value(from), self.value(to)) {
            (Some(a), Some(b)) if a != b => {
                let share = (f64::from(self.threshold) - a) / (b - a);
                share.clamp(GREY_MARGIN, 1.0 - GREY_MARGIN)
            }
            _ => 0.5,
        }
    }
}

/// The surface of a volume by marching cubes, by layers in the caller's pool.
///
/// Each mixed edge of the grid has one vertex, each cell the triangles that its code asks for; `rule` decides the faces whose
/// foreground samples are diagonal. The mesh is a closed oriented 2-manifold for every volume. Vertices are numbered by slice, and
/// within it by row; the result does not depend on threads.
///
/// With [`Ambiguity::Paired`] this is the modified marching cubes of the source: of an r-regular solid sampled at h < r / √3 the
/// surface is homeomorphic to that of the solid (theorem 23).
pub fn marching_cubes(samples: &Samples, rule: Ambiguity, crossings: &impl Crossings) -> Surface {
    marching_with(samples, Table::of(rule), crossings)
}

/// The surface of a volume, its cells cut by a rule. Vertices of cells come behind those of the grid, by layer and row.
pub(crate) fn marching_with(
    samples: &Samples,
    cuts: &impl Cuts,
    crossings: &impl Crossings,
) -> Surface {
    let scan = Scan::new(samples, Gaps::default());
    let starts = starts(scan, cuts);
    let layers = starts.len() - 1;
    let [of_grid, of_cells, of_triangles] = starts[layers].numbers();
    let mut vertices = vec![[0.0; 3]; of_grid + of_cells];
    let mut triangles = vec![[0; 3]; of_triangles];
    let mut room = Room::new(&mut vertices, of_grid, &mut triangles);
    // One thread has nothing to share.
    let chunks = if rayon::current_num_threads() == 1 { 1 } else { CHUNKS };
    let chunk = layers.div_ceil(chunks).max(1);
    let mut bands = Vec::new();
    for first in (0..layers).step_by(chunk) {
        let end = (first + chunk).min(layers);
        bands.push((first..end, room.split_off(starts[first], starts[end])));
    }
    let cutter = Cutter { scan, cuts, crossings, starts: &starts };
    bands.into_par_iter().for_each_init(
        || Numbers::new(samples),
        |numbers, (layers, room)| cutter.band(layers, room, numbers),
    );
    Surface { vertices, triangles }
}

/// Where a band of layers leaves what it makes.
pub(crate) struct Room<'a> {
    /// Vertices on the edges of the grid.
    vertices: &'a mut [[f64; 3]],
    /// Vertices within cells.
    within: &'a mut [[f64; 3]],
    triangles: &'a mut [[u32; 3]],
}

impl<'a> Room<'a> {
    /// All of a surface, of whose vertices so many lie on the grid.
    pub(crate) fn new(
        vertices: &'a mut [[f64; 3]],
        of_grid: usize,
        triangles: &'a mut [[u32; 3]],
    ) -> Room<'a> {
        let (vertices, within) = vertices.split_at_mut(of_grid);
        Room { vertices, within, triangles }
    }

    /// Takes off what lies in front: from one slice to another.
    fn split_off(&mut self, from: Starts, to: Starts) -> Room<'a> {
        let (from, to) = (from.numbers(), to.numbers());
        let [of_grid, of_cells, of_triangles] = [0, 1, 2].map(|kind| to[kind] - from[kind]);
        Room {
            vertices: split_off(&mut self.vertices, of_grid),
            within: split_off(&mut self.within, of_cells),
            triangles: split_off(&mut self.triangles, of_triangles),
        }
    }
}

fn split_off<'a, T>(all: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (front, back) = std::mem::take(all).split_at_mut(count);
    *all = back;
    front
}

/// Bands of layers that threads share: enough for some tens of threads, few enough that each is worth its numbering.
const CHUNKS: usize = 64;

/// What bands are cut from, and how.
pub(crate) struct Cutter<'a, C, X> {
    pub(crate) scan: Scan<'a>,
    pub(crate) cuts: &'a C,
    pub(crate) crossings: &'a X,
    pub(crate) starts: &'a [Starts],
}

impl<C: Cuts, X: Crossings> Cutter<'_, C, X> {
    /// Places the vertices of the slices `layers`, and the triangles of the layers of cells above them. What `numbers` had before does
    /// not matter.
    pub(crate) fn band(&self, layers: Range<usize>, room: Room<'_>, numbers: &mut Numbers) {
        let Cutter { scan, cuts, crossings, starts } = *self;
        let Room { vertices, mut within, mut triangles } = room;
        let first_within = starts[starts.len() - 1].of_slice + starts[layers.start].within_cells;
        let mut next_within = first_within;
        let mut mesh = CellMesh::default();
        let plain: [Option<&[[u8; 3]]>; 256] = std::array::from_fn(|code| cuts.plain(code as u8));
        let mut places = vertices.iter_mut();
        let first = layers.start;
        // The vertices of the last slice have no cells above them; it has none, being the layer around the volume.
        for z in layers {
            let mut add = |place: [usize; 3], direction: usize| {
                let from = place.map(|coordinate| coordinate as i64 - 1);
                let mut vertex = from.map(|coordinate| coordinate as f64);
                vertex[direction] += crossings.share(from, direction);
                if let Some(place) = places.next() {
                    *place = vertex;
                }
            };
            let Starts { of_slice, to_next, .. } = starts[z];
            if z == first {
                numbers.fill(scan, z, [false, false], of_slice, &mut add);
            } else {
                // Numbered already as the upper slice of the layer before.
                scan.mixed_edges(z, false, |direction, y, word, mut bits| {
                    while bits != 0 {
                        add([word * 64 + bits.trailing_zeros() as usize, y, z], direction);
                        bits &= bits - 1;
                    }
                });
            }
            numbers.fill(scan, z, [false, true], to_next, &mut add);
            numbers.fill(scan, z + 1, [true, false], starts[z + 1].of_slice, |_, _| ());
            let offsets = numbers.offsets();
            scan.mixed_words(z, |y, word, corners, mixed| {
                mixed_codes(word, corners, mixed, |x, code| {
                    let of_cell = numbers.of_cell(x, y);
                    if let Some(plain) = plain[usize::from(code)] {
                        let number = |edge: u8| of_cell[offsets[usize::from(edge)]];
                        let own = split_off(&mut triangles, plain.len());
                        own.iter_mut().zip(plain).for_each(|(to, edges)| *to = edges.map(number));
                        return;
                    }
                    mesh.triangles.clear();
                    mesh.vertices.clear();
                    cuts.cut(scan, [x, y, z], code, &mut mesh);
                    let number = |corner: u8| match offsets.get(usize::from(corner)) {
                        Some(&offset) => of_cell[offset],
                        None => next_within + u32::from(corner) - 12,
                    };
                    let own = split_off(&mut triangles, mesh.triangles.len());
                    own.iter_mut()
                        .zip(&mesh.triangles)
                        .for_each(|(to, corners)| *to = corners.map(number));
                    let start = [x, y, z].map(|at| at as f64 - 1.0);
                    let own = split_off(&mut within, mesh.vertices.len());
                    own.iter_mut().zip(&mesh.vertices).for_each(|(to, vertex)| {
                        *to = [0, 1, 2].map(|axis| start[axis] + vertex[axis]);
                    });
                    next_within += mesh.vertices.len() as u32;
                });
            });
            numbers.swap();
        }
    }
}

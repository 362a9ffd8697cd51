//! Marching cubes over a volume: one vertex a mixed edge, the triangles of a table.

use rayon::prelude::*;

use crate::cell::EDGES;
use crate::cells::{mixed_codes, mixed_words};
use crate::codes::facts;
use crate::table::{Ambiguity, Table, hole};
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

/// How a mixed cell is cut.
pub(crate) trait Cuts: Sync {
    /// The triangles of a code, where nothing else decides them.
    fn plain(&self, code: u8) -> Option<&[[u8; 3]]>;

    /// Adds the triangles of a cell. Neighbours must leave the same segments on their common face, or close what lies between.
    fn cut(&self, samples: &Samples, place: [usize; 3], code: u8, mesh: &mut CellMesh);
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

    fn cut(&self, samples: &Samples, place: [usize; 3], code: u8, mesh: &mut CellMesh) {
        mesh.triangles.extend_from_slice(&Table::cut(self, code).triangles);
        let mut faces = facts()[usize::from(code)].c1_faces;
        if self.joins(code) {
            return;
        }
        while faces != 0 {
            let face = faces.trailing_zeros() as usize;
            faces &= faces - 1;
            if self.joins(samples.code(beyond(place, face))) {
                let [a, b, c, d] = hole(code, face).map(|edge| edge as u8);
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }
}

/// The surface of a volume, its cells cut by a rule. Vertices of cells come behind those of the grid, by layer and row.
pub(crate) fn marching_with(
    samples: &Samples,
    cuts: &impl Cuts,
    crossings: &impl Crossings,
) -> Surface {
    let layers = samples.size()[2] + 2;
    let (starts, total) = first_numbers(samples);
    // One thread has nothing to share, and need not put bands together.
    let chunks = if rayon::current_num_threads() == 1 { 1 } else { CHUNKS };
    let chunk = (layers - 1).div_ceil(chunks).max(1);
    let mut vertices = vec![[0.0; 3]; total as usize];
    let mut own = &mut vertices[..];
    let mut bands = Vec::new();
    for first in (0..layers - 1).step_by(chunk) {
        let end = (first + chunk).min(layers - 1);
        let (part, more) = own.split_at_mut((starts[end][0] - starts[first][0]) as usize);
        own = more;
        bands.push((first..end, part));
    }
    let bands: Vec<Band> = bands
        .into_par_iter()
        .map(|(layers, vertices)| band(samples, cuts, crossings, &starts, layers, vertices))
        .collect();
    joined(vertices, bands)
}

/// The first numbers of the vertices of each slice, those within it and those to the next one; and the number of all.
///
/// # Panics
///
/// Where there are more than 2³² vertices.
pub(crate) fn first_numbers(samples: &Samples) -> (Vec<[u32; 2]>, u32) {
    let layers = samples.size()[2] + 2;
    let counts: Vec<[u32; 2]> =
        (0..layers).into_par_iter().map(|z| vertex_counts(samples, z)).collect();
    let mut total = 0_u32;
    let starts = counts.into_iter().map(|[within, between]| {
        let start = total;
        let end = u64::from(start) + u64::from(within) + u64::from(between);
        assert!(end < u64::from(u32::MAX), "a surface has below 2^32 vertices");
        total = end as u32;
        [start, start + within]
    });
    (starts.collect(), total)
}

/// The surface of all bands, vertices within cells behind the others.
fn joined(mut vertices: Vec<[f64; 3]>, mut bands: Vec<Band>) -> Surface {
    for band in &mut bands {
        // Counted from the largest number down, until the vertices of the grid are counted.
        let first = vertices.len() as u32;
        let least = u32::MAX - band.within.len() as u32;
        if !band.within.is_empty() {
            let corners = band.triangles.iter_mut().flatten();
            corners
                .filter(|corner| **corner > least)
                .for_each(|corner| *corner = first + (u32::MAX - *corner));
        }
        vertices.append(&mut band.within);
    }
    if let [only] = &mut bands[..] {
        return Surface { vertices, triangles: std::mem::take(&mut only.triangles) };
    }
    let mut triangles = vec![[0; 3]; bands.iter().map(|band| band.triangles.len()).sum()];
    let mut rest = &mut triangles[..];
    let mut copies = Vec::new();
    for band in bands {
        let (part, more) = rest.split_at_mut(band.triangles.len());
        rest = more;
        copies.push((part, band.triangles));
    }
    copies.into_par_iter().for_each(|(part, own)| part.copy_from_slice(&own));
    Surface { vertices, triangles }
}

/// Triangles of a band of layers.
#[derive(Default)]
pub(crate) struct Band {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Vertices within cells; triangles count them from the largest number down.
    within: Vec<[f64; 3]>,
}

/// Bands of layers that threads share: enough for some tens of threads, few enough that each is worth its numbering.
const CHUNKS: usize = 64;

/// Calls `visit(direction, y, word, bits)` for every word of mixed edges of a slice: along x and y, or (`is_upward`) to the next slice.
pub(crate) fn mixed_edges(
    samples: &Samples,
    z: usize,
    is_upward: bool,
    mut visit: impl FnMut(usize, usize, usize, u64),
) {
    let [_, ny, nz] = samples.size();
    if is_upward && z > nz {
        return;
    }
    for y in 0..ny + 2 {
        let row = samples.row(y, z);
        if is_upward {
            for (word, (a, b)) in row.iter().zip(samples.row(y, z + 1)).enumerate() {
                if a != b {
                    visit(2, y, word, a ^ b);
                }
            }
            continue;
        }
        for (word, &bits) in row.iter().enumerate() {
            // The last bit of a row is the layer around the volume, so nothing is lost behind it.
            let next = row.get(word + 1).map_or(0, |next| next << 63);
            let mixed = bits ^ (bits >> 1 | next);
            if mixed != 0 {
                visit(0, y, word, mixed);
            }
        }
        if y <= ny {
            for (word, (a, b)) in row.iter().zip(samples.row(y + 1, z)).enumerate() {
                if a != b {
                    visit(1, y, word, a ^ b);
                }
            }
        }
    }
}

fn vertex_counts(samples: &Samples, z: usize) -> [u32; 2] {
    [false, true].map(|is_upward| {
        let mut count = 0;
        mixed_edges(samples, z, is_upward, |_, _, _, bits| count += bits.count_ones());
        count
    })
}

/// Numbers of the vertices of two slices, by direction and place.
struct Numbers {
    columns: usize,
    places: usize,
    of: Vec<u32>,
    /// Which half of the numbers is the lower slice.
    lower: usize,
}

impl Numbers {
    fn new(samples: &Samples) -> Numbers {
        let columns = samples.words_per_row() * 64;
        let places = columns * (samples.size()[1] + 2);
        Numbers { columns, places, of: vec![0; 6 * places], lower: 0 }
    }

    fn start(&self, is_upper: bool, direction: usize) -> usize {
        ((self.lower ^ usize::from(is_upper)) * 3 + direction) * self.places
    }

    /// Where the number of each edge of a cell lies, counted from the place of the cell.
    fn offsets(&self) -> [usize; 12] {
        std::array::from_fn(|edge| {
            let corner = EDGES[edge][0];
            let start = self.start(corner >> 2 & 1 == 1, edge / 4);
            start + (corner >> 1 & 1) * self.columns + (corner & 1)
        })
    }

    /// Numbers the edges of a slice from `next`, within it or to the one above, and calls `visit(place, direction)` for each in turn.
    /// Entries of other edges keep what was there before; none of them is read.
    fn fill(
        &mut self,
        samples: &Samples,
        z: usize,
        [is_upper, is_upward]: [bool; 2],
        mut next: u32,
        mut visit: impl FnMut([usize; 3], usize),
    ) {
        let starts = [0, 1, 2].map(|direction| self.start(is_upper, direction));
        mixed_edges(samples, z, is_upward, |direction, y, word, mut bits| {
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
}

/// Places the vertices of the slices `layers`, and gives the triangles of the layers of cells above them.
pub(crate) fn band(
    samples: &Samples,
    cuts: &impl Cuts,
    crossings: &impl Crossings,
    starts: &[[u32; 2]],
    layers: std::ops::Range<usize>,
    vertices: &mut [[f64; 3]],
) -> Band {
    let mut band = Band::default();
    // Nearly always there are two triangles a vertex.
    band.triangles.reserve(2 * vertices.len());
    let mut mesh = CellMesh::default();
    let plain: [Option<&[[u8; 3]]>; 256] = std::array::from_fn(|code| cuts.plain(code as u8));
    let mut numbers = Numbers::new(samples);
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
        let [within, between] = starts[z];
        if z == first {
            numbers.fill(samples, z, [false, false], within, &mut add);
        } else {
            // Numbered already as the upper slice of the layer before.
            mixed_edges(samples, z, false, |direction, y, word, mut bits| {
                while bits != 0 {
                    add([word * 64 + bits.trailing_zeros() as usize, y, z], direction);
                    bits &= bits - 1;
                }
            });
        }
        numbers.fill(samples, z, [false, true], between, &mut add);
        numbers.fill(samples, z + 1, [true, false], starts[z + 1][0], |_, _| ());
        let offsets = numbers.offsets();
        let Band { triangles, within } = &mut band;
        mixed_words(samples, z, |y, word, corners, mixed| {
            mixed_codes(word, corners, mixed, |x, code| {
                let of_cell = &numbers.of[y * numbers.columns + x..];
                if let Some(plain) = plain[usize::from(code)] {
                    for &[a, b, c] in plain {
                        let number = |edge: u8| of_cell[offsets[usize::from(edge)]];
                        triangles.push([number(a), number(b), number(c)]);
                    }
                    return;
                }
                mesh.triangles.clear();
                mesh.vertices.clear();
                cuts.cut(samples, [x, y, z], code, &mut mesh);
                let number = |corner: u8| match offsets.get(usize::from(corner)) {
                    Some(&offset) => of_cell[offset],
                    None => u32::MAX - (within.len() + usize::from(corner) - 12) as u32,
                };
                triangles.extend(mesh.triangles.iter().map(|corners| corners.map(number)));
                let start = [x, y, z].map(|at| at as f64 - 1.0);
                let places =
                    mesh.vertices.iter().map(|own| [0, 1, 2].map(|axis| start[axis] + own[axis]));
                within.extend(places);
            });
        });
        numbers.lower ^= 1;
    }
    band
}

/// The cell across a face. A C1 face has foreground samples, so there is one.
fn beyond(cell: [usize; 3], face: usize) -> [usize; 3] {
    let mut other = cell;
    other[face / 2] = if face % 2 == 1 { cell[face / 2] + 1 } else { cell[face / 2] - 1 };
    other
}

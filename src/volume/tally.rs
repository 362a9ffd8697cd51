//! Figures of a surface that comes in bands: those of [`Surface`](crate::Surface), in the memory of two bands.

use crate::surface::{Piece, area_and_volume, border_count, euler};
use crate::{Surface, SurfaceBand};

/// Sums over the bands of a surface, handed over in turn.
#[derive(Debug)]
pub struct SurfaceTally {
    /// Number of the first vertex that is remembered, and what is known of it and those after it.
    first: u32,
    places: Vec<[f64; 3]>,
    /// The piece of each of these vertices, or [`NONE`].
    piece_of: Vec<u32>,
    /// Triangles whose highest vertices have not come yet.
    waiting: Vec<[u32; 3]>,
    /// What volumes are measured about.
    origin: Option<[f64; 3]>,
    growing: Vec<Growing>,
    finished: Vec<Growing>,
    /// Sides of triangles that another may still share: the lower vertex from bit 32 on, the higher one from bit 1 on, both counted
    /// from `first`, and the direction of the side.
    sides: Vec<u64>,
    /// Sides that belong to one triangle only, by the numbers of their vertices.
    border: Vec<[u32; 2]>,
    is_closed: bool,
    is_oriented: bool,
    vertices: u64,
    triangles: u64,
}

/// Figures of a whole surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceFigures {
    /// The number of vertices.
    pub vertices: u64,
    /// The number of triangles.
    pub triangles: u64,
    /// Every side of a triangle belongs to two triangles.
    pub is_closed: bool,
    /// Two triangles that share a side run along it in opposite directions.
    pub is_oriented: bool,
    /// Sides that belong to one triangle only.
    pub border_sides: u64,
    /// Connected pieces that these sides make.
    pub borders: u64,
    /// Its area, in squares of the unit of the vertices.
    pub area: f64,
    /// The volume it encloses, in cubes of this unit; an open surface encloses none.
    pub volume: Option<f64>,
    /// Its connected pieces, the one with the lowest vertex number first.
    pub pieces: Vec<Piece>,
}

/// A piece that may go on.
#[derive(Clone, Copy, Debug)]
struct Growing {
    /// The piece it was joined to, or itself.
    parent: u32,
    first_vertex: u32,
    vertices: i64,
    triangles: i64,
    border_sides: u64,
    area: f64,
    volume: f64,
}

const NONE: u32 = u32::MAX;

impl Surface {
    /// The figures of the surface, as a tally of its bands has them.
    pub fn figures(&self) -> SurfaceFigures {
        let check = self.check();
        let border = self.border_sides();
        let volume = if self.triangles.is_empty() { 0.0 } else { self.volume() };
        SurfaceFigures {
            vertices: self.vertices.len() as u64,
            triangles: self.triangles.len() as u64,
            is_closed: check.is_closed,
            is_oriented: check.is_oriented,
            border_sides: border.len() as u64,
            borders: border_count(&border),
            area: self.area(),
            volume: check.is_closed.then_some(volume),
            pieces: self.pieces(),
        }
    }
}

impl SurfaceFigures {
    /// The Euler number of the whole surface.
    pub fn euler(&self) -> i64 {
        euler(self.vertices as i64, self.triangles as i64, self.border_sides)
    }
}

impl Default for SurfaceTally {
    fn default() -> SurfaceTally {
        SurfaceTally {
            first: 0,
            places: Vec::new(),
            piece_of: Vec::new(),
            waiting: Vec::new(),
            origin: None,
            growing: Vec::new(),
            finished: Vec::new(),
            sides: Vec::new(),
            border: Vec::new(),
            is_closed: true,
            is_oriented: true,
            vertices: 0,
            triangles: 0,
        }
    }
}

impl SurfaceTally {
    /// A tally of nothing.
    pub fn new() -> SurfaceTally {
        SurfaceTally::default()
    }

    /// Adds the next band, its vertices in the unit that figures are asked in. `visit` is shown the corners of each triangle once all
    /// of them have come, in the order of the surface.
    ///
    /// # Panics
    ///
    /// Where the band does not follow the one before.
    pub fn add(&mut self, band: &SurfaceBand, mut visit: impl FnMut([[f64; 3]; 3])) {
        assert_eq!(u64::from(band.first), self.vertices, "bands come in turn");
        self.origin = self.origin.or(band.vertices.first().copied());
        self.vertices += band.vertices.len() as u64;
        self.places.extend_from_slice(&band.vertices);
        self.piece_of.resize(self.places.len(), NONE);
        self.measure(&mut visit);
        self.forget(band.first);
        self.waiting.clone_from(&band.triangles);
    }

    /// The figures of all bands; `visit` is shown the triangles that are left.
    pub fn finish(mut self, mut visit: impl FnMut([[f64; 3]; 3])) -> SurfaceFigures {
        self.measure(&mut visit);
        self.forget(u32::MAX);
        self.is_closed &= self.sides.is_empty();
        let mut pieces = self.finished;
        pieces.sort_by_key(|piece| piece.first_vertex);
        let volume = pieces.iter().map(|piece| piece.volume).sum();
        let pieces: Vec<Piece> = pieces.iter().map(Growing::figures).collect();
        SurfaceFigures {
            vertices: self.vertices,
            triangles: self.triangles,
            is_closed: self.is_closed,
            is_oriented: self.is_oriented,
            border_sides: self.border.len() as u64,
            borders: border_count(&self.border),
            area: pieces.iter().map(|piece| piece.area).sum(),
            volume: self.is_closed.then_some(volume),
            pieces,
        }
    }

    /// Measures the triangles that waited.
    fn measure(&mut self, visit: &mut impl FnMut([[f64; 3]; 3])) {
        let triangles = std::mem::take(&mut self.waiting);
        self.triangles += triangles.len() as u64;
        let origin = self.origin.unwrap_or_default();
        for corners in &triangles {
            let own = corners.map(|corner| (corner - self.first) as usize);
            let piece = self.piece(own, corners);
            let places = own.map(|corner| self.places[corner]);
            visit(places);
            let (area, volume) = area_and_volume(origin, places);
            let piece = &mut self.growing[piece as usize];
            piece.triangles += 1;
            piece.area += area;
            piece.volume += volume;
        }
        let first = self.first;
        self.sides.extend(
            triangles
                .iter()
                .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
                .map(|(a, b)| side(a.min(b) - first, a.max(b) - first) | u64::from(a < b)),
        );
    }

    /// The piece of a triangle, that of its corners; those of several pieces join them.
    fn piece(&mut self, own: [usize; 3], corners: &[u32; 3]) -> u32 {
        let known = own.map(|corner| self.piece_of[corner]);
        let mut piece = NONE;
        for of in known.into_iter().filter(|&of| of != NONE) {
            let root = self.root(of);
            piece = if piece == NONE { root } else { self.join(piece, root) };
        }
        if piece == NONE {
            piece = self.growing.len() as u32;
            let first_vertex = corners[0].min(corners[1]).min(corners[2]);
            let empty = Growing {
                parent: piece,
                first_vertex,
                vertices: 0,
                triangles: 0,
                border_sides: 0,
                area: 0.0,
                volume: 0.0,
            };
            self.growing.push(empty);
        }
        for (corner, number) in own.into_iter().zip(corners) {
            if self.piece_of[corner] == NONE {
                let piece = &mut self.growing[piece as usize];
                piece.vertices += 1;
                piece.first_vertex = piece.first_vertex.min(*number);
            }
            self.piece_of[corner] = piece;
        }
        piece
    }

    fn root(&mut self, mut piece: u32) -> u32 {
        loop {
            let parent = self.growing[piece as usize].parent;
            if parent == piece {
                return piece;
            }
            self.growing[piece as usize].parent = self.growing[parent as usize].parent;
            piece = parent;
        }
    }

    /// Joins two roots, and gives the one that is left.
    fn join(&mut self, a: u32, b: u32) -> u32 {
        let (into, from) = (a.min(b), a.max(b));
        if into != from {
            let Growing { first_vertex, vertices, triangles, border_sides, area, volume, .. } =
                self.growing[from as usize];
            self.growing[from as usize].parent = into;
            let piece = &mut self.growing[into as usize];
            piece.first_vertex = piece.first_vertex.min(first_vertex);
            piece.vertices += vertices;
            piece.triangles += triangles;
            piece.border_sides += border_sides;
            piece.area += area;
            piece.volume += volume;
        }
        into
    }

    /// Forgets the vertices below a number: no triangle to come has one of them.
    fn forget(&mut self, below: u32) {
        let gone = ((below - self.first) as usize).min(self.places.len());
        self.pair_sides(gone as u32);
        self.places.drain(..gone);
        self.piece_of.drain(..gone);
        self.first += gone as u32;
        // Pieces with a vertex that is left go on, under new numbers; the others are finished.
        let mut number = vec![NONE; self.growing.len()];
        let mut growing = Vec::new();
        for index in 0..self.piece_of.len() {
            if self.piece_of[index] == NONE {
                continue;
            }
            let root = self.root(self.piece_of[index]);
            if number[root as usize] == NONE {
                number[root as usize] = growing.len() as u32;
                let parent = growing.len() as u32;
                growing.push(Growing { parent, ..self.growing[root as usize] });
            }
            self.piece_of[index] = number[root as usize];
        }
        let is_root = |index: usize| self.growing[index].parent == index as u32;
        let finished = (0..self.growing.len()).filter(|&at| is_root(at) && number[at] == NONE);
        self.finished.extend(finished.map(|at| self.growing[at]));
        self.growing = growing;
    }

    /// Pairs the sides that have one of the first vertices, and keeps those whose second triangle may still come, without these vertices.
    fn pair_sides(&mut self, gone: u32) {
        let (starts, mut ends) = self.sides_by_vertex();
        let mut left = Vec::new();
        for (low, bounds) in (0_u32..).zip(starts.windows(2)) {
            let of_vertex = &mut ends[bounds[0] as usize..bounds[1] as usize];
            of_vertex.sort_unstable();
            for group in of_vertex.chunk_by(|a, b| a >> 1 == b >> 1) {
                if group.len() == 1 && low >= gone {
                    left.push((u64::from(low - gone) << 32) | u64::from(group[0] - 2 * gone));
                    continue;
                }
                let is_side = group[0] >> 1 != low;
                if group.len() == 1 {
                    let piece = self.root(self.piece_of[low as usize]);
                    self.growing[piece as usize].border_sides += 1;
                    self.border.push([low, group[0] >> 1].map(|corner| self.first + corner));
                }
                self.is_closed &= group.len() == 2 && is_side;
                self.is_oriented &= group.len() == 1 || group.len() == 2 && group[0] != group[1];
            }
        }
        self.sides = left;
    }

    /// The sides counted out by their lower vertex: where those of each begin, and the rest of each side.
    fn sides_by_vertex(&self) -> (Vec<u32>, Vec<u32>) {
        let mut starts = vec![0_u32; self.places.len() + 1];
        for side in &self.sides {
            starts[(side >> 32) as usize + 1] += 1;
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut ends = vec![0_u32; self.sides.len()];
        // From the last to the first, each start goes from the end of its vertex to its begin.
        for side in self.sides.iter().rev() {
            let next = &mut starts[(side >> 32) as usize + 1];
            *next -= 1;
            ends[*next as usize] = *side as u32;
        }
        starts.remove(0);
        starts.push(self.sides.len() as u32);
        (starts, ends)
    }
}

/// The side between two of the vertices that are remembered, the lower one first.
fn side(low: u32, high: u32) -> u64 {
    u64::from(low) << 32 | u64::from(high) << 1
}

impl Growing {
    fn figures(&self) -> Piece {
        let Growing { vertices, triangles, border_sides, area, volume, .. } = *self;
        Piece::of(vertices, triangles, border_sides, [area, volume])
    }
}

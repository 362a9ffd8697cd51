//! A triangle mesh: the face that a reconstruction shows, closed but about missing samples.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::parts::Forest;

/// A triangle mesh of the boundary of a solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Vertices in samples: sample (x, y, z) lies at x, y, z.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of the triangles, counter-clockwise seen from outside the solid.
    pub triangles: Vec<[u32; 3]>,
}

/// What a mesh is as a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SurfaceCheck {
    /// Every side of a triangle belongs to two triangles.
    pub is_closed: bool,
    /// Two triangles that share a side run along it in opposite directions.
    pub is_oriented: bool,
    /// The triangles about every vertex make one ring.
    pub is_manifold: bool,
}

/// Figures of one connected piece of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Piece {
    /// Vertices − sides + triangles.
    pub euler: i64,
    /// Handles: 1 − Euler number / 2; `None` of an open piece.
    pub genus: Option<i64>,
    /// Sides that belong to one triangle only; 0 of a closed piece.
    pub border_sides: u64,
    /// Area, in the square of the unit of the vertices.
    pub area: f64,
    /// Volume that the piece encloses, in the cube of the unit of the vertices: negative for the wall of a cavity. An open piece encloses
    /// none.
    pub volume: Option<f64>,
}

impl Piece {
    /// Figures from counts and sums over the triangles.
    pub(crate) fn of(
        vertices: i64,
        triangles: i64,
        border_sides: u64,
        [area, volume]: [f64; 2],
    ) -> Piece {
        let euler = euler(vertices, triangles, border_sides);
        let is_closed = border_sides == 0;
        Piece {
            euler,
            genus: is_closed.then_some(1 - euler / 2),
            border_sides,
            area,
            volume: is_closed.then_some(volume),
        }
    }
}

/// Vertices − sides + triangles. Each triangle has three sides, a side two triangles or, at a border, one.
pub(crate) fn euler(vertices: i64, triangles: i64, border_sides: u64) -> i64 {
    vertices - (triangles + border_sides as i64) / 2
}

impl Surface {
    /// The Euler number of the whole mesh.
    pub fn euler(&self) -> i64 {
        let border_sides = self.border_sides().len() as u64;
        euler(self.vertices.len() as i64, self.triangles.len() as i64, border_sides)
    }

    /// Sides that belong to one triangle only.
    pub(crate) fn border_sides(&self) -> Vec<[u32; 2]> {
        let sides = self.sides();
        let groups = sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1));
        groups.filter(|group| group.len() == 1).map(|group| [group[0].0, group[0].1]).collect()
    }

    /// Sides sorted by their corners, with the direction in which a triangle runs along them.
    fn sides(&self) -> Vec<(u32, u32, bool)> {
        let mut sides: Vec<(u32, u32, bool)> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
            .map(|(a, b)| (a.min(b), a.max(b), a < b))
            .collect();
        sides.par_sort_unstable();
        sides
    }

    /// Checks that the mesh is a closed oriented 2-manifold.
    pub fn check(&self) -> SurfaceCheck {
        let sides = self.sides();
        let mut check = SurfaceCheck { is_closed: true, is_oriented: true, is_manifold: true };
        for group in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            check.is_closed &= group.len() == 2 && group[0].0 != group[0].1;
            check.is_oriented &= group.len() == 1 || group.len() == 2 && group[0].2 != group[1].2;
        }
        check.is_manifold = check.is_closed && check.is_oriented && self.has_rings();
        check
    }

    /// Whether the triangles about every vertex make one ring. The mesh is closed and oriented.
    fn has_rings(&self) -> bool {
        // For every corner of a triangle: the vertex, the one after it and the one before it.
        let mut corners: Vec<(u32, u32, u32)> = self
            .triangles
            .iter()
            .flat_map(|&[a, b, c]| [(a, b, c), (b, c, a), (c, a, b)])
            .collect();
        corners.par_sort_unstable();
        let mut vertices = 0;
        let rings = corners.chunk_by(|a, b| a.0 == b.0).all(|fan| {
            vertices += 1;
            let mut steps = 0;
            let mut at = fan[0].1;
            loop {
                let Ok(found) = fan.binary_search_by_key(&at, |corner| corner.1) else {
                    return false;
                };
                at = fan[found].2;
                steps += 1;
                if at == fan[0].1 || steps > fan.len() {
                    return steps == fan.len();
                }
            }
        });
        rings && vertices == self.vertices.len()
    }

    /// The connected pieces, the one with the lowest vertex number first.
    pub fn pieces(&self) -> Vec<Piece> {
        let mut forest = Forest::of(self.vertices.len() as u32);
        for &[a, b, c] in &self.triangles {
            forest.join(a, b);
            forest.join(a, c);
        }
        let mut pieces: BTreeMap<u32, (i64, i64, u64, [f64; 2])> = BTreeMap::new();
        for vertex in 0..self.vertices.len() as u32 {
            pieces.entry(forest.root(vertex)).or_default().0 += 1;
        }
        for corners in &self.triangles {
            let piece = pieces.entry(forest.root(corners[0])).or_default();
            let (area, volume) = self.area_and_volume(corners);
            piece.1 += 1;
            piece.3[0] += area;
            piece.3[1] += volume;
        }
        for [vertex, _] in self.border_sides() {
            pieces.entry(forest.root(vertex)).or_default().2 += 1;
        }
        pieces
            .into_values()
            .map(|(vertices, triangles, border_sides, sums)| {
                Piece::of(vertices, triangles, border_sides, sums)
            })
            .collect()
    }

    /// The area of the mesh.
    pub fn area(&self) -> f64 {
        self.triangles.iter().map(|corners| self.area_and_volume(corners).0).sum()
    }

    /// The volume that the mesh encloses, if it is closed.
    pub fn volume(&self) -> f64 {
        self.triangles.iter().map(|corners| self.area_and_volume(corners).1).sum()
    }

    /// Area of a triangle, and the volume between it and the first vertex of the mesh.
    fn area_and_volume(&self, corners: &[u32; 3]) -> (f64, f64) {
        area_and_volume(self.vertices[0], corners.map(|corner| self.vertices[corner as usize]))
    }

    /// The same mesh with every vertex moved by a rule, such as into the frame of a file.
    ///
    /// `is_mirror` says that the rule turns right hands into left hands: the triangles are then turned round.
    pub fn moved(mut self, rule: impl Fn([f64; 3]) -> [f64; 3], is_mirror: bool) -> Surface {
        self.vertices.iter_mut().for_each(|vertex| *vertex = rule(*vertex));
        if is_mirror {
            self.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
        }
        self
    }
}

/// Area of a triangle, and the volume between it and a place.
pub(crate) fn area_and_volume(origin: [f64; 3], corners: [[f64; 3]; 3]) -> (f64, f64) {
    let minus = |u: [f64; 3], v: [f64; 3]| [0, 1, 2].map(|axis| u[axis] - v[axis]);
    let [a, b, c] = corners.map(|vertex| minus(vertex, origin));
    let cross = |u: [f64; 3], v: [f64; 3]| {
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
    };
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let normal = cross(minus(b, a), minus(c, a));
    (dot(normal, normal).sqrt() / 2.0, dot(a, cross(b, c)) / 6.0)
}

/// Connected pieces of a border, given by its sides.
pub(crate) fn border_count(sides: &[[u32; 2]]) -> u64 {
    let mut corners: Vec<u32> = sides.as_flattened().to_vec();
    corners.sort_unstable();
    corners.dedup();
    let mut forest = Forest::of(corners.len() as u32);
    let place = |corner: u32| corners.partition_point(|&other| other < corner) as u32;
    sides.iter().for_each(|&[a, b]| forest.join(place(a), place(b)));
    forest.roots() as u64
}

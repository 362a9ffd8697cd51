//! Surface of grey values as the trilinear function has it, cell by cell: its topology, and vertices on it.

use crate::cell::EDGES;
use crate::codes::facts;
use crate::cuts::{CellMesh, Cuts};
use crate::decider::{Joined, body_joins, joined_faces, surface_pieces};
use crate::marching::{Grey, marching_with};
use crate::scan::Scan;
use crate::table::{Ambiguity, Table, loops_of, triangulated};
use crate::{Samples, Surface};

/// The surface of grey values that has, in every cell, the topology of the trilinear function of its eight values.
///
/// Vertices lie where the edges of the grid cross the threshold, as those of [`marching_cubes`](crate::marching_cubes) with [`Grey`]. Some
/// cells have a few vertices more: a loop that flat triangles cannot span has one in its middle, a tunnel has a ring about its waist.
/// The mesh is a closed oriented 2-manifold for every volume, and does not depend on threads.
///
/// `samples` are foreground where a value is at the threshold or above; parts may be left out. Saddles decide what is joined, see the
/// module `decider` for sources and ties. A face with a corner that has no value, or whose part was left out, counts its corners as ±1. A
/// cell with such a corner, or at the border, has no tunnel. Differences to the threshold are taken in double precision.
///
/// Complexity: linear in the samples, a few hundred steps for a cell whose signs leave a choice.
pub fn trilinear_surface(samples: &Samples, grey: &Grey<'_>) -> Surface {
    let cuts = Decided { grey, table: Table::of(Ambiguity::Apart) };
    marching_with(samples, &cuts, grey)
}

/// Cuts by the trilinear function of each cell.
struct Decided<'a> {
    grey: &'a Grey<'a>,
    table: &'static Table,
}

impl Cuts for Decided<'_> {
    fn plain(&self, code: u8) -> Option<&[[u8; 3]]> {
        let cut = self.table.cut(code);
        let is_plain = facts()[usize::from(code)].c1_faces == 0 && cut.loops <= 1;
        is_plain.then_some(cut.triangles.as_slice())
    }

    fn cut(&self, _: Scan<'_>, [x, y, z]: [usize; 3], code: u8, mesh: &mut CellMesh) {
        let c1_faces = facts()[usize::from(code)].c1_faces;
        let mut values = [0.0; 8];
        for (corner, value) in values.iter_mut().enumerate() {
            let is_inside = code >> corner & 1 == 1;
            let place = [x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2)];
            let own = self.grey.above_threshold(place.map(|at| at as i64 - 1));
            let own = own.filter(|own| (*own >= 0.0) == is_inside);
            *value = own.unwrap_or(f64::NAN);
        }
        mesh_of(code, &values, c1_faces, mesh);
    }
}

/// Triangles of a cell that leaves a choice. Values that are not there are NaN.
pub(crate) fn mesh_of(code: u8, values: &[f64; 8], c1_faces: u8, mesh: &mut CellMesh) {
    let shape = Shape::of(code, values, c1_faces);
    let tunnel = shape.tunnel.and_then(|height| Some((shape.ends()?, height)));
    let cell = Cell { values, code };
    for (number, around) in shape.loops.iter().enumerate() {
        if tunnel.is_some_and(|(ends, _)| ends.contains(&number)) {
            continue;
        }
        match triangulated(around) {
            Some(triangles) => mesh.triangles.extend(triangles),
            None => cell.fan(around, mesh),
        }
    }
    if let Some(([a, b], height)) = tunnel {
        cell.tube(&shape.loops[a], &shape.loops[b], height, mesh);
    }
}

/// The topology of a cell.
#[derive(Clone, Debug)]
pub(crate) struct Shape {
    /// Edges about every piece of the surface, foreground to the left seen from the background.
    pub(crate) loops: Vec<Vec<usize>>,
    /// Pieces of the surface of the cell.
    pub(crate) pieces: Joined,
    /// Corners that a tunnel joins, of pieces that are apart on the surface.
    pub(crate) joined: Option<[usize; 2]>,
    /// The height of the tunnel's waist.
    pub(crate) tunnel: Option<f64>,
}

impl Shape {
    pub(crate) fn of(code: u8, values: &[f64; 8], c1_faces: u8) -> Shape {
        let faces = crate::cell::FACES;
        let lacks = |face: &usize| faces[*face].iter().any(|&corner| values[corner].is_nan());
        // All ±1 is a tie, which joins.
        let tied = (0..6_usize).filter(|face| c1_faces >> face & 1 == 1 && lacks(face));
        let tied = tied.fold(0_u8, |bits, face| bits | 1 << face);
        let joined_faces = tied | joined_faces(values, c1_faces & !tied);
        let pieces = surface_pieces(code, joined_faces);
        let body =
            if values.iter().any(|value| value.is_nan()) { None } else { body_joins(values) };
        let body = body.filter(|([a, b], _)| pieces[*a] != pieces[*b]);
        Shape {
            loops: loops_of(code, joined_faces),
            pieces,
            joined: body.map(|(corners, _)| corners),
            tunnel: body.map(|(_, height)| height),
        }
    }

    /// Pieces of the cell itself, its tunnel opened.
    #[cfg(test)]
    pub(crate) fn body_pieces(&self) -> Joined {
        let mut pieces = self.pieces;
        if let Some([a, b]) = self.joined {
            crate::decider::join(&mut pieces, a, b);
        }
        pieces
    }

    /// The two loops that the tunnel joins: those between its two pieces and the one that lies about the tunnel.
    fn ends(&self) -> Option<[usize; 2]> {
        let [first, second] = self.joined?.map(|corner| self.pieces[corner]);
        let beside: Vec<[u8; 2]> = self
            .loops
            .iter()
            .map(|around| EDGES[around[0]].map(|corner| self.pieces[corner]))
            .collect();
        let other = |sides: &[u8; 2], piece: u8| match *sides {
            [a, b] if a == piece => Some(b),
            [a, b] if b == piece => Some(a),
            _ => None,
        };
        for (a, sides) in beside.iter().enumerate() {
            let Some(about) = other(sides, first) else { continue };
            let b = beside.iter().position(|sides| other(sides, second) == Some(about));
            if let Some(b) = b {
                return Some([a, b]);
            }
        }
        None
    }
}

/// A cell whose triangles need vertices of their own.
struct Cell<'a> {
    values: &'a [f64; 8],
    code: u8,
}

impl Cell<'_> {
    /// Triangles about a vertex in the middle of a loop.
    fn fan(&self, around: &[usize], mesh: &mut CellMesh) {
        let places = around.iter().map(|&edge| self.crossing(edge));
        let sum = places.fold([0.0; 3], |sum, place| [0, 1, 2].map(|axis| sum[axis] + place[axis]));
        let middle = mesh.add(self.settled(sum.map(|side| side / around.len() as f64)));
        for (at, &edge) in around.iter().enumerate() {
            let next = around[(at + 1) % around.len()];
            mesh.triangles.push([edge as u8, next as u8, middle]);
        }
    }

    /// A tube between two loops, with a ring of vertices about its waist.
    fn tube(&self, first: &[usize], second: &[usize], height: f64, mesh: &mut CellMesh) {
        // Seen along the tube the second runs the other way.
        let mut second: Vec<usize> = second.to_vec();
        second.reverse();
        let places: [Vec<[f64; 3]>; 2] =
            [first, &second].map(|around| around.iter().map(|&edge| self.crossing(edge)).collect());
        let (count, other) = (first.len(), second.len());
        // The turn at which opposite vertices are nearest.
        let partner = |at: usize, turn: usize| (at * other / count + turn) % other;
        let cost = |turn: usize| -> f64 {
            (0..count).map(|at| square(places[0][at], places[1][partner(at, turn)])).sum()
        };
        let turn = (0..other).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(0);
        second.rotate_left(turn);
        let ring: Vec<u8> = (0..count)
            .map(|at| {
                let (a, b) = (places[0][at], places[1][partner(at, turn)]);
                let mut waist = [0, 1, 2].map(|axis| f64::midpoint(a[axis], b[axis]));
                waist[2] = f64::midpoint(waist[2], height);
                mesh.add(self.settled(waist))
            })
            .collect();
        let mut above = Vec::new();
        strip(
            &first.iter().map(|&edge| edge as u8).collect::<Vec<_>>(),
            &ring,
            &mut mesh.triangles,
        );
        strip(&second.iter().map(|&edge| edge as u8).collect::<Vec<_>>(), &ring, &mut above);
        mesh.triangles.extend(above.into_iter().map(|[a, b, c]| [a, c, b]));
    }

    fn crossing(&self, edge: usize) -> [f64; 3] {
        let [low, high] = EDGES[edge];
        let (a, b) = (self.value(low), self.value(high));
        let share = if a == b { 0.5 } else { (a / (a - b)).clamp(0.01, 0.99) };
        let mut place = [low & 1, low >> 1 & 1, low >> 2].map(|at| at as f64);
        place[edge / 4] += share;
        place
    }

    fn value(&self, corner: usize) -> f64 {
        let sign = if self.code >> corner & 1 == 1 { 1.0 } else { -1.0 };
        if self.values[corner].is_nan() { sign } else { self.values[corner] }
    }

    /// A place moved onto the surface, if Newton's steps along the gradient get it there within the cell.
    fn settled(&self, start: [f64; 3]) -> [f64; 3] {
        let corners: [f64; 8] = std::array::from_fn(|corner| self.value(corner));
        let scale = corners.iter().fold(0.0_f64, |scale, value| scale.max(value.abs()));
        let mut place = start;
        for _ in 0..20 {
            let (value, gradient) = value_and_gradient(&corners, place);
            if value.abs() <= 1e-14 * scale {
                return place;
            }
            let length: f64 = gradient.iter().map(|side| side * side).sum();
            if length == 0.0 {
                break;
            }
            place = [0, 1, 2].map(|axis| {
                (place[axis] - value * gradient[axis] / length).clamp(MARGIN, 1.0 - MARGIN)
            });
        }
        let is_near = value_and_gradient(&corners, place).0.abs() <= 1e-6 * scale;
        if is_near { place } else { start.map(|at| at.clamp(MARGIN, 1.0 - MARGIN)) }
    }
}

/// Vertices within a cell keep this from its faces.
const MARGIN: f64 = 0.001;

fn square(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|axis| (a[axis] - b[axis]).powi(2)).sum()
}

/// The trilinear function of corner values and its gradient.
pub(crate) fn value_and_gradient(corners: &[f64; 8], place: [f64; 3]) -> (f64, [f64; 3]) {
    let weight = |corner: usize, axis: usize| {
        if corner >> axis & 1 == 1 { place[axis] } else { 1.0 - place[axis] }
    };
    let mut value = 0.0;
    let mut gradient = [0.0; 3];
    for (corner, own) in corners.iter().enumerate() {
        let weights = [0, 1, 2].map(|axis| weight(corner, axis));
        value += own * weights[0] * weights[1] * weights[2];
        for (axis, side) in gradient.iter_mut().enumerate() {
            let others = weights[(axis + 1) % 3] * weights[(axis + 2) % 3];
            *side += if corner >> axis & 1 == 1 { own * others } else { -own * others };
        }
    }
    (value, gradient)
}

/// Triangles between two rings that run the same way, counter-clockwise for the first one.
fn strip(first: &[u8], second: &[u8], triangles: &mut Vec<[u8; 3]>) {
    let (mut a, mut b) = (0, 0);
    while a < first.len() || b < second.len() {
        let (from, to) = (first[a % first.len()], second[b % second.len()]);
        // Whichever lags behind as a share of its ring.
        if b == second.len() || a < first.len() && a * second.len() <= b * first.len() {
            a += 1;
            triangles.push([from, first[a % first.len()], to]);
        } else {
            b += 1;
            triangles.push([from, second[b % second.len()], to]);
        }
    }
}

#[cfg(test)]
mod tests;

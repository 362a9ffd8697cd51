//! The trilinear function of eight values: which corners it joins, on the faces of the cell and within it.
//!
//! Source: Nielson, Hamann, The asymptotic decider, Visualization 1991 (faces); Chernyaev, Marching Cubes 33, CERN CN/95-17 (the body).
//! The body test is derived here anew, as theirs is made for single cases. In the slice z = t the function is bilinear, with the corner
//! values A, B, C, D in turn, each linear in t. A slice has two pieces of one sign only if the signs alternate. It joins A with C where
//! Q = A·C − B·D is 0 or above, and B with D elsewhere. Every piece of a slice reaches its corners, thus the vertical edges of the cell. So
//! corners are joined within the cell and not on its faces only at an extremum of Q within the slices that alternate. Q is quadratic: it
//! has one extremum, so a cell has at most one tunnel.
//!
//! Ties: a value of 0 is foreground. A saddle of a face that is exactly 0 joins the foreground. A saddle of the body that is 0 opens no
//! tunnel. Faces are decided exactly; the body is, too, for values that are whole numbers of at most 8 bits after scaling by a power of 2,
//! and to rounding for others.

use crate::cell::FACES;

/// The slice z = 0 of a cell: its corners in turn. Those of z = 1 are 4 more.
const SLICE: [usize; 4] = [0, 1, 3, 2];

/// Corners as pieces: each corner has the number of the lowest corner that it is joined with.
pub(crate) type Joined = [u8; 8];

/// Faces on which the trilinear function joins diagonal foreground corners: bit f for face f.
///
/// `c1_faces` are the faces that leave a choice; foreground is what is 0 or above.
pub(crate) fn joined_faces(values: &[f64; 8], c1_faces: u8) -> u8 {
    (0..6).filter(|face| c1_faces >> face & 1 == 1).fold(0, |faces, face| {
        let [a, b, c, d] = FACES[face].map(|corner| values[corner]);
        let [inside, outside] = if a >= 0.0 { [(a, c), (b, d)] } else { [(b, d), (a, c)] };
        faces | u8::from(is_product_at_least(inside, outside)) << face
    })
}

/// Whether a·b ≥ c·d, exactly: the products by their rounded values, then by what rounding took away.
fn is_product_at_least((a, b): (f64, f64), (c, d): (f64, f64)) -> bool {
    let (first, second) = (a * b, c * d);
    if first != second {
        return first > second;
    }
    a.mul_add(b, -first) >= c.mul_add(d, -second)
}

/// Pieces of the surface of the cell: corners of the same sign, joined along edges and by faces that decide so.
pub(crate) fn surface_pieces(code: u8, joined_faces: u8) -> Joined {
    let mut pieces: Joined = [0, 1, 2, 3, 4, 5, 6, 7];
    let is_inside = |corner: usize| code >> corner & 1 == 1;
    for (face, corners) in FACES.into_iter().enumerate() {
        for at in 0..4 {
            let (corner, next, opposite) =
                (corners[at], corners[(at + 1) % 4], corners[(at + 2) % 4]);
            if is_inside(corner) == is_inside(next) {
                join(&mut pieces, corner, next);
            } else if is_inside(corner) == is_inside(opposite)
                && is_inside(corners[(at + 3) % 4]) == is_inside(next)
                && is_inside(corner) == (joined_faces >> face & 1 == 1)
            {
                join(&mut pieces, corner, opposite);
            }
        }
    }
    pieces
}

pub(crate) fn join(pieces: &mut Joined, a: usize, b: usize) {
    let (low, high) = (pieces[a].min(pieces[b]), pieces[a].max(pieces[b]));
    pieces.iter_mut().filter(|piece| **piece == high).for_each(|piece| *piece = low);
}

/// Two corners that the inside of the cell joins, and the height z of the slice in which it does so most, if there are any.
///
/// They may be joined on the surface of the cell, too.
pub(crate) fn body_joins(values: &[f64; 8]) -> Option<([usize; 2], f64)> {
    let low = SLICE.map(|corner| values[corner]);
    let rise: [f64; 4] = std::array::from_fn(|at| values[SLICE[at] + 4] - low[at]);
    // Q = square·t² + slope·t + start.
    let square = rise[0] * rise[2] - rise[1] * rise[3];
    let slope = low[0] * rise[2] + low[2] * rise[0] - low[1] * rise[3] - low[3] * rise[1];
    let start = low[0] * low[2] - low[1] * low[3];
    // The extremum, at −slope / (2·square), lies within the cell.
    let is_within = if square < 0.0 {
        slope > 0.0 && slope < -2.0 * square
    } else {
        slope < 0.0 && -slope < 2.0 * square
    };
    // A maximum above 0, or a minimum below.
    if square == 0.0 || !is_within || slope * slope <= 4.0 * square * start {
        return None;
    }
    // Values there, times 2·|square|, and their signs.
    let is_inside: [bool; 4] = std::array::from_fn(|at| {
        let value = 2.0 * square * low[at] - slope * rise[at];
        if square > 0.0 { value >= 0.0 } else { value <= 0.0 }
    });
    if is_inside[0] != is_inside[2] || is_inside[1] != is_inside[3] || is_inside[0] == is_inside[1]
    {
        return None;
    }
    // A maximum above 0 joins A and C, a minimum below 0 joins B and D, whichever of them is foreground.
    let pair = if square < 0.0 { [0, 2] } else { [1, 3] };
    let corner = |at: usize| {
        let bottom = SLICE[at];
        if (values[bottom] >= 0.0) == is_inside[at] { bottom } else { bottom + 4 }
    };
    Some((pair.map(corner), -slope / (2.0 * square)))
}

//! Tangent planes of points, from their nearest neighbours.

use asphera_geometry::PointMm;

use crate::geometry::{cross, dot, minus, unit};
use crate::neighbours::{Near, Neighbours};

/// A tangent plane, and how far its point looks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentPlane {
    pub(crate) normal: PointMm,
    /// Points farther away do not count.
    pub(crate) reach_mm: f64,
}

/// The planes of all points; `None` where the neighbours lie on a line.
pub(crate) fn of(tree: &Neighbours) -> Vec<Option<TangentPlane>> {
    tree.map_nearest(NEAREST, |at, near, room: &mut Vec<Near>| {
        let (far, _) = *near.last()?;
        let mut reach_mm = far.sqrt();
        if let Some(normal) = fitted(tree, at, near) {
            return Some(TangentPlane { normal, reach_mm: REACH * reach_mm });
        }
        // Along a scan line the nearest lie in a row: look farther until the next line is seen.
        for _ in 0..MOST_DOUBLINGS {
            reach_mm *= 2.0;
            tree.within(at, reach_mm, room);
            if let Some(normal) = fitted(tree, at, room) {
                return Some(TangentPlane { normal, reach_mm: REACH * reach_mm });
            }
            if room.len() + 1 >= tree.len().min(MOST_IN_A_ROW) {
                return None;
            }
        }
        None
    })
}

/// The direction of least spread; `None` where the points spread along one line only.
fn fitted(tree: &Neighbours, at: u32, near: &[Near]) -> Option<PointMm> {
    let origin = tree.points_mm[at as usize];
    let scale = 1.0 / near.last()?.0.sqrt();
    let (mut mean, mut squares) = ([0.0; 3], [0.0; 6]);
    for &(_, other) in near {
        let [x, y, z] = minus(tree.points_mm[other as usize], origin).map(|side| side * scale);
        mean = [mean[0] + x, mean[1] + y, mean[2] + z];
        for (sum, term) in squares.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x]) {
            *sum += term;
        }
    }
    let count = near.len() as f64 + 1.0;
    let [x, y, z] = mean.map(|sum| sum / count);
    let terms = [x * x, y * y, z * z, x * y, y * z, z * x];
    let [xx, yy, zz, xy, yz, zx] = std::array::from_fn(|i| squares[i] / count - terms[i]);
    // The smallest root of the characteristic polynomial, from below by Newton's steps.
    let trace = xx + yy + zz;
    let minors = xx * yy - xy * xy + yy * zz - yz * yz + zz * xx - zx * zx;
    // The minors are the sum of products of two spreads: the second against the first.
    if minors < LEAST_SPREAD * trace * trace {
        return None;
    }
    let det = xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx);
    let mut root = 0.0;
    for _ in 0..12 {
        let value = ((root - trace) * root + minors) * root - det;
        let slope = (3.0 * root - 2.0 * trace) * root + minors;
        let step = value / slope;
        if step.is_nan() || step >= 0.0 {
            break;
        }
        root -= step;
    }
    let rows = [[xx - root, xy, zx], [xy, yy - root, yz], [zx, yz, zz - root]];
    let crosses = [cross(rows[0], rows[1]), cross(rows[1], rows[2]), cross(rows[2], rows[0])];
    let longest = crosses.into_iter().max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)))?;
    unit(longest)
}

/// How many neighbours tell the plane.
pub(super) const NEAREST: usize = 16;
/// How far a point looks, in distances of the last of them.
const REACH: f64 = 2.3;
/// The least spread across a line of neighbours, of that along it.
const LEAST_SPREAD: f64 = 0.02;
const MOST_DOUBLINGS: u32 = 12;
const MOST_IN_A_ROW: usize = 2000;

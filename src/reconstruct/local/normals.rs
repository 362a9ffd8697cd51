//! Tangent planes of points, from their nearest neighbours.

use asphera_geometry::PointMm;

use crate::geometry::{cross, dot, minus, squared, unit};
use crate::neighbours::{Near, Neighbours};

/// A tangent plane, and how far its point looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TangentPlane {
    pub(crate) normal: PointMm,
    /// Points farther away do not count.
    pub(crate) reach_mm: f64,
}

/// Places by number, and what lies about them.
pub(crate) trait Places {
    fn points_mm(&self) -> &[PointMm];
    /// Neighbours within a distance, itself left out, the nearest first; of equal distances the smaller coordinates.
    fn within(&self, at: u32, radius_mm: f64, found: &mut Vec<Near>);
}

/// The planes of all points; `None` where the neighbours lie on a line.
pub(crate) fn of(tree: &Neighbours) -> Vec<Option<TangentPlane>> {
    tree.map_nearest(NEAREST, |at, near, room: &mut (Vec<u32>, Vec<Near>)| {
        let (numbers, wider) = room;
        numbers.clear();
        numbers.extend(near.iter().map(|&(_, other)| other));
        fit(tree, at, numbers, wider).plane
    })
}

/// The plane of a point, and what it depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) plane: Option<TangentPlane>,
    /// The square of the distance within which a new point may change it, mm².
    pub(super) sight_mm2: f64,
}

/// The plane of a point with its nearest neighbours, the nearest first.
pub(super) fn fit(places: &impl Places, at: u32, near: &[u32], room: &mut Vec<Near>) -> Fit {
    let points_mm = places.points_mm();
    let place = points_mm[at as usize];
    let far = near.last().map_or(0.0, |&last| squared(place, points_mm[last as usize]));
    let of = |normal: PointMm, reach_mm: f64, sight_mm2: f64| Fit {
        plane: Some(TangentPlane { normal, reach_mm: REACH * reach_mm }),
        // Of fewer neighbours than are asked for, the next one counts wherever it is.
        sight_mm2: if near.len() < NEAREST { f64::INFINITY } else { sight_mm2 },
    };
    if let Some(normal) = fitted(points_mm, place, near.iter().copied(), far) {
        return of(normal, far.sqrt(), far);
    }
    let none = |sight_mm2: f64| Fit { plane: None, sight_mm2 };
    if near.len() < NEAREST {
        return none(f64::INFINITY);
    }
    // Along a scan line the nearest lie in a row: look farther until the next line is seen.
    let mut reach_mm = far.sqrt();
    for _ in 0..MOST_DOUBLINGS {
        reach_mm *= 2.0;
        places.within(at, reach_mm, room);
        let sight_mm2 = (reach_mm * reach_mm).max(far);
        let wider_mm2 = room.last().map_or(0.0, |&(far, _)| far);
        let others = room.iter().map(|&(_, other)| other);
        if let Some(normal) = fitted(points_mm, place, others, wider_mm2) {
            return of(normal, reach_mm, sight_mm2);
        }
        if room.len() + 1 >= MOST_IN_A_ROW {
            return none(sight_mm2);
        }
        if room.len() + 1 == points_mm.len() {
            return none(f64::INFINITY);
        }
    }
    none(reach_mm * reach_mm)
}

/// Whether a plane is that of the nearest neighbours alone, the last of them at the square of a distance.
pub(super) fn is_of_nearest(plane: Option<TangentPlane>, far_mm2: f64) -> bool {
    plane.is_some_and(|plane| plane.reach_mm == REACH * far_mm2.sqrt())
}

/// The direction of least spread; `None` where the points spread along one line only. The last is at the square of a distance.
fn fitted(
    points_mm: &[PointMm],
    origin: PointMm,
    near: impl ExactSizeIterator<Item = u32>,
    far_mm2: f64,
) -> Option<PointMm> {
    if near.len() == 0 {
        return None;
    }
    let count = near.len() as f64 + 1.0;
    let scale = 1.0 / far_mm2.sqrt();
    let (mut mean, mut squares) = ([0.0; 3], [0.0; 6]);
    for other in near {
        let [x, y, z] = minus(points_mm[other as usize], origin).map(|side| side * scale);
        mean = [mean[0] + x, mean[1] + y, mean[2] + z];
        for (sum, term) in squares.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x]) {
            *sum += term;
        }
    }
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

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
        let normal = of_nearest(tree.points_mm(), at, numbers);
        fit(tree, at, numbers, normal, wider).plane
    })
}

/// The plane of a point, and what it depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fit {
    pub(super) plane: Option<TangentPlane>,
    /// The square of the distance within which a new point may change it, mm².
    pub(super) sight_mm2: f64,
}

/// Calls with the planes of points in their order. `near` gives the nearest neighbours of a point, the nearest first.
pub(super) fn fit_all<'a>(
    places: &impl Places,
    mut points: impl Iterator<Item = u32>,
    near: impl Fn(u32) -> &'a [u32],
    mut take: impl FnMut(u32, Fit),
) {
    let mut room = Vec::new();
    // Together: roots wait for divisions, and those of different points need not wait for each other.
    while let Some(first) = points.next() {
        let mut group = [first; TOGETHER];
        let mut count = 1;
        while let Some(at) = (count < TOGETHER).then(|| points.next()).flatten() {
            group[count] = at;
            count += 1;
        }
        let lists = group.map(&near);
        let points_mm = places.points_mm();
        let normals = if lists.iter().all(|list| list.len() == NEAREST) {
            let [one, two, three, four] = lists;
            let [a, b] = spreads_of_nearest(points_mm, [group[0], group[1]], [one, two]);
            let [c, d] = spreads_of_nearest(points_mm, [group[2], group[3]], [three, four]);
            normals([a, b, c, d])
        } else {
            std::array::from_fn(|lane| of_nearest(points_mm, group[lane], lists[lane]))
        };
        for lane in 0..count {
            take(group[lane], fit(places, group[lane], lists[lane], normals[lane], &mut room));
        }
    }
}

/// The normal of a point by its nearest neighbours alone.
fn of_nearest(points_mm: &[PointMm], at: u32, near: &[u32]) -> Option<PointMm> {
    let [normal] =
        if near.is_empty() { [None] } else { normals(spreads_of_nearest(points_mm, [at], [near])) };
    normal
}

/// The spreads of the nearest neighbours of points, of which all have as many.
fn spreads_of_nearest<const K: usize>(
    points_mm: &[PointMm],
    points: [u32; K],
    near: [&[u32]; K],
) -> [Spread; K] {
    let origins = points.map(|at| points_mm[at as usize]);
    let far_mm2 = std::array::from_fn(|lane| {
        near[lane].last().map_or(0.0, |&last| squared(origins[lane], points_mm[last as usize]))
    });
    let place = |lane: usize, index: usize| points_mm[near[lane][index] as usize];
    spreads(origins, near[0].len(), place, far_mm2)
}

/// The plane of a point with its nearest neighbours, the nearest first, and the normal that these tell alone.
fn fit(
    places: &impl Places,
    at: u32,
    near: &[u32],
    normal: Option<PointMm>,
    room: &mut Vec<Near>,
) -> Fit {
    let points_mm = places.points_mm();
    let place = points_mm[at as usize];
    let far = near.last().map_or(0.0, |&last| squared(place, points_mm[last as usize]));
    let of = |normal: PointMm, reach_mm: f64, sight_mm2: f64| Fit {
        plane: Some(TangentPlane { normal, reach_mm: REACH * reach_mm }),
        // Of fewer neighbours than are asked for, the next one counts wherever it is.
        sight_mm2: if near.len() < NEAREST { f64::INFINITY } else { sight_mm2 },
    };
    if let Some(normal) = normal {
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
        let other = |_: usize, index: usize| points_mm[room[index].1 as usize];
        if !room.is_empty()
            && let [Some(normal)] = normals(spreads([place], room.len(), other, [wider_mm2]))
        {
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

/// The spreads about some origins, of which all have as many neighbours. `place` gives a neighbour of an origin; the last one is
/// at the square of a distance.
#[inline(always)]
fn spreads<const K: usize>(
    origins: [PointMm; K],
    near: usize,
    place: impl Fn(usize, usize) -> PointMm,
    far_mm2: [f64; K],
) -> [Spread; K] {
    let count = near as f64 + 1.0;
    let scales = far_mm2.map(|square| 1.0 / square.sqrt());
    let (mut mean, mut squares) = ([[0.0; K]; 3], [[0.0; K]; 6]);
    for index in 0..near {
        let mut ways = [[0.0; K]; 3];
        for lane in 0..K {
            let way = minus(place(lane, index), origins[lane]);
            for axis in 0..3 {
                ways[axis][lane] = way[axis];
            }
        }
        for lane in 0..K {
            let [x, y, z] = ways.map(|way| way[lane] * scales[lane]);
            for (sum, term) in mean.iter_mut().zip([x, y, z]) {
                sum[lane] += term;
            }
            for (sum, term) in squares.iter_mut().zip([x * x, y * y, z * z, x * y, y * z, z * x]) {
                sum[lane] += term;
            }
        }
    }
    std::array::from_fn(|lane| {
        let [x, y, z] = mean.map(|sum| sum[lane] / count);
        let terms = [x * x, y * y, z * z, x * y, y * z, z * x];
        Spread::new(std::array::from_fn(|i| squares[i][lane] / count - terms[i]))
    })
}

/// The directions of least spread; `None` where points spread along one line only.
fn normals<const K: usize>(spreads: [Spread; K]) -> [Option<PointMm>; K] {
    let roots = smallest_roots(&spreads);
    std::array::from_fn(|lane| spreads[lane].normal(roots[lane]))
}

/// A symmetric matrix of spreads: xx, yy, zz, xy, yz, zx, and its characteristic polynomial.
struct Spread {
    terms: [f64; 6],
    trace: f64,
    minors: f64,
    det: f64,
}

impl Spread {
    fn new(terms: [f64; 6]) -> Spread {
        let [xx, yy, zz, xy, yz, zx] = terms;
        Spread {
            terms,
            trace: xx + yy + zz,
            minors: xx * yy - xy * xy + yy * zz - yz * yz + zz * xx - zx * zx,
            det: xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx),
        }
    }

    /// The direction of a root; `None` where the points lie along a line.
    fn normal(&self, root: f64) -> Option<PointMm> {
        // The minors are the sum of products of two spreads: the second against the first.
        if self.minors < LEAST_SPREAD * self.trace * self.trace {
            return None;
        }
        let [xx, yy, zz, xy, yz, zx] = self.terms;
        let rows = [[xx - root, xy, zx], [xy, yy - root, yz], [zx, yz, zz - root]];
        let crosses = [cross(rows[0], rows[1]), cross(rows[1], rows[2]), cross(rows[2], rows[0])];
        let longest = crosses.into_iter().max_by(|a, b| dot(*a, *a).total_cmp(&dot(*b, *b)))?;
        unit(longest)
    }
}

/// The smallest roots of characteristic polynomials, from below by Newton's steps.
#[inline(always)]
fn smallest_roots<const K: usize>(spreads: &[Spread; K]) -> [f64; K] {
    let mut roots = [0.0; K];
    let mut is_moving = [true; K];
    for _ in 0..12 {
        for lane in 0..K {
            let (root, Spread { trace, minors, det, .. }) = (roots[lane], &spreads[lane]);
            let value = ((root - trace) * root + minors) * root - det;
            let slope = (3.0 * root - 2.0 * trace) * root + minors;
            let step = value / slope;
            is_moving[lane] &= step < 0.0;
            roots[lane] = if is_moving[lane] { root - step } else { root };
        }
        if !is_moving.contains(&true) {
            break;
        }
    }
    roots
}

/// How many neighbours tell the plane.
pub(super) const NEAREST: usize = 16;
/// Points whose planes are fitted together.
const TOGETHER: usize = 4;
/// How far a point looks, in distances of the last of them.
const REACH: f64 = 2.3;
/// The least spread across a line of neighbours, of that along it.
const LEAST_SPREAD: f64 = 0.02;
const MOST_DOUBLINGS: u32 = 12;
const MOST_IN_A_ROW: usize = 2000;

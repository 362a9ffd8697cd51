//! Proof that tetrahedra are the Delaunay triangulation of points, by exact signs.
//!
//! It reads points and tetrahedra alone. That the hull is convex at every edge and all spheres are empty locally is not enough:
//! layers may wind about a place twice. So a place inside is found that every hull facet has on its inner side, and it must
//! lie in one tetrahedron only. As all tetrahedra are turned alike, the number of them over a place is the number of
//! windings of the hull about it, hence one everywhere inside.

use std::cmp::Ordering;

use asphera_geometry::PointMm;
use asphera_geometry::predicates::{orientation_in_space, sphere_encloses};
use rayon::prelude::*;
use thiserror::Error;

/// The first thing found wrong with tetrahedra.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unsound {
    /// A corner is not the number of a point.
    #[error("tetrahedron {corners:?}: expected corners below {points}")]
    NoSuchPoint {
        /// The tetrahedron.
        corners: [u32; 4],
        /// How many points there are.
        points: usize,
    },
    /// No tetrahedra at all.
    #[error("expected tetrahedra, found none")]
    Empty,
    /// A tetrahedron without volume.
    #[error("tetrahedron {corners:?} is flat")]
    Flat {
        /// The tetrahedron.
        corners: [u32; 4],
    },
    /// A facet with two tetrahedra on one side.
    #[error("facet {facet:?} has two tetrahedra on one side")]
    SameSide {
        /// The facet.
        facet: [u32; 3],
    },
    /// A sphere that is not empty.
    #[error("point {inside} counts as inside the sphere of tetrahedron {corners:?}")]
    SphereNotEmpty {
        /// The tetrahedron.
        corners: [u32; 4],
        /// The point inside.
        inside: u32,
    },
    /// An edge of the hull without two facets that are turned alike.
    #[error("hull edge {edge:?} does not have two facets turned alike")]
    HullOpen {
        /// The edge.
        edge: [u32; 2],
    },
    /// A hull that is not convex.
    #[error("point {beyond} lies outside hull facet {facet:?}")]
    NotConvex {
        /// The facet.
        facet: [u32; 3],
        /// The point outside.
        beyond: u32,
    },
    /// No tetrahedron has room for a place that doubles hold.
    #[error("no place strictly inside a tetrahedron can be written in doubles")]
    NoInnerPlace,
    /// Tetrahedra overlap.
    #[error("{times} tetrahedra lie over one place")]
    Overlap {
        /// How many.
        times: usize,
    },
    /// A point belongs to no tetrahedron.
    #[error("point {point} belongs to no tetrahedron")]
    Unused {
        /// The point.
        point: u32,
    },
    /// The Euler number of a ball is 1.
    #[error("vertices - edges + facets - tetrahedra: expected 1, found {euler}")]
    Euler {
        /// The number found.
        euler: i64,
    },
}

/// Checks that tetrahedra are the Delaunay triangulation of `points_mm`, which must differ in place. n·log n time.
///
/// # Errors
///
/// The first thing found wrong.
pub fn check_delaunay(points_mm: &[PointMm], tetrahedra: &[[u32; 4]]) -> Result<(), Unsound> {
    if tetrahedra.is_empty() {
        return Err(Unsound::Empty);
    }
    let turned = turned(points_mm, tetrahedra)?;
    let sides = sides(&turned);
    let mut hull = Vec::new();
    let mut facets = 0;
    for pair in sides.chunk_by(|left, right| left.key == right.key) {
        facets += 1;
        match *pair {
            [side] => hull.push(side),
            [left, right] if left.is_even != right.is_even => {
                let corners = turned[left.cell as usize];
                if encloses(points_mm, corners, right.apex) {
                    return Err(Unsound::SphereNotEmpty { corners, inside: right.apex });
                }
            }
            [side, ..] => return Err(Unsound::SameSide { facet: side.key }),
            [] => {}
        }
    }
    check_hull(points_mm, &hull)?;
    check_windings(points_mm, &turned, &hull)?;
    check_counts(points_mm.len(), &turned, facets)
}

/// A facet of a tetrahedron and the corner opposite.
#[derive(Clone, Copy)]
struct Side {
    /// Its vertices in ascending order.
    key: [u32; 3],
    /// Whether these turn counter-clockwise seen from the apex.
    is_even: bool,
    apex: u32,
    cell: u32,
}

impl Side {
    /// Its vertices, counter-clockwise seen from the apex.
    fn corners(&self) -> [u32; 3] {
        let [a, b, c] = self.key;
        if self.is_even { [a, b, c] } else { [a, c, b] }
    }
}

fn at(points_mm: &[PointMm], corner: u32) -> PointMm {
    points_mm[corner as usize]
}

fn side_of(points_mm: &[PointMm], facet: [u32; 3], place: PointMm) -> Ordering {
    let [a, b, c] = facet.map(|corner| at(points_mm, corner));
    // Counter-clockwise seen from the place is `Less`.
    orientation_in_space(a, b, c, place).reverse()
}

fn encloses(points_mm: &[PointMm], corners: [u32; 4], point: u32) -> bool {
    let [a, b, c, d] = corners.map(|corner| at(points_mm, corner));
    sphere_encloses(a, b, c, d, at(points_mm, point))
}

/// Tetrahedra with corners of orientation `Greater`.
fn turned(points_mm: &[PointMm], tetrahedra: &[[u32; 4]]) -> Result<Vec<[u32; 4]>, Unsound> {
    let points = points_mm.len();
    let turn = |&corners: &[u32; 4]| {
        if corners.iter().any(|&corner| corner as usize >= points) {
            return Err(Unsound::NoSuchPoint { corners, points });
        }
        let [a, b, c, d] = corners;
        match side_of(points_mm, [a, b, c], at(points_mm, d)) {
            Ordering::Equal => Err(Unsound::Flat { corners }),
            Ordering::Less => Ok(corners),
            Ordering::Greater => Ok([b, a, c, d]),
        }
    };
    tetrahedra.iter().map(turn).collect()
}

/// Sides of all tetrahedra, those of one facet beside each other.
fn sides(turned: &[[u32; 4]]) -> Vec<Side> {
    let mut sides: Vec<Side> = (0..)
        .zip(turned)
        .flat_map(|(cell, corners)| {
            super::FACES.iter().zip(corners).map(move |(face, &apex)| {
                let mut key = face.map(|slot| corners[slot]);
                let is_even = sort_by_turns(&mut key);
                Side { key, is_even, apex, cell }
            })
        })
        .collect();
    sides.par_sort_unstable_by_key(|side| (side.key, side.is_even, side.cell));
    sides
}

/// Sorts; whether that is a turn without a reflection.
fn sort_by_turns(key: &mut [u32; 3]) -> bool {
    let mut is_even = true;
    for (i, j) in [(0, 1), (1, 2), (0, 1)] {
        if key[i] > key[j] {
            key.swap(i, j);
            is_even = !is_even;
        }
    }
    is_even
}

/// Every edge of the hull has two facets turned alike, neither with the other's third corner outside.
fn check_hull(points_mm: &[PointMm], hull: &[Side]) -> Result<(), Unsound> {
    let mut edges: Vec<([u32; 2], bool, usize)> = Vec::with_capacity(3 * hull.len());
    for (index, side) in hull.iter().enumerate() {
        let [a, b, c] = side.corners();
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edges.push(([from.min(to), from.max(to)], from < to, index));
        }
    }
    edges.par_sort_unstable();
    for pair in edges.chunk_by(|left, right| left.0 == right.0) {
        let [(edge, _, one), (_, _, other)] = *pair else {
            return Err(Unsound::HullOpen { edge: pair[0].0 });
        };
        if pair[0].1 == pair[1].1 {
            return Err(Unsound::HullOpen { edge });
        }
        let third = hull[other].key.into_iter().find(|corner| !edge.contains(corner));
        let facet = hull[one].corners();
        if let Some(beyond) = third
            && side_of(points_mm, facet, at(points_mm, beyond)).is_lt()
        {
            return Err(Unsound::NotConvex { facet, beyond });
        }
    }
    Ok(())
}

/// A place that all hull facets have inside lies in one tetrahedron.
fn check_windings(
    points_mm: &[PointMm],
    turned: &[[u32; 4]],
    hull: &[Side],
) -> Result<(), Unsound> {
    let holds = |corners: &[u32; 4], place: PointMm, least: Ordering| {
        super::FACES.iter().all(|face| {
            let side = side_of(points_mm, face.map(|slot| corners[slot]), place);
            side == Ordering::Greater || side == least
        })
    };
    let inner = turned.iter().find_map(|corners| {
        let places = corners.map(|corner| at(points_mm, corner));
        let middle = [0, 1, 2].map(|axis| places.iter().map(|p| p[axis] / 4.0).sum::<f64>());
        holds(corners, middle, Ordering::Greater).then_some(middle)
    });
    let inner = inner.ok_or(Unsound::NoInnerPlace)?;
    for side in hull {
        let facet = side.corners();
        if side_of(points_mm, facet, inner).is_le() {
            return Err(Unsound::NotConvex { facet, beyond: side.apex });
        }
    }
    let times = turned.par_iter().filter(|corners| holds(corners, inner, Ordering::Equal)).count();
    if times == 1 { Ok(()) } else { Err(Unsound::Overlap { times }) }
}

fn check_counts(points: usize, turned: &[[u32; 4]], facets: usize) -> Result<(), Unsound> {
    let mut used = vec![false; points];
    for &corner in turned.as_flattened() {
        used[corner as usize] = true;
    }
    if let Some(point) = used.iter().position(|used| !used) {
        return Err(Unsound::Unused { point: point as u32 });
    }
    let mut edges: Vec<[u32; 2]> = turned
        .par_iter()
        .flat_map_iter(|&[a, b, c, d]| {
            [[a, b], [a, c], [a, d], [b, c], [b, d], [c, d]].map(|[p, q]| [p.min(q), p.max(q)])
        })
        .collect();
    edges.par_sort_unstable();
    edges.dedup();
    let euler = points as i64 - edges.len() as i64 + facets as i64 - turned.len() as i64;
    if euler == 1 { Ok(()) } else { Err(Unsound::Euler { euler }) }
}

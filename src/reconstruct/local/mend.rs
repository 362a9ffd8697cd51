//! Small holes filled where corners do not agree.
//!
//! Of all triangulations of a hole's loop the one with the least sum of squared circumradii is taken, by the recursion of
//! G. T. Klincsek (Annals of Discrete Mathematics 9 (1980) 121-123). No facet is wider than a star may be, none is turned
//! against its corners' normals, and none crosses the surface. A hole without such a triangulation stays.

use std::collections::{BTreeMap, BTreeSet};

use asphera_geometry::PointMm;

use super::holes::{self, Hole};
use super::normals::TangentPlane;
use crate::geometry::{cross, dot, minus};
use crate::neighbours::{Near, Neighbours};
use crate::prove::cross_any;

/// Fills the holes of a mesh; gives the facets to add. The order of `facets` does not matter.
pub(super) fn facets(
    tree: &Neighbours,
    planes: &[Option<TangentPlane>],
    facets: &[[u32; 3]],
) -> Vec<[u32; 3]> {
    let holes = holes::all(&tree.points_mm, planes, facets);
    if holes.is_empty() {
        return Vec::new();
    }
    let mut at_corner = AtCorner::of(facets);
    let mut added = Vec::new();
    for hole in &holes {
        let Some(filling) = filling(&tree.points_mm, planes, hole, &at_corner) else { continue };
        let near = about(tree, planes, hole, &at_corner);
        if !cross_any(&tree.points_mm, &filling, &near) {
            filling.iter().for_each(|&facet| at_corner.add(facet));
            added.extend(filling);
        }
    }
    added
}

/// The facets at each corner.
struct AtCorner {
    starts: Vec<u32>,
    facets: Vec<[u32; 3]>,
    added: BTreeMap<u32, Vec<[u32; 3]>>,
}

impl AtCorner {
    fn of(facets: &[[u32; 3]]) -> AtCorner {
        let corners = facets.as_flattened().iter().max().map_or(0, |&most| most as usize + 1);
        let mut starts = vec![0_u32; corners + 1];
        for &corner in facets.as_flattened() {
            starts[corner as usize + 1] += 1;
        }
        for corner in 0..corners {
            starts[corner + 1] += starts[corner];
        }
        let mut next = starts.clone();
        let mut sorted = vec![[0; 3]; 3 * facets.len()];
        for &facet in facets {
            for corner in facet {
                sorted[next[corner as usize] as usize] = facet;
                next[corner as usize] += 1;
            }
        }
        AtCorner { starts, facets: sorted, added: BTreeMap::new() }
    }

    fn add(&mut self, facet: [u32; 3]) {
        for corner in facet {
            self.added.entry(corner).or_default().push(facet);
        }
    }

    fn at(&self, corner: u32) -> impl Iterator<Item = [u32; 3]> + '_ {
        let corner = corner as usize;
        let range = match self.starts.get(corner..corner + 2) {
            Some(&[from, to]) => from as usize..to as usize,
            _ => 0..0,
        };
        let added = self.added.get(&(corner as u32)).into_iter().flatten();
        self.facets[range].iter().chain(added).copied()
    }

    /// How many facets an edge has.
    fn facets_at(&self, one: u32, other: u32) -> usize {
        self.at(one).filter(|facet| facet.contains(&other)).count()
    }
}

/// The best triangulation of a hole; `None` where there is none.
fn filling(
    points_mm: &[PointMm],
    planes: &[Option<TangentPlane>],
    hole: &Hole,
    at_corner: &AtCorner,
) -> Option<Vec<[u32; 3]>> {
    let len = hole.corners.len();
    let cost = |corners: [usize; 3]| cost(points_mm, planes, hole, corners);
    let edge =
        |from: usize, to: usize| at_corner.facets_at(hole.corners[from], hole.corners[to % len]);
    // A filling may have taken a side that walks along two holes share.
    if (0..len).any(|from| edge(from, from + 1) != 1) {
        return None;
    }
    let is_free = |from: usize, to: usize| {
        let is_side = to == from + 1 || (from == 0 && to + 1 == len);
        is_side || edge(from, to) == 0
    };
    // The least cost of what lies between two corners, and the corner in between.
    let mut best = vec![vec![(0.0, 0); len]; len];
    for span in 2..len {
        for from in 0..len - span {
            let to = from + span;
            let least = (from + 1..to)
                .map(|middle| {
                    let parts: f64 = best[from][middle].0 + best[middle][to].0;
                    (parts + cost([from, middle, to]), middle)
                })
                .min_by(|one, other| one.0.total_cmp(&other.0))?;
            best[from][to] = if is_free(from, to) { least } else { (f64::INFINITY, least.1) };
        }
    }
    if !best[0][len - 1].0.is_finite() {
        return None;
    }
    let mut found = Vec::with_capacity(len - 2);
    let mut waiting = vec![(0, len - 1)];
    while let Some((from, to)) = waiting.pop() {
        if to > from + 1 {
            let middle = best[from][to].1;
            found.push([from, middle, to].map(|index| hole.corners[index]));
            waiting.extend([(from, middle), (middle, to)]);
        }
    }
    Some(found)
}

/// The square of the circumradius; infinite of a facet that is too wide or turned.
fn cost(
    points_mm: &[PointMm],
    planes: &[Option<TangentPlane>],
    hole: &Hole,
    corners: [usize; 3],
) -> f64 {
    let [a, b, c] = corners.map(|index| points_mm[hole.corners[index] as usize]);
    let normal = cross(minus(b, a), minus(c, a));
    let size = dot(normal, normal).sqrt();
    let is_turned =
        corners.iter().any(|&index| dot(normal, hole.normals[index]) < LEAST_COSINE * size);
    let reach_mm = corners
        .iter()
        .filter_map(|&index| planes[hole.corners[index] as usize])
        .map(|plane| plane.reach_mm)
        .fold(f64::INFINITY, f64::min);
    let square = |p: PointMm, q: PointMm| dot(minus(q, p), minus(q, p));
    let radius_squared = square(a, b) * square(b, c) * square(c, a) / (4.0 * size * size);
    let is_wide = radius_squared.is_nan() || radius_squared > reach_mm * reach_mm / 4.0;
    if is_turned || is_wide { f64::INFINITY } else { radius_squared }
}

/// The facets that may meet what fills a hole: those with a corner near it.
fn about(
    tree: &Neighbours,
    planes: &[Option<TangentPlane>],
    hole: &Hole,
    at_corner: &AtCorner,
) -> Vec<[u32; 3]> {
    let first = hole.corners[0];
    let origin = tree.points_mm[first as usize];
    let reach_mm = |corner: u32| planes[corner as usize].map_or(0.0, |plane| plane.reach_mm);
    let far = |&corner: &u32| {
        let way = minus(tree.points_mm[corner as usize], origin);
        dot(way, way).sqrt() + 2.0 * reach_mm(corner)
    };
    let radius_mm = hole.corners.iter().map(far).fold(0.0, f64::max);
    let mut near: Vec<Near> = Vec::new();
    tree.within(first, radius_mm, &mut near);
    let corners = near.iter().map(|&(_, corner)| corner).chain([first]);
    let found: BTreeSet<[u32; 3]> = corners.flat_map(|corner| at_corner.at(corner)).collect();
    found.into_iter().collect()
}

/// Of the angle between a facet's normal and that of a corner, 120°: at a sharp edge the normals are those of a mixture of both
/// sides. The outside of a small patch, which is a loop too, turns by 180°.
const LEAST_COSINE: f64 = -0.5;

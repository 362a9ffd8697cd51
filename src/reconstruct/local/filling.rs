//! The best triangulation of a hole's loop.
//!
//! Of all triangulations the one with the least sum of squared circumradii is taken, by the recursion of G. T. Klincsek (Annals of
//! Discrete Mathematics 9 (1980) 121-123). No facet is wider than a star may be, and none is turned against its corners' normals.

use asphera_geometry::PointMm;

use super::holes::{Borders, Loop};
use super::stars::Facet;
use crate::geometry::{cross, dot, minus};

/// The facets of the best triangulation; `None` where there is none. `facets_at` counts the facets of an edge.
pub(super) fn best_filling(
    borders: &Borders<'_>,
    edge: &Loop,
    facets_at: impl Fn(u32, u32) -> usize,
) -> Option<Vec<Facet>> {
    let len = edge.corners.len();
    let facets_at = |from: usize, to: usize| facets_at(edge.corners[from], edge.corners[to % len]);
    // A filling may have taken a side that two holes share.
    if (0..len).any(|from| facets_at(from, from + 1) != 1) {
        return None;
    }
    let is_free = |from: usize, to: usize| {
        let is_side = to == from + 1 || (from == 0 && to + 1 == len);
        is_side || facets_at(from, to) == 0
    };
    // The least cost of what lies between two corners, and the corner in between.
    let mut best = vec![vec![(0.0, 0); len]; len];
    for span in 2..len {
        for from in 0..len - span {
            let to = from + span;
            let least = (from + 1..to)
                .map(|middle| {
                    let parts: f64 = best[from][middle].0 + best[middle][to].0;
                    (parts + cost(borders, edge, [from, middle, to]), middle)
                })
                .min_by(|one, other| one.0.total_cmp(&other.0))?;
            let is_possible = least.0.is_finite() && is_free(from, to);
            best[from][to] = if is_possible { least } else { (f64::INFINITY, least.1) };
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
            found.push([from, middle, to].map(|index| edge.corners[index]));
            waiting.extend([(from, middle), (middle, to)]);
        }
    }
    Some(found)
}

/// The square of the circumradius; infinite of a facet that is too wide or turned.
fn cost(borders: &Borders<'_>, edge: &Loop, corners: [usize; 3]) -> f64 {
    let [a, b, c] = corners.map(|index| borders.points_mm[edge.corners[index] as usize]);
    let normal = cross(minus(b, a), minus(c, a));
    let size = dot(normal, normal).sqrt();
    let is_turned =
        corners.iter().any(|&index| dot(normal, edge.normals[index]) < LEAST_COSINE * size);
    let reach_mm = corners
        .iter()
        .filter_map(|&index| borders.planes[edge.corners[index] as usize])
        .map(|plane| plane.reach_mm)
        .fold(f64::INFINITY, f64::min);
    let square = |p: PointMm, q: PointMm| dot(minus(q, p), minus(q, p));
    let radius_squared = square(a, b) * square(b, c) * square(c, a) / (4.0 * size * size);
    let is_wide = radius_squared.is_nan() || radius_squared > reach_mm * reach_mm / 4.0;
    if is_turned || is_wide { f64::INFINITY } else { radius_squared }
}

/// Of the angle between a facet's normal and that of a corner, 120°: at a sharp edge the normals are those of a mixture of both
/// sides. The outside of a small patch, which is a loop too, turns by 180°.
const LEAST_COSINE: f64 = -0.5;

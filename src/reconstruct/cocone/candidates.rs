//! Candidate facets, and the points that are flat.

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::Candidates;
use crate::delaunay::Delaunay;
use crate::geometry::{dot, minus};
use crate::poles::{Poles, outward_normal};
use crate::rings::FacetSet;

/// The Voronoi edge across a facet: from a centre towards another, or without end.
struct DualEdge {
    from: PointMm,
    way: PointMm,
    /// Whether it ends at `from` + `way`.
    ends: bool,
}

pub(super) fn of<'a>(delaunay: &'a Delaunay, centres: &[PointMm], poles: &Poles) -> Candidates<'a> {
    let facets: Vec<(u32, usize)> = delaunay.facets().collect();
    // How far each facet's dual edge reaches in the cocone of each corner; below 0 where it does not meet it.
    let reaches: Vec<[f64; 3]> = facets
        .par_iter()
        .map(|&(cell, slot)| {
            let edge = dual(delaunay, centres, cell, slot);
            delaunay.facet(cell, slot).map(|corner| {
                let normal = poles.normals[corner as usize];
                normal.map_or(-1.0, |normal| reach(&edge, delaunay.place(corner), normal))
            })
        })
        .collect();
    let mut set = FacetSet::empty(delaunay);
    let mut widths = vec![0.0_f64; delaunay.points_mm.len()];
    let mut flat = vec![true; delaunay.points_mm.len()];
    for (&(cell, slot), reaches) in facets.iter().zip(&reaches) {
        let corners = delaunay.facet(cell, slot);
        if reaches.iter().all(|&reach| reach >= 0.0) {
            set.insert(cell, slot);
        }
        for (&corner, &reach) in corners.iter().zip(reaches).filter(|(_, reach)| **reach >= 0.0) {
            let width = &mut widths[corner as usize];
            *width = width.max(reach);
            // Cells of the other corners meet the cocone in this edge.
            let Some(normal) = poles.normals[corner as usize] else { continue };
            let agrees = |other: &u32| {
                poles.normals[*other as usize]
                    .is_some_and(|other| dot(normal, other).abs() >= COS_NEIGHBOURS)
            };
            flat[corner as usize] &= corners.iter().all(agrees);
        }
    }
    for (vertex, flat) in flat.iter_mut().enumerate() {
        let place = delaunay.points_mm[vertex];
        let height = poles.second[vertex].map_or(0.0, |pole| {
            let way = minus(pole, place);
            dot(way, way).sqrt()
        });
        *flat &= widths[vertex] <= WIDEST * height;
    }
    (set, flat)
}

fn dual(delaunay: &Delaunay, centres: &[PointMm], cell: u32, slot: usize) -> DualEdge {
    let from = centres[cell as usize];
    let other = delaunay.neighbours[cell as usize][slot];
    if delaunay.is_outside(other) {
        DualEdge { from, way: outward_normal(delaunay, other), ends: false }
    } else {
        DualEdge { from, way: minus(centres[other as usize], from), ends: true }
    }
}

/// The farthest place of an edge in the cocone of a point, as a distance from it; -1 where it does not meet it.
///
/// Both halves of the double cone about the normal are convex. So an edge misses the cocone where both ends lie in one half.
fn reach(edge: &DualEdge, place: PointMm, normal: PointMm) -> f64 {
    let start = minus(edge.from, place);
    let end = if edge.ends { [0, 1, 2].map(|axis| start[axis] + edge.way[axis]) } else { edge.way };
    let half = |way: PointMm| {
        let (along, length) = (dot(way, normal), dot(way, way).sqrt());
        if along.abs() <= COS_CONE * length {
            0
        } else if along > 0.0 {
            1
        } else {
            -1
        }
    };
    let (first, last) = (half(start), half(end));
    if first != 0 && first == last {
        return -1.0;
    }
    let length = |way: PointMm| dot(way, way).sqrt();
    let mut far = if first == 0 { length(start) } else { 0.0_f64 };
    if last == 0 {
        far = far.max(if edge.ends { length(end) } else { f64::INFINITY });
    }
    // Where the edge crosses the cone: (y·n)² = cos²·y² along y = start + t·way.
    let (sn, wn) = (dot(start, normal), dot(edge.way, normal));
    let cone = COS_CONE * COS_CONE;
    let a = wn * wn - cone * dot(edge.way, edge.way);
    let b = sn * wn - cone * dot(start, edge.way);
    let c = sn * sn - cone * dot(start, start);
    let root = (b * b - a * c).max(0.0).sqrt();
    let limit = if edge.ends { 1.0 } else { f64::INFINITY };
    for t in [(-b - root) / a, (-b + root) / a] {
        if t > 0.0 && t < limit {
            far = far.max(length([0, 1, 2].map(|axis| start[axis] + t * edge.way[axis])));
        }
    }
    far
}

/// The cosine of 67.5°: the cocone opens by 22.5° from the tangent plane.
const COS_CONE: f64 = 0.382_683_432_365_089_8;
/// The cosine of 60°.
const COS_NEIGHBOURS: f64 = 0.5;
/// The widest cocone of a flat point, as a share of the distance of its second pole.
const WIDEST: f64 = 1.2;

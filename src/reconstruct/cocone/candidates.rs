//! Candidate facets, and the points that are flat.

use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::Candidates;
use crate::delaunay::Delaunay;
use crate::geometry::{dot, minus, scaled};
use crate::poles::{Poles, outward_normal};
use crate::rings::FacetSet;

/// The Voronoi edge across a facet: from a centre towards another, or without end.
pub(super) struct DualEdge {
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
    let corners: Vec<[u32; 3]> =
        facets.iter().map(|&(cell, slot)| delaunay.facet(cell, slot)).collect();
    let flat = flat_points(&delaunay.points_mm, poles, &corners, &reaches);
    let mut set = FacetSet::empty(delaunay);
    let mut candidates = 0;
    for (&(cell, slot), reaches) in facets.iter().zip(&reaches) {
        if reaches.iter().all(|&reach| reach >= 0.0) {
            set.insert(cell, slot);
            candidates += 1;
        }
    }
    Candidates { set, flat, count: candidates }
}

/// Points whose cocone is narrow beside the distance of the second pole and whose normal agrees: with those of all cells that meet
/// the cocone, or with that of one flat point among them.
pub(super) fn flat_points(
    places_mm: &[PointMm],
    poles: &Poles,
    facets: &[[u32; 3]],
    reaches: &[[f64; 3]],
) -> Vec<bool> {
    let count = places_mm.len();
    let (mut widths, mut agrees_with_all) = (vec![0.0_f64; count], vec![true; count]);
    let agree = |one: u32, other: u32| {
        let normals = [one, other].map(|vertex| poles.normals[vertex as usize]);
        matches!(normals, [Some(one), Some(other)] if dot(one, other).abs() >= COS_NEIGHBOURS)
    };
    for (corners, reaches) in facets.iter().zip(reaches) {
        for (&corner, &reach) in corners.iter().zip(reaches).filter(|(_, reach)| **reach >= 0.0) {
            let width = &mut widths[corner as usize];
            *width = width.max(reach);
            // Cells of the other corners meet the cocone in this edge.
            agrees_with_all[corner as usize] &= corners.iter().all(|&other| agree(corner, other));
        }
    }
    let is_narrow = |vertex: usize| {
        let place = places_mm[vertex];
        let height = poles.second[vertex].map_or(0.0, |pole| {
            let way = minus(pole, place);
            dot(way, way).sqrt()
        });
        widths[vertex] <= WIDEST * height
    };
    let narrow: Vec<bool> = (0..count).map(is_narrow).collect();
    let mut flat: Vec<bool> =
        narrow.iter().zip(agrees_with_all).map(|(&narrow, agrees)| narrow && agrees).collect();
    // Flat points make their neighbours flat, until none is added.
    loop {
        let mut is_done = true;
        for (corners, reaches) in facets.iter().zip(reaches) {
            for (&corner, &reach) in corners.iter().zip(reaches) {
                if reach < 0.0 || flat[corner as usize] || !narrow[corner as usize] {
                    continue;
                }
                if corners.iter().any(|&other| flat[other as usize] && agree(corner, other)) {
                    flat[corner as usize] = true;
                    is_done = false;
                }
            }
        }
        if is_done {
            return flat;
        }
    }
}

pub(super) fn dual(delaunay: &Delaunay, centres: &[PointMm], cell: u32, slot: usize) -> DualEdge {
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
pub(super) fn reach(edge: &DualEdge, place: PointMm, normal: PointMm) -> f64 {
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
    // Where the edge crosses the cone: (y·n)² = cos²·y² along y = start + t·way. The nearer end is the start, and no root is
    // the difference of large numbers.
    let (start, way) = if edge.ends && length(end) < length(start) {
        (end, scaled(edge.way, -1.0))
    } else {
        (start, edge.way)
    };
    let (sn, wn) = (dot(start, normal), dot(way, normal));
    let cone = COS_CONE * COS_CONE;
    let a = wn * wn - cone * dot(way, way);
    let b = sn * wn - cone * dot(start, way);
    let c = sn * sn - cone * dot(start, start);
    let q = -(b + (b * b - a * c).max(0.0).sqrt().copysign(b));
    let limit = if edge.ends { 1.0 } else { f64::INFINITY };
    for t in [q / a, c / q] {
        if t > 0.0 && t < limit {
            far = far.max(length([0, 1, 2].map(|axis| start[axis] + t * way[axis])));
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

//! Carving: triangles at the border go where that brings a sample within the region to the border.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::inside::Inside;
use crate::triangulation::{TriangleId, distance_mm};
use crate::{SampleId, Triangulation};

/// Takes triangles off the region, that of the least added border first, until no sample within can be brought to the
/// border: a triangle goes if exactly one of its sides is border and the corner opposite lies within.
pub(super) fn sculpt(triangulation: &Triangulation, region: &mut Inside) {
    let mut is_within = vec![true; triangulation.len()];
    for (edge, id) in triangulation.edges().iter().zip(0..) {
        let is_hull = edge.triangles().contains(&None);
        let [left, right] = edge.triangles().map(|triangle| region.holds(triangle));
        if is_hull || region.is_border(triangulation, id) || (!left && !right) {
            for end in edge.ends {
                is_within[end as usize] = false;
            }
        }
    }
    let mut heap = BinaryHeap::new();
    for triangle in 0..triangulation.triangles().len() as TriangleId {
        if let Some((added_mm, _)) = removable(triangulation, region, &is_within, triangle) {
            heap.push(Reverse((key(added_mm), triangle)));
        }
    }
    while let Some(Reverse((_, triangle))) = heap.pop() {
        let Some((_, apex)) = removable(triangulation, region, &is_within, triangle) else {
            continue;
        };
        region.set(triangle, false);
        is_within[apex as usize] = false;
        for beyond in triangulation.across(triangle).into_iter().flatten() {
            if let Some((added_mm, _)) = removable(triangulation, region, &is_within, beyond) {
                heap.push(Reverse((key(added_mm), beyond)));
            }
        }
    }
}

/// What taking a triangle off adds to the border in mm, and the sample that it brings there; none if it must stay.
fn removable(
    triangulation: &Triangulation,
    region: &Inside,
    is_within: &[bool],
    triangle: TriangleId,
) -> Option<(f64, SampleId)> {
    if !region.holds(Some(triangle)) {
        return None;
    }
    let beyond = triangulation.across(triangle);
    let mut open = (0..3).filter(|&side| !region.holds(beyond[side]));
    let (Some(side), None) = (open.next(), open.next()) else { return None };
    let corners = triangulation.triangles()[triangle as usize];
    let apex = corners[(side + 2) % 3];
    if !is_within[apex as usize] {
        return None;
    }
    let [p, q, r] =
        [corners[side], corners[(side + 1) % 3], apex].map(|corner| triangulation.place(corner));
    Some(((distance_mm(p, r) + distance_mm(r, q)) - distance_mm(p, q), apex))
}

/// A length of at least zero that orders as its bits do; rounding below zero counts as zero.
fn key(length_mm: f64) -> u64 {
    length_mm.max(0.0).to_bits()
}

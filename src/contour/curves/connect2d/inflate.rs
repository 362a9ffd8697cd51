//! Inflating: every sample is left with at most one side on which the outside touches it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::inside::Inside;
use crate::triangulation::{EdgeId, TriangleId};
use crate::{SampleId, Triangulation};

/// A run of sectors about a sample that lie outside, between walls or triangles inside.
struct Wedge {
    triangles: Vec<TriangleId>,
    reaches_beyond_hull: bool,
    /// Length of the far sides less that of the two edges that bound it, mm.
    cost_mm: f64,
}

/// Fills wedges, least cost first, until no sample has more than one.
pub(super) fn inflate(triangulation: &Triangulation, walls: &[bool], region: &mut Inside) {
    let mut heap = BinaryHeap::new();
    let offer = |heap: &mut BinaryHeap<_>, region: &Inside, sample: SampleId| {
        if let Some(wedge) = cheapest(triangulation, walls, region, sample) {
            heap.push(Reverse((key(wedge.cost_mm), sample)));
        }
    };
    for sample in 0..triangulation.len() as SampleId {
        offer(&mut heap, region, sample);
    }
    while let Some(Reverse((cost, sample))) = heap.pop() {
        // What was filled since may have changed the wedges: an entry counts only as it stands.
        let Some(wedge) = cheapest(triangulation, walls, region, sample) else { continue };
        if key(wedge.cost_mm) != cost {
            heap.push(Reverse((key(wedge.cost_mm), sample)));
            continue;
        }
        for &triangle in &wedge.triangles {
            region.set(triangle, true);
        }
        let mut touched: Vec<SampleId> = wedge
            .triangles
            .iter()
            .flat_map(|&triangle| triangulation.triangles()[triangle as usize])
            .collect();
        touched.sort_unstable();
        touched.dedup();
        for sample in touched {
            offer(&mut heap, region, sample);
        }
    }
}

/// The wedge of a sample to be filled first: of several the cheapest that does not reach beyond the hull.
fn cheapest(
    triangulation: &Triangulation,
    walls: &[bool],
    region: &Inside,
    sample: SampleId,
) -> Option<Wedge> {
    let wedges = wedges(triangulation, walls, region, sample);
    if wedges.len() < 2 {
        return None;
    }
    let fillable = wedges.into_iter().filter(|wedge| !wedge.reaches_beyond_hull);
    fillable.min_by(|a, b| {
        a.cost_mm
            .total_cmp(&b.cost_mm)
            .then_with(|| a.triangles.iter().min().cmp(&b.triangles.iter().min()))
    })
}

/// The wedges of a sample.
fn wedges(
    triangulation: &Triangulation,
    walls: &[bool],
    region: &Inside,
    sample: SampleId,
) -> Vec<Wedge> {
    let fan = triangulation.fan(sample);
    let count = fan.edges.len();
    let is_outside = |index: usize| !region.holds(fan.sectors[index % count]);
    // A sector begins a wedge if it is outside and what lies before it is inside or behind a wall.
    let begins = |index: usize| {
        is_outside(index) && (walls[fan.edges[index] as usize] || !is_outside(index + count - 1))
    };
    let starts: Vec<usize> = (0..count).filter(|&index| begins(index)).collect();
    let run = |start: usize| {
        let mut end = start + 1;
        while end < start + count && is_outside(end) && !begins(end % count) {
            end += 1;
        }
        start..end
    };
    starts
        .into_iter()
        .map(|start| {
            let sectors = run(start);
            let bounds = [sectors.start, sectors.end].map(|index| fan.edges[index % count]);
            let triangles: Vec<TriangleId> =
                sectors.clone().filter_map(|index| fan.sectors[index % count]).collect();
            Wedge {
                cost_mm: cost_mm(triangulation, sample, &triangles, bounds),
                reaches_beyond_hull: triangles.len() < sectors.len(),
                triangles,
            }
        })
        .collect()
}

/// Length of the sides opposite a sample less that of two edges, mm.
fn cost_mm(
    triangulation: &Triangulation,
    sample: SampleId,
    triangles: &[TriangleId],
    bounds: [EdgeId; 2],
) -> f64 {
    let far = |&triangle: &TriangleId| {
        let sides = triangulation.sides(triangle);
        sides.into_iter().find(|&side| !triangulation.ends(side).contains(&sample))
    };
    let link: f64 =
        triangles.iter().filter_map(far).map(|side| triangulation.length_mm(side)).sum();
    link - (triangulation.length_mm(bounds[0]) + triangulation.length_mm(bounds[1]))
}

/// A length that orders as its bits do.
fn key(length_mm: f64) -> i64 {
    let bits = (length_mm + 0.0).to_bits() as i64;
    bits ^ (((bits >> 63) as u64) >> 1) as i64
}

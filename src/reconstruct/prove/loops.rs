//! The border of a mesh as loops.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;

use super::edges::Edges;
use super::umbrellas::Umbrellas;
use crate::geometry::{dot, minus};

/// A loop of border edges.
#[derive(Clone, Debug, PartialEq)]
pub struct BorderLoop {
    /// How many edges it has.
    pub edges: usize,
    /// Its length in mm.
    pub length_mm: f64,
    /// The smallest number of a vertex on it.
    pub vertex: u32,
}

/// The loops, the one of the smallest vertex first. A border that branches at a non-manifold edge ends there.
pub(super) fn of(
    points_mm: &[PointMm],
    facets: &[[u32; 3]],
    edges: &Edges,
    umbrellas: &Umbrellas,
) -> Vec<BorderLoop> {
    // At an open fan two border edges meet: by fans a loop that passes a vertex twice is walked without a doubt.
    let mut at_fan: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let fans = |index: u32| {
        edges.border[index as usize].corners().map(|slot| umbrellas.fan[slot as usize])
    };
    for index in 0..edges.border.len() as u32 {
        for fan in fans(index) {
            at_fan.entry(fan).or_default().push(index);
        }
    }
    let mut is_seen = vec![false; edges.border.len()];
    let mut found = Vec::new();
    for first in 0..edges.border.len() as u32 {
        if is_seen[first as usize] {
            continue;
        }
        is_seen[first as usize] = true;
        let mut waiting = vec![first];
        let mut edge = BorderLoop { edges: 0, length_mm: 0.0, vertex: u32::MAX };
        while let Some(index) = waiting.pop() {
            let side = edges.border[index as usize];
            let way = minus(points_mm[side.low as usize], points_mm[side.high as usize]);
            edge.edges += 1;
            edge.length_mm += dot(way, way).sqrt();
            edge.vertex = edge.vertex.min(side.low);
            debug_assert!(facets[side.facet() as usize].contains(&side.low));
            for fan in fans(index) {
                for &next in &at_fan[&fan] {
                    if !std::mem::replace(&mut is_seen[next as usize], true) {
                        waiting.push(next);
                    }
                }
            }
        }
        found.push(edge);
    }
    found.sort_by_key(|border| (border.vertex, border.edges));
    found
}

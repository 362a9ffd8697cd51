//! Pieces as the paper grows them: among the k nearest places, with a τ that follows their spacing.
//!
//! Growth is not the same as τ-components: a place whose k nearest lie on one side breaks a piece, and every break makes a loop.
//! It reproduces the paper's figures; [`PointGraph::new`] is what to count loops with.

use std::collections::{BTreeMap, VecDeque};

use crate::cloud::{Cloud, PlaceId};
use crate::extract::ExtractError;
use crate::graph::{Arc, GraphError, PointGraph, nodes, sorted_by_strip};
use crate::nearest::Nearest;
use crate::strips::Strips;

/// Parameters of the growth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Neighbours among which a piece grows; the paper takes 10, and fewer than 12.
    pub k: usize,
    /// Pieces of consecutive strips are joined where they are nearer than this many times the mean of their τ; the paper takes 2.
    pub arc_tau: f64,
    /// τ follows the spacing; otherwise it stays what it was.
    pub is_adaptive: bool,
}

impl Default for Growth {
    fn default() -> Growth {
        Growth { k: 10, arc_tau: 2.0, is_adaptive: true }
    }
}

/// The graph of grown pieces (sections 2.3 and 3.2 of the paper). n·(k + log n) time, 12·k bytes a place.
///
/// Pieces begin at the first place that is in none, and take places in the order in which they are reached.
///
/// # Errors
///
/// Errors as of [`PointGraph::new`]; lists of neighbours that are too long.
pub fn grown_graph<const D: usize>(
    cloud: &Cloud<D>,
    values: &[f64],
    strips: Strips,
    tau_mm: f64,
    growth: Growth,
) -> Result<PointGraph<D>, ExtractError> {
    if !(tau_mm > 0.0 && tau_mm.is_finite()) {
        return Err(GraphError::Tau { tau_mm }.into());
    }
    let nearest = cloud.nearest(growth.k)?;
    let mut of_place = vec![NONE; cloud.len()];
    // The last τ of each piece, and its strip.
    let mut taus = Vec::new();
    let mut strip_of = Vec::new();
    for (strip, places) in sorted_by_strip(cloud, values, &strips)?.into_iter().enumerate() {
        let is_in = |place: PlaceId| strips.strip_of(values[place as usize]) == strip;
        for place in places {
            if of_place[place as usize] == NONE {
                let number = taus.len() as u32;
                taus.push(grow(
                    &nearest,
                    &mut of_place,
                    place,
                    (number, tau_mm),
                    (&growth, &is_in),
                ));
                strip_of.push(strip);
            }
        }
    }
    let widest = growth.arc_tau * taus.iter().copied().fold(0.0, f64::max);
    let mut least: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for place in 0..cloud.len() as u32 {
        let own = of_place[place as usize];
        cloud.visit_within(place, widest, |other, square| {
            let other = of_place[other as usize];
            if strip_of[other as usize] == strip_of[own as usize] + 1 {
                let mean = (taus[own as usize] + taus[other as usize]) / 2.0;
                let distance = square.sqrt();
                if distance < growth.arc_tau * mean {
                    let known = least.entry([own, other]).or_insert(distance);
                    *known = known.min(distance);
                }
            }
        });
    }
    let arcs = least.into_iter().map(|(nodes, distance_mm)| Arc { nodes, distance_mm }).collect();
    let nodes = nodes(cloud, values, &strips, &of_place, taus.len() as u32);
    Ok(PointGraph { strips, nodes, arcs, of_place })
}

/// Grows a piece from a place and gives its last τ in mm.
fn grow(
    nearest: &Nearest,
    of_place: &mut [u32],
    start: PlaceId,
    (number, mut tau): (u32, f64),
    (growth, is_in): (&Growth, &impl Fn(PlaceId) -> bool),
) -> f64 {
    let mut queue = VecDeque::from([start]);
    of_place[start as usize] = number;
    let mut visited = 0.0;
    while let Some(place) = queue.pop_front() {
        visited += 1.0;
        let distances = nearest.distances_mm(place);
        let within = distances.partition_point(|&distance| distance <= tau);
        for &other in &nearest.neighbours(place)[..within] {
            if of_place[other as usize] == NONE && is_in(other) {
                of_place[other as usize] = number;
                queue.push_back(other);
            }
        }
        if growth.is_adaptive && within > 0 {
            let factor = if within == nearest.k() { 1.0 } else { 2.0 };
            tau = (factor * distances[within - 1] + visited * tau) / (visited + 1.0);
        }
    }
    tau
}

/// In no piece.
const NONE: u32 = u32::MAX;

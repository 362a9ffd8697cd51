//! The graph Voronoi diagram: every point belongs to the landmark that is nearest in hops.

use rayon::prelude::*;

use super::landmarks::Landmarks;
use super::links::Links;

/// The landmark of each point, by its place in the order of choice: of several as near, the first.
///
/// This is the search from all landmarks at once, ring by ring. Of all landmarks at the distance of a point, the first is
/// the first of a neighbour one hop nearer, so that a ring depends on the ring before it alone.
pub(super) fn owners(links: &Links, landmarks: &Landmarks) -> Vec<u32> {
    let hops = &landmarks.hops;
    let farthest = hops.iter().copied().max().unwrap_or(0);
    let mut rings = vec![Vec::new(); usize::from(farthest) + 1];
    for (point, &distance) in (0..).zip(hops) {
        rings[usize::from(distance)].push(point);
    }
    let mut owners = vec![u32::MAX; links.len()];
    for (rank, &point) in (0..).zip(&landmarks.points) {
        owners[point as usize] = rank;
    }
    for (ring, inside) in rings[1..].iter().zip(0..) {
        let found: Vec<u32> = ring
            .par_iter()
            .map(|&point| {
                let inner = links.at(point).iter().filter(|&&near| hops[near as usize] == inside);
                inner.map(|&near| owners[near as usize]).min().unwrap_or(u32::MAX)
            })
            .collect();
        for (&point, owner) in ring.iter().zip(found) {
            owners[point as usize] = owner;
        }
    }
    owners
}

//! Where cells touch: the edges of the combinatorial Delaunay map.

use rayon::prelude::*;

use super::links::Links;

/// Two cells that touch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contact {
    /// The landmarks, the one chosen earlier first.
    pub landmarks: [u32; 2],
    /// Points of either cell with a neighbour in the other: b(S1, S2) + b(S2, S1) of section 3.1.
    pub points: u32,
}

/// All pairs of cells that touch, by the order of their landmarks. `owners` holds the cell of each point.
pub(super) fn contacts(links: &Links, owners: &[u32]) -> Vec<Contact> {
    let mut pairs: Vec<[u32; 2]> = (0..owners.len() as u32)
        .into_par_iter()
        .fold(
            || (Vec::new(), Vec::new()),
            |(mut pairs, mut others), point| {
                let own = owners[point as usize];
                others.clear();
                let near = links.at(point).iter().map(|&near| owners[near as usize]);
                for other in near.filter(|&other| other != own) {
                    if !others.contains(&other) {
                        others.push(other);
                    }
                }
                pairs.extend(others.iter().map(|&other| [own.min(other), own.max(other)]));
                (pairs, others)
            },
        )
        .flat_map_iter(|(pairs, _)| pairs)
        .collect();
    pairs.par_sort_unstable();
    let groups = pairs.chunk_by(|one, other| one == other);
    groups.map(|group| Contact { landmarks: group[0], points: group.len() as u32 }).collect()
}

/// Pairs of cells that meet: some point has both in its neighbourhood, itself included. In ascending order.
pub(super) fn meetings(links: &Links, owners: &[u32]) -> Vec<[u32; 2]> {
    let mut pairs: Vec<[u32; 2]> = (0..owners.len() as u32)
        .into_par_iter()
        .fold(
            || (Vec::new(), Vec::new()),
            |(mut pairs, mut around), point| {
                around.clear();
                around.push(owners[point as usize]);
                around.extend(links.at(point).iter().map(|&near| owners[near as usize]));
                around.sort_unstable();
                around.dedup();
                for (at, &one) in around.iter().enumerate() {
                    pairs.extend(around[at + 1..].iter().map(|&other| [one, other]));
                }
                (pairs, around)
            },
        )
        .flat_map_iter(|(pairs, _)| pairs)
        .collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}

//! Which facets of a surface must be turned so that neighbours agree.

use rayon::prelude::*;

/// A way to turn facets.
pub(crate) struct Turning {
    /// For each facet whether it must be turned; the first of each patch is not.
    pub(crate) is_turned: Vec<bool>,
    /// For each facet the patch it belongs to, numbered in the order of their first facets. Patches meet in borders, corners and
    /// edges of more than two facets.
    pub(crate) patch: Vec<u32>,
    pub(crate) patches: usize,
}

impl Turning {
    /// The way to turn facets with corners among so many points; `None` where a patch has one side only. Linear time.
    pub(crate) fn of(points: usize, facets: &[[u32; 3]]) -> Option<Turning> {
        let beside = neighbours(points, facets);
        let mut is_turned = vec![false; facets.len()];
        let mut patch = vec![NONE; facets.len()];
        let mut patches = 0;
        let mut waiting = Vec::new();
        for first in 0..facets.len() {
            if patch[first] != NONE {
                continue;
            }
            patch[first] = patches;
            waiting.push(first);
            while let Some(facet) = waiting.pop() {
                for &way in beside[facet].iter().filter(|&&way| way != NONE) {
                    let (other, agrees) = ((way >> 1) as usize, way & 1 == 1);
                    let wanted = is_turned[facet] == agrees;
                    if patch[other] == NONE {
                        patch[other] = patches;
                        is_turned[other] = wanted;
                        waiting.push(other);
                    } else if is_turned[other] != wanted {
                        return None;
                    }
                }
            }
            patches += 1;
        }
        Some(Turning { is_turned, patch, patches: patches as usize })
    }
}

/// For each side of each facet twice the number of the facet beyond, and 1 more where both are listed alike; [`NONE`] of a side of
/// one facet or of more than two.
fn neighbours(points: usize, facets: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let sides = || {
        facets.as_flattened().iter().zip(0_u32..).map(|(&from, slot)| {
            let facet = facets[slot as usize / 3];
            let to = facet[(slot as usize + 1) % 3];
            (from.min(to), from.max(to), slot << 1 | u32::from(from < to))
        })
    };
    // Sides by their lower ends.
    let mut starts = vec![0_u32; points + 1];
    sides().for_each(|(low, ..)| starts[low as usize + 1] += 1);
    for point in 0..points {
        starts[point + 1] += starts[point];
    }
    let mut next = starts.clone();
    let mut by_low = vec![[0; 2]; 3 * facets.len()];
    for (low, high, slot) in sides() {
        let to = &mut next[low as usize];
        by_low[*to as usize] = [high, slot];
        *to += 1;
    }
    drop(next);
    let beyond = |(slot, from, to): (u32, u32, u32)| {
        let (low, high) = (from.min(to) as usize, from.max(to));
        let own = &by_low[starts[low] as usize..starts[low + 1] as usize];
        let mut others = own.iter().filter(|side| side[0] == high && side[1] >> 1 != slot);
        match (others.next(), others.next()) {
            (Some(&[_, other]), None) if (other >> 1) / 3 != slot / 3 => {
                let agrees = u32::from((from < to) != (other & 1 == 1));
                ((other >> 1) / 3) << 1 | agrees
            }
            _ => NONE,
        }
    };
    facets
        .par_iter()
        .enumerate()
        .with_min_len(FACETS_AT_ONCE)
        .map(|(at, &[a, b, c])| {
            let slot = 3 * at as u32;
            [(slot, a, b), (slot + 1, b, c), (slot + 2, c, a)].map(beyond)
        })
        .collect()
}

/// Facets that a thread takes in turn.
const FACETS_AT_ONCE: usize = 1 << 12;
const NONE: u32 = u32::MAX;

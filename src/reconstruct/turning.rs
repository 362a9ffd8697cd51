//! Which facets of a surface must be turned so that neighbours agree.

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
    // Sides in the order of their lower ends.
    let mut starts = vec![0_u32; points + 1];
    sides().for_each(|(low, ..)| starts[low as usize + 1] += 1);
    for point in 0..points {
        starts[point + 1] += starts[point];
    }
    let mut next = starts.clone();
    let mut sorted = vec![[0; 2]; 3 * facets.len()];
    for (low, high, slot) in sides() {
        let to = &mut next[low as usize];
        sorted[*to as usize] = [high, slot];
        *to += 1;
    }
    drop(next);
    let mut beside = vec![[NONE; 3]; facets.len()];
    for ends in starts.windows(2) {
        let own = &mut sorted[ends[0] as usize..ends[1] as usize];
        own.sort_unstable();
        for group in own.chunk_by(|a, b| a[0] == b[0]) {
            let &[[_, one], [_, other]] = group else { continue };
            let agrees = u32::from(one & 1 != other & 1);
            let [facet, beyond] = [one, other].map(|slot| (slot >> 1) / 3);
            if facet != beyond {
                beside[facet as usize][(one >> 1) as usize % 3] = beyond << 1 | agrees;
                beside[beyond as usize][(other >> 1) as usize % 3] = facet << 1 | agrees;
            }
        }
    }
    beside
}

const NONE: u32 = u32::MAX;

//! Which facets of a surface must be turned so that neighbours agree.

use std::ops::Range;

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
        let ways = |facet: usize| beside[facet].into_iter().filter(|&way| way != NONE);
        let parts = rayon::current_num_threads().min(facets.len() / FACETS_AT_ONCE).max(1);
        let size = facets.len().div_ceil(parts).max(1);
        let leaves = |facet: usize, way: u32| (way >> 1) as usize / size != facet / size;
        let all = (0..facets.len()).into_par_iter().with_min_len(FACETS_AT_ONCE);
        // Facets with a way from part to part.
        let leaving: Vec<usize> = match parts {
            1 => Vec::new(),
            _ => all.filter(|&facet| ways(facet).any(|way| leaves(facet, way))).collect(),
        };
        // Points in random order leave more between the parts than within: one walk is faster then.
        if parts == 1 || leaving.len() > facets.len() / MOST_LEAVE {
            return walk(0..facets.len(), ways);
        }
        let walked: Vec<Option<Turning>> = (0..parts)
            .into_par_iter()
            .map(|own| walk(own * size..((own + 1) * size).min(facets.len()), ways))
            .collect();
        let leaving = leaving.into_iter().flat_map(|facet| {
            ways(facet).filter(move |&way| leaves(facet, way)).map(move |way| (facet, way))
        });
        joined(walked.into_iter().collect::<Option<_>>()?, leaving)
    }
}

/// Walks over things from neighbour to neighbour, without leaving a range. Ways are as in [`neighbours`].
fn walk<Ways: Iterator<Item = u32>>(
    range: Range<usize>,
    ways: impl Fn(usize) -> Ways,
) -> Option<Turning> {
    let mut is_turned = vec![false; range.len()];
    let mut patch = vec![NONE; range.len()];
    let mut patches = 0;
    let mut waiting = Vec::new();
    for first in range.clone() {
        if patch[first - range.start] != NONE {
            continue;
        }
        patch[first - range.start] = patches;
        waiting.push(first);
        while let Some(own) = waiting.pop() {
            let own_turned = is_turned[own - range.start];
            for way in ways(own) {
                let (other, agrees) = ((way >> 1) as usize, way & 1 == 1);
                if !range.contains(&other) {
                    continue;
                }
                let (at, wanted) = (other - range.start, own_turned == agrees);
                if patch[at] == NONE {
                    patch[at] = patches;
                    is_turned[at] = wanted;
                    waiting.push(other);
                } else if is_turned[at] != wanted {
                    return None;
                }
            }
        }
        patches += 1;
    }
    Some(Turning { is_turned, patch, patches: patches as usize })
}

/// Joins what was walked in parts by the ways that leave these: a walk from patch to patch.
fn joined(parts: Vec<Turning>, leaving: impl Iterator<Item = (usize, u32)>) -> Option<Turning> {
    let mut whole = Turning { is_turned: Vec::new(), patch: Vec::new(), patches: 0 };
    for part in parts {
        whole.is_turned.extend(part.is_turned);
        let before = whole.patches as u32;
        whole.patch.extend(part.patch.into_iter().map(|own| own + before));
        whole.patches += part.patches;
    }
    let Turning { is_turned, patch, patches } = &mut whole;
    let mut beside = vec![Vec::new(); *patches];
    for (facet, way) in leaving {
        let (other, agrees) = ((way >> 1) as usize, way & 1 == 1);
        let agrees = agrees ^ is_turned[facet] ^ is_turned[other];
        beside[patch[facet] as usize].push(patch[other] << 1 | u32::from(agrees));
    }
    let of_patches = walk(0..beside.len(), |own| beside[own].iter().copied())?;
    is_turned.par_iter_mut().zip(patch).with_min_len(FACETS_AT_ONCE).for_each(
        |(is_turned, patch)| {
            *is_turned ^= of_patches.is_turned[*patch as usize];
            *patch = of_patches.patch[*patch as usize];
        },
    );
    *patches = of_patches.patches;
    Some(whole)
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
/// Sides that may lie between parts: one of so many facets.
const MOST_LEAVE: usize = 16;
const NONE: u32 = u32::MAX;

#[cfg(test)]
mod tests {
    use rayon::ThreadPoolBuilder;

    use super::*;

    /// A band of squares, each in two facets, listed alike or not by a pattern; closed with or without a twist.
    fn band(squares: u32, is_twisted: bool) -> (usize, Vec<[u32; 3]>) {
        let corner = |square: u32, side: u32| {
            let (turns, at) = (square / squares, square % squares);
            2 * at + (side + u32::from(is_twisted) * turns) % 2
        };
        let facets = (0..squares).flat_map(|at| {
            let [a, b] = [0, 1].map(|side| corner(at, side));
            let [c, d] = [0, 1].map(|side| corner(at + 1, side));
            let turned = |[p, q, r]: [u32; 3], is_turned: bool| {
                if is_turned { [p, r, q] } else { [p, q, r] }
            };
            [turned([a, b, c], at % 3 == 0), turned([b, d, c], at % 7 < 3)]
        });
        (2 * squares as usize, facets.collect())
    }

    #[test]
    fn threads_turn_facets_as_one_does() {
        for (is_twisted, is_mixed) in [(false, false), (false, true), (true, false), (true, true)] {
            let (points, mut facets) = band(30_000, is_twisted);
            // Two bands, one after the other or mixed.
            let others = facets.iter().map(|facet| facet.map(|corner| corner + points as u32));
            let others: Vec<[u32; 3]> = others.collect();
            facets.extend(others);
            if is_mixed {
                facets.sort_unstable_by_key(|&[a, b, c]| (a ^ b ^ c).wrapping_mul(0x9e37_79b9));
            }
            let [one, three] = [1, 3].map(|threads| {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let turning = pool.install(|| Turning::of(2 * points, &facets));
                turning.map(|Turning { is_turned, patch, patches }| (is_turned, patch, patches))
            });
            assert_eq!(one, three);
            assert_eq!(one.is_none(), is_twisted);
            let Some((is_turned, patch, patches)) = one else { continue };
            assert_eq!((patches, patch[0], is_turned[0]), (2, 0, false));
            // No side is passed twice the same way.
            let mut ways: Vec<[u32; 2]> = Vec::new();
            for (&[a, b, c], is_turned) in facets.iter().zip(is_turned) {
                let [b, c] = if is_turned { [c, b] } else { [b, c] };
                ways.extend([[a, b], [b, c], [c, a]]);
            }
            ways.sort_unstable();
            assert!(ways.windows(2).all(|pair| pair[0] != pair[1]));
        }
    }
}

//! The profile where only some sectors have samples: in the corners of a part that is not round.
//!
//! There the sectors that go on say what is alike in them. But each sector lost a quartic of its own, so their mean f does
//! not go on where the profile p of all ends. As far as both are known f − p is the difference of two quartics, which is
//! one as well, whatever the rings. So the profile goes on as f less that quartic, and what it leaves of the part has no bend
//! where sectors end.

use super::middle_third;
use super::sectors::{Mean, Polynomial};
use crate::defects::tail;

/// Lets a profile that is known up to the node `last`, and level from there on, go on to the end of some sectors; level where
/// too few are known.
pub(super) fn go_on(heights_mm: &mut [f64], last: usize, sectors: &[Vec<Mean>]) {
    if last + NARROW >= heights_mm.len() {
        return;
    }
    let mut those: Vec<usize> = Vec::new();
    let mut apart = Apart::default();
    for node in last + 1..heights_mm.len() {
        let known: Vec<usize> =
            (0..sectors.len()).filter(|&sector| sectors[sector][node].weight > 0.0).collect();
        if known != those {
            apart = Apart::of(&heights_mm[..node], &known, sectors);
            those = known;
        }
        let scale = heights_mm.len() as f64;
        heights_mm[node] = match (middle_mean(&those, sectors, node), apart.at(node as f64 / scale))
        {
            (Some(height_mm), Some(apart_mm)) => height_mm - apart_mm,
            _ => heights_mm[node - 1],
        };
    }
}

/// How far the mean of some sectors lies from the profile: an even quartic.
#[derive(Default)]
struct Apart {
    terms: Option<[f64; 3]>,
}

impl Apart {
    fn of(profile_mm: &[f64], those: &[usize], sectors: &[Vec<Mean>]) -> Apart {
        let scale = sectors.first().map_or(1.0, |sector| sector.len() as f64);
        let both = profile_mm.iter().enumerate().filter_map(|(node, profile_mm)| {
            let height_mm = middle_mean(those, sectors, node)?;
            let weight = those.iter().map(|&sector| sectors[sector][node].weight).sum::<f64>();
            Some((node as f64 / scale, weight, height_mm - profile_mm))
        });
        let both: Vec<(f64, f64, f64)> = both.collect();
        let mut most_mm = f64::INFINITY;
        let mut found = Apart::default();
        for _ in 0..ROUNDS {
            let mut fit = Polynomial::<3>::new();
            for &(way, weight, apart_mm) in &both {
                let off_mm = (apart_mm - found.at(way).unwrap_or(apart_mm)).abs();
                if off_mm * weight.sqrt() <= most_mm {
                    fit.add(way * way, weight, apart_mm);
                }
            }
            found = Apart { terms: fit.solved().map(Into::into) };
            let off = |&(way, weight, apart_mm): &(f64, f64, f64)| {
                Some((apart_mm - found.at(way)?).abs() * weight.sqrt())
            };
            let mut sizes: Vec<f64> = both.iter().filter_map(off).collect();
            most_mm = CALM * tail::scale(&mut sizes).unwrap_or(f64::INFINITY);
        }
        found
    }

    /// At a share of the way to the last node.
    fn at(&self, way: f64) -> Option<f64> {
        let square = way * way;
        self.terms.map(|[level, curved, steep]| level + square * (curved + square * steep))
    }
}

/// Mean of the middle third of some sectors at a node; `None` where one of them is not known, or they are too few.
fn middle_mean(those: &[usize], sectors: &[Vec<Mean>], node: usize) -> Option<f64> {
    let mut heights_mm = Vec::with_capacity(those.len());
    for &sector in those {
        let mean = &sectors[sector][node];
        (mean.weight > 0.0).then(|| heights_mm.push(mean.height_mm))?;
    }
    if heights_mm.len() < FEW {
        return None;
    }
    heights_mm.sort_unstable_by(f64::total_cmp);
    Some(middle_third(&heights_mm, |height_mm| *height_mm))
}

/// The border of a round part is no corner: few samples make up so many nodes or fewer.
const NARROW: usize = 6;
/// Rounds of fits. A ring that is not quite round, or about another place, differs from sector to sector: it does not count
/// from the second one on.
const ROUNDS: usize = 3;
/// Standard deviations beyond which a difference does not count.
const CALM: f64 = 3.0;
/// A defect in one of so many sectors moves nothing.
const FEW: usize = 4;

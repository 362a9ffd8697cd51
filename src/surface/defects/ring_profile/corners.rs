//! The profile where only some sectors have samples: in the corners of a part that is not round.
//!
//! There the sectors that go on say what is alike in them. But each sector lost a quartic of its own, so their mean f does
//! not go on where the profile p of all ends. As far as both are known f − p is the difference of two quartics, which is
//! one as well, whatever the rings. So the profile goes on as f less that quartic, and what it leaves of the part has no bend
//! where sectors end.

use super::middle_third;
use super::sectors::{Mean, Polynomial};
use crate::defects::tail;

/// Lets a profile that is known up to the node `last` go on to the end of some sectors, and by its own quartic where too few
/// are known, as in the tip of a corner.
pub(super) fn go_on(heights_mm: &mut [f64], last: usize, sectors: &[Vec<Mean>]) {
    if last + NARROW >= heights_mm.len() {
        return;
    }
    let mut those: Vec<usize> = Vec::new();
    let mut apart = Quartic::default();
    let way = |node: usize| node as f64 / sectors[0].len() as f64;
    for node in last + 1..heights_mm.len() {
        let known: Vec<usize> =
            (0..sectors.len()).filter(|&sector| sectors[sector][node].weight > 0.0).collect();
        if known != those {
            let others_mm = |node| middle_mean(&known, sectors, node);
            apart = Quartic::between(&heights_mm[..node], &known, sectors, others_mm);
            those = known;
        }
        let mean_mm = middle_mean(&those, sectors, node);
        heights_mm[node] = match mean_mm.zip(apart.at(way(node))) {
            Some((height_mm, apart_mm)) => height_mm - apart_mm,
            None => return go_on_alone(heights_mm, node, sectors),
        };
    }
}

/// Lets a profile go on from a node by its own quartic.
fn go_on_alone(heights_mm: &mut [f64], first: usize, sectors: &[Vec<Mean>]) {
    let all: Vec<usize> = (0..sectors.len()).collect();
    let own = Quartic::between(&vec![0.0; first], &all, sectors, |node| Some(heights_mm[node]));
    for node in first..heights_mm.len() {
        let [before, at] = [node - 1, node].map(|node| node as f64 / sectors[0].len() as f64);
        let more_mm = own.at(at).zip(own.at(before)).map_or(0.0, |(at, before)| at - before);
        heights_mm[node] = heights_mm[node - 1] + more_mm;
    }
}

/// An even quartic.
#[derive(Default)]
struct Quartic {
    terms: Option<[f64; 3]>,
}

impl Quartic {
    /// How far other heights lie from a profile.
    fn between(
        profile_mm: &[f64],
        those: &[usize],
        sectors: &[Vec<Mean>],
        others_mm: impl Fn(usize) -> Option<f64>,
    ) -> Quartic {
        let scale = sectors.first().map_or(1.0, |sector| sector.len() as f64);
        let both = profile_mm.iter().enumerate().filter_map(|(node, profile_mm)| {
            let height_mm = others_mm(node)?;
            let weight = those.iter().map(|&sector| sectors[sector][node].weight).sum::<f64>();
            Some((node as f64 / scale, weight, height_mm - profile_mm))
        });
        let both: Vec<(f64, f64, f64)> = both.collect();
        let mut most_mm = f64::INFINITY;
        let mut found = Quartic::default();
        for _ in 0..ROUNDS {
            let mut fit = Polynomial::<3>::new();
            for &(way, weight, apart_mm) in &both {
                let off_mm = (apart_mm - found.at(way).unwrap_or(apart_mm)).abs();
                if off_mm * weight.sqrt() <= most_mm {
                    fit.add(way * way, weight, apart_mm);
                }
            }
            found = Quartic { terms: fit.solved().map(Into::into) };
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

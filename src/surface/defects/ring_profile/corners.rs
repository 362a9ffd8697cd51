//! The profile where only some sectors have samples: in the corners of a part that is not round.
//!
//! There the sectors that go on say what is alike in them. But each sector lost a quartic of its own, so their mean f does
//! not go on where the profile p of all ends. As far as both are known f − p is the difference of two quartics, which is
//! one as well, whatever the rings. So the profile goes on as f less that quartic, and what it leaves of the part has no bend
//! where sectors end.

use super::middle_third;
use super::quartic::Quartic;
use super::sectors::Mean;

/// Lets a profile that is known up to the node `last` go on to the end of some sectors, and by its own quartic where too few
/// are known, as in the tip of a corner.
pub(super) fn go_on(heights_mm: &mut [f64], last: usize, sectors: &[Vec<Mean>]) {
    if last + NARROW >= heights_mm.len() {
        return;
    }
    let mut those: Vec<usize> = Vec::new();
    let mut apart = Quartic::default();
    for node in last + 1..heights_mm.len() {
        let known: Vec<usize> =
            (0..sectors.len()).filter(|&sector| sectors[sector][node].weight > 0.0).collect();
        if known != those {
            apart = Quartic::through(
                heights_mm.len(),
                (0..node).filter_map(|node| {
                    let apart_mm = middle_mean(&known, sectors, node)? - heights_mm[node];
                    Some((node, weight(&known, sectors, node), apart_mm))
                }),
            );
            those = known;
        }
        let mean_mm = middle_mean(&those, sectors, node);
        heights_mm[node] = match mean_mm.zip(apart.at(node)) {
            Some((height_mm, apart_mm)) => height_mm - apart_mm,
            None => return go_on_alone(heights_mm, node, sectors),
        };
    }
}

/// Lets a profile go on from a node by its own quartic.
fn go_on_alone(heights_mm: &mut [f64], first: usize, sectors: &[Vec<Mean>]) {
    let own = Quartic::of(&heights_mm[..first], heights_mm.len(), sectors);
    for node in first..heights_mm.len() {
        let more_mm = own.at(node).zip(own.at(node - 1)).map_or(0.0, |(at, before)| at - before);
        heights_mm[node] = heights_mm[node - 1] + more_mm;
    }
}

/// Samples of some sectors at a node.
fn weight(those: &[usize], sectors: &[Vec<Mean>], node: usize) -> f64 {
    those.iter().map(|&sector| sectors[sector][node].weight).sum()
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
/// A defect in one of so many sectors moves nothing.
const FEW: usize = 4;

//! Even quartics along the radius, which every window of the reference follows.

use super::sectors::{Mean, Polynomial};
use crate::defects::tail;

/// An even quartic by nodes outwards.
#[derive(Default)]
pub(super) struct Quartic {
    terms: Option<[f64; 3]>,
    /// Nodes along a unit of the radius.
    scale: f64,
}

impl Quartic {
    /// The quartic of a profile known at its first nodes, without its rings. `nodes` are all.
    pub(super) fn of(known_mm: &[f64], nodes: usize, sectors: &[Vec<Mean>]) -> Quartic {
        let weight = |node: usize| sectors.iter().map(|sector| sector[node].weight).sum();
        let known = known_mm.iter().enumerate();
        Quartic::through(nodes, known.map(|(node, &height_mm)| (node, weight(node), height_mm)))
    }

    /// The quartic through heights with their nodes and weights. What is far off, as a ring is, does not count from the second
    /// round on.
    pub(super) fn through(
        nodes: usize,
        heights: impl Iterator<Item = (usize, f64, f64)>,
    ) -> Quartic {
        let heights: Vec<(usize, f64, f64)> = heights.collect();
        let mut most = f64::INFINITY;
        let mut found = Quartic { terms: None, scale: nodes as f64 };
        for _ in 0..ROUNDS {
            let mut fit = Polynomial::<3>::new();
            for &(node, weight, height_mm) in &heights {
                let off_mm = (height_mm - found.at(node).unwrap_or(height_mm)).abs();
                if off_mm * weight.sqrt() <= most {
                    fit.add(found.square(node), weight, height_mm);
                }
            }
            found.terms = fit.solved().map(Into::into);
            let off = |&(node, weight, height_mm): &(usize, f64, f64)| {
                Some((height_mm - found.at(node)?).abs() * weight.sqrt())
            };
            let mut sizes: Vec<f64> = heights.iter().filter_map(off).collect();
            most = CALM * tail::scale(&mut sizes).unwrap_or(f64::INFINITY);
        }
        found
    }

    /// Height at a node; `None` where none was found.
    pub(super) fn at(&self, node: usize) -> Option<f64> {
        let square = self.square(node);
        self.terms.map(|[level, curved, steep]| level + square * (curved + square * steep))
    }

    fn square(&self, node: usize) -> f64 {
        (node as f64 / self.scale).powi(2)
    }
}

/// Rounds of fits.
const ROUNDS: usize = 3;
/// Standard deviations beyond which a height does not count.
const CALM: f64 = 3.0;

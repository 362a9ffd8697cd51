//! How far points see, and who sees a place.

use asphera_geometry::BoxMm;

use super::{BLIND, Content, MARGIN, NONE, Node, PlaceTree, ROOT};
use crate::geometry::gap;

/// How far a point sees, for a purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sight {
    /// A new place within it may change the plane.
    Plane = 0,
    /// A new place within it may change the star.
    Star = 1,
    /// A changed facet within it may change the filling of a hole.
    Hole = 2,
}

pub(super) const SIGHTS: usize = 3;

impl PlaceTree {
    /// How far a point sees for any of some purposes, as the square rounded up, mm²: below 0 not at all.
    #[inline]
    pub(crate) fn sight_mm2(&self, at: u32, which: &[Sight]) -> f64 {
        farthest(&self.sights[at as usize], which)
    }

    /// Sets how far points see, as squares, mm².
    pub(crate) fn set_sights(
        &mut self,
        which: Sight,
        squares_mm2: impl Iterator<Item = (u32, f64)>,
    ) {
        let which = which as usize;
        let mut before = NONE;
        for (at, square) in squares_mm2 {
            let (own, square) = (&mut self.sights[at as usize][which], rounded_up(square));
            if *own == square {
                continue;
            }
            *own = square;
            let leaf = self.leaf_of[at as usize];
            if before != leaf && before != NONE {
                self.refresh(before, which);
            }
            before = leaf;
        }
        if before != NONE {
            self.refresh(before, which);
        }
    }

    /// Sets the sight of a leaf by its points, and of what it lies in.
    fn refresh(&mut self, leaf: u32, which: usize) {
        let Content::Leaf { block, len } = self.nodes[leaf as usize].content else { return };
        let held = &self.blocks[block as usize][..len as usize];
        let mut most = held.iter().map(|&at| self.sights[at as usize][which]).fold(BLIND, f32::max);
        let mut node = leaf;
        while self.nodes[node as usize].sights[which] != most {
            self.nodes[node as usize].sights[which] = most;
            node = self.nodes[node as usize].parent;
            let Some(Node { content: Content::Split { low, high, .. }, .. }) =
                self.nodes.get(node as usize)
            else {
                return;
            };
            let of = |half: u32| self.nodes[half as usize].sights[which];
            most = of(*low).max(of(*high));
        }
    }

    /// Whether no point sees anything.
    pub(crate) fn is_blind(&self, which: &[Sight]) -> bool {
        self.nodes.first().is_none_or(|root| farthest(&root.sights, which) < 0.0)
    }

    /// Calls with every point of leaves that may see a place of a box.
    pub(crate) fn seeing(&self, which: &[Sight], box_mm: &BoxMm, found: &mut impl FnMut(u32)) {
        if !self.nodes.is_empty() {
            self.seeing_below(ROOT, which, box_mm, found);
        }
    }

    fn seeing_below(&self, node: u32, which: &[Sight], own: &BoxMm, found: &mut impl FnMut(u32)) {
        let Node { bounds, sights, content, .. } = &self.nodes[node as usize];
        // Both sides are rounded: a margin lets none be missed.
        if gap(own, bounds) * (1.0 - MARGIN) > farthest(sights, which) {
            return;
        }
        match *content {
            Content::Leaf { block, len } => {
                self.blocks[block as usize][..len as usize].iter().for_each(|&at| found(at));
            }
            Content::Split { low, high, .. } => {
                self.seeing_below(low, which, own, found);
                self.seeing_below(high, which, own, found);
            }
        }
    }
}

fn farthest(sights: &[f32; SIGHTS], which: &[Sight]) -> f64 {
    let larger = |a: f32, b: f32| if a > b { a } else { b };
    f64::from(which.iter().map(|&which| sights[which as usize]).fold(BLIND, larger))
}

fn rounded_up(value: f64) -> f32 {
    let rounded = value as f32;
    if f64::from(rounded) < value { rounded.next_up() } else { rounded }
}

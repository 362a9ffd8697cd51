//! Where the points of a first batch part, found by all threads.
//!
//! The tree is filled leaf by leaf, on one thread. Most of that is to part the points of large nodes, which depends on
//! nothing but these points: so it is done before.

use asphera_geometry::BoxMm;

use super::{Cell, Content, PlaceTree, middle, partition};
use crate::surface::Numbered;

/// How the points of a large node part.
pub(super) struct Plan {
    /// The box of the points; empty where the node is split already.
    pub(super) bounds: BoxMm,
    pub(super) axis: usize,
    pub(super) at_mm: f64,
    /// So many lie below.
    pub(super) below: usize,
    halves: [Option<Box<Plan>>; 2],
}

impl Plan {
    /// The plans of both halves, where they are large.
    pub(super) fn halves(&self) -> [Option<&Plan>; 2] {
        self.halves.each_ref().map(Option::as_deref)
    }
}

impl PlaceTree {
    /// Parts the points of a node of an empty tree, or of one that it will have; `None` where they are few or in one place.
    pub(super) fn plan(
        &self,
        node: Option<u32>,
        cell: Cell,
        batch: &mut [Numbered],
    ) -> Option<Box<Plan>> {
        if batch.len() < LARGE {
            return None;
        }
        let content = node.map(|node| self.nodes[node as usize].content);
        let (bounds, (axis, at_mm), nodes) = match content {
            Some(Content::Split { low, high, axis, at_mm }) => {
                (BoxMm::EMPTY, (usize::from(axis), at_mm), [Some(low), Some(high)])
            }
            Some(Content::Leaf { .. }) | None => {
                let bounds = BoxMm::about(batch.iter().map(|&(place, _)| place));
                if bounds.low == bounds.high {
                    return None;
                }
                (bounds, middle(&bounds, &cell)?, [None; 2])
            }
        };
        let below = partition(batch, axis, at_mm);
        let (low_batch, high_batch) = batch.split_at_mut(below);
        let [low_cell, high_cell] = halved(&cell, axis, at_mm);
        let (low, high) = rayon::join(
            || self.plan(nodes[0], low_cell, low_batch),
            || self.plan(nodes[1], high_cell, high_batch),
        );
        Some(Box::new(Plan { bounds, axis, at_mm, below, halves: [low, high] }))
    }
}

/// The halves of a cell.
pub(super) fn halved(cell: &Cell, axis: usize, at_mm: f64) -> [Cell; 2] {
    let (mut low, mut high) = (*cell, *cell);
    low.high[axis] = at_mm;
    high.low[axis] = at_mm;
    [low, high]
}

/// Fewer points are parted while the tree is filled.
const LARGE: usize = 1 << 12;

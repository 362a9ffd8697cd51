//! The k-d tree over the places of a cloud (J. L. Bentley, Communications of the ACM 18 (1975) 509-517,
//! doi:10.1145/361002.361007).
//!
//! A node is a range of places. It is cut at the median of its widest side; ties fall by coordinates, and copies of a
//! place stay together. So one set of points makes one tree, whatever their order. The order of the leaves is the order
//! of the places: neighbours lie near each other in memory.
//!
//! The surface crate's `WeightedTree` answers other questions: it holds weights, knows three dimensions only, keeps
//! copies apart and answers one place at a time.

use asphera_geometry::{BoundsMm, greater};
use std::cmp::Ordering;

/// A point on its way into the tree: coordinates in mm, and its row in the input.
pub(crate) type Entry<const D: usize> = ([f64; D], u32);

/// A node of the tree. Its left child follows it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node<const D: usize> {
    /// The least coordinates of its places in mm.
    pub(crate) low: [f64; D],
    /// The largest.
    pub(crate) high: [f64; D],
    /// Its first place.
    pub(crate) first: u32,
    /// The place behind its last one.
    pub(crate) end: u32,
    /// Steps from the node to its right child; 0 for a leaf.
    pub(crate) right: u32,
}

/// A leaf holds so many places at most.
pub(crate) const LEAF: usize = 12;

/// Ranges above this length are split on two threads.
const SHARED: usize = 1 << 15;

impl<const D: usize> Node<D> {
    /// Places of the node.
    pub(crate) fn len(&self) -> usize {
        (self.end - self.first) as usize
    }

    /// Square of the distance from a place to the box in mm², never above that to a place in it.
    pub(crate) fn squared_distance(&self, place: &[f64; D]) -> f64 {
        let mut sum = 0.0;
        for (axis, at) in place.iter().enumerate() {
            let gap = greater(greater(self.low[axis] - at, at - self.high[axis]), 0.0);
            sum += gap * gap;
        }
        sum
    }

    /// Square of the distance between two boxes in mm².
    pub(crate) fn squared_gap(&self, other: &Node<D>) -> f64 {
        let mut sum = 0.0;
        for axis in 0..D {
            let [below, above] =
                [other.low[axis] - self.high[axis], self.low[axis] - other.high[axis]];
            let gap = greater(greater(above, below), 0.0);
            sum += gap * gap;
        }
        sum
    }
}

/// Square of the distance of two places in mm².
pub(crate) fn squared_distance<const D: usize>(p: &[f64; D], q: &[f64; D]) -> f64 {
    let mut sum = 0.0;
    for axis in 0..D {
        let step = p[axis] - q[axis];
        sum += step * step;
    }
    sum
}

/// Order of places by their coordinates, the first axis first.
pub(crate) fn by_coordinates<const D: usize>(p: &[f64; D], q: &[f64; D]) -> Ordering {
    let unequal = (0..D).map(|axis| p[axis].total_cmp(&q[axis])).find(|order| order.is_ne());
    unequal.unwrap_or(Ordering::Equal)
}

/// Sorts the entries into the order of the leaves and gives the nodes, each before those below it. n·log n time.
pub(crate) fn build<const D: usize>(entries: &mut [Entry<D>]) -> Vec<Node<D>> {
    if entries.is_empty() { Vec::new() } else { split(entries, 0) }
}

fn split<const D: usize>(entries: &mut [Entry<D>], first: u32) -> Vec<Node<D>> {
    let mut nodes = Vec::new();
    if entries.len() <= SHARED {
        nodes.reserve(2 * entries.len() / LEAF + 2);
        descend(entries, first, &mut nodes);
        return nodes;
    }
    let mut own = bounded(entries, first);
    let Some(cut) = cut(entries, &own) else {
        nodes.push(own);
        return nodes;
    };
    let (left, right) = entries.split_at_mut(cut);
    let (left, right) = rayon::join(|| split(left, first), || split(right, first + cut as u32));
    own.right = left.len() as u32 + 1;
    nodes.reserve_exact(left.len() + right.len() + 1);
    nodes.push(own);
    nodes.extend(left);
    nodes.extend(right);
    nodes
}

fn descend<const D: usize>(entries: &mut [Entry<D>], first: u32, nodes: &mut Vec<Node<D>>) {
    let own = bounded(entries, first);
    let at = nodes.len();
    nodes.push(own);
    let cut = if entries.len() > LEAF { cut(entries, &own) } else { None };
    let Some(cut) = cut else {
        entries.sort_unstable_by(|a, b| by_coordinates(&a.0, &b.0).then(a.1.cmp(&b.1)));
        return;
    };
    let (left, right) = entries.split_at_mut(cut);
    descend(left, first, nodes);
    nodes[at].right = (nodes.len() - at) as u32;
    descend(right, first + cut as u32, nodes);
}

fn bounded<const D: usize>(entries: &[Entry<D>], first: u32) -> Node<D> {
    let BoundsMm { low, high } = BoundsMm::about(entries.iter().map(|&(place, _)| place));
    Node { low, high, first, end: first + entries.len() as u32, right: 0 }
}

/// Parts the entries at their median and gives how many come first; `None` where all lie in one place.
fn cut<const D: usize>(entries: &mut [Entry<D>], own: &Node<D>) -> Option<usize> {
    let side = |axis: usize| own.high[axis] - own.low[axis];
    let axis = (1..D).fold(0, |widest, axis| if side(axis) > side(widest) { axis } else { widest });
    if side(axis) <= 0.0 {
        return None;
    }
    let half = entries.len() / 2;
    entries.select_nth_unstable_by(half, |a, b| {
        a.0[axis].total_cmp(&b.0[axis]).then_with(|| by_coordinates(&a.0, &b.0))
    });
    let middle = entries[half].0;
    // Copies of the middle one go to its side; where they are all of the left half, to the left.
    let kept = keep_first(&mut entries[..half], |place| *place != middle);
    if kept > 0 {
        return Some(kept);
    }
    Some(half + keep_first(&mut entries[half..], |place| *place == middle))
}

/// Brings the entries for which `wanted` is true to the front and gives how many there are.
fn keep_first<const D: usize>(
    entries: &mut [Entry<D>],
    wanted: impl Fn(&[f64; D]) -> bool,
) -> usize {
    let mut kept = 0;
    for at in 0..entries.len() {
        if wanted(&entries[at].0) {
            entries.swap(kept, at);
            kept += 1;
        }
    }
    kept
}

//! The samples in the cells of a quadtree: what is near a place without a mesh.

use asphera_geometry::{BoundsMm, along_morton, greater};

use crate::counting::{self, Entry, key, number, sort_by_key};
use crate::samples::{PlaceMm, SampleId, Samples};

/// Number of a sample along the curve through the cells: its index in [`Cells::places`].
pub(crate) type Position = u32;

/// The samples along Morton's curve, and a tree of boxes about runs of them.
///
/// A run is cut where the curve leaves a cell of the quadtree. Cells are as small as their samples ask for, however wide the box about
/// all is. Which samples share one depends on the places alone.
pub(crate) struct Cells {
    places: Vec<PlaceMm>,
    samples: Vec<SampleId>,
    nodes: Vec<Node>,
}

/// A run of samples: those of a cell. The first of its two halves follows it, and then the other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// The box about its places.
    bounds: BoundsMm,
    /// Its first sample.
    first: Position,
    /// The sample behind its last one.
    end: Position,
    /// The node behind it and all below it.
    next: u32,
}

/// Up to so many samples are one run: they are compared with each other faster than a walk tells them apart.
pub(crate) const LEAF: usize = 12;

impl Cells {
    /// The cells of samples; n·log n time.
    pub(crate) fn new(samples: &Samples) -> Cells {
        let (in_order, nodes) = cut(samples);
        let places = in_order.iter().map(|&sample| samples.places()[sample as usize]).collect();
        Cells { places, samples: in_order, nodes }
    }

    /// The places along the curve, mm.
    pub(crate) fn places(&self) -> &[PlaceMm] {
        &self.places
    }

    /// The sample at each position.
    pub(crate) fn samples(&self) -> &[SampleId] {
        &self.samples
    }

    /// The smallest runs, in order: every sample is in one.
    pub(crate) fn leaves(&self) -> Vec<Node> {
        self.nodes.iter().copied().filter(Node::is_leaf).collect()
    }

    /// Gives the smallest runs no farther from a box than the root of `squared_mm2`, in order, until `visit` gives false.
    pub(crate) fn visit_near(
        &self,
        about: &BoundsMm,
        squared_mm2: f64,
        mut visit: impl FnMut(&Node) -> bool,
    ) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if squared_gap(&node.bounds, about) > squared_mm2 {
                at = node.next as usize;
                continue;
            }
            if node.is_leaf() && !visit(node) {
                return;
            }
            at += 1;
        }
    }

    /// Gives runs to `visit`, near ones of a place first. It gives the square of the distance in mm² beyond which no more are wanted;
    /// boxes that `is_wanted` refuses are left out.
    pub(crate) fn search(
        &self,
        at: PlaceMm,
        is_wanted: impl Fn(&BoundsMm) -> bool,
        mut visit: impl FnMut(&Node) -> f64,
    ) {
        let here = BoundsMm::about([at]);
        let gap = |node: u32| squared_gap(&self.nodes[node as usize].bounds, &here);
        let mut limit_mm2 = f64::INFINITY;
        let mut open = Vec::new();
        if !self.nodes.is_empty() {
            open.push((gap(0), 0));
        }
        while let Some((squared_mm2, index)) = open.pop() {
            let node = &self.nodes[index as usize];
            if squared_mm2 > limit_mm2 || !is_wanted(&node.bounds) {
                continue;
            }
            if node.is_leaf() {
                limit_mm2 = visit(node);
                continue;
            }
            let mut halves = [index + 1, self.nodes[index as usize + 1].next];
            let [first, second] = halves.map(gap);
            if first < second {
                halves.swap(0, 1);
            }
            open.extend(halves.map(|half| (gap(half), half)));
        }
    }
}

impl Node {
    /// The box about its places.
    pub(crate) fn bounds(&self) -> &BoundsMm {
        &self.bounds
    }

    /// Its samples.
    pub(crate) fn positions(&self) -> std::ops::Range<usize> {
        self.first as usize..self.end as usize
    }

    fn is_leaf(&self) -> bool {
        (self.end - self.first) as usize <= LEAF
    }
}

/// Square of the distance of two boxes in mm².
#[inline]
fn squared_gap(a: &BoundsMm, b: &BoundsMm) -> f64 {
    let mut sum = 0.0;
    for axis in 0..2 {
        let gap = greater(a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]);
        let gap = greater(gap, 0.0);
        sum += gap * gap;
    }
    sum
}

/// The samples along the curve through the cells; n·log n time.
pub(crate) fn in_cells(samples: &Samples) -> Vec<SampleId> {
    let mut entries: Vec<Entry> = (0..samples.len() as Entry).collect();
    if !entries.is_empty() {
        give_keys(&mut entries, samples.places());
        sort_by_key(&mut entries);
        refine(&mut entries, samples.places());
    }
    entries.into_iter().map(number).collect()
}

/// Orders sorted entries that share a cell, where they are more than a run may have.
fn refine(entries: &mut [Entry], places: &[PlaceMm]) {
    let cells = entries.chunk_by_mut(|&a, &b| key(a) == key(b));
    for cell in cells.filter(|cell| cell.len() > LEAF) {
        divide(cell, places);
        refine(cell, places);
    }
}

/// Gives the entries of a cell keys by a square of their own, and sorts them.
///
/// Each sample is a place of its own, so they do not share a cell of that square.
fn divide(entries: &mut [Entry], places: &[PlaceMm]) {
    give_keys(entries, places);
    entries.sort_unstable();
}

/// The samples along the curve, and the tree over them.
fn cut(samples: &Samples) -> (Vec<SampleId>, Vec<Node>) {
    let mut entries: Vec<Entry> = (0..samples.len() as Entry).collect();
    let mut nodes = Vec::with_capacity(entries.len() / 2);
    if !entries.is_empty() {
        give_keys(&mut entries, samples.places());
        sort_by_key(&mut entries);
        split(&mut entries, 0, samples.places(), &mut nodes);
    }
    (entries.into_iter().map(number).collect(), nodes)
}

/// Gives every entry the key of its cell in the square that holds them all.
fn give_keys(entries: &mut [Entry], places: &[PlaceMm]) {
    let place = |entry: Entry| places[number(entry) as usize];
    let bounds = BoundsMm::about(entries.iter().map(|&entry| place(entry)));
    let [width_mm, height_mm] = bounds.size_mm();
    let per_mm = f64::from(u16::MAX) / width_mm.max(height_mm);
    for entry in entries {
        let at = place(*entry);
        // A number too large becomes the largest, and of one place alone no number becomes nought.
        let cell = [0, 1].map(|axis| ((at[axis] - bounds.low[axis]) * per_mm) as u16);
        *entry = counting::entry(along_morton(cell), number(*entry));
    }
}

/// Makes the nodes of sorted entries, the first of which has a position.
fn split(entries: &mut [Entry], first: usize, places: &[PlaceMm], nodes: &mut Vec<Node>) {
    let node = nodes.len();
    let [from, to] = [first, first + entries.len()].map(|position| position as Position);
    nodes.push(Node { bounds: BoundsMm::EMPTY, first: from, end: to, next: 0 });
    let mut bounds = BoundsMm::EMPTY;
    if entries.len() <= LEAF {
        bounds = BoundsMm::about(entries.iter().map(|&it| places[number(it) as usize]));
    } else {
        if key(entries[0]) == key(entries[entries.len() - 1]) {
            // One cell of the square above.
            divide(entries, places);
        }
        let bit = 1 << (key(entries[0]) ^ key(entries[entries.len() - 1])).ilog2();
        let cut = entries.partition_point(|&entry| key(entry) & bit == 0);
        let (low, high) = entries.split_at_mut(cut);
        for (half, first) in [(low, first), (high, first + cut)] {
            let at = nodes.len();
            split(half, first, places, nodes);
            bounds.join(&nodes[at].bounds);
        }
    }
    nodes[node].bounds = bounds;
    nodes[node].next = nodes.len() as u32;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_without_a_tree_is_that_of_its_leaves() {
        for count in [0, 1, 5, 13, 400, 3_000_u32] {
            // Every second one lies in a spot that is one cell of the whole.
            let places: Vec<PlaceMm> = (0..count)
                .map(|at| [at.wrapping_mul(0x9E37_79B9), at.wrapping_mul(0x85EB_CA6B)])
                .zip(0..)
                .map(|(at, index)| at.map(|it| f64::from(it) * [1.0, 1e-9][index % 2]))
                .collect();
            let samples = Samples::new(&places).expect("finite places");
            assert_eq!(in_cells(&samples), cut(&samples).0);
        }
    }
}

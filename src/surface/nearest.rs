//! A tree of points with weights: the least of weight + distance over all points.
//!
//! With weights of zero this is the nearest point. With the radius of a ball as negative weight it
//! is the ball whose border is nearest, and with bounds of a function that changes by no more than
//! the way gone it is the bound they give at a place. A k-d tree (J. L. Bentley, Communications of
//! the ACM 18 (1975) 509-517, doi:10.1145/361002.361007) whose inner nodes know the least weight
//! below them. It is cut at the median by count, so any number of equal points is no trouble.

use crate::PointMm;

/// The tree. n·log n time to build, log n on average to ask, 40 bytes a point.
#[derive(Clone, Debug, Default)]
pub(super) struct WeightedTree {
    /// Points and weights; a node is a range, its left child the first half.
    entries: Vec<Entry>,
    /// The box and the least weight of each node with more than [`LEAF`] entries, in heap order.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    at_mm: PointMm,
    weight_mm: f64,
    index: u32,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low_mm: PointMm,
    high_mm: PointMm,
    weight_mm: f64,
}

/// Up to how many entries are looked at one by one.
const LEAF: usize = 8;

impl WeightedTree {
    /// The tree of points with weights below infinity.
    pub(super) fn new(points: impl Iterator<Item = (PointMm, f64)>) -> WeightedTree {
        let mut entries: Vec<Entry> = points
            .zip(0..)
            .map(|((at_mm, weight_mm), index)| Entry { at_mm, weight_mm, index })
            .collect();
        let mut nodes = Vec::new();
        split(&mut entries, 0, &mut nodes);
        WeightedTree { entries, nodes }
    }

    /// The least of weight + distance in mm; `None` without points.
    pub(super) fn least(&self, place: PointMm) -> Option<f64> {
        let mut best = f64::INFINITY;
        self.search(0, &self.entries, place, &mut best);
        (best < f64::INFINITY).then_some(best)
    }

    /// The numbers, as they came, of the points with the `count` least sums, least first; of equal
    /// sums any.
    pub(super) fn least_few(&self, place: PointMm, count: usize) -> Vec<u32> {
        let mut found: Vec<(f64, u32)> = Vec::with_capacity(count + 1);
        self.gather(0, &self.entries, place, count, &mut found);
        found.into_iter().map(|(_, index)| index).collect()
    }

    fn search(&self, node: usize, entries: &[Entry], place: PointMm, best: &mut f64) {
        if entries.len() <= LEAF {
            for entry in entries {
                *best = best.min(entry.weight_mm + super::vector::distance(entry.at_mm, place));
            }
            return;
        }
        let (left, right) = entries.split_at(entries.len() / 2);
        let mut halves = [(2 * node + 1, left), (2 * node + 2, right)]
            .map(|(child, half)| (self.floor(child, half, place), child, half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (floor, child, half) in halves {
            if floor < *best {
                self.search(child, half, place, best);
            }
        }
    }

    fn gather(
        &self,
        node: usize,
        entries: &[Entry],
        place: PointMm,
        count: usize,
        found: &mut Vec<(f64, u32)>,
    ) {
        let beats = |sum: f64, found: &Vec<(f64, u32)>| {
            found.len() < count || found.last().is_some_and(|last| sum < last.0)
        };
        if entries.len() <= LEAF {
            for entry in entries {
                let sum = entry.weight_mm + super::vector::distance(entry.at_mm, place);
                if beats(sum, found) {
                    let rank = found.partition_point(|other| other.0 <= sum);
                    found.insert(rank, (sum, entry.index));
                    found.truncate(count);
                }
            }
            return;
        }
        let (left, right) = entries.split_at(entries.len() / 2);
        let mut halves = [(2 * node + 1, left), (2 * node + 2, right)]
            .map(|(child, half)| (self.floor(child, half, place), child, half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (floor, child, half) in halves {
            if beats(floor, found) {
                self.gather(child, half, place, count, found);
            }
        }
    }

    /// What no sum of a node is below.
    fn floor(&self, node: usize, entries: &[Entry], place: PointMm) -> f64 {
        if entries.len() <= LEAF {
            return f64::NEG_INFINITY;
        }
        let Node { low_mm, high_mm, weight_mm } = self.nodes[node];
        let mut squared = 0.0;
        for axis in 0..3 {
            let beside = (low_mm[axis] - place[axis]).max(place[axis] - high_mm[axis]).max(0.0);
            squared += beside * beside;
        }
        weight_mm + squared.sqrt()
    }
}

/// Sorts the entries of a node into its halves, and so on down.
fn split(entries: &mut [Entry], node: usize, nodes: &mut Vec<Node>) {
    if entries.len() <= LEAF {
        return;
    }
    let mut own = Node {
        low_mm: [f64::INFINITY; 3],
        high_mm: [f64::NEG_INFINITY; 3],
        weight_mm: f64::INFINITY,
    };
    for entry in entries.iter() {
        for axis in 0..3 {
            own.low_mm[axis] = own.low_mm[axis].min(entry.at_mm[axis]);
            own.high_mm[axis] = own.high_mm[axis].max(entry.at_mm[axis]);
        }
        own.weight_mm = own.weight_mm.min(entry.weight_mm);
    }
    let extent = |axis: usize| own.high_mm[axis] - own.low_mm[axis];
    let axis =
        (1..3).fold(0, |widest, axis| if extent(axis) > extent(widest) { axis } else { widest });
    if nodes.len() <= node {
        nodes.resize(node + 1, own);
    }
    nodes[node] = own;
    let half = entries.len() / 2;
    entries.select_nth_unstable_by(half, |a, b| a.at_mm[axis].total_cmp(&b.at_mm[axis]));
    let (left, right) = entries.split_at_mut(half);
    split(left, 2 * node + 1, nodes);
    split(right, 2 * node + 2, nodes);
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::WeightedTree;
    use crate::lfs::vector::distance;

    proptest! {
        #[test]
        fn the_least_sum_is_that_of_all(
            entries in prop::collection::vec(
                ([-4_i8..4, -4_i8..4, -4_i8..4], 0_i8..8), 0..200,
            ),
            place in [-6_i8..6, -6_i8..6, -6_i8..6],
        ) {
            // Few places for many points: most are there several times.
            let entries: Vec<_> =
                entries.into_iter().map(|(at, weight)| (at.map(f64::from), f64::from(weight))).collect();
            let place = place.map(f64::from);
            let mut sums: Vec<f64> =
                entries.iter().map(|&(at, weight)| weight + distance(at, place)).collect();
            sums.sort_by(f64::total_cmp);
            let tree = WeightedTree::new(entries.iter().copied());
            prop_assert_eq!(tree.least(place), sums.first().copied());
            let unweighted = WeightedTree::new(entries.iter().map(|&(at, _)| (at, 0.0)));
            let few: Vec<f64> =
                unweighted.least_few(place, 5).into_iter().map(|index| distance(entries[index as usize].0, place)).collect();
            let mut ways: Vec<f64> = entries.iter().map(|&(at, _)| distance(at, place)).collect();
            ways.sort_by(f64::total_cmp);
            ways.truncate(5);
            prop_assert_eq!(few, ways);
        }
    }
}

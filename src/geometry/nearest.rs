//! The nearest of a set of points in space, and with weights the least of weight + distance over all of them.
//!
//! With the radius of a ball as negative weight the latter is the ball whose border is nearest, and with bounds of a
//! function that changes by no more than the way gone it is the bound they give at a place. A k-d tree (J. L.
//! Bentley, Communications of the ACM 18 (1975) 509-517, doi:10.1145/361002.361007) whose inner nodes know their box
//! and the least weight below them.
//!
//! It is cut at the median by count and then by number, so any number of points in one place or on one line is no
//! trouble, and one set of points makes one tree. A library's tree would have to hold weights, and rasters, on which
//! whole lines of points share a coordinate: kiddo 5.3.2 fails at the 33rd of them
//! (<https://github.com/sdd-org/kiddo/issues/475>), and of points in one place still does.

use crate::{BoxMm, PointMm};

/// The tree. n·log n time to build, log n on average to ask, 40 bytes a point.
#[derive(Clone, Debug, Default)]
pub struct WeightedTree {
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
    bounds: BoxMm,
    weight_mm: f64,
}

/// Up to how many entries are looked at one by one.
const LEAF: usize = 8;

impl WeightedTree {
    /// The tree of points without weights, fewer than 2³².
    pub fn of_points(points: &[PointMm]) -> WeightedTree {
        WeightedTree::new(points.iter().map(|&point| (point, 0.0)))
    }

    /// The tree of points with weights below infinity.
    pub fn new(points: impl Iterator<Item = (PointMm, f64)>) -> WeightedTree {
        let mut entries: Vec<Entry> = points
            .zip(0..)
            .map(|((at_mm, weight_mm), index)| Entry { at_mm, weight_mm, index })
            .collect();
        let mut nodes = Vec::new();
        split(&mut entries, 0, &mut nodes);
        WeightedTree { entries, nodes }
    }

    /// The least of weight + distance in mm; `None` without points.
    pub fn least(&self, place: PointMm) -> Option<f64> {
        self.least_below(place, f64::INFINITY)
    }

    /// The least of weight + distance in mm if it is below a bound, within rounding; `None` where nothing is.
    ///
    /// Far from all points a small bound ends the search at once.
    pub fn least_below(&self, place: PointMm, bound_mm: f64) -> Option<f64> {
        let mut best = bound_mm;
        self.search(0, &self.entries, place, &mut best);
        (best < bound_mm).then_some(best)
    }

    /// The numbers, as they came, of the points with the `count` least sums, least first; of equal
    /// sums any.
    pub fn least_few(&self, place: PointMm, count: usize) -> Vec<u32> {
        let mut found: Vec<(f64, u32)> = Vec::with_capacity(count + 1);
        self.gather(0, &self.entries, place, count, &mut found);
        found.into_iter().map(|(_, index)| index).collect()
    }

    /// The number of the point with the least sum of those for which `wanted` is true, and that sum in mm; of equal
    /// sums the one of the smallest number.
    pub fn nearest(&self, place: PointMm, wanted: impl Fn(u32) -> bool) -> Option<(u32, f64)> {
        let mut best = (f64::INFINITY, u32::MAX);
        self.seek(0, &self.entries, place, &wanted, &mut best);
        (best.0 < f64::INFINITY).then_some((best.1, best.0))
    }

    fn seek(
        &self,
        node: usize,
        entries: &[Entry],
        place: PointMm,
        wanted: &impl Fn(u32) -> bool,
        best: &mut (f64, u32),
    ) {
        if entries.len() <= LEAF {
            for entry in entries.iter().filter(|entry| wanted(entry.index)) {
                let sum = entry.weight_mm + distance(entry.at_mm, place);
                if sum < best.0 || (sum == best.0 && entry.index < best.1) {
                    *best = (sum, entry.index);
                }
            }
            return;
        }
        for (floor, child, half) in self.halves(node, entries, place) {
            // Rounding may put a floor above a sum by some last bits, which must not decide between equals.
            if floor - ROUNDING * floor.abs() <= best.0 {
                self.seek(child, half, place, wanted, best);
            }
        }
    }

    /// Visits points of boxes that `reaches` lets through, until `take` gives true; whether it did.
    ///
    /// `reaches` is asked with the box of points and the least of their weights in mm; where it gives false none of them is
    /// visited. `take` is told the number of a point. The order of the visits depends on the points alone.
    pub fn visit(
        &self,
        reaches: impl Fn(&BoxMm, f64) -> bool,
        mut take: impl FnMut(u32) -> bool,
    ) -> bool {
        self.pass(0, &self.entries, &reaches, &mut take)
    }

    fn pass(
        &self,
        node: usize,
        entries: &[Entry],
        reaches: &impl Fn(&BoxMm, f64) -> bool,
        take: &mut impl FnMut(u32) -> bool,
    ) -> bool {
        if entries.len() <= LEAF {
            return entries.iter().any(|entry| take(entry.index));
        }
        let Node { bounds, weight_mm } = &self.nodes[node];
        if !reaches(bounds, *weight_mm) {
            return false;
        }
        let (left, right) = entries.split_at(entries.len() / 2);
        self.pass(2 * node + 1, left, reaches, take)
            || self.pass(2 * node + 2, right, reaches, take)
    }

    /// The children of a node with what none of their sums is below, the lower first.
    fn halves<'a>(
        &self,
        node: usize,
        entries: &'a [Entry],
        place: PointMm,
    ) -> [(f64, usize, &'a [Entry]); 2] {
        let (left, right) = entries.split_at(entries.len() / 2);
        let mut halves = [(2 * node + 1, left), (2 * node + 2, right)]
            .map(|(child, half)| (self.floor(child, half, place), child, half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        halves
    }

    fn search(&self, node: usize, entries: &[Entry], place: PointMm, best: &mut f64) {
        if entries.len() <= LEAF {
            for entry in entries {
                *best = best.min(entry.weight_mm + distance(entry.at_mm, place));
            }
            return;
        }
        for (floor, child, half) in self.halves(node, entries, place) {
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
                let sum = entry.weight_mm + distance(entry.at_mm, place);
                if beats(sum, found) {
                    let rank = found.partition_point(|other| other.0 <= sum);
                    found.insert(rank, (sum, entry.index));
                    found.truncate(count);
                }
            }
            return;
        }
        for (floor, child, half) in self.halves(node, entries, place) {
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
        let Node { bounds, weight_mm } = &self.nodes[node];
        weight_mm + bounds.squared_distance_mm2(place).sqrt()
    }
}

/// Sorts the entries of a node into its halves, and so on down.
fn split(entries: &mut [Entry], node: usize, nodes: &mut Vec<Node>) {
    if entries.len() <= LEAF {
        return;
    }
    let mut own = Node { bounds: BoxMm::EMPTY, weight_mm: f64::INFINITY };
    for entry in entries.iter() {
        own.bounds.add(entry.at_mm);
        own.weight_mm = own.weight_mm.min(entry.weight_mm);
    }
    let size_mm = own.bounds.size_mm();
    let axis =
        (1..3).fold(0, |widest, axis| if size_mm[axis] > size_mm[widest] { axis } else { widest });
    if nodes.len() <= node {
        nodes.resize(node + 1, own);
    }
    nodes[node] = own;
    let half = entries.len() / 2;
    entries.select_nth_unstable_by(half, |a, b| {
        a.at_mm[axis].total_cmp(&b.at_mm[axis]).then(a.index.cmp(&b.index))
    });
    let (left, right) = entries.split_at_mut(half);
    split(left, 2 * node + 1, nodes);
    split(right, 2 * node + 2, nodes);
}

/// Distance of two places in mm.
fn distance(p: PointMm, q: PointMm) -> f64 {
    let [x, y, z] = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
    (x * x + y * y + z * z).sqrt()
}

/// Of a floor.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::{WeightedTree, distance};
    use crate::regressions::beside_source;

    #[test]
    fn a_visit_sees_every_point_of_the_boxes_that_reach() {
        let points: Vec<_> =
            (0..1000).map(|index| [f64::from(index % 40), f64::from(index / 40), 0.0]).collect();
        let tree = WeightedTree::of_points(&points);
        let place = [11.0, 7.0, 0.0];
        let mut within = Vec::new();
        let ended = tree.visit(
            |bounds, _| bounds.squared_distance_mm2(place) <= 9.0,
            |number| {
                if distance(points[number as usize], place) <= 3.0 {
                    within.push(number);
                }
                false
            },
        );
        within.sort_unstable();
        let all = (0..1000).filter(|&number| distance(points[number as usize], place) <= 3.0);
        assert_eq!(within, all.collect::<Vec<_>>());
        assert!(!ended && tree.visit(|_, _| true, |number| number == 999));
    }

    #[test]
    fn many_points_in_one_place_and_on_one_line() {
        let line = |index: u32| [1.0, 2.0, f64::from(index / 100)];
        let points: Vec<_> = (0..5000).map(line).collect();
        let tree = WeightedTree::of_points(&points);
        assert_eq!(tree.nearest([1.0, 2.0, 7.2], |_| true), Some((700, 7.2 - 7.0)));
        assert_eq!(tree.nearest([1.0, 2.0, 7.0], |number| number != 700), Some((701, 0.0)));
        assert_eq!(tree.nearest([0.0; 3], |_| false), None);
        assert_eq!(WeightedTree::of_points(&[]).nearest([0.0; 3], |_| true), None);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn the_nearest_agrees_with_looking_at_all(
            // A coarse lattice, so that many distances are equal.
            points in prop::collection::vec(prop::array::uniform3(-4_i8..4), 0..120),
            place in prop::array::uniform3(-5_i8..5),
            without in 0_u32..60,
        ) {
            let points: Vec<_> = points.into_iter().map(|p| p.map(f64::from)).collect();
            let place = place.map(f64::from);
            let expected = (0..)
                .zip(&points)
                .filter(|&(number, _)| number != without)
                .map(|(number, &point)| (number, distance(point, place)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            let found = WeightedTree::of_points(&points).nearest(place, |number| number != without);
            prop_assert_eq!(found, expected);
        }

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

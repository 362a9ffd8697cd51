//! Pairs of triangles whose boxes meet.

use asphera_geometry::{BoxMm, PointMm};
use rayon::prelude::*;

/// Calls for every pair of boxes that meet, the smaller number first, and gives all that the calls gave.
///
/// A tree of boxes cut at the median of their middles; every box asks it for those of greater number.
pub(super) fn pairs(boxes: &[BoxMm], keep: impl Fn(u32, u32) -> bool + Sync) -> Vec<[u32; 2]> {
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    let mut nodes = vec![BoxMm::EMPTY; node_count(boxes.len())];
    build(boxes, &mut order, 0, &mut nodes);
    (0..boxes.len() as u32)
        .into_par_iter()
        .flat_map_iter(|number| {
            let mut found = Vec::new();
            ask(boxes, &order, 0, &nodes, number, &mut |other| {
                if keep(number, other) {
                    found.push([number, other]);
                }
            });
            found
        })
        .collect()
}

/// A tree of boxes that is asked for what is nearest to a place.
pub(crate) struct Tree {
    order: Vec<u32>,
    nodes: Vec<BoxMm>,
}

impl Tree {
    pub(crate) fn of(boxes: &[BoxMm]) -> Tree {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = vec![BoxMm::EMPTY; node_count(boxes.len())];
        build(boxes, &mut order, 0, &mut nodes);
        Tree { order, nodes }
    }

    /// The least square of a distance in mm², where `square` gives that of an item in a box; infinite without items.
    pub(crate) fn least(&self, place: PointMm, square: impl Fn(u32) -> f64) -> f64 {
        let mut best = f64::INFINITY;
        self.seek(&self.order, 0, place, &square, &mut best);
        best
    }

    fn seek(
        &self,
        order: &[u32],
        node: usize,
        place: PointMm,
        square: &impl Fn(u32) -> f64,
        best: &mut f64,
    ) {
        if order.len() <= LEAF {
            *best = order.iter().map(|&number| square(number)).fold(*best, f64::min);
            return;
        }
        let (left, right) = order.split_at(order.len() / 2);
        let mut halves = [(2 * node + 1, left), (2 * node + 2, right)]
            .map(|(node, half)| (self.nodes[node].squared_distance_mm2(place), node, half));
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (floor, node, half) in halves {
            if floor < *best {
                self.seek(half, node, place, square, best);
            }
        }
    }
}

fn node_count(len: usize) -> usize {
    if len <= LEAF { 1 } else { (4 * len / LEAF).next_power_of_two() }
}

fn build(boxes: &[BoxMm], order: &mut [u32], node: usize, nodes: &mut [BoxMm]) {
    let mut whole = BoxMm::EMPTY;
    order.iter().for_each(|&number| whole.join(&boxes[number as usize]));
    nodes[node] = whole;
    if order.len() <= LEAF {
        return;
    }
    let extent = |axis: usize| whole.high[axis] - whole.low[axis];
    let axis =
        (1..3).fold(0, |widest, axis| if extent(axis) > extent(widest) { axis } else { widest });
    let middle = |number: u32| boxes[number as usize].low[axis] + boxes[number as usize].high[axis];
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |&a, &b| middle(a).total_cmp(&middle(b)).then(a.cmp(&b)));
    let (left, right) = order.split_at_mut(half);
    build(boxes, left, 2 * node + 1, nodes);
    build(boxes, right, 2 * node + 2, nodes);
}

fn ask(
    boxes: &[BoxMm],
    order: &[u32],
    node: usize,
    nodes: &[BoxMm],
    number: u32,
    take: &mut impl FnMut(u32),
) {
    let own = &boxes[number as usize];
    if !meet(own, &nodes[node]) {
        return;
    }
    if order.len() <= LEAF {
        for &other in order {
            if other > number && meet(own, &boxes[other as usize]) {
                take(other);
            }
        }
        return;
    }
    let (left, right) = order.split_at(order.len() / 2);
    ask(boxes, left, 2 * node + 1, nodes, number, take);
    ask(boxes, right, 2 * node + 2, nodes, number, take);
}

fn meet(a: &BoxMm, b: &BoxMm) -> bool {
    (0..3).all(|axis| a.low[axis] <= b.high[axis] && b.low[axis] <= a.high[axis])
}

const LEAF: usize = 4;

//! Points near a place or a box.

use asphera_geometry::{BoxMm, PointMm, greater};

use super::{Content, MARGIN, Node, PlaceTree, ROOT};
use crate::geometry::{dot, gap, squared};
use crate::local::Places;
use crate::neighbours::Near;

/// A middle, and the square of a radius, mm².
pub(in crate::local) type Ball = (PointMm, f64);

/// Square of the distance from a place to the farthest corner of a box.
#[inline(always)]
fn span(bounds: &BoxMm, place: PointMm) -> f64 {
    let ways = [0, 1, 2]
        .map(|axis| greater(place[axis] - bounds.low[axis], bounds.high[axis] - place[axis]));
    dot(ways, ways)
}

impl Places for PlaceTree {
    fn points_mm(&self) -> &[PointMm] {
        &self.points_mm
    }

    fn within(&self, at: u32, radius_mm: f64, found: &mut Vec<Near>) {
        let place = self.points_mm[at as usize];
        found.clear();
        self.gather_within(place, radius_mm, found);
        found.retain(|&(_, other)| other != at);
        found.sort_unstable_by(|a, b| self.order(a, b));
    }
}

impl PlaceTree {
    /// Appends the points within a distance of a place, in no order.
    pub(in crate::local) fn gather_within(
        &self,
        place: PointMm,
        radius_mm: f64,
        found: &mut Vec<Near>,
    ) {
        self.collect(ROOT, place, radius_mm * radius_mm, found);
    }

    /// A node below which all points within a distance of a box lie: the first on the way down whose halves both may have some.
    fn below(&self, own: &BoxMm, distance_mm: f64) -> u32 {
        let farther_mm = distance_mm * (1.0 + MARGIN);
        let mut node = ROOT;
        while let Content::Split { low, high, axis, at_mm } = self.nodes[node as usize].content {
            let axis = usize::from(axis);
            node = if own.high[axis] + farther_mm < at_mm {
                low
            } else if own.low[axis] - farther_mm >= at_mm {
                high
            } else {
                break;
            };
        }
        node
    }

    /// Gathers the points of leaves that lie within a distance of a box, as its square, near ones first; gives `false` where it
    /// stopped at `most`.
    pub(crate) fn gather(
        &self,
        own: &BoxMm,
        limit_mm2: f64,
        most: usize,
        (waiting, found): (&mut Vec<u32>, &mut Vec<u32>),
    ) -> bool {
        let distance = |node: u32| gap(own, &self.nodes[node as usize].bounds) * (1.0 - MARGIN);
        waiting.clear();
        let start = self.below(own, limit_mm2.sqrt());
        waiting.extend((distance(start) <= limit_mm2).then_some(start));
        while let Some(node) = waiting.pop() {
            match self.nodes[node as usize].content {
                Content::Leaf { block, len } => {
                    found.extend_from_slice(&self.blocks[block as usize][..len as usize]);
                    if found.len() > most {
                        return false;
                    }
                }
                Content::Split { low, high, .. } => {
                    let (to_low, to_high) = (distance(low), distance(high));
                    let mut halves = [(to_high, high), (to_low, low)];
                    if to_high < to_low {
                        halves.swap(0, 1);
                    }
                    let within = halves.iter().filter(|half| half.0 <= limit_mm2);
                    waiting.extend(within.map(|&(_, half)| half));
                }
            }
        }
        true
    }

    /// Calls with every point of leaves that reach into one of some balls and into a further one, but not of leaves within a last one.
    pub(in crate::local) fn gather_in_balls(
        &self,
        balls: &[Ball],
        within: Ball,
        without: Ball,
        waiting: &mut Vec<u32>,
        found: &mut impl FnMut(u32),
    ) {
        let meets = |node: u32| {
            let bounds = &self.nodes[node as usize].bounds;
            let reaches_into = |&(middle, square): &Ball| {
                gap(&BoxMm { low: middle, high: middle }, bounds) <= square
            };
            reaches_into(&within) && balls.iter().any(reaches_into)
        };
        waiting.clear();
        waiting.push(self.below(&BoxMm { low: within.0, high: within.0 }, within.1.sqrt()));
        while let Some(node) = waiting.pop() {
            let Node { bounds, content, .. } = &self.nodes[node as usize];
            match *content {
                Content::Leaf { .. } if span(bounds, without.0) < without.1 * (1.0 - MARGIN) => {}
                Content::Leaf { block, len } => {
                    self.blocks[block as usize][..len as usize].iter().for_each(|&at| found(at));
                }
                Content::Split { low, high, .. } => {
                    waiting.extend([low, high].into_iter().filter(|&half| meets(half)));
                }
            }
        }
    }

    fn collect(&self, node: u32, place: PointMm, limit: f64, found: &mut Vec<Near>) {
        let Node { bounds, content, .. } = &self.nodes[node as usize];
        if gap(&BoxMm { low: place, high: place }, bounds) * (1.0 - MARGIN) > limit {
            return;
        }
        match *content {
            Content::Leaf { block, len } => {
                for &other in &self.blocks[block as usize][..len as usize] {
                    let square = squared(place, self.points_mm[other as usize]);
                    if square <= limit {
                        found.push((square, other));
                    }
                }
            }
            Content::Split { low, high, .. } => {
                self.collect(low, place, limit, found);
                self.collect(high, place, limit, found);
            }
        }
    }

    /// The widest side of the points about a point: of its leaf, or of the first box above it that is one.
    pub(crate) fn side_mm(&self, at: u32) -> f64 {
        let mut node = self.leaf_of[at as usize];
        loop {
            let Some(Node { bounds, parent, .. }) = self.nodes.get(node as usize) else {
                return 0.0;
            };
            let side = |axis: usize| bounds.high[axis] - bounds.low[axis];
            let widest = (0..3).map(side).fold(0.0, f64::max);
            if widest > 0.0 {
                return widest;
            }
            node = *parent;
        }
    }

    /// The leaf of a point, by which points near each other can be taken together.
    pub(in crate::local) fn leaf_of(&self, at: u32) -> u32 {
        self.leaf_of[at as usize]
    }

    /// The box of some points.
    pub(crate) fn about(&self, points: impl Iterator<Item = u32>) -> BoxMm {
        BoxMm::about(points.map(|at| self.points_mm[at as usize]))
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn balls_miss_no_point_but_those_that_are_not_asked_for(
            places in prop::collection::vec(prop::array::uniform3(-9_i32..9), 1..400),
            middles in prop::array::uniform4(prop::array::uniform3(-12.0..12.0)),
            radii_mm in prop::array::uniform4(0.0..9.0),
        ) {
            let mut batch: Vec<_> =
                places.iter().map(|place| place.map(f64::from)).zip(0..).collect();
            let mut tree = PlaceTree::default();
            tree.insert(&mut batch);
            let [one, other, within, without] =
                [0, 1, 2, 3].map(|ball| (middles[ball], radii_mm[ball] * radii_mm[ball]));
            let mut called = Vec::new();
            let mut call = |at| called.push(at);
            tree.gather_in_balls(&[one, other], within, without, &mut Vec::new(), &mut call);
            let is_in = |at: u32, (middle, square): Ball| {
                squared(middle, tree.points_mm()[at as usize]) <= square
            };
            for at in 0..tree.len() as u32 {
                let is_called = called.iter().filter(|&&other| other == at).count();
                prop_assert!(is_called <= 1);
                if (is_in(at, one) || is_in(at, other)) && is_in(at, within) && !is_in(at, without) {
                    prop_assert_eq!(is_called, 1);
                }
            }
        }
    }
}

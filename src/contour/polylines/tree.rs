//! A tree of sides, found by their middles.

use asphera_geometry::{BoundsMm, greater, lesser};

use super::middle;
use crate::PlaceMm;
use crate::triangulation::distance_mm;

/// A k-d tree of the middles of sides; half the length of a side is how much nearer than its middle it may come.
///
/// As `WeightedTree` of points. Its boxes about sides that slant are wide, and all that is as near as a box would be
/// looked at: beside a line about √n sides. So nodes know strips along their sides, too.
pub(super) struct SideTree {
    /// A node is a range, its left child the first half.
    entries: Vec<Entry>,
    /// In heap order.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Entry {
    middle_mm: PlaceMm,
    half_mm: f64,
    side: u32,
}

/// Sides that lie near one another.
#[derive(Clone, Copy)]
pub(super) struct Node {
    /// The box about their middles.
    bounds: BoundsMm,
    /// Half the length of the longest.
    half_mm: f64,
    strip: Strip,
}

/// A box about sides that lies along them.
#[derive(Clone, Copy)]
struct Strip {
    from: PlaceMm,
    along: [f64; 2],
    /// Its range along and across, counted from a place of it.
    low_mm: [f64; 2],
    high_mm: [f64; 2],
    rounding_mm: f64,
}

/// Up to how many sides are looked at one by one.
const LEAF: usize = 8;

/// More sides have no strip: they bend too much.
const MOST_IN_STRIP: usize = 4096;

impl SideTree {
    pub(super) fn new(sides: &[[PlaceMm; 2]]) -> SideTree {
        let entry = |(&[p, q], side): (&[PlaceMm; 2], u32)| Entry {
            middle_mm: middle(p, q),
            half_mm: 0.5 * distance_mm(p, q),
            side,
        };
        let mut entries: Vec<Entry> = sides.iter().zip(0..).map(entry).collect();
        let mut nodes = Vec::new();
        split(&mut entries, 0, sides, &mut nodes);
        SideTree { entries, nodes }
    }

    /// The side for which the distance to its middle less half its length is least, of equal ones that of the smallest number; none without
    /// sides.
    pub(super) fn nearest(&self, place: PlaceMm) -> Option<u32> {
        let mut best = (f64::INFINITY, u32::MAX);
        self.seek(0, &self.entries, place, &mut best);
        (best.0 < f64::INFINITY).then_some(best.1)
    }

    fn seek(&self, node: usize, entries: &[Entry], place: PlaceMm, best: &mut (f64, u32)) {
        if entries.len() <= LEAF {
            for entry in entries {
                let found_mm = -entry.half_mm + distance_mm(entry.middle_mm, place);
                if found_mm < best.0 || (found_mm == best.0 && entry.side < best.1) {
                    *best = (found_mm, entry.side);
                }
            }
            return;
        }
        let (left, right) = entries.split_at(entries.len() / 2);
        let mut halves = [(2 * node + 1, left), (2 * node + 2, right)].map(|(child, half)| {
            let node = &self.nodes[child];
            (node.floor_mm(place).max(node.gap_mm([place; 2]) - node.half_mm), child, half)
        });
        if halves[1].0 < halves[0].0 {
            halves.swap(0, 1);
        }
        for (floor_mm, child, half) in halves {
            // Rounding may put a floor above a side by some last bits, which must not decide between equals.
            if floor_mm - ROUNDING * floor_mm.abs() <= best.0 {
                self.seek(child, half, place, best);
            }
        }
    }

    /// Visits the sides of nodes, which `reaches` is asked about, and told whether their sides are looked at one by one. Their order depends on
    /// the sides alone.
    pub(super) fn visit(&self, reaches: impl Fn(&Node, bool) -> bool, mut take: impl FnMut(u32)) {
        self.pass(0, &self.entries, &reaches, &mut take);
    }

    fn pass(
        &self,
        node: usize,
        entries: &[Entry],
        reaches: &impl Fn(&Node, bool) -> bool,
        take: &mut impl FnMut(u32),
    ) {
        let is_leaf = entries.len() <= LEAF;
        if entries.is_empty() || !reaches(&self.nodes[node], is_leaf) {
            return;
        }
        if is_leaf {
            entries.iter().for_each(|entry| take(entry.side));
            return;
        }
        let (left, right) = entries.split_at(entries.len() / 2);
        self.pass(2 * node + 1, left, reaches, take);
        self.pass(2 * node + 2, right, reaches, take);
    }
}

impl Node {
    fn new(entries: &[Entry], sides: &[[PlaceMm; 2]]) -> Node {
        let bounds = BoundsMm::about(entries.iter().map(|entry| entry.middle_mm));
        let half_mm = entries.iter().fold(f64::NEG_INFINITY, |most, it| most.max(it.half_mm));
        Node { bounds, half_mm, strip: Strip::about(entries, sides) }
    }

    /// A length in mm that no side is nearer to a place than: distance of the box, less half of the longest side.
    pub(super) fn floor_mm(&self, place: PlaceMm) -> f64 {
        let nearest = self.bounds.nearest(place);
        let [x, y] = [place[0] - nearest[0], place[1] - nearest[1]];
        (x * x + y * y).sqrt() - self.half_mm
    }

    /// A length in mm that no side is nearer to a side than: distance of the strip.
    pub(super) fn gap_mm(&self, side: [PlaceMm; 2]) -> f64 {
        self.strip.gap_mm(side)
    }
}

impl Strip {
    /// Holds every place.
    const ALL: Strip = Strip {
        from: [0.0; 2],
        along: [1.0, 0.0],
        low_mm: [f64::NEG_INFINITY; 2],
        high_mm: [f64::INFINITY; 2],
        rounding_mm: 0.0,
    };

    fn about(entries: &[Entry], sides: &[[PlaceMm; 2]]) -> Strip {
        if entries.len() > MOST_IN_STRIP {
            return Strip::ALL;
        }
        let ends = || entries.iter().flat_map(|entry| sides[entry.side as usize]);
        let from = entries[0].middle_mm;
        let (mut sum, mut squares, mut product) = ([0.0; 2], [0.0; 2], 0.0);
        for end in ends() {
            let [x, y] = [end[0] - from[0], end[1] - from[1]];
            sum = [sum[0] + x, sum[1] + y];
            squares = [squares[0] + x * x, squares[1] + y * y];
            product += x * y;
        }
        let count = 2.0 * entries.len() as f64;
        let difference = squares[0] - squares[1] - (sum[0] * sum[0] - sum[1] * sum[1]) / count;
        let twice = 2.0 * (product - sum[0] * sum[1] / count);
        // Any direction will do; that in which the ends spread makes the strip narrow.
        let [x, y] = [difference + distance_mm([difference, twice], [0.0; 2]), twice];
        let length = distance_mm([x, y], [0.0; 2]);
        let along = if length > 0.0 && length < f64::INFINITY {
            [x / length, y / length]
        } else if difference < 0.0 {
            [0.0, 1.0]
        } else {
            [1.0, 0.0]
        };
        let mut strip = Strip { from, along, ..Strip::ALL };
        let range = BoundsMm::about(ends().map(|end| strip.turned(end)));
        let size_mm: f64 = range.low.iter().chain(&range.high).map(|value| value.abs()).sum();
        strip.low_mm = range.low;
        strip.high_mm = range.high;
        strip.rounding_mm = STRIP_ROUNDING * (size_mm + from[0].abs() + from[1].abs());
        strip
    }

    /// A place as seen along the strip and across it.
    fn turned(&self, place: PlaceMm) -> [f64; 2] {
        let [x, y] = [place[0] - self.from[0], place[1] - self.from[1]];
        [x * self.along[0] + y * self.along[1], y * self.along[0] - x * self.along[1]]
    }

    /// How far apart the two are along or across the strip.
    fn gap_mm(&self, side: [PlaceMm; 2]) -> f64 {
        let [p, q] = side.map(|end| self.turned(end));
        let gap = |axis: usize| {
            let (low_mm, high_mm) = (lesser(p[axis], q[axis]), greater(p[axis], q[axis]));
            greater(greater(self.low_mm[axis] - high_mm, low_mm - self.high_mm[axis]), 0.0)
        };
        let [x, y] = [gap(0), gap(1)];
        let size_mm = p[0].abs() + p[1].abs() + q[0].abs() + q[1].abs();
        (x * x + y * y).sqrt() - (self.rounding_mm + STRIP_ROUNDING * size_mm)
    }
}

/// Sorts the entries of a node into its halves, and so on down.
fn split(entries: &mut [Entry], node: usize, sides: &[[PlaceMm; 2]], nodes: &mut Vec<Node>) {
    if entries.is_empty() {
        return;
    }
    let own = Node::new(entries, sides);
    if nodes.len() <= node {
        nodes.resize(node + 1, own);
    }
    nodes[node] = own;
    if entries.len() <= LEAF {
        return;
    }
    let [width_mm, height_mm] = own.bounds.size_mm();
    let axis = usize::from(height_mm > width_mm);
    let half = entries.len() / 2;
    entries.select_nth_unstable_by(half, |a, b| {
        a.middle_mm[axis].total_cmp(&b.middle_mm[axis]).then(a.side.cmp(&b.side))
    });
    let (left, right) = entries.split_at_mut(half);
    split(left, 2 * node + 1, sides, nodes);
    split(right, 2 * node + 2, sides, nodes);
}

/// Of a floor.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Of all lengths that a strip is made of: coordinates, differences, products.
const STRIP_ROUNDING: f64 = 64.0 * f64::EPSILON;

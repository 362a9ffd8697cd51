//! The nearest neighbours of all points, found for many at once.
//!
//! A k-d tree cut at medians whose leaves lie in one array in their order, so that points near each other are near in memory. The
//! points of a leaf ask together: what may be near to any of them is gathered once. Of equal distances the smaller coordinates come
//! first, so that lists do not depend on the order of the points. [`asphera_geometry::WeightedTree`] answers one place at a time.

use std::cmp::Ordering;

use asphera_geometry::{BoxMm, PointMm};
use rayon::prelude::*;

use crate::geometry::{gap, squared};
use crate::local::Places;

/// The tree. Points are numbered by their place in it.
pub(crate) struct Neighbours {
    /// The points in the order of the tree.
    pub(crate) points_mm: Vec<PointMm>,
    /// Their numbers as they came.
    pub(crate) ids: Vec<u32>,
    /// The box of each node, in heap order; a node is a range, its left child the first half.
    nodes: Vec<BoxMm>,
}

/// A node of the tree and the range of points in it.
#[derive(Clone, Copy)]
struct Branch {
    node: usize,
    from: usize,
    to: usize,
}

impl Branch {
    fn is_leaf(self) -> bool {
        self.to - self.from <= LEAF
    }

    /// Numbers of its points in the tree.
    fn points(self) -> std::ops::Range<u32> {
        self.from as u32..self.to as u32
    }

    fn halves(self) -> [Branch; 2] {
        let middle = self.from + (self.to - self.from) / 2;
        [
            Branch { node: 2 * self.node + 1, from: self.from, to: middle },
            Branch { node: 2 * self.node + 2, from: middle, to: self.to },
        ]
    }
}

/// A neighbour: the square of its distance in mm², and its number in the tree.
pub(crate) type Near = (f64, u32);

impl Neighbours {
    /// The tree of points that differ in place, with their numbers. n·log n time.
    pub(crate) fn of(points: Vec<(PointMm, u32)>) -> Neighbours {
        let mut points = points;
        let mut nodes = vec![BoxMm::EMPTY; node_count(points.len())];
        build(&mut points, 0, &mut nodes);
        let ids = points.iter().map(|&(_, id)| id).collect();
        let points_mm = points.into_iter().map(|(point, _)| point).collect();
        Neighbours { points_mm, ids, nodes }
    }

    pub(crate) fn len(&self) -> usize {
        self.points_mm.len()
    }

    fn root(&self) -> Branch {
        Branch { node: 0, from: 0, to: self.len() }
    }

    /// Does something with the `count` nearest of every point, itself left out, the nearest first; in the order of the tree.
    ///
    /// `make` is given the number of the point, its neighbours and room that it may keep between calls.
    pub(crate) fn map_nearest<T: Send, S: Default>(
        &self,
        count: usize,
        make: impl Fn(u32, &[Near], &mut S) -> T + Sync,
    ) -> Vec<T> {
        let mut leaves = Vec::new();
        ranges(0, self.len(), &mut leaves);
        let chunks: Vec<Vec<T>> = leaves
            .par_chunks(64)
            .map(|chunk| {
                let mut room = Room::default();
                let mut state = S::default();
                let mut made = Vec::with_capacity(64 * LEAF);
                for &(from, to) in chunk {
                    self.ask_leaf(from, to, count, &mut room);
                    for at in from..to {
                        let near = self.select(at, count, &mut room);
                        made.push(make(at as u32, near, &mut state));
                    }
                }
                made
            })
            .collect();
        chunks.into_iter().flatten().collect()
    }

    /// The `count` nearest of every point, the nearest first: so many numbers for each point, in the order of the tree.
    ///
    /// Fewer than `count` where there are no more.
    pub(crate) fn nearest_of_all(&self, count: usize) -> Vec<u32> {
        let mut leaves = Vec::new();
        ranges(0, self.len(), &mut leaves);
        let chunks: Vec<Vec<u32>> = leaves
            .par_chunks(64)
            .map(|chunk| {
                let mut room = Room::default();
                let mut found = Vec::with_capacity(64 * LEAF * count);
                for &(from, to) in chunk {
                    self.ask_leaf(from, to, count, &mut room);
                    for at in from..to {
                        let near = self.select(at, count, &mut room);
                        found.extend(near.iter().map(|&(_, other)| other));
                    }
                }
                found
            })
            .collect();
        chunks.concat()
    }

    /// The `count` nearest of a place within the root of a limit, the nearest first.
    pub(crate) fn nearest_within(
        &self,
        place: PointMm,
        limit_mm2: f64,
        count: usize,
        found: &mut Vec<Near>,
    ) {
        found.clear();
        if self.len() == 0 {
            return;
        }
        self.collect(self.root(), place, limit_mm2 * (1.0 + 1e-12), u32::MAX, found);
        let order = |a: &Near, b: &Near| self.order(a, b);
        if found.len() > count {
            found.select_nth_unstable_by(count - 1, order);
            found.truncate(count);
        }
        found.sort_unstable_by(order);
    }

    /// Gathers what may be among the nearest of the points of a leaf.
    fn ask_leaf(&self, from: usize, to: usize, count: usize, room: &mut Room) {
        let own = BoxMm::about(self.points_mm[from..to].iter().copied());
        // A box that holds nothing wide, as of few points in a line, asks for a start.
        let wide = (0..3).map(|axis| own.high[axis] - own.low[axis]).fold(0.0, f64::max);
        let mut radius = if room.radius > 0.0 { room.radius.min(4.0 * wide) } else { wide };
        loop {
            room.gathered.clear();
            self.gather(self.root(), &own, radius * radius, &mut room.gathered);
            let wanted = count.min(self.len() - 1);
            if room.gathered.len() > wanted {
                // Distances of the point of the leaf that is worst off.
                let mut worst: f64 = 0.0;
                for at in from..to {
                    let place = self.points_mm[at];
                    room.squares.clear();
                    room.squares.extend(
                        room.gathered
                            .iter()
                            .map(|&other| squared(place, self.points_mm[other as usize])),
                    );
                    let (_, &mut far, _) =
                        room.squares.select_nth_unstable_by(wanted, f64::total_cmp);
                    worst = worst.max(far);
                }
                if worst <= radius * radius || room.gathered.len() == self.len() {
                    room.radius = worst.sqrt() * 1.05;
                    return;
                }
                radius = worst.sqrt() * (1.0 + 1e-9);
            } else {
                radius = (2.0 * radius).max(f64::MIN_POSITIVE * 1e100);
            }
        }
    }

    /// The nearest of what was gathered.
    fn select<'a>(&self, at: usize, count: usize, room: &'a mut Room) -> &'a [Near] {
        let place = self.points_mm[at];
        room.found.clear();
        let others = room.gathered.iter().filter(|&&other| other as usize != at);
        room.found
            .extend(others.map(|&other| (squared(place, self.points_mm[other as usize]), other)));
        let order = |a: &Near, b: &Near| self.order(a, b);
        if room.found.len() > count {
            room.found.select_nth_unstable_by(count - 1, order);
            room.found.truncate(count);
        }
        room.found.sort_unstable_by(order);
        &room.found
    }

    /// The nearest first; of equal distances the smaller coordinates.
    #[inline]
    fn order(&self, a: &Near, b: &Near) -> Ordering {
        a.0.total_cmp(&b.0).then_with(|| {
            by_coordinates(self.points_mm[a.1 as usize], self.points_mm[b.1 as usize])
        })
    }

    fn gather(&self, branch: Branch, own: &BoxMm, limit: f64, found: &mut Vec<u32>) {
        if gap(own, &self.nodes[branch.node]) > limit {
            return;
        }
        if branch.is_leaf() {
            found.extend(branch.points());
            return;
        }
        for half in branch.halves() {
            self.gather(half, own, limit, found);
        }
    }

    fn collect(
        &self,
        branch: Branch,
        place: PointMm,
        limit: f64,
        without: u32,
        found: &mut Vec<Near>,
    ) {
        if self.nodes[branch.node].squared_distance_mm2(place) > limit {
            return;
        }
        if branch.is_leaf() {
            for other in branch.points() {
                let square = squared(place, self.points_mm[other as usize]);
                if square <= limit && other != without {
                    found.push((square, other));
                }
            }
            return;
        }
        for half in branch.halves() {
            self.collect(half, place, limit, without, found);
        }
    }
}

impl Places for Neighbours {
    fn points_mm(&self) -> &[PointMm] {
        &self.points_mm
    }

    fn within(&self, at: u32, radius_mm: f64, found: &mut Vec<Near>) {
        let place = self.points_mm[at as usize];
        found.clear();
        self.collect(self.root(), place, radius_mm * radius_mm, at, found);
        found.sort_unstable_by(|a, b| self.order(a, b));
    }
}

/// Memory of a thread between leaves.
#[derive(Default)]
struct Room {
    radius: f64,
    gathered: Vec<u32>,
    squares: Vec<f64>,
    found: Vec<Near>,
}

/// The order of places by x, y, z, by which ties fall.
#[inline]
pub(crate) fn by_coordinates(p: PointMm, q: PointMm) -> Ordering {
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2]))
}

fn build(points: &mut [(PointMm, u32)], node: usize, nodes: &mut [BoxMm]) {
    let whole = BoxMm::about(points.iter().map(|&(point, _)| point));
    nodes[node] = whole;
    if points.len() <= LEAF {
        return;
    }
    let extent = |axis: usize| whole.high[axis] - whole.low[axis];
    let axis =
        (1..3).fold(0, |widest, axis| if extent(axis) > extent(widest) { axis } else { widest });
    let half = points.len() / 2;
    points.select_nth_unstable_by(half, |a, b| {
        a.0[axis].total_cmp(&b.0[axis]).then_with(|| by_coordinates(a.0, b.0))
    });
    let (left, right) = points.split_at_mut(half);
    build(left, 2 * node + 1, nodes);
    build(right, 2 * node + 2, nodes);
}

fn node_count(len: usize) -> usize {
    if len <= LEAF { 1 } else { (4 * len / LEAF).next_power_of_two() }
}

/// The leaves as ranges of points.
fn ranges(from: usize, to: usize, found: &mut Vec<(usize, usize)>) {
    if to - from <= LEAF {
        if to > from {
            found.push((from, to));
        }
        return;
    }
    let middle = from + (to - from) / 2;
    ranges(from, middle, found);
    ranges(middle, to, found);
}

const LEAF: usize = 8;

//! The search for places near those of a leaf.
//!
//! Places of a leaf share the walk through the tree: one search finds all leaves that can hold a neighbour of any of them. How far
//! neighbours lie is foreseen, and bounded, by those of places that are near (J. Sankaranarayanan, H. Samet, A. Varshney, Computers &
//! Graphics 31 (2007) 157-174, doi:10.1016/j.cag.2006.11.011, do the same with blocks of an octree).

use crate::cloud::{Cloud, PlaceId};
use crate::tree::{Node, squared_distance};

/// A place near another one: the bits of the square of its distance, which are in the order of squares, above its number. So entries
/// sort by distance, and equally near ones by number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Entry(u128);

impl Entry {
    fn new(square: f64, id: PlaceId) -> Entry {
        Entry(u128::from(square.to_bits()) << 32 | u128::from(id))
    }

    /// Square of the distance in mm².
    pub(crate) fn square(self) -> f64 {
        f64::from_bits((self.0 >> 32) as u64)
    }

    pub(crate) fn id(self) -> PlaceId {
        self.0 as PlaceId
    }
}

/// Memory of one thread that searches for the neighbours of leaves.
pub(super) struct Search<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    k: usize,
    /// The likely reach of a place over that of a place nearby.
    likely: f64,
    reached: Vec<Node<D>>,
    open: Vec<u32>,
    near: Vec<Entry>,
    /// Places that were searched last, each with the distance of its farthest neighbour in mm: those of the leaf, and the one before
    /// it.
    known: Vec<([f64; D], f64)>,
    /// The place to come, if leaves follow one another.
    next: Option<PlaceId>,
}

impl<'a, const D: usize> Search<'a, D> {
    pub(super) fn new(cloud: &'a Cloud<D>, k: usize) -> Search<'a, D> {
        let (reached, open, near, known) = Default::default();
        let likely = 1.0 + LIKELY / (k as f64).sqrt();
        Search { cloud, k, likely, reached, open, near, known, next: None }
    }

    /// Gives the `k` nearest of every place of some leaves, the farthest of them last and the others in no order.
    pub(super) fn leaves(
        &mut self,
        leaves: &[(u32, u32)],
        mut take: impl FnMut(PlaceId, &mut [Entry]),
    ) {
        let k = self.k;
        let mut take = |place, found: &mut [Entry]| {
            let nearest = select(found, k);
            let square = nearest[k - 1].square();
            take(place, nearest);
            square
        };
        leaves.iter().for_each(|leaf| self.leaf(leaf, &mut take));
    }

    /// Gives places near every place of a leaf, in no order, the `k` nearest others among them. What takes them says the square of the
    /// distance to the `k`-th, in mm².
    pub(super) fn leaf(
        &mut self,
        &(leaf, around): &(u32, u32),
        take: &mut impl FnMut(PlaceId, &mut [Entry]) -> f64,
    ) {
        let (nodes, places) = (&self.cloud.nodes, self.cloud.places());
        let own = &nodes[leaf as usize];
        let first = &places[own.first as usize];
        // Leaves follow one another in space, so the place before is near.
        match self.known.pop() {
            Some(last) if self.next == Some(own.first) => {
                self.known.clear();
                self.known.push(last);
            }
            _ => {
                self.known.clear();
                let rough_mm = self.rough_reach_mm(own.first, around);
                self.known.push((*first, rough_mm));
            }
        }
        self.next = Some(own.end);
        let own_places = &places[own.first as usize..own.end as usize];
        let farthest = own_places.iter().map(|place| squared_distance(first, place));
        let wide_mm = farthest.fold(0.0, f64::max).sqrt();
        for (place, at) in (own.first..own.end).zip(own_places) {
            let mut count = 0;
            for limit_mm in self.bounds_mm(at) {
                if place == own.first {
                    // Rounding may put a place within the limit that is a trifle beyond it.
                    self.reach(own, squared(limit_mm + wide_mm) * (1.0 + 1e-9));
                }
                count = self.scan_reached(place, squared(limit_mm));
                if count >= self.k {
                    break;
                }
            }
            let reach_mm = take(place, &mut self.near[..count]).sqrt();
            self.known.push((*at, reach_mm));
            if place == own.first {
                let limit = squared(reach_mm + wide_mm);
                self.reached.retain(|leaf| leaf.squared_gap(own) <= limit);
            }
        }
    }

    /// A distance in mm within which a place most likely has `k` neighbours, and one within which it has them for certain.
    ///
    /// A known place has as many within its reach; both places are as far apart as they are; so within the sum there are as many.
    fn bounds_mm(&self, at: &[f64; D]) -> [f64; 2] {
        let (mut bound_mm, mut near_mm) = (f64::INFINITY, 0.0);
        for (place, mm) in &self.known {
            let sum_mm = mm + squared_distance(at, place).sqrt();
            if sum_mm < bound_mm {
                (bound_mm, near_mm) = (sum_mm, *mm);
            }
        }
        [bound_mm.min(near_mm * self.likely), bound_mm]
    }

    /// Lists the places of the leaves that are reached no farther from a place than the root of `limit`; gives how many there are.
    fn scan_reached(&mut self, place: PlaceId, limit: f64) -> usize {
        let at = &self.cloud.places()[place as usize];
        let mut count = 0;
        for other in &self.reached {
            if other.squared_distance(at) <= limit {
                count = scan(self.cloud, (place, other), limit, (&mut self.near, count));
            }
        }
        count
    }

    /// A distance in mm within which a place has `k` neighbours: those in a node that holds more of them.
    fn rough_reach_mm(&mut self, place: PlaceId, around: u32) -> f64 {
        let node = &self.cloud.nodes[around as usize];
        let count = scan(self.cloud, (place, node), f64::INFINITY, (&mut self.near, 0));
        select(&mut self.near[..count], self.k)[self.k - 1].square().sqrt()
    }

    /// Lists the leaves no farther from a leaf than the root of `limit`.
    fn reach(&mut self, own: &Node<D>, limit: f64) {
        let nodes = &self.cloud.nodes;
        self.reached.clear();
        self.open.clear();
        self.open.push(0);
        while let Some(at) = self.open.pop() {
            let node = &nodes[at as usize];
            if node.squared_gap(own) > limit {
                continue;
            }
            if node.right == 0 {
                self.reached.push(*node);
            } else {
                self.open.extend([at + node.right, at + 1]);
            }
        }
    }
}

/// The square of a distance that others are compared with; rounding leaves none out.
fn squared(mm: f64) -> f64 {
    mm * mm * (1.0 + 1e-9)
}

/// Adds the places of a node no farther from a place than the root of `limit` to the first `count` entries; gives how many there are.
fn scan<const D: usize>(
    cloud: &Cloud<D>,
    (place, node): (PlaceId, &Node<D>),
    limit: f64,
    (near, count): (&mut Vec<Entry>, usize),
) -> usize {
    let at = &cloud.places()[place as usize];
    let others = &cloud.places()[node.first as usize..node.end as usize];
    if near.len() < count + others.len() {
        near.resize(2 * (count + others.len()), Entry::default());
    }
    let into = &mut near[count..count + others.len()];
    let mut found = 0;
    for (other, position) in (node.first..node.end).zip(others) {
        let square = squared_distance(at, position);
        // Every one is written, and stays if it is near: that spares a branch that nobody can foresee.
        into[found] = Entry::new(square, other);
        found += usize::from(square <= limit && other != place);
    }
    count + found
}

/// The `k` nearest of some entries, the farthest of them last.
fn select(found: &mut [Entry], k: usize) -> &mut [Entry] {
    if found.len() <= FEW {
        found.sort_unstable();
    } else {
        found.select_nth_unstable(k - 1);
    }
    &mut found[..k]
}

/// So many entries are sorted as fast as some are selected.
const FEW: usize = 32;

/// The likely reach is that of a place nearby and so many √k-ths of it more: of points at random it varies by half of one.
const LIKELY: f64 = 0.6;

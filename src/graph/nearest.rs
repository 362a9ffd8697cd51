//! The k nearest places of every place, all at once.
//!
//! Places of a leaf share the walk through the tree: one search finds all leaves that can hold a neighbour of any of them. How far
//! neighbours lie is foreseen, and bounded, by those of places that are near (J. Sankaranarayanan, H. Samet, A. Varshney, Computers &
//! Graphics 31 (2007) 157-174, doi:10.1016/j.cag.2006.11.011, do the same with blocks of an octree).

use rayon::prelude::*;

use crate::cloud::{Cloud, CloudError, MOST_NEIGHBOURS, PlaceId};
use crate::tree::{Node, squared_distance};

/// The nearest places of every place, nearest first; of equal distances the smaller number first.
#[derive(Clone, Debug)]
pub struct Nearest {
    k: usize,
    ids: Vec<PlaceId>,
    distances_mm: Vec<f64>,
}

impl Nearest {
    /// How many neighbours each place has: as many as were asked for, or all other places.
    pub fn k(&self) -> usize {
        self.k
    }

    /// The neighbours of a place, nearest first.
    ///
    /// # Panics
    ///
    /// If there is no such place.
    pub fn neighbours(&self, place: PlaceId) -> &[PlaceId] {
        let at = place as usize * self.k;
        &self.ids[at..at + self.k]
    }

    /// The distances of the neighbours in mm, the least first.
    ///
    /// # Panics
    ///
    /// If there is no such place.
    pub fn distances_mm(&self, place: PlaceId) -> &[f64] {
        let at = place as usize * self.k;
        &self.distances_mm[at..at + self.k]
    }
}

impl<const D: usize> Cloud<D> {
    /// The `k` nearest other places of every place. n·(k + log n) time, 12·k bytes a place.
    ///
    /// # Errors
    ///
    /// Lists of more than [`MOST_NEIGHBOURS`].
    pub fn nearest(&self, k: usize) -> Result<Nearest, CloudError> {
        let k = k.min(self.len().saturating_sub(1));
        let found = k as u64 * self.len() as u64;
        if found > MOST_NEIGHBOURS {
            return Err(CloudError::TooManyNeighbours { found, places: self.len() });
        }
        let mut nearest =
            Nearest { k, ids: vec![0; k * self.len()], distances_mm: vec![0.0; k * self.len()] };
        if k == 0 {
            return Ok(nearest);
        }
        let leaves = self.leaves(k);
        let (mut ids, mut distances) = (&mut nearest.ids[..], &mut nearest.distances_mm[..]);
        let mut jobs = Vec::new();
        for run in leaves.chunks(RUN) {
            let places = run.iter().map(|&(leaf, _)| self.nodes[leaf as usize].len());
            let length = k * places.sum::<usize>();
            let (own, rest) = std::mem::take(&mut ids).split_at_mut(length);
            let (own_distances, rest_distances) =
                std::mem::take(&mut distances).split_at_mut(length);
            (ids, distances) = (rest, rest_distances);
            jobs.push((run, own, own_distances));
        }
        jobs.into_par_iter().for_each(|(run, ids, distances)| {
            let mut rows = ids.chunks_exact_mut(k).zip(distances.chunks_exact_mut(k));
            Search::new(self, k).leaves(run, |_, nearest| {
                nearest.sort_unstable();
                if let Some((ids, distances)) = rows.next() {
                    for ((id, distance), &entry) in ids.iter_mut().zip(distances).zip(&*nearest) {
                        (*id, *distance) = (entry.id(), entry.square().sqrt());
                    }
                }
            });
        });
        Ok(nearest)
    }

    /// Mean distance of a place to the nearest other place in mm: the spacing σ_P of the points. `None` of fewer than two
    /// places.
    pub fn spacing_mm(&self) -> Option<f64> {
        if self.len() < 2 {
            return None;
        }
        let leaves = self.leaves(1);
        let sums: Vec<f64> = leaves
            .par_chunks(RUN)
            .map(|run| {
                let mut search = Search::new(self, 1);
                let of_leaf = |leaf| {
                    let mut sum = 0.0;
                    search.leaf(leaf, &mut |_, nearest| sum += nearest[0].square().sqrt());
                    sum
                };
                run.iter().map(of_leaf).sum()
            })
            .collect();
        Some(sums.iter().sum::<f64>() / self.len() as f64)
    }

    /// Distances to the `k`-th neighbour in mm of some `count` places spread over all of them, in no order. Of fewer places than
    /// that, of all; the last neighbour where there are fewer than `k`.
    pub(crate) fn reach_of_some(&self, k: usize, count: usize) -> Vec<f64> {
        let k = k.min(self.len().saturating_sub(1));
        if k == 0 {
            return Vec::new();
        }
        let leaves = self.leaves(k);
        let step = (self.len() / count.max(1)).max(1);
        let chosen: Vec<(u32, u32)> = leaves.into_iter().step_by(step).collect();
        let runs = chosen.par_chunks(RUN).map(|run| {
            let mut found = Vec::new();
            Search::new(self, k)
                .leaves(run, |_, nearest| found.push(nearest[k - 1].square().sqrt()));
            found
        });
        runs.flatten_iter().collect()
    }

    /// Work on the `k` nearest other places of every place, the farthest of them last and the others in no order. The outcomes of runs of
    /// places follow one another.
    pub(crate) fn of_nearest<R: Send>(
        &self,
        k: usize,
        work: impl Fn(PlaceId, &mut [Entry], &mut Vec<R>) + Sync,
    ) -> Vec<Vec<R>> {
        let k = k.min(self.len().saturating_sub(1));
        if k == 0 {
            return Vec::new();
        }
        let leaves = self.leaves(k);
        let runs = leaves.par_chunks(RUN).map(|run| {
            let mut outcomes = Vec::new();
            Search::new(self, k).leaves(run, |place, nearest| work(place, nearest, &mut outcomes));
            outcomes
        });
        runs.collect()
    }

    /// Every leaf, with the smallest node about it that holds some three times `k` places.
    fn leaves(&self, k: usize) -> Vec<(u32, u32)> {
        let enough = 3 * k + 1;
        let mut leaves = Vec::new();
        let mut open = Vec::new();
        if !self.nodes.is_empty() {
            open.push((0_u32, 0_u32));
        }
        while let Some((at, around)) = open.pop() {
            let node = &self.nodes[at as usize];
            let around = if node.len() >= enough { at } else { around };
            if node.right == 0 {
                leaves.push((at, around));
            } else {
                open.push((at + node.right, around));
                open.push((at + 1, around));
            }
        }
        leaves
    }

    /// Visits all other places nearer to a place than `radius_mm`, each with its squared distance in mm².
    pub(crate) fn visit_within(
        &self,
        place: PlaceId,
        radius_mm: f64,
        mut take: impl FnMut(PlaceId, f64),
    ) {
        let at = &self.places()[place as usize];
        let limit = radius_mm * radius_mm;
        let mut open = vec![0_u32];
        while let Some(number) = open.pop() {
            let node = &self.nodes[number as usize];
            if node.squared_distance(at) >= limit {
                continue;
            }
            if node.right != 0 {
                open.extend([number + node.right, number + 1]);
                continue;
            }
            for other in node.first..node.end {
                let square = squared_distance(at, &self.places()[other as usize]);
                if square < limit && other != place {
                    take(other, square);
                }
            }
        }
    }
}

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
struct Search<'a, const D: usize> {
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
    fn new(cloud: &'a Cloud<D>, k: usize) -> Search<'a, D> {
        let (reached, open, near, known) = Default::default();
        let likely = 1.0 + LIKELY / (k as f64).sqrt();
        Search { cloud, k, likely, reached, open, near, known, next: None }
    }

    /// Gives the `k` nearest of every place of some leaves: see [`Search::leaf`].
    fn leaves(&mut self, leaves: &[(u32, u32)], mut take: impl FnMut(PlaceId, &mut [Entry])) {
        leaves.iter().for_each(|leaf| self.leaf(leaf, &mut take));
    }

    /// Gives the `k` nearest of every place of a leaf, the farthest of them last and the others in no order.
    fn leaf(&mut self, &(leaf, around): &(u32, u32), take: &mut impl FnMut(PlaceId, &mut [Entry])) {
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
            let nearest = select(&mut self.near[..count], self.k);
            let reach_mm = nearest[self.k - 1].square().sqrt();
            take(place, nearest);
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

/// Leaves that one job takes.
const RUN: usize = 128;

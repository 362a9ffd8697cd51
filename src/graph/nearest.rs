//! The k nearest places of every place, all at once.
//!
//! Places of a leaf share the walk through the tree: bounds come from the places around the leaf, then one search finds
//! all leaves that can hold a nearer place of any of them (J. Sankaranarayanan, H. Samet, A. Varshney, Computers &
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
            let mut search = Search::new(self, k);
            let mut at = 0;
            for &(leaf, around) in run {
                let (found, squares) = search.leaf(leaf, around);
                ids[at..at + found.len()].copy_from_slice(found);
                for (distance, square) in distances[at..].iter_mut().zip(squares) {
                    *distance = square.sqrt();
                }
                at += found.len();
            }
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
                let of_leaf = |&(leaf, around): &(u32, u32)| {
                    search.leaf(leaf, around).1.iter().map(|square| square.sqrt()).sum::<f64>()
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
            let mut search = Search::new(self, k);
            let mut found = Vec::new();
            for &(leaf, around) in run {
                let (_, squares) = search.leaf(leaf, around);
                found.extend(squares.iter().skip(k - 1).step_by(k).map(|square| square.sqrt()));
            }
            found
        });
        runs.flatten_iter().collect()
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

/// Memory of one thread that searches for the neighbours of leaves.
struct Search<'a, const D: usize> {
    cloud: &'a Cloud<D>,
    k: usize,
    squares: Vec<f64>,
    ids: Vec<PlaceId>,
    reached: Vec<u32>,
    open: Vec<u32>,
}

impl<'a, const D: usize> Search<'a, D> {
    fn new(cloud: &'a Cloud<D>, k: usize) -> Search<'a, D> {
        Search {
            cloud,
            k,
            squares: Vec::new(),
            ids: Vec::new(),
            reached: Vec::new(),
            open: Vec::new(),
        }
    }

    /// The neighbours of all places of a leaf, with the squares of their distances in mm².
    fn leaf(&mut self, leaf: u32, around: u32) -> (&[PlaceId], &[f64]) {
        let nodes = &self.cloud.nodes;
        let (own, about) = (&nodes[leaf as usize], &nodes[around as usize]);
        let length = self.k * own.len();
        self.squares.clear();
        self.squares.resize(length, f64::INFINITY);
        self.ids.clear();
        self.ids.resize(length, PlaceId::MAX);
        let rows = self.squares.chunks_exact_mut(self.k).zip(self.ids.chunks_exact_mut(self.k));
        let mut farthest: f64 = 0.0;
        for (place, (squares, ids)) in (own.first..own.end).zip(rows) {
            let mut list = List { squares, ids };
            list.scan(self.cloud, place, about.first, about.end);
            farthest = farthest.max(list.limit());
        }
        self.reach(own, around, farthest);
        let rows = self.squares.chunks_exact_mut(self.k).zip(self.ids.chunks_exact_mut(self.k));
        for (place, (squares, ids)) in (own.first..own.end).zip(rows) {
            let mut list = List { squares, ids };
            let at = &self.cloud.places()[place as usize];
            for &other in &self.reached {
                let other = &nodes[other as usize];
                if other.squared_distance(at) <= list.limit() {
                    list.scan(self.cloud, place, other.first, other.end);
                }
            }
        }
        (&self.ids, &self.squares)
    }

    /// Lists the leaves outside of `around` no farther from a leaf than the root of `limit`.
    fn reach(&mut self, own: &Node<D>, around: u32, limit: f64) {
        let nodes = &self.cloud.nodes;
        self.reached.clear();
        self.open.clear();
        self.open.push(0);
        while let Some(at) = self.open.pop() {
            let node = &nodes[at as usize];
            if at == around || node.squared_gap(own) > limit {
                continue;
            }
            if node.right == 0 {
                self.reached.push(at);
            } else {
                self.open.extend([at + node.right, at + 1]);
            }
        }
    }
}

/// The nearest places found so far of one place, nearest first.
struct List<'a> {
    squares: &'a mut [f64],
    ids: &'a mut [PlaceId],
}

impl List<'_> {
    /// Square of the largest distance in the list, mm²; infinite until it is full.
    fn limit(&self) -> f64 {
        self.squares[self.squares.len() - 1]
    }

    fn scan<const D: usize>(&mut self, cloud: &Cloud<D>, place: PlaceId, first: u32, end: u32) {
        let at = &cloud.places()[place as usize];
        let others = &cloud.places()[first as usize..end as usize];
        for (other, position) in (first..end).zip(others) {
            let square = squared_distance(at, position);
            if square <= self.limit() && other != place {
                self.insert(square, other);
            }
        }
    }

    fn insert(&mut self, square: f64, id: PlaceId) {
        let mut at = self.squares.len();
        while at > 0 && (square, id) < (self.squares[at - 1], self.ids[at - 1]) {
            at -= 1;
        }
        if at < self.squares.len() {
            let last = self.squares.len() - 1;
            self.squares.copy_within(at..last, at + 1);
            self.ids.copy_within(at..last, at + 1);
            (self.squares[at], self.ids[at]) = (square, id);
        }
    }
}

/// Leaves that one job takes.
const RUN: usize = 128;

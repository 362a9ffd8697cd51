//! The k nearest places of every place, all at once.

mod search;

use rayon::prelude::*;

pub(crate) use self::search::Entry;
use self::search::Search;
use crate::cloud::{Cloud, CloudError, MOST_NEIGHBOURS, PlaceId};
use crate::tree::squared_distance;

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
        let runs = self.of_nearest(1, |_, found, nearest_mm: &mut Vec<f64>| {
            let square = found.iter().min().map_or(0.0, |nearest| nearest.square());
            nearest_mm.push(square.sqrt());
            square
        });
        Some(self.mean_by_leaves(&runs.concat()))
    }

    /// The mean of a value a place, by sums of leaves. It does not depend on the order of the points or the threads.
    pub(crate) fn mean_by_leaves(&self, of_place: &[f64]) -> f64 {
        let of_leaf = |&(leaf, _): &(u32, u32)| -> f64 {
            let leaf = &self.nodes[leaf as usize];
            of_place[leaf.first as usize..leaf.end as usize].iter().sum()
        };
        let leaves = self.leaves(1);
        let sums = leaves.chunks(RUN).map(|run| run.iter().map(of_leaf).sum::<f64>());
        sums.sum::<f64>() / self.len() as f64
    }

    /// Distances to the `k`-th neighbour in mm of some `count` places spread over all of them, in no order. Of fewer places than
    /// that, of all; the last neighbour where there are fewer than `k`.
    pub(crate) fn reach_of_some(&self, k: usize, count: usize) -> Vec<f64> {
        let k = k.min(self.len().saturating_sub(1));
        if k == 0 {
            return Vec::new();
        }
        let chosen = self.some_leaves(k, count);
        let runs = chosen.par_chunks(RUN).map(|run| {
            let mut found = Vec::new();
            Search::new(self, k)
                .leaves(run, |_, nearest| found.push(nearest[k - 1].square().sqrt()));
            found
        });
        runs.flatten_iter().collect()
    }

    /// Some `count` places spread over all of them: those of [`Cloud::reach_of_some`].
    pub(crate) fn some_places(&self, count: usize) -> impl Iterator<Item = PlaceId> {
        let leaves = self.some_leaves(1, count).into_iter();
        leaves.map(|(leaf, _)| &self.nodes[leaf as usize]).flat_map(|leaf| leaf.first..leaf.end)
    }

    fn some_leaves(&self, k: usize, count: usize) -> Vec<(u32, u32)> {
        let step = (self.len() / count.max(1)).max(1);
        self.leaves(k).into_iter().step_by(step).collect()
    }

    /// Work on places near every place, in no order, the `k` nearest others among them. The work gives the square of the distance to the
    /// `k`-th in mm². Runs of places, which follow one another, have an outcome each.
    pub(crate) fn of_nearest<R: Default + Send>(
        &self,
        k: usize,
        work: impl Fn(PlaceId, &mut [Entry], &mut R) -> f64 + Sync,
    ) -> Vec<R> {
        let k = k.min(self.len().saturating_sub(1));
        if k == 0 {
            return Vec::new();
        }
        let leaves = self.leaves(k);
        let runs = leaves.par_chunks(RUN).map(|run| {
            let (mut search, mut outcome) = (Search::new(self, k), R::default());
            let mut work = |place, found: &mut [Entry]| work(place, found, &mut outcome);
            run.iter().for_each(|leaf| search.leaf(leaf, &mut work));
            outcome
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
        self.visit_about(&self.places()[place as usize], radius_mm, |other, square| {
            if other != place {
                take(other, square);
            }
        });
    }

    /// Visits all places nearer to any point than `radius_mm`, each with its squared distance in mm².
    pub(crate) fn visit_about(
        &self,
        at: &[f64; D],
        radius_mm: f64,
        mut take: impl FnMut(PlaceId, f64),
    ) {
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
                if square < limit {
                    take(other, square);
                }
            }
        }
    }
}

/// Leaves that one job takes.
const RUN: usize = 128;

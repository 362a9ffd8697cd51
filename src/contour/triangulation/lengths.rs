//! The edges in the order of their lengths.

use std::cmp::Ordering;
use std::iter;
use std::sync::OnceLock;

use asphera_geometry::predicates::{certain_distances, compare_distances, squared_distance};
use rayon::prelude::*;

use super::EdgeId;
use crate::counting::{Entry, entry, key, number, sort_by_key};
use crate::samples::PlaceMm;

/// The edges in the order of their lengths.
pub(super) struct Lengths {
    /// All edges, shortest first, equal ones by their numbers.
    pub(super) sorted: Vec<EdgeId>,
    /// Whether each of them is longer than the one before it.
    is_longer: Vec<bool>,
    classes: OnceLock<Vec<u32>>,
}

impl Lengths {
    /// The order of `count` edges with these ends in mm, decided exactly; linear time where few are nearly as long as others.
    pub(super) fn new(count: usize, ends: impl Fn(EdgeId) -> [PlaceMm; 2] + Sync) -> Lengths {
        let numbers = (0..count as EdgeId).into_par_iter();
        let squares: Vec<f64> = numbers
            .map(|edge| {
                let [p, q] = ends(edge);
                squared_distance(p, q)
            })
            .collect();
        let square = |of: Entry| squares[number(of) as usize];
        // Squares are above 0: they order as their bits do, of which the upper ones part most.
        let bits = squares.iter().map(|square| (square.to_bits() >> 31) as u32);
        let mut entries: Vec<Entry> = bits.zip(0..).map(|(bits, edge)| entry(bits, edge)).collect();
        sort_by_key(&mut entries);
        for run in entries.chunk_by_mut(|&a, &b| key(a) == key(b)).filter(|run| run.len() > 1) {
            run.par_sort_unstable_by(|&a, &b| square(a).total_cmp(&square(b)).then(a.cmp(&b)));
        }
        // Rounding hides the order of neighbours alone: between two that it tells apart it does so for all before and behind.
        let exact = |a: Entry, b: Entry| -> Ordering {
            certain_distances(square(a), square(b)).unwrap_or_else(|| {
                let ([p, q], [r, s]) = (ends(number(a)), ends(number(b)));
                compare_distances(p, q, r, s)
            })
        };
        let is_open = |a: &Entry, b: &Entry| certain_distances(square(*a), square(*b)).is_none();
        for run in entries.chunk_by_mut(is_open).filter(|run| run.len() > 1) {
            run.par_sort_unstable_by(|&a, &b| exact(a, b).then(number(a).cmp(&number(b))));
        }
        let is_longer = entries.windows(2).map(|pair| exact(pair[0], pair[1]).is_ne());
        Lengths {
            is_longer: iter::once(false).chain(is_longer).collect(),
            sorted: entries.into_iter().map(number).collect(),
            classes: OnceLock::new(),
        }
    }

    /// Rank of the length of each edge; edges of exactly the same length have the same.
    pub(super) fn classes(&self) -> &[u32] {
        self.classes.get_or_init(|| {
            let mut classes = vec![0; self.sorted.len()];
            let mut class = 0;
            for (&edge, &is_longer) in self.sorted.iter().zip(&self.is_longer) {
                class += u32::from(is_longer);
                classes[edge as usize] = class;
            }
            classes
        })
    }
}

#[cfg(test)]
mod tests {
    use asphera_geometry::Numbers;

    use super::*;

    /// Edges from the origin: turned lattices, whose equal lengths rounding tells apart, steps of last bits, and random ones.
    fn ends(edge: EdgeId) -> [PlaceMm; 2] {
        let numbers = Numbers::new(7, 0, 0);
        let step = |at: u32| f64::from(edge / at % 5 + 1);
        let to = match edge % 4 {
            0 => [step(4), step(20)],
            1 => [0.6 * step(4) - 0.8 * step(20), 0.8 * step(4) + 0.6 * step(20)],
            2 => [1.0 + f64::from(edge % 32) * f64::EPSILON, 1.0],
            _ => [numbers.normal(edge as usize), numbers.normal(edge as usize + 1_000_000)],
        };
        [[0.0; 2], to]
    }

    #[test]
    fn they_are_those_of_a_sort_by_exact_comparisons() {
        for count in [0, 1, 50, 4_000] {
            let lengths = Lengths::new(count, ends);
            let exact = |&a: &EdgeId, &b: &EdgeId| {
                let ([p, q], [r, s]) = (ends(a), ends(b));
                compare_distances(p, q, r, s)
            };
            let mut expected: Vec<EdgeId> = (0..count as EdgeId).collect();
            expected.sort_by(exact);
            assert_eq!(lengths.sorted, expected);
            for pair in expected.windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|edge| lengths.classes()[edge as usize]);
                assert_eq!(b - a, u32::from(exact(&pair[0], &pair[1]).is_ne()));
            }
        }
    }
}

//! The edges in the order of their lengths.

use std::cmp::Ordering;
use std::sync::OnceLock;

use asphera_geometry::predicates::{certain_distances, compare_distances, squared_distance};
use rayon::prelude::*;

use super::{EdgeId, Triangulation};
use crate::counting::{Entry, entry, key, number, sort_by_key};
use crate::samples::PlaceMm;

/// The edges in the order of their lengths.
pub(super) struct Lengths {
    /// All edges, shortest first, equal ones by their numbers.
    pub(super) sorted: Vec<EdgeId>,
    /// Whether each of them is as long as the one before it.
    is_equal: Vec<bool>,
    classes: OnceLock<Vec<u32>>,
}

impl Lengths {
    /// The order of `count` edges with these ends in mm, decided exactly; linear time where few are nearly as long as others.
    pub(super) fn new(count: usize, ends: impl Fn(EdgeId) -> [PlaceMm; 2] + Sync) -> Lengths {
        let (entries, is_equal) = sorted(count, ends);
        Lengths {
            is_equal,
            sorted: entries.into_iter().map(number).collect(),
            classes: OnceLock::new(),
        }
    }

    /// Rank of the length of each edge; edges of exactly the same length have the same.
    pub(super) fn classes(&self) -> &[u32] {
        self.classes.get_or_init(|| {
            let mut classes = vec![0; self.sorted.len()];
            let mut class = 0;
            for (index, (&edge, &is_equal)) in self.sorted.iter().zip(&self.is_equal).enumerate() {
                class += u32::from(index > 0 && !is_equal);
                classes[edge as usize] = class;
            }
            classes
        })
    }
}

/// The square of an edge's length in mm², and its key.
///
/// Squares are above 0: they order as their bits do, of which the upper ones part most.
fn square_and_key([p, q]: [PlaceMm; 2]) -> (f64, u32) {
    let square = squared_distance(p, q);
    (square, (square.to_bits() >> 31) as u32)
}

/// The entries of edges in the order of their lengths, equal ones by their numbers, and whether each is as long as the one before it.
fn sorted(count: usize, ends: impl Fn(EdgeId) -> [PlaceMm; 2] + Sync) -> (Vec<Entry>, Vec<bool>) {
    let numbers = (0..count as EdgeId).into_par_iter();
    let squares: Vec<f64> = numbers.map(|edge| square_and_key(ends(edge)).0).collect();
    let square = |of: Entry| squares[number(of) as usize];
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
    // Keys that are two apart part squares by more than rounding: only few need to be fetched, from all over memory.
    let is_open = |a: &Entry, b: &Entry| {
        key(*b) - key(*a) < 2 && certain_distances(square(*a), square(*b)).is_none()
    };
    let (mut is_equal, mut first) = (vec![false; count], 0);
    for run in entries.chunk_by_mut(is_open) {
        if run.len() > 1 {
            run.par_sort_unstable_by(|&a, &b| exact(a, b).then(number(a).cmp(&number(b))));
            for (at, pair) in (first + 1..).zip(run.windows(2)) {
                is_equal[at] = exact(pair[0], pair[1]).is_eq();
            }
        }
        first += run.len();
    }
    (entries, is_equal)
}

impl Triangulation {
    /// Edges, given by their numbers, in the order of their lengths, equal ones by their numbers.
    pub(crate) fn sorted_by_length(&self, edges: &[EdgeId]) -> Vec<EdgeId> {
        let (entries, _) = sorted(edges.len(), |index| self.ends_mm(edges[index as usize]));
        entries.into_iter().map(|entry| edges[number(entry) as usize]).collect()
    }

    /// The shortest edges, at least so many of them, and the others; both by their numbers.
    ///
    /// A method that is mostly done after the shortest need not have all sorted.
    pub(crate) fn parted_by_length(&self, shortest: usize) -> [Vec<EdgeId>; 2] {
        let numbers = 0..self.edges().len() as EdgeId;
        if numbers.len() < MANY {
            return [numbers.collect(), Vec::new()];
        }
        let upper = |edge: EdgeId| square_and_key(self.ends_mm(edge)).1 >> 16;
        let keys: Vec<u16> = numbers.clone().map(|edge| upper(edge) as u16).collect();
        let mut counts = vec![0_usize; 1 << 16];
        keys.iter().for_each(|&key| counts[usize::from(key)] += 1);
        let mut sum = 0;
        let last = counts.iter().position(|count| {
            sum += count;
            sum >= shortest
        });
        let last = last.unwrap_or(counts.len());
        let (short, long) = numbers.partition(|&edge| usize::from(keys[edge as usize]) <= last);
        [short, long]
    }
}

/// Fewer edges are sorted as fast as they are parted.
const MANY: usize = 1 << 12;

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

    #[test]
    fn those_of_a_part_are_in_the_order_of_all() {
        let numbers = Numbers::new(9, 0, 0);
        let random = |at: usize| [numbers.normal(at), numbers.normal(at + 1_000_000)];
        let raster = |at: usize| [(at % 70) as f64 * 0.1, (at / 70) as f64 * 0.1];
        for place in [&random as &dyn Fn(usize) -> PlaceMm, &raster] {
            for count in [40, 4_000] {
                let places: Vec<PlaceMm> = (0..count).map(place).collect();
                let samples = crate::Samples::new(&places).expect("finite places");
                let set = Triangulation::new(samples);
                let [short, long] = set.parted_by_length(count);
                assert!(short.len() >= count.min(set.edges().len()));
                assert!(short.is_sorted() && long.is_sorted());
                let parts = [short, long].map(|part| set.sorted_by_length(&part));
                assert_eq!(parts.concat(), set.by_length());
            }
        }
    }
}

//! Windows of places: squares within squares, each with the mean of the heights in it.
//!
//! Places are sorted along Morton's curve, so that those of any square of a quadtree stand one after the other (Samet,
//! Foundations of Multidimensional and Metric Data Structures, 1.4). A mean over a window is nowhere above the highest of
//! its places, and knows their noise averaged.

use asphera_geometry::{BoundsMm, along_morton};
use rayon::prelude::*;

/// Places in the order of the curve, and the squares over them.
pub(super) struct Windows {
    /// Indices of places, along the curve.
    pub(super) order: Vec<u32>,
    /// Squares with two places or more; of those with the same places one.
    pub(super) windows: Vec<Window>,
    /// The coarse square each of `order` lies in.
    pub(super) cell_of: Vec<u32>,
    /// A place near the middle of each coarse square.
    pub(super) middles: Vec<u32>,
}

/// A run of the order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window {
    pub(super) first: u32,
    pub(super) count: u32,
    /// Mean of the heights.
    pub(super) mean: f64,
    /// Variance that their noise leaves in it.
    pub(super) variance: f64,
}

impl Window {
    /// Where in the order its middle is: the last of the four squares it has begins there.
    pub(super) fn middle(&self) -> usize {
        (u64::from(self.first) + 3 * u64::from(self.count) / 4) as usize
    }
}

impl Windows {
    /// `variances` are those of independent noise at each place. `O(n log n)`; up to 2³² places.
    pub(super) fn new(places_mm: &[[f64; 2]], heights: &[f64], variances: &[f64]) -> Windows {
        let depth = depth(places_mm.len());
        let keys = keys(places_mm, depth);
        let mut order: Vec<u32> = (0..places_mm.len() as u32).collect();
        order.par_sort_unstable_by_key(|&place| (keys[place as usize], place));
        let along: Vec<u32> = order.iter().map(|&place| keys[place as usize]).collect();
        let of_level = |level: u32| {
            let (shift, finer) = (2 * (depth - level), 2 * (depth - level).saturating_sub(1));
            let mut found = Vec::new();
            let mut first = 0;
            for run in along.chunk_by(|a, b| a >> shift == b >> shift) {
                let whole_is_new = level == depth || run[0] >> finer != run[run.len() - 1] >> finer;
                if run.len() > 1 && whole_is_new {
                    let count = run.len() as f64;
                    let [mut height, mut variance] = [0.0; 2];
                    for &place in &order[first..first + run.len()] {
                        height += heights[place as usize];
                        variance += variances[place as usize];
                    }
                    found.push(Window {
                        first: first as u32,
                        count: run.len() as u32,
                        mean: height / count,
                        variance: variance / (count * count),
                    });
                }
                first += run.len();
            }
            found
        };
        let levels: Vec<Vec<Window>> = (COARSEST..=depth).into_par_iter().map(of_level).collect();
        let shift = 2 * depth.saturating_sub(CELLS);
        let (mut cell_of, mut middles) = (Vec::with_capacity(order.len()), Vec::new());
        for run in along.chunk_by(|a, b| a >> shift == b >> shift) {
            middles.push(order[cell_of.len() + 3 * run.len() / 4]);
            cell_of.resize(cell_of.len() + run.len(), middles.len() as u32 - 1);
        }
        Windows { order, windows: levels.concat(), cell_of, middles }
    }
}

/// Halvings of the side until there are some four squares a place.
fn depth(places: usize) -> u32 {
    let mut depth = COARSEST;
    while depth < DEEPEST && 1_usize << (2 * depth) < 4 * places {
        depth += 1;
    }
    depth
}

/// Places on Morton's curve: bits of x and y in turn, over the square that holds all.
fn keys(places_mm: &[[f64; 2]], depth: u32) -> Vec<u32> {
    let BoundsMm { low, high } = BoundsMm::about(places_mm.iter().copied());
    let side_mm = (high[0] - low[0]).max(high[1] - low[1]).max(f64::MIN_POSITIVE);
    let squares = 1_u32 << depth;
    let key = |place: &[f64; 2]| {
        along_morton([0, 1].map(|axis| {
            let share = (place[axis] - low[axis]) / side_mm;
            ((share * f64::from(squares)) as u32).min(squares - 1) as u16
        }))
    };
    places_mm.par_iter().map(key).collect()
}

/// The largest windows: a quarter of the side of the part.
const COARSEST: u32 = 2;
/// As far as a key has bits.
const DEEPEST: u32 = 16;
/// Coarse squares: 32 by 32.
const CELLS: u32 = 5;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_a_lattice_hold_4_16_and_64_places() {
        let places: Vec<[f64; 2]> =
            (0..1024).map(|i| [f64::from(i % 32), f64::from(i / 32)]).collect();
        let heights: Vec<f64> = places.iter().map(|[x, y]| 3.0 * x - 2.0 * y).collect();
        let found = Windows::new(&places, &heights, &[16.0; 1024]);
        let mut counts = std::collections::BTreeMap::new();
        for window in &found.windows {
            *counts.entry(window.count).or_insert(0) += 1;
            assert_eq!(window.variance, 16.0 / f64::from(window.count));
            let run = &found.order[window.first as usize..][..window.count as usize];
            let (mut low, mut high, mut sum) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2], 0.0);
            for &place in run {
                for axis in 0..2 {
                    low[axis] = low[axis].min(places[place as usize][axis]);
                    high[axis] = high[axis].max(places[place as usize][axis]);
                }
                sum += heights[place as usize];
            }
            assert!((window.mean - sum / run.len() as f64).abs() < 1e-12);
            let area = (high[0] - low[0] + 1.0) * (high[1] - low[1] + 1.0);
            assert_eq!(area, f64::from(window.count), "its places are those of a square");
        }
        assert_eq!(counts.into_iter().collect::<Vec<_>>(), [(4, 256), (16, 64), (64, 16)]);
        assert_eq!(found.middles.len(), 1024);
    }

    #[test]
    fn one_place_none_the_same_and_a_line() {
        let of = |places: &[[f64; 2]]| {
            let heights = vec![1.0; places.len()];
            Windows::new(places, &heights, &heights)
        };
        assert!(of(&[]).windows.is_empty() && of(&[[3.0, 4.0]]).windows.is_empty());
        let same = of(&[[1e6, -1e6]; 50]);
        assert_eq!((same.windows.len(), same.windows[0].count), (1, 50));
        let line: Vec<[f64; 2]> = (0..256).map(|i| [f64::from(i), 7.0]).collect();
        let largest = of(&line).windows.iter().map(|window| window.count).max();
        assert_eq!(largest, Some(64));
    }
}

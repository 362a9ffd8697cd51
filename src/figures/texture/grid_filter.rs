//! Regression with Gaussian weights on a grid.

use rayon::prelude::*;

use super::regression::{FittedNode, MOMENTS, Sums, TERMS, terms_of};
use super::{Grid, Order};

/// The weights of a filter along the rows and columns of a grid.
///
/// A weight is a product of one along x and one along y, and so is its product with u^i·v^j. Therefore each
/// moment about all nodes is a convolution of the weights of the nodes along x, then along y: gaps are nodes
/// of weight 0.
pub(super) struct GridFilter<'a> {
    grid: &'a Grid,
    along_x: Taps,
    along_y: Taps,
    terms: Vec<usize>,
    /// Powers of u that are convolved along x: of the weights, then of the weighted heights.
    powers: [usize; 2],
    /// Convolutions along y, those of the weights first.
    products: Vec<Product>,
    /// The mean of the measured heights, about which sums are formed.
    about_nm: f64,
}

/// A moment as the convolution along y of a plane of sums along x.
struct Product {
    plane: usize,
    power: usize,
    /// Which of the moments of the weights it is, or of the heights.
    target: Target,
}

#[derive(Clone, Copy)]
enum Target {
    Moment(usize),
    Height(usize),
}

/// exp(−πu²)·u^i at the nodes from −reach to reach, for i from 0.
struct Taps {
    reach: usize,
    powers: Vec<Vec<f64>>,
}

impl Taps {
    fn new(spacing_mm: f64, unit_mm: f64, window_mm: f64, nodes: usize) -> Taps {
        let reach = (window_mm / spacing_mm).min(nodes.saturating_sub(1) as f64) as usize;
        let at = |k: usize| (k as f64 - reach as f64) * spacing_mm / unit_mm;
        let tap = |u: f64, i: i32| (-std::f64::consts::PI * u * u).exp() * u.powi(i);
        let taps = |i: i32| (0..=2 * reach).map(|k| tap(at(k), i)).collect();
        Taps { reach, powers: (0..=4).map(taps).collect() }
    }
}

impl GridFilter<'_> {
    pub(super) fn new(grid: &Grid, unit_mm: f64, window_mm: f64, order: Order) -> GridFilter<'_> {
        let [dx, dy] = grid.spacing_mm();
        let (rows, columns) = (grid.rows(), grid.columns());
        let powers = match order {
            Order::Zero => [1, 1],
            Order::Two => [5, 3],
        };
        let moments = MOMENTS.iter().enumerate().filter(|(_, (i, j))| i + j < powers[0]);
        let moments =
            moments.map(|(n, &(i, j))| Product { plane: i, power: j, target: Target::Moment(n) });
        let heights = TERMS.iter().enumerate().filter(|(_, (i, j))| i + j < powers[1]);
        let heights = heights.map(|(n, &(i, j))| Product {
            plane: powers[0] + i,
            power: j,
            target: Target::Height(n),
        });
        GridFilter {
            grid,
            along_x: Taps::new(dx, unit_mm, window_mm, columns),
            along_y: Taps::new(dy, unit_mm, window_mm, rows),
            terms: terms_of(order, columns > 1, rows > 1),
            powers,
            products: moments.chain(heights).collect(),
            about_nm: grid.nodes().map_or(0.0, |nodes| {
                let first = nodes.heights_nm[0];
                first + nodes.mean(|i| nodes.heights_nm[i] - first)
            }),
        }
    }

    /// How many terms a full neighbourhood determines.
    pub(super) fn terms(&self) -> u8 {
        self.terms.len() as u8
    }

    /// The polynomial about each node, for weights of the nodes, which are 0 at gaps.
    pub(super) fn fit(&self, weights: &[f64]) -> Vec<FittedNode> {
        let columns = self.grid.columns();
        if weights.is_empty() {
            return Vec::new();
        }
        let planes = self.powers[0] + self.powers[1];
        let mut along_x = vec![0.0; planes * weights.len()];
        along_x.par_chunks_mut(planes * columns).enumerate().for_each(|(row, sums)| {
            let begin = row * columns;
            let weights = &weights[begin..begin + columns];
            let height = |(x, weight): (usize, &f64)| match self.grid.at(begin + x) {
                Some(height_nm) => weight * (height_nm - self.about_nm),
                None => 0.0,
            };
            let heights: Vec<f64> = weights.iter().enumerate().map(height).collect();
            for (plane, sums) in sums.chunks_exact_mut(columns).enumerate() {
                let (values, power) = match plane.checked_sub(self.powers[0]) {
                    None => (weights, plane),
                    Some(power) => (&heights[..], power),
                };
                self.convolve(values, power, sums);
            }
        });
        let mut fitted = vec![FittedNode::default(); weights.len()];
        fitted
            .par_chunks_mut(columns)
            .enumerate()
            .for_each(|(row, fitted)| self.fit_row(row, &along_x, fitted));
        fitted
    }

    /// Convolution of a row with one power of the taps.
    fn convolve(&self, values: &[f64], power: usize, sums: &mut [f64]) {
        let (reach, columns) = (self.along_x.reach, values.len());
        for (k, tap) in self.along_x.powers[power].iter().enumerate() {
            // The node x gets the value at x + k − reach.
            let first = reach.saturating_sub(k);
            let end = columns.min(columns + reach - k);
            let from = first + k - reach;
            for (sum, value) in sums[first..end].iter_mut().zip(&values[from..]) {
                *sum += tap * value;
            }
        }
    }

    fn fit_row(&self, row: usize, along_x: &[f64], fitted: &mut [FittedNode]) {
        let (rows, columns) = (self.grid.rows(), self.grid.columns());
        let measured = |x: usize| self.grid.at(row * columns + x).is_some();
        if !(0..columns).any(measured) {
            return;
        }
        let size = (self.powers[0] + self.powers[1]) * columns;
        let mut sums = vec![0.0; self.products.len() * columns];
        let reach = self.along_y.reach;
        for source in row.saturating_sub(reach)..rows.min(row + reach + 1) {
            let planes = &along_x[source * size..(source + 1) * size];
            for (product, sums) in self.products.iter().zip(sums.chunks_exact_mut(columns)) {
                let tap = self.along_y.powers[product.power][source + reach - row];
                let values = &planes[product.plane * columns..(product.plane + 1) * columns];
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += tap * value;
                }
            }
        }
        for (x, fitted) in fitted.iter_mut().enumerate().filter(|(x, _)| measured(*x)) {
            let mut node = Sums::default();
            for (n, product) in self.products.iter().enumerate() {
                let sum = sums[n * columns + x];
                match product.target {
                    Target::Moment(moment) => node.moments[moment] = sum,
                    Target::Height(term) => node.heights[term] = sum,
                }
            }
            *fitted = node.fit(&self.terms);
            fitted.value_nm += self.about_nm;
        }
    }
}

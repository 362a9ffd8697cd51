//! Expansion: the coefficients of values at scattered places in a basis, by least squares.
//!
//! Two passes over the points. The first sums the normal equations; the second sums the residuals of their
//! solution, which gives the residual figures without cancellation and one step of refinement. Points are
//! taken in blocks within fixed chunks, and chunks are joined as a fixed binary tree: the result depends on
//! the order of the points in the last bits, but never on the number of threads.

use std::ops::Range;

use nalgebra::DMatrix;
use rayon::prelude::*;
use thiserror::Error;

use super::gram::{Gram, dot};
use super::normal::Normal;
use super::{Basis, LANES, Scale};

/// Coefficients of values in a basis.
#[derive(Clone, Debug, PartialEq)]
pub struct Expansion {
    /// The coefficient of every term, in the unit of the values; `None` where the places do not determine it
    /// (the value of every coefficient then is that of a fit without these terms).
    pub coefficients: Vec<Option<f64>>,
    /// Names of the terms without a coefficient.
    pub indeterminate: Vec<String>,
    /// Largest over smallest singular value of the matrix of the other terms at the places, its columns
    /// scaled to unit length: 1 if they are orthogonal over the places. Coefficients lose about its
    /// logarithm in digits, and noise is amplified by up to it.
    pub condition: f64,
    /// Points the expansion is over.
    pub used: usize,
    /// Points left out because place, value or weight was not finite.
    pub not_finite: usize,
    /// Points left out because the basis is not defined there.
    pub outside: usize,
    /// Root of the (weighted) mean square of what the terms leave, in the unit of the values.
    pub residual_rms: f64,
    /// The largest residual in size.
    pub largest_residual: LargestResidual,
    covariance: Option<DMatrix<f64>>,
    kept: Vec<usize>,
}

/// The largest residual and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LargestResidual {
    /// Value minus expansion, in the unit of the values.
    pub residual: f64,
    /// Index of the point; of equal ones the first.
    pub index: usize,
}

/// Why there is no expansion.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ExpandError {
    /// Lists of different lengths.
    #[error("{places} places with {values} values and {weights} weights, expected as many of each")]
    Lengths {
        /// Places given.
        places: usize,
        /// Values given.
        values: usize,
        /// Weights given; as many as places if there are none.
        weights: usize,
    },
    /// A weight below zero.
    #[error("weight {index} is {weight}, expected zero or a positive number")]
    Weight {
        /// Index of the point.
        index: usize,
        /// Its weight.
        weight: f64,
    },
    /// Every place lies where the basis is not defined.
    #[error(
        "none of {outside} points lies where the {kind} is defined: \
         half width {half_x_mm} mm by {half_y_mm} mm, nearest point at {nearest_mm} mm, farthest at \
         {farthest_mm} mm from the axis; normalise by at least the latter or centre the points"
    )]
    Outside {
        /// The basis.
        kind: &'static str,
        /// Finite points, all of them outside.
        outside: usize,
        /// Half width or radius along x, in mm.
        half_x_mm: f64,
        /// Half width or radius along y, in mm.
        half_y_mm: f64,
        /// Distance of the nearest of them from the axis, in mm.
        nearest_mm: f64,
        /// Distance of the farthest of them from the axis, in mm.
        farthest_mm: f64,
    },
    /// Fewer points than terms.
    #[error(
        "{used} usable points for {terms} terms of the {kind} ({outside} more lie outside its domain, \
         {not_finite} are not finite): give more points or fewer terms"
    )]
    TooFew {
        /// The basis.
        kind: &'static str,
        /// Points that could be used.
        used: usize,
        /// Terms asked for.
        terms: usize,
        /// Points outside the domain.
        outside: usize,
        /// Points that are not finite.
        not_finite: usize,
    },
    /// Sums that overflowed.
    #[error("the values are too large: the sum of their squares is not finite")]
    Overflow,
}

impl Expansion {
    /// Covariance of two coefficients in the square of the unit of the values, from σ²·(AᵀWA)⁻¹ with σ² the
    /// weighted square of the residuals over the degrees of freedom. `None` for an indeterminate term and
    /// without degrees of freedom.
    ///
    /// It takes the residuals for noise without correlation and the weights for reciprocal variances; what
    /// other terms would still explain, and weights that are areas, make it an estimate.
    pub fn covariance(&self, term: usize, other: usize) -> Option<f64> {
        let row = self.kept.binary_search(&term).ok()?;
        let column = self.kept.binary_search(&other).ok()?;
        Some(self.covariance.as_ref()?[(row, column)])
    }

    /// Standard uncertainty (k = 1) of a coefficient: the root of its variance.
    pub fn u(&self, term: usize) -> Option<f64> {
        self.covariance(term, term).map(f64::sqrt)
    }

    /// The coefficients with 0 for the indeterminate ones: what [`residuals`] takes.
    pub fn filled(&self) -> Vec<f64> {
        self.coefficients.iter().map(|coefficient| coefficient.unwrap_or(0.0)).collect()
    }
}

/// Coefficients of `values` at `places_mm` (x, y in mm), so that the sum of the squares of the residuals,
/// each times its weight if there are weights, is least. `O(n·terms²)`.
///
/// A term that the terms before it already give at these places, to 1e-6 of its size, is indeterminate.
/// Points that are not finite and points outside the domain are left out and counted; a weight of 0 takes
/// part in nothing but the count.
pub fn expand(
    basis: &dyn Basis,
    scale: &Scale,
    places_mm: &[[f64; 2]],
    values: &[f64],
    weights: Option<&[f64]>,
) -> Result<Expansion, ExpandError> {
    let count = places_mm.len();
    let weighed = weights.map_or(count, <[f64]>::len);
    if values.len() != count || weighed != count {
        return Err(ExpandError::Lengths { places: count, values: values.len(), weights: weighed });
    }
    if let Some(index) = weights.and_then(|weights| weights.iter().position(|&w| w < 0.0)) {
        let weight = weights.map_or(f64::NAN, |weights| weights[index]);
        return Err(ExpandError::Weight { index, weight });
    }
    let points = Points { basis, scale, places_mm, values, weights };
    let terms = basis.terms();
    let sums = points.tree(0..count, &|range| points.sums(range), &Sums::join);
    sums.check(&points)?;
    let normal = Normal::new(&sums.gram.leading(terms));
    let kept = normal.kept().to_vec();
    let all = sums.gram.leading(terms + 1);
    let along: Vec<f64> = (0..terms).map(|j| all[(j, terms)]).collect();
    if along.iter().any(|entry| !entry.is_finite()) || !all[(terms, terms)].is_finite() {
        return Err(ExpandError::Overflow);
    }
    let mut coefficients = vec![0.0; terms];
    for (&term, value) in kept.iter().zip(normal.solve(&along)) {
        coefficients[term] = value;
    }
    let rest = points.tree(0..count, &|range| points.rest(range, &coefficients), &Rest::join);
    // The refined solution leaves less by what the correction explains.
    let mut square = rest.square;
    for (&term, correction) in kept.iter().zip(normal.solve(&rest.along)) {
        coefficients[term] += correction;
        square -= correction * rest.along[term];
    }
    let square = square.max(0.0);
    let freedom = sums.used - kept.len();
    let covariance = (freedom > 0).then(|| normal.inverse() * (square / freedom as f64));
    let is_kept = |term: &usize| kept.binary_search(term).is_ok();
    Ok(Expansion {
        coefficients: (0..terms).map(|term| is_kept(&term).then(|| coefficients[term])).collect(),
        indeterminate: (0..terms).filter(|term| !is_kept(term)).map(|j| basis.name(j)).collect(),
        condition: normal.condition(),
        used: sums.used,
        not_finite: sums.not_finite,
        outside: sums.outside,
        residual_rms: if rest.weight > 0.0 { (square / rest.weight).sqrt() } else { 0.0 },
        largest_residual: rest.largest,
        covariance,
        kept,
    })
}

/// Value minus expansion at every place, in the unit of the values; NaN where the place or value is not
/// finite or the basis is not defined. Lists beyond the shortest are not looked at. `O(n·terms)`.
pub fn residuals(
    basis: &dyn Basis,
    scale: &Scale,
    coefficients: &[f64],
    places_mm: &[[f64; 2]],
    values: &[f64],
) -> Vec<f64> {
    let count = places_mm.len().min(values.len());
    let points = Points { basis, scale, places_mm, values, weights: None };
    let mut all = vec![f64::NAN; count];
    all.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, out)| {
        let start = chunk * CHUNK;
        let mut block = Block::new(basis.terms());
        points.blocks(
            start..start + out.len(),
            &mut block,
            &mut Tally::default(),
            |block, count| {
                for (lane, residual) in block.residuals(coefficients).iter().enumerate().take(count)
                {
                    out[block.indices[lane] - start] = *residual;
                }
            },
        );
    });
    all
}

/// What is expanded.
struct Points<'a> {
    basis: &'a dyn Basis,
    scale: &'a Scale,
    places_mm: &'a [[f64; 2]],
    values: &'a [f64],
    weights: Option<&'a [f64]>,
}

/// Usable points of a block, and their rows.
struct Block {
    u: [f64; LANES],
    v: [f64; LANES],
    weights: [f64; LANES],
    indices: [usize; LANES],
    /// One row a term and, last, the value; all 0 beyond the points there are.
    rows: Vec<[f64; LANES]>,
}

/// Points that were not used, and how far those outside are.
#[derive(Clone, Copy, Debug)]
struct Tally {
    not_finite: usize,
    outside: usize,
    nearest_mm: f64,
    farthest_mm: f64,
}

impl Default for Tally {
    fn default() -> Tally {
        Tally { not_finite: 0, outside: 0, nearest_mm: f64::INFINITY, farthest_mm: 0.0 }
    }
}

impl Points<'_> {
    /// The results of the chunks of a range, joined pairwise.
    fn tree<T: Send>(
        &self,
        range: Range<usize>,
        leaf: &(dyn Fn(Range<usize>) -> T + Sync),
        join: &(dyn Fn(T, T) -> T + Sync),
    ) -> T {
        if range.len() <= CHUNK {
            return leaf(range);
        }
        let middle = range.start + range.len().div_ceil(CHUNK) / 2 * CHUNK;
        let (left, right) = rayon::join(
            || self.tree(range.start..middle, leaf, join),
            || self.tree(middle..range.end, leaf, join),
        );
        join(left, right)
    }

    /// Shows the usable points of a range in blocks to `visit`, with their number.
    fn blocks(
        &self,
        range: Range<usize>,
        block: &mut Block,
        tally: &mut Tally,
        mut visit: impl FnMut(&mut Block, usize),
    ) {
        let mut count = 0;
        for index in range {
            let [x_mm, y_mm] = self.places_mm[index];
            let (value, weight) = (self.values[index], self.weights.map_or(1.0, |w| w[index]));
            if !(x_mm.is_finite() && y_mm.is_finite() && value.is_finite() && weight.is_finite()) {
                tally.not_finite += 1;
                continue;
            }
            let [u, v] = self.scale.normalised(x_mm, y_mm);
            if !self.basis.contains(u, v) {
                tally.outside += 1;
                let distance_mm = x_mm.hypot(y_mm);
                tally.nearest_mm = tally.nearest_mm.min(distance_mm);
                tally.farthest_mm = tally.farthest_mm.max(distance_mm);
                continue;
            }
            block.put(count, index, [u, v], value, weight);
            count += 1;
            if count == LANES {
                block.evaluate(self.basis, count);
                visit(block, count);
                count = 0;
            }
        }
        if count > 0 {
            block.evaluate(self.basis, count);
            visit(block, count);
        }
    }

    fn sums(&self, range: Range<usize>) -> Sums {
        let terms = self.basis.terms();
        let mut block = Block::new(terms);
        let mut gram = Gram::new(terms + 1);
        let (mut used, mut tally) = (0, Tally::default());
        self.blocks(range, &mut block, &mut tally, |block, count| {
            used += count;
            if self.weights.is_some() {
                block.weigh();
            }
            gram.add(&block.rows);
        });
        let Tally { not_finite, outside, nearest_mm, farthest_mm } = tally;
        Sums { gram, used, not_finite, outside, nearest_mm, farthest_mm }
    }

    fn rest(&self, range: Range<usize>, coefficients: &[f64]) -> Rest {
        let terms = self.basis.terms();
        let mut block = Block::new(terms);
        let largest = LargestResidual { residual: 0.0, index: range.start };
        let mut rest = Rest { along: vec![0.0; terms], square: 0.0, weight: 0.0, largest };
        self.blocks(range, &mut block, &mut Tally::default(), |block, count| {
            rest.add(block, count, coefficients);
        });
        rest
    }
}

impl Block {
    fn new(terms: usize) -> Block {
        Block {
            u: [0.0; LANES],
            v: [0.0; LANES],
            weights: [0.0; LANES],
            indices: [0; LANES],
            rows: vec![[0.0; LANES]; terms + 1],
        }
    }

    fn put(&mut self, lane: usize, index: usize, [u, v]: [f64; 2], value: f64, weight: f64) {
        (self.u[lane], self.v[lane]) = (u, v);
        (self.indices[lane], self.weights[lane]) = (index, weight);
        let last = self.rows.len() - 1;
        self.rows[last][lane] = value;
    }

    /// Fills the rows of the terms and clears the lanes from `count` on.
    fn evaluate(&mut self, basis: &dyn Basis, count: usize) {
        let last = self.rows.len() - 1;
        basis.block(&self.u, &self.v, &mut self.rows[..last]);
        if count < LANES {
            for row in &mut self.rows {
                row[count..].fill(0.0);
            }
            self.weights[count..].fill(0.0);
        }
    }

    fn weigh(&mut self) {
        let roots = self.weights.map(f64::sqrt);
        for row in &mut self.rows {
            for (entry, root) in row.iter_mut().zip(&roots) {
                *entry *= root;
            }
        }
    }

    fn residuals(&self, coefficients: &[f64]) -> [f64; LANES] {
        let mut residuals = self.rows[self.rows.len() - 1];
        for (row, coefficient) in self.rows.iter().zip(coefficients) {
            for (residual, value) in residuals.iter_mut().zip(row) {
                *residual -= coefficient * value;
            }
        }
        residuals
    }
}

/// What the first pass sums.
struct Sums {
    gram: Gram,
    used: usize,
    not_finite: usize,
    outside: usize,
    nearest_mm: f64,
    farthest_mm: f64,
}

impl Sums {
    fn join(self, other: Sums) -> Sums {
        Sums {
            gram: self.gram.join(&other.gram),
            used: self.used + other.used,
            not_finite: self.not_finite + other.not_finite,
            outside: self.outside + other.outside,
            nearest_mm: self.nearest_mm.min(other.nearest_mm),
            farthest_mm: self.farthest_mm.max(other.farthest_mm),
        }
    }

    fn check(&self, points: &Points<'_>) -> Result<(), ExpandError> {
        let (kind, terms) = (points.basis.kind(), points.basis.terms());
        if self.used == 0 && self.outside > 0 {
            return Err(ExpandError::Outside {
                kind,
                outside: self.outside,
                half_x_mm: points.scale.half_x_mm(),
                half_y_mm: points.scale.half_y_mm(),
                nearest_mm: self.nearest_mm,
                farthest_mm: self.farthest_mm,
            });
        }
        if self.used < terms {
            let Sums { used, outside, not_finite, .. } = *self;
            return Err(ExpandError::TooFew { kind, used, terms, outside, not_finite });
        }
        Ok(())
    }
}

/// What the second pass sums.
struct Rest {
    /// Aᵀ·W·r.
    along: Vec<f64>,
    /// rᵀ·W·r.
    square: f64,
    /// Sum of the weights.
    weight: f64,
    largest: LargestResidual,
}

impl Rest {
    fn add(&mut self, block: &Block, count: usize, coefficients: &[f64]) {
        let residuals = block.residuals(coefficients);
        let mut weighted = residuals;
        for (entry, weight) in weighted.iter_mut().zip(&block.weights) {
            *entry *= weight;
        }
        for (sum, row) in self.along.iter_mut().zip(&block.rows) {
            *sum += dot(&weighted, row);
        }
        self.square += dot(&weighted, &residuals);
        self.weight += block.weights.iter().sum::<f64>();
        for (&residual, &index) in residuals.iter().zip(&block.indices).take(count) {
            if residual.abs() > self.largest.residual.abs() {
                self.largest = LargestResidual { residual, index };
            }
        }
    }

    fn join(mut self, other: Rest) -> Rest {
        for (sum, more) in self.along.iter_mut().zip(&other.along) {
            *sum += more;
        }
        self.square += other.square;
        self.weight += other.weight;
        if other.largest.residual.abs() > self.largest.residual.abs() {
            self.largest = other.largest;
        }
        self
    }
}

/// Points a task works on. Fixed, because the result depends on it in the last bits.
const CHUNK: usize = 4096;

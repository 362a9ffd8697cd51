//! The two passes of an expansion over its points: blocks, what each sums, and how chunks are joined.

use std::ops::Range;

use super::expand::{ExpandError, LargestResidual};
use super::gram::{Gram, dot};
use super::{Basis, LANES, Scale};

/// What is expanded.
pub(super) struct Points<'a> {
    pub(super) basis: &'a dyn Basis,
    pub(super) scale: &'a Scale,
    pub(super) places_mm: &'a [[f64; 2]],
    pub(super) values: &'a [f64],
    pub(super) weights: Option<&'a [f64]>,
}

/// Usable points of a block, and their rows.
pub(super) struct Block {
    u: [f64; LANES],
    v: [f64; LANES],
    weights: [f64; LANES],
    pub(super) indices: [usize; LANES],
    /// One row a term and, last, the value; all 0 beyond the points there are.
    rows: Vec<[f64; LANES]>,
}

/// Points that were not used, and how far those outside are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tally {
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
    pub(super) fn tree<T: Send>(
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
    pub(super) fn blocks(
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

    pub(super) fn sums(&self, range: Range<usize>) -> Sums {
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

    pub(super) fn rest(&self, range: Range<usize>, coefficients: &[f64]) -> Rest {
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
    pub(super) fn new(terms: usize) -> Block {
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

    pub(super) fn residuals(&self, coefficients: &[f64]) -> [f64; LANES] {
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
pub(super) struct Sums {
    pub(super) gram: Gram,
    pub(super) used: usize,
    pub(super) not_finite: usize,
    pub(super) outside: usize,
    nearest_mm: f64,
    farthest_mm: f64,
}

impl Sums {
    pub(super) fn join(self, other: Sums) -> Sums {
        Sums {
            gram: self.gram.join(&other.gram),
            used: self.used + other.used,
            not_finite: self.not_finite + other.not_finite,
            outside: self.outside + other.outside,
            nearest_mm: self.nearest_mm.min(other.nearest_mm),
            farthest_mm: self.farthest_mm.max(other.farthest_mm),
        }
    }

    pub(super) fn check(&self, points: &Points<'_>) -> Result<(), ExpandError> {
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
pub(super) struct Rest {
    /// Aᵀ·W·r.
    pub(super) along: Vec<f64>,
    /// rᵀ·W·r.
    pub(super) square: f64,
    /// Sum of the weights.
    pub(super) weight: f64,
    pub(super) largest: LargestResidual,
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

    pub(super) fn join(mut self, other: Rest) -> Rest {
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
pub(super) const CHUNK: usize = 4096;

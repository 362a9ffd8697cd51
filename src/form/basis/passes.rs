//! The two passes of an expansion over its points: blocks, what each sums, and how chunks are joined.

use std::ops::Range;

use nalgebra::DMatrix;

use super::expand::{ExpandError, LargestResidual};
use super::gram::dot;
use super::normal::Normal;
use super::{Basis, LANES, Scale};

/// What is expanded.
pub(super) struct Points<'a> {
    pub(super) basis: &'a dyn Basis,
    pub(super) scale: &'a Scale,
    pub(super) places_mm: &'a [[f64; 2]],
    pub(super) values: &'a [f64],
    pub(super) weights: Option<&'a [f64]>,
}

/// Usable points of a block. Lanes from `count` on hold finite places, values of 0 and weights of 0.
pub(super) struct Block {
    pub(super) u: [f64; LANES],
    pub(super) v: [f64; LANES],
    pub(super) values: [f64; LANES],
    pub(super) weights: [f64; LANES],
    pub(super) indices: [usize; LANES],
    pub(super) count: usize,
}

/// A way to the normal equations of a basis and to what their solution leaves.
pub(super) trait Kernel: Sync {
    /// Room for the rows of a block.
    type Room;

    fn room(&self) -> Self::Room;

    /// How many sums the first pass has, and the second.
    fn lengths(&self) -> [usize; 2];

    /// Adds what a block gives to the sums of the first pass.
    fn add_equations(&self, block: &Block, room: &mut Self::Room, sums: &mut [f64]);

    /// The equations of these sums.
    fn equations(&self, sums: &[f64]) -> Equations;

    /// Whether rounding of these sums leaves the solution of their equations as good as it is said to be.
    fn is_sure(&self, sums: &[f64], equations: &Equations, normal: &Normal) -> bool;

    /// The coefficients of the terms as those of the functions that the second pass evaluates.
    fn spelled(&self, coefficients: &[f64]) -> Vec<f64>;

    /// Value minus the sum of the functions, for every lane. What they were made of stays in `room`.
    fn residuals(&self, block: &Block, room: &mut Self::Room, spelled: &[f64]) -> [f64; LANES];

    /// Adds the sums of the functions of the last block times its weighted residuals.
    fn add_rest(&self, weighted: &[f64; LANES], room: &Self::Room, sums: &mut [f64]);

    /// Aᵀ·W·r of the terms, of these sums.
    fn along(&self, sums: &[f64]) -> Vec<f64>;
}

/// Normal equations.
pub(super) struct Equations {
    /// Aᵀ·W·A.
    pub(super) gram: DMatrix<f64>,
    /// Aᵀ·W·y.
    pub(super) along: Vec<f64>,
    /// yᵀ·W·y.
    pub(super) square: f64,
}

/// Points that were not used, and how far those outside are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tally {
    pub(super) used: usize,
    pub(super) not_finite: usize,
    pub(super) outside: usize,
    nearest_mm: f64,
    farthest_mm: f64,
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

    /// Shows the usable points of a range in blocks to `visit`.
    pub(super) fn blocks(&self, range: Range<usize>, mut visit: impl FnMut(&Block)) -> Tally {
        let mut block = Block {
            u: [0.0; LANES],
            v: [0.0; LANES],
            values: [0.0; LANES],
            weights: [0.0; LANES],
            indices: [0; LANES],
            count: 0,
        };
        let mut tally = Tally::default();
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
            tally.used += 1;
            let lane = block.count;
            (block.u[lane], block.v[lane]) = (u, v);
            (block.values[lane], block.weights[lane]) = (value, weight);
            block.indices[lane] = index;
            block.count += 1;
            if block.count == LANES {
                visit(&block);
                block.count = 0;
            }
        }
        if block.count > 0 {
            block.values[block.count..].fill(0.0);
            block.weights[block.count..].fill(0.0);
            visit(&block);
        }
        tally
    }

    /// The first pass.
    pub(super) fn sums<K: Kernel>(&self, kernel: &K) -> Sums {
        let leaf = |range| {
            let mut room = kernel.room();
            let mut sums = vec![0.0; kernel.lengths()[0]];
            let tally =
                self.blocks(range, |block| kernel.add_equations(block, &mut room, &mut sums));
            Sums { sums, tally }
        };
        self.tree(0..self.places_mm.len(), &leaf, &Sums::join)
    }

    /// The second pass.
    pub(super) fn rest<K: Kernel>(&self, kernel: &K, coefficients: &[f64]) -> Rest {
        let spelled = kernel.spelled(coefficients);
        let leaf = |range: Range<usize>| {
            let mut room = kernel.room();
            let largest = LargestResidual { residual: 0.0, index: range.start };
            let sums = vec![0.0; kernel.lengths()[1]];
            let mut rest = Rest { sums, square: 0.0, weight: 0.0, largest };
            self.blocks(range, |block| {
                let residuals = kernel.residuals(block, &mut room, &spelled);
                let weighted = rest.add(block, &residuals);
                kernel.add_rest(&weighted, &room, &mut rest.sums);
            });
            rest
        };
        self.tree(0..self.places_mm.len(), &leaf, &Rest::join)
    }
}

/// Sums of the first pass.
pub(super) struct Sums {
    pub(super) sums: Vec<f64>,
    pub(super) tally: Tally,
}

impl Sums {
    fn join(mut self, other: Sums) -> Sums {
        add(&mut self.sums, &other.sums);
        let (one, other) = (self.tally, other.tally);
        self.tally = Tally {
            used: one.used + other.used,
            not_finite: one.not_finite + other.not_finite,
            outside: one.outside + other.outside,
            nearest_mm: one.nearest_mm.min(other.nearest_mm),
            farthest_mm: one.farthest_mm.max(other.farthest_mm),
        };
        self
    }
}

impl Default for Tally {
    fn default() -> Tally {
        Tally { used: 0, not_finite: 0, outside: 0, nearest_mm: f64::INFINITY, farthest_mm: 0.0 }
    }
}

impl Tally {
    /// Whether there are points enough for the terms.
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
            let Tally { used, outside, not_finite, .. } = *self;
            return Err(ExpandError::TooFew { kind, used, terms, outside, not_finite });
        }
        Ok(())
    }
}

/// Sums of the second pass.
pub(super) struct Rest {
    /// The sums of the kernel.
    pub(super) sums: Vec<f64>,
    /// rᵀ·W·r.
    pub(super) square: f64,
    /// Sum of the weights.
    pub(super) weight: f64,
    pub(super) largest: LargestResidual,
}

impl Rest {
    /// Adds the residuals of a block; returns them times the weights.
    fn add(&mut self, block: &Block, residuals: &[f64; LANES]) -> [f64; LANES] {
        let mut weighted = *residuals;
        for (entry, weight) in weighted.iter_mut().zip(&block.weights) {
            *entry *= weight;
        }
        self.square += dot(&weighted, residuals);
        self.weight += block.weights.iter().sum::<f64>();
        for (&residual, &index) in residuals.iter().zip(&block.indices).take(block.count) {
            if residual.abs() > self.largest.residual.abs() {
                self.largest = LargestResidual { residual, index };
            }
        }
        weighted
    }

    fn join(mut self, other: Rest) -> Rest {
        add(&mut self.sums, &other.sums);
        self.square += other.square;
        self.weight += other.weight;
        if other.largest.residual.abs() > self.largest.residual.abs() {
            self.largest = other.largest;
        }
        self
    }
}

fn add(sums: &mut [f64], more: &[f64]) {
    for (sum, more) in sums.iter_mut().zip(more) {
        *sum += more;
    }
}

/// Points a task works on. Fixed, because the result depends on it in the last bits.
pub(super) const CHUNK: usize = 4096;

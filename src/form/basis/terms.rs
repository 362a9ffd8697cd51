//! Normal equations by the products of the terms themselves: what any basis can.
//!
//! They cost half of what a QR factorisation does and run from registers; what they lose,
//! the square of the condition, is given back by one step of refinement with exact residuals (Björck, Linear
//! Algebra Appl. 88/89 (1987) 31, "corrected semi-normal equations").

use super::gram::{add_products, dot, leading};
use super::normal::Normal;
use super::passes::{Block, Equations, Kernel};
use super::{Basis, LANES};

/// The terms of a basis.
pub(super) struct Terms<'a> {
    pub(super) basis: &'a dyn Basis,
    pub(super) weighted: bool,
}

impl Kernel for Terms<'_> {
    /// One row a term and, last, the value; all 0 beyond the points there are.
    type Room = Vec<[f64; LANES]>;

    fn room(&self) -> Vec<[f64; LANES]> {
        vec![[0.0; LANES]; self.basis.terms() + 1]
    }

    fn lengths(&self) -> [usize; 2] {
        let terms = self.basis.terms();
        [(terms + 1) * (terms + 1), terms]
    }

    fn add_equations(&self, block: &Block, room: &mut Vec<[f64; LANES]>, sums: &mut [f64]) {
        self.evaluate(block, room);
        if self.weighted {
            let roots = block.weights.map(f64::sqrt);
            for row in &mut *room {
                for (entry, root) in row.iter_mut().zip(&roots) {
                    *entry *= root;
                }
            }
        }
        add_products(room, sums);
    }

    fn equations(&self, sums: &[f64]) -> Equations {
        let terms = self.basis.terms();
        let all = leading(sums, terms + 1, terms + 1);
        Equations {
            gram: leading(sums, terms + 1, terms),
            along: (0..terms).map(|term| all[(term, terms)]).collect(),
            square: all[(terms, terms)],
        }
    }

    fn is_sure(&self, _: &[f64], _: &Equations, _: &Normal) -> bool {
        true
    }

    fn spelled(&self, coefficients: &[f64]) -> Vec<f64> {
        coefficients.to_vec()
    }

    fn residuals(
        &self,
        block: &Block,
        room: &mut Vec<[f64; LANES]>,
        spelled: &[f64],
    ) -> [f64; LANES] {
        self.evaluate(block, room);
        let mut residuals = block.values;
        for (row, coefficient) in room.iter().zip(spelled) {
            for (residual, value) in residuals.iter_mut().zip(row) {
                *residual -= coefficient * value;
            }
        }
        residuals
    }

    fn add_rest(&self, weighted: &[f64; LANES], room: &Vec<[f64; LANES]>, sums: &mut [f64]) {
        for (sum, row) in sums.iter_mut().zip(room) {
            *sum += dot(weighted, row);
        }
    }

    fn along(&self, sums: &[f64]) -> Vec<f64> {
        sums.to_vec()
    }
}

impl Terms<'_> {
    fn evaluate(&self, block: &Block, rows: &mut [[f64; LANES]]) {
        let last = rows.len() - 1;
        self.basis.block(&block.u, &block.v, &mut rows[..last]);
        rows[last] = block.values;
        if block.count < LANES {
            for row in rows {
                row[block.count..].fill(0.0);
            }
        }
    }
}

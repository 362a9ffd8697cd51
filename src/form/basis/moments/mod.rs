//! Normal equations of functions of the disc from far fewer sums than they have entries.
//!
//! A term of the disc is `c(s)·P(s)·Re z^a` or `c(s)·P(s)·Im z^a`, with z = u + iv, s = |z|², P a polynomial and c
//! common to all. The product of two of them, a ≥ b, is by the addition theorems
//!
//! ```text
//! Re z^a·Re z^b = ½(Re z^(a+b) + s^b·Re z^(a−b))   Im z^a·Im z^b = ½(s^b·Re z^(a−b) − Re z^(a+b))
//! Re z^a·Im z^b = ½(Im z^(a+b) − s^b·Im z^(a−b))   Im z^a·Re z^b = ½(Im z^(a+b) + s^b·Im z^(a−b))
//! ```
//!
//! so the Gram matrix follows from the *moments* `Σ w·c²·T_j(2s − 1)·z^M`, T_j Chebyshev's polynomials: 144 real
//! sums for the 37 Fringe terms, whose products are 703. Neither pass evaluates a term: the right side and the
//! residuals take the functions T_j·z^m.
//!
//! The moments of one M are a functional of polynomials in s. At K Chebyshev nodes, K above every degree, it is
//! a weight on each node (discrete orthogonality; Mason & Handscomb, Chebyshev Polynomials (2003), 4.6), and an
//! entry of the Gram matrix the weighted sum of values at the nodes, exactly but for rounding.
//!
//! **Rounding.** An entry is off by about ε·Σw·h², h the largest |P| at a node, whatever its own size, while the
//! products of the terms themselves are off by ε of it. Where that could be felt, because the points cover a
//! small part of the disc or the terms are of high order, [`Kernel::is_sure`] says no, and
//! [`Terms`](super::terms::Terms) take over.

use std::f64::consts::PI;

use nalgebra::DMatrix;

use super::LANES;
use super::disc::Disc;
use super::gram::{add_pair, dot};
use super::normal::Normal;
use super::passes::{Block, Equations, Kernel};

/// Sums for a disc.
pub(super) struct Moments {
    bend: f64,
    terms: Vec<Term>,
    /// s at each node.
    nodes: Vec<f64>,
    /// For each node and j what T_j there counts: the share of a moment in the weight of the node, and of a
    /// value at the node in a coefficient.
    shares: Vec<Vec<f64>>,
    /// Of each M: sums of Re and of Im, of each j. At M = 0, where Im is 0, its place is taken by the right
    /// side of m = 0.
    products: Vec<Run>,
    /// Of each m: sums of the right side, Re and Im, of each j; from m = 1 on in the first pass.
    sides: Vec<Run>,
    /// Sums of the second pass.
    rests: Vec<Run>,
    /// Largest |P| at a node.
    height: f64,
}

/// A term, with P at the nodes.
struct Term {
    order: usize,
    sine: bool,
    values: Vec<f64>,
}

/// Where twice `count` sums begin.
#[derive(Clone, Copy, Default)]
struct Run {
    start: usize,
    count: usize,
}

/// Rows of a block.
pub(super) struct Room {
    /// T_j(2s − 1).
    chebyshev: Vec<[f64; LANES]>,
    /// c·Re z^m and c·Im z^m of the second pass.
    angular: Vec<[[f64; LANES]; 2]>,
}

impl Moments {
    /// `None` if the products of the terms are no more, or are known better.
    pub(super) fn new(disc: &Disc) -> Option<Moments> {
        let columns = disc.columns();
        let largest = columns.last()?.order as usize;
        let mut degrees = vec![None; largest + 1];
        for column in columns {
            degrees[column.order as usize] = Some(column.degree());
        }
        let mut counts = vec![0; 2 * largest + 1];
        let mut singles = vec![0; largest + 1];
        for (a, above) in degrees.iter().enumerate() {
            let Some(above) = above else { continue };
            singles[a] = above + 1;
            for (b, below) in degrees[..=a].iter().enumerate() {
                let Some(below) = below else { continue };
                counts[a + b] = counts[a + b].max(above + below + 1);
                counts[a - b] = counts[a - b].max(above + below + b + 1);
            }
        }
        let (products, from) = runs(&counts, 0);
        let rests = runs(&singles, 0).0;
        singles[0] = 0;
        let (sides, end) = runs(&singles, from);
        if end >= disc.terms() * (disc.terms() + 1) / 2 {
            return None;
        }
        let size = counts.iter().copied().max()?;
        let angle = |node: usize| PI * (node as f64 + 0.5) / size as f64;
        let nodes: Vec<f64> = (0..size).map(|node| 0.5 * (1.0 + angle(node).cos())).collect();
        let share = |node: usize, j: usize| {
            (if j == 0 { 1.0 } else { 2.0 }) * (j as f64 * angle(node)).cos() / size as f64
        };
        let shares = (0..size).map(|node| (0..size).map(|j| share(node, j)).collect()).collect();
        let terms = terms(disc, &nodes);
        let values = terms.iter().flat_map(|term| &term.values);
        let height = values.fold(0.0, |most: f64, value| most.max(value.abs()));
        let moments =
            Moments { bend: disc.bend(), terms, nodes, shares, products, sides, rests, height };
        (f64::EPSILON * height * height <= SURE).then_some(moments)
    }

    /// The weight of each node of a run of moments.
    fn weights(&self, moments: &[f64]) -> Vec<f64> {
        self.shares
            .iter()
            .map(|shares| shares.iter().zip(moments).map(|(s, m)| s * m).sum())
            .collect()
    }

    /// The sums of functions P·Re z^m and P·Im z^m that these runs hold, of every term. `first` is what stands
    /// at m = 0.
    fn of_terms(&self, sums: &[f64], runs: &[Run], first: Option<&[f64]>) -> Vec<f64> {
        let weights: Vec<[Vec<f64>; 2]> = runs
            .iter()
            .enumerate()
            .map(|(order, run)| match first {
                Some(first) if order == 0 => [self.weights(first), Vec::new()],
                _ => run.parts(sums).map(|part| self.weights(part)),
            })
            .collect();
        let of = |term: &Term| {
            let weights = &weights[term.order][usize::from(term.sine)];
            term.values.iter().zip(weights).map(|(value, weight)| value * weight).sum()
        };
        self.terms.iter().map(of).collect()
    }

    /// The Gram matrix of the moments.
    fn gram(&self, sums: &[f64]) -> DMatrix<f64> {
        let mut weights: Vec<[Vec<f64>; 2]> = self
            .products
            .iter()
            .map(|run| run.parts(sums).map(|part| self.weights(part)))
            .collect();
        weights[0][1].fill(0.0);
        let largest = self.rests.len() - 1;
        let powers: Vec<Vec<f64>> = (0..=largest as i32)
            .map(|power| self.nodes.iter().map(|s| s.powi(power)).collect())
            .collect();
        let mut gram = DMatrix::zeros(self.terms.len(), self.terms.len());
        for (i, one) in self.terms.iter().enumerate() {
            for (j, other) in self.terms.iter().enumerate().take(i + 1) {
                let (above, below) =
                    if one.order >= other.order { (one, other) } else { (other, one) };
                let part = usize::from(above.sine != below.sine);
                let sum_sign = if above.sine && below.sine { -1.0 } else { 1.0 };
                let difference_sign = if !above.sine && below.sine { -1.0 } else { 1.0 };
                let of_sum = &weights[above.order + below.order][part];
                let of_difference = &weights[above.order - below.order][part];
                let powers = &powers[below.order];
                let mut entry = 0.0;
                for node in 0..self.nodes.len() {
                    let weight = sum_sign * of_sum[node]
                        + difference_sign * (powers[node] * of_difference[node]);
                    entry += one.values[node] * other.values[node] * weight;
                }
                gram[(i, j)] = 0.5 * entry;
                gram[(j, i)] = 0.5 * entry;
            }
        }
        gram
    }

    /// s, and T_j(2s − 1) below `count`.
    fn chebyshev(&self, block: &Block, count: usize, rows: &mut [[f64; LANES]]) -> [f64; LANES] {
        let mut square = [0.0; LANES];
        let mut twice = [0.0; LANES];
        for lane in 0..LANES {
            square[lane] = block.u[lane] * block.u[lane] + block.v[lane] * block.v[lane];
            twice[lane] = 2.0 * (2.0 * square[lane] - 1.0);
        }
        rows[0] = [1.0; LANES];
        if count > 1 {
            rows[1] = twice.map(|twice| 0.5 * twice);
        }
        for j in 2..count {
            let [before, now, next] =
                rows.get_disjoint_mut([j - 2, j - 1, j]).expect("three different rows");
            for lane in 0..LANES {
                next[lane] = twice[lane] * now[lane] - before[lane];
            }
        }
        square
    }
}

impl Kernel for Moments {
    type Room = Room;

    fn room(&self) -> Room {
        Room {
            chebyshev: vec![[0.0; LANES]; self.nodes.len()],
            angular: vec![[[0.0; LANES]; 2]; self.rests.len()],
        }
    }

    fn lengths(&self) -> [usize; 2] {
        // The last of the first pass is the square of the values.
        [self.sides.last().map_or(0, Run::end) + 1, self.rests.last().map_or(0, Run::end)]
    }

    fn add_equations(&self, block: &Block, room: &mut Room, sums: &mut [f64]) {
        let rows = &mut room.chebyshev;
        let square = self.chebyshev(block, self.nodes.len(), rows);
        // The powers bear the factors of a product, w·c²; in the right side one c too many is divided out.
        let mut power = [block.weights, [0.0; LANES]];
        let mut values = block.values;
        if self.bend != 0.0 {
            for lane in 0..LANES {
                let rest = 1.0 - self.bend * self.bend * square[lane];
                power[0][lane] /= rest;
                values[lane] *= rest.sqrt();
            }
        }
        let mut weighted = block.values;
        for (value, weight) in weighted.iter_mut().zip(&block.weights) {
            *value *= weight;
        }
        let last = sums.len() - 1;
        sums[last] += dot(&weighted, &block.values);
        for (order, products) in self.products.iter().enumerate() {
            if order > 0 {
                turn(&mut power, block);
            }
            let [re, im] = &power;
            let side = self.sides.get(order);
            if order == 0 || side.is_some_and(|side| side.count > 0) {
                let times = |row: &[f64; LANES]| {
                    let mut row = *row;
                    for (entry, value) in row.iter_mut().zip(&values) {
                        *entry *= value;
                    }
                    row
                };
                if order == 0 {
                    products.add([re, &times(re)], rows, sums);
                    continue;
                }
                if let Some(side) = side {
                    side.add([&times(re), &times(im)], rows, sums);
                }
            }
            products.add([re, im], rows, sums);
        }
    }

    fn equations(&self, sums: &[f64]) -> Equations {
        let [_, side] = self.products[0].parts(sums);
        Equations {
            gram: self.gram(sums),
            along: self.of_terms(sums, &self.sides, Some(side)),
            square: sums[sums.len() - 1],
        }
    }

    fn is_sure(&self, sums: &[f64], equations: &Equations, normal: &Normal) -> bool {
        let gram = &equations.gram;
        let diagonal = (0..gram.nrows()).map(|term| gram[(term, term)]);
        let least = diagonal.fold(f64::INFINITY, f64::min);
        // That of T_0 is the sum of the weights.
        let weight = sums[self.products[0].start];
        let off = f64::EPSILON * self.height * self.height * weight / least;
        normal.kept().len() == self.terms.len() && off * normal.condition().powi(2) <= SURE
    }

    fn spelled(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut spelled = vec![0.0; self.lengths()[1]];
        for (term, coefficient) in self.terms.iter().zip(coefficients) {
            let run = self.rests[term.order];
            let start = run.start + if term.sine { run.count } else { 0 };
            for (value, shares) in term.values.iter().zip(&self.shares) {
                for (entry, share) in spelled[start..][..run.count].iter_mut().zip(shares) {
                    *entry += coefficient * value * share;
                }
            }
        }
        spelled
    }

    fn residuals(&self, block: &Block, room: &mut Room, spelled: &[f64]) -> [f64; LANES] {
        let count = self.rests.iter().map(|run| run.count).max().unwrap_or(0);
        let square = self.chebyshev(block, count, &mut room.chebyshev);
        let mut power = [[1.0; LANES], [0.0; LANES]];
        if self.bend != 0.0 {
            for lane in 0..LANES {
                power[0][lane] = (1.0 - self.bend * self.bend * square[lane]).sqrt().recip();
            }
        }
        for (order, row) in room.angular.iter_mut().enumerate() {
            if order > 0 {
                turn(&mut power, block);
            }
            *row = power;
        }
        let mut residuals = block.values;
        for (group, residuals) in residuals.as_chunks_mut::<GROUP>().0.iter_mut().enumerate() {
            let from = group * GROUP;
            for (run, [re, im]) in self.rests.iter().zip(&room.angular) {
                let mut sums = [[0.0; GROUP]; 2];
                let [even, odd] = run.parts(spelled);
                for ((even, odd), row) in even.iter().zip(odd).zip(&room.chebyshev) {
                    let row: &[f64; GROUP] = row[from..].first_chunk().expect("whole groups");
                    for lane in 0..GROUP {
                        sums[0][lane] += even * row[lane];
                        sums[1][lane] += odd * row[lane];
                    }
                }
                for lane in 0..GROUP {
                    residuals[lane] -=
                        re[from + lane] * sums[0][lane] + im[from + lane] * sums[1][lane];
                }
            }
        }
        if block.count < LANES {
            residuals[block.count..].fill(0.0);
        }
        residuals
    }

    fn add_rest(&self, weighted: &[f64; LANES], room: &Room, sums: &mut [f64]) {
        for (run, rows) in self.rests.iter().zip(&room.angular) {
            if run.count > 0 {
                let mut rows = *rows;
                for row in &mut rows {
                    for (entry, weighted) in row.iter_mut().zip(weighted) {
                        *entry *= weighted;
                    }
                }
                run.add([&rows[0], &rows[1]], &room.chebyshev, sums);
            }
        }
    }

    fn along(&self, sums: &[f64]) -> Vec<f64> {
        self.of_terms(sums, &self.rests, None)
    }
}

impl Run {
    fn end(&self) -> usize {
        self.start + 2 * self.count
    }

    /// Its sums: of Re, and of Im.
    fn parts<'a>(&self, sums: &'a [f64]) -> [&'a [f64]; 2] {
        let (re, im) = sums[self.start..self.end()].split_at(self.count);
        [re, im]
    }

    /// Adds the products of two rows with those of Chebyshev's polynomials.
    fn add(&self, pair: [&[f64; LANES]; 2], rows: &[[f64; LANES]], sums: &mut [f64]) {
        let (re, im) = sums[self.start..self.end()].split_at_mut(self.count);
        add_pair(pair, &rows[..self.count], [re, im]);
    }
}

/// Runs of these counts one after the other, and where they end.
fn runs(counts: &[usize], from: usize) -> (Vec<Run>, usize) {
    let mut start = from;
    let run = |&count: &usize| {
        let run = Run { start, count };
        start = run.end();
        run
    };
    let runs = counts.iter().map(run).collect();
    (runs, start)
}

/// The terms of a disc in their order.
fn terms(disc: &Disc, nodes: &[f64]) -> Vec<Term> {
    let mut terms: Vec<Term> = Vec::new();
    terms.resize_with(disc.terms(), || Term { order: 0, sine: false, values: Vec::new() });
    for column in disc.columns() {
        for &node in nodes {
            column.each_radial(node, |slot, sine, value| {
                let term = &mut terms[slot.term];
                (term.order, term.sine) = (column.order as usize, sine);
                term.values.push(value);
            });
        }
    }
    terms
}

/// From (u + iv)^m to the next power, times what it bears.
fn turn([re, im]: &mut [[f64; LANES]; 2], block: &Block) {
    for lane in 0..LANES {
        let (u, v) = (block.u[lane], block.v[lane]);
        let turned = re[lane] * v + im[lane] * u;
        re[lane] = re[lane] * u - im[lane] * v;
        im[lane] = turned;
    }
}

/// Lanes whose sums stay in registers.
const GROUP: usize = 8;
/// How far rounding may move the solution of the equations, as a share. One step of refinement leaves its
/// square; variances have it themselves.
const SURE: f64 = 1e-9;

#[cfg(test)]
mod tests;

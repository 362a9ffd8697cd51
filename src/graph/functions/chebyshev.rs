//! Eigenvectors of the largest eigenvalues of a symmetric operator, by a subspace that Chebyshev polynomials filter (Y. Zhou,
//! Y. Saad, M. L. Tiago, J. R. Chelikowsky, Journal of Computational Physics 219 (2006) 172-184, algorithm 4.3).

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

use super::laplacian::Laplacian;
use crate::cloud::CHUNK;

/// Some vectors, place by place: the values of one place lie side by side.
#[derive(Clone)]
pub(super) struct Block {
    pub(super) width: usize,
    pub(super) values: Vec<f64>,
}

/// Eigenpairs of 1 minus the operator, the least eigenvalue first.
pub(super) struct Pairs {
    pub(super) eigenvalues: Vec<f64>,
    pub(super) vectors: Block,
    /// The norm of what each pair leaves.
    pub(super) residuals: Vec<f64>,
    pub(super) rounds: usize,
}

impl Block {
    /// Vectors of functions of the place.
    pub(super) fn new(
        places: usize,
        width: usize,
        value: impl Fn(usize, usize) -> f64 + Sync,
    ) -> Block {
        let of = |at: usize| value(at / width, at % width);
        Block { width, values: (0..places * width).into_par_iter().map(of).collect() }
    }

    /// The inner products of the vectors of two blocks. Sums run over fixed chunks.
    fn products(&self, other: &Block) -> DMatrix<f64> {
        let width = self.width;
        let of_chunk = |(own, others): (&[f64], &[f64])| {
            let mut sums = vec![0.0; width * width];
            for (a, b) in own.chunks_exact(width).zip(others.chunks_exact(width)) {
                for (sums, a) in sums.chunks_exact_mut(width).zip(a) {
                    sums.iter_mut().zip(b).for_each(|(sum, b)| *sum += a * b);
                }
            }
            sums
        };
        let chunks =
            self.values.par_chunks(CHUNK * width).zip(other.values.par_chunks(CHUNK * width));
        let parts: Vec<Vec<f64>> = chunks.map(of_chunk).collect();
        let mut total = vec![0.0; width * width];
        for part in &parts {
            total.iter_mut().zip(part).for_each(|(total, part)| *total += part);
        }
        DMatrix::from_row_slice(width, width, &total)
    }

    /// The vectors combined by the columns of a matrix.
    fn combined(&self, by: &DMatrix<f64>) -> Block {
        let width = self.width;
        let by: Vec<f64> = by.transpose().as_slice().to_vec();
        let mut values = vec![0.0; self.values.len()];
        let rows = values.par_chunks_mut(width).zip(self.values.par_chunks(width));
        rows.for_each(|(into, row)| {
            for (value, weights) in row.iter().zip(by.chunks_exact(width)) {
                into.iter_mut().zip(weights).for_each(|(into, weight)| *into += value * weight);
            }
        });
        Block { width, values }
    }

    /// Orthonormal vectors of the same span; those that hang on others become small and stay in the block.
    fn orthonormal(&self) -> Block {
        let mut block = self.clone();
        for _ in 0..ORTHONORMALISATIONS {
            let found = SymmetricEigen::new(block.products(&block));
            let most = found.eigenvalues.max();
            let mut by = found.eigenvectors;
            for (at, value) in found.eigenvalues.iter().enumerate() {
                let length = value.max(most * LEAST).sqrt();
                by.column_mut(at).iter_mut().for_each(|entry| *entry /= length);
            }
            block = block.combined(&by);
        }
        block
    }
}

/// The operator on every vector of a block, times a factor, plus two further blocks times theirs.
fn apply(
    operator: &Laplacian,
    block: &Block,
    [times, own, with]: [f64; 3],
    further: Option<&Block>,
) -> Block {
    let width = block.width;
    let mut values = vec![0.0; block.values.len()];
    values.par_chunks_mut(width).enumerate().for_each(|(place, into)| {
        for (other, weight) in operator.neighbours(place) {
            let row = &block.values[other * width..][..width];
            into.iter_mut().zip(row).for_each(|(into, value)| *into += weight * value);
        }
        let row = &block.values[place * width..][..width];
        into.iter_mut().zip(row).for_each(|(into, value)| *into = times * *into + own * value);
        if let Some(further) = further {
            let row = &further.values[place * width..][..width];
            into.iter_mut().zip(row).for_each(|(into, value)| *into += with * value);
        }
    });
    Block { width, values }
}

/// The Chebyshev polynomial of a degree that is small for eigenvalues from −1 to `cut` and large above.
fn filtered(operator: &Laplacian, block: &Block, cut: f64, degree: usize) -> Block {
    let (half, middle) = (f64::midpoint(1.0, cut), f64::midpoint(-1.0, cut));
    // What the polynomial is at 1, where it is largest, keeps the vectors at their length.
    let top = (1.0 - middle) / half;
    let mut ratio = 1.0 / top;
    let mut before = block.clone();
    let mut now = apply(operator, block, [ratio / half, -middle * ratio / half, 0.0], None);
    for _ in 1..degree {
        let next_ratio = 1.0 / (2.0 * top - ratio);
        let factors =
            [2.0 * next_ratio / half, -2.0 * next_ratio * middle / half, -ratio * next_ratio];
        let next = apply(operator, &now, factors, Some(&before));
        (before, now, ratio) = (now, next, next_ratio);
    }
    now
}

/// The `wanted` pairs of largest eigenvalues, from a block that is somewhat wider. `tolerance` is that of the residuals.
pub(super) fn largest(operator: &Laplacian, start: &Block, wanted: usize, tolerance: f64) -> Pairs {
    let mut block = start.orthonormal();
    let mut degree = FIRST_DEGREE;
    let mut rounds = 0;
    loop {
        rounds += 1;
        // Rayleigh and Ritz.
        let images = apply(operator, &block, [1.0, 0.0, 0.0], None);
        let mut gram = block.products(&images);
        gram = (&gram + gram.transpose()) * 0.5;
        let found = SymmetricEigen::new(gram);
        let mut order: Vec<usize> = (0..block.width).collect();
        order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
        let by = found.eigenvectors.select_columns(&order);
        let values: Vec<f64> = order.iter().map(|&at| found.eigenvalues[at]).collect();
        let (vectors, images) = (block.combined(&by), images.combined(&by));
        let residuals = residuals(&vectors, &images, &values);
        if residuals[..wanted].iter().all(|residual| *residual <= tolerance)
            || rounds == MOST_ROUNDS
        {
            let eigenvalues = values.iter().map(|value| 1.0 - value).collect();
            return Pairs { eigenvalues, vectors, residuals, rounds };
        }
        let cut = values[block.width - 1].clamp(-0.5, 1.0 - 1e-12);
        block = filtered(operator, &vectors, cut, degree).orthonormal();
        degree = (2 * degree).min(MOST_DEGREE);
    }
}

fn residuals(vectors: &Block, images: &Block, values: &[f64]) -> Vec<f64> {
    let width = vectors.width;
    let of_chunk = |(vectors, images): (&[f64], &[f64])| {
        let mut sums = vec![0.0; width];
        for (row, image) in vectors.chunks_exact(width).zip(images.chunks_exact(width)) {
            for at in 0..width {
                sums[at] += (image[at] - values[at] * row[at]).powi(2);
            }
        }
        sums
    };
    let chunks =
        vectors.values.par_chunks(CHUNK * width).zip(images.values.par_chunks(CHUNK * width));
    let parts: Vec<Vec<f64>> = chunks.map(of_chunk).collect();
    (0..width).map(|at| parts.iter().map(|part| part[at]).sum::<f64>().sqrt()).collect()
}

/// A Gram matrix has squared condition: the second time leaves rounding alone.
const ORTHONORMALISATIONS: usize = 2;
/// Squares of lengths below this share of the largest are rounding.
const LEAST: f64 = 1e-28;
const FIRST_DEGREE: usize = 24;
const MOST_DEGREE: usize = 200;
const MOST_ROUNDS: usize = 60;

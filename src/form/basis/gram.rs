//! Sums of products of the columns of a tall matrix, block by block.
//!
//! The normal equations cost half of what a QR factorisation does and run from registers; what they lose,
//! the square of the condition, is given back by one step of refinement with exact residuals (Björck, Linear
//! Algebra Appl. 88/89 (1987) 31, "corrected semi-normal equations").

use nalgebra::DMatrix;

use super::LANES;

/// Upper triangle of AᵀA. The products of a block are summed first, then those of the blocks, so that
/// rounding grows with the logarithm of the number of rows when parts are joined pairwise.
#[derive(Clone, Debug)]
pub(super) struct Gram {
    columns: usize,
    /// Entry (i, j), i ≤ j, at `i·columns + j`.
    sums: Vec<f64>,
}

impl Gram {
    pub(super) fn new(columns: usize) -> Gram {
        Gram { columns, sums: vec![0.0; columns * columns] }
    }

    /// Adds the rows of a block, given column after column.
    pub(super) fn add(&mut self, block: &[[f64; LANES]]) {
        debug_assert_eq!(block.len(), self.columns);
        for (first, pair) in block.chunks(TILE_ROWS).enumerate() {
            let top = first * TILE_ROWS;
            // Tiles that the diagonal cuts are computed whole: the few products too many lie below it.
            for (offset, group) in block[top..].chunks(TILE_COLUMNS).enumerate() {
                let left = top + offset * TILE_COLUMNS;
                if let ([a, b], [c, d, e, f]) = (pair, group) {
                    let products = tile([a, b], [c, d, e, f]);
                    for (row, products) in (top..).zip(products) {
                        let sums = &mut self.sums[row * self.columns + left..][..TILE_COLUMNS];
                        for (sum, [even, odd]) in sums.iter_mut().zip(products) {
                            *sum += even + odd;
                        }
                    }
                } else {
                    for (row, a) in (top..).zip(pair) {
                        for (column, b) in (left..).zip(group) {
                            self.sums[row * self.columns + column] += dot(a, b);
                        }
                    }
                }
            }
        }
    }

    pub(super) fn join(mut self, other: &Gram) -> Gram {
        for (sum, more) in self.sums.iter_mut().zip(&other.sums) {
            *sum += more;
        }
        self
    }

    /// AᵀA of the first `count` columns.
    pub(super) fn leading(&self, count: usize) -> DMatrix<f64> {
        DMatrix::from_fn(count, count, |i, j| self.sums[i.min(j) * self.columns + i.max(j)])
    }
}

/// The eight dot products of two columns with four, each in two interleaved sums: what sixteen vector
/// registers of two numbers hold.
fn tile(a: [&[f64; LANES]; 2], b: [&[f64; LANES]; 4]) -> [[[f64; 2]; TILE_COLUMNS]; TILE_ROWS] {
    let mut sums = [[[0.0; 2]; TILE_COLUMNS]; TILE_ROWS];
    for k in (0..LANES).step_by(2) {
        for (sums, a) in sums.iter_mut().zip(a) {
            for (sum, b) in sums.iter_mut().zip(b) {
                sum[0] += a[k] * b[k];
                sum[1] += a[k + 1] * b[k + 1];
            }
        }
    }
    sums
}

/// The product of two columns, in two interleaved sums.
pub(super) fn dot(a: &[f64; LANES], b: &[f64; LANES]) -> f64 {
    let mut sum = [0.0; 2];
    for k in (0..LANES).step_by(2) {
        sum[0] += a[k] * b[k];
        sum[1] += a[k + 1] * b[k + 1];
    }
    sum[0] + sum[1]
}

const TILE_ROWS: usize = 2;
const TILE_COLUMNS: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_products() {
        for columns in 1..14 {
            let block: Vec<[f64; LANES]> = (0..columns)
                .map(|j| {
                    std::array::from_fn(|k| ((j * 37 + k * 11 + j * j * k) % 23) as f64 - 11.0)
                })
                .collect();
            let mut gram = Gram::new(columns);
            gram.add(&block);
            gram.add(&block);
            let gram = gram.clone().join(&gram).leading(columns);
            for i in 0..columns {
                for j in 0..columns {
                    let products = block[i].iter().zip(&block[j]).map(|(a, b)| a * b);
                    // Whole numbers: exact.
                    assert_eq!(gram[(i, j)], 4.0 * products.sum::<f64>(), "{columns}: {i} {j}");
                }
            }
        }
    }
}

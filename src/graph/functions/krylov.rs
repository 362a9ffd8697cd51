//! The slowest vibrations by the inverse of the Laplacian: a subspace that is multiplied by it again and again (block Lanczos,
//! G. H. Golub, R. Underwood, Mathematical Software III (1977) 361-377, with all vectors made orthogonal to all before).

use nalgebra::{DMatrix, SymmetricEigen};
use rayon::prelude::*;

use super::chebyshev::Block;
use super::cholesky::{COLUMNS, Cholesky, Row};
use super::laplacian::Laplacian;
use crate::cloud::CHUNK;

/// Vectors close to the eigenvectors of the least eigenvalues, the null vector first, `width` in all. `wanted` of them are so close
/// that residuals are below the tolerance; `None` where that takes too many vectors or they do not become independent.
///
/// Eigenvalues are found up to [`COLUMNS`] times.
pub(super) fn slowest(
    (operator, factor): (&Laplacian, &Cholesky),
    null: &[f64],
    start: &Block,
    (wanted, tolerance): (usize, f64),
) -> Option<Block> {
    let width = start.width;
    let scale = null.iter().map(|value| value * value).sum::<f64>().sqrt();
    let null: Vec<f64> = null.iter().map(|value| value / scale).collect();
    let column = |place: usize, at: usize| start.values[place * width + 1 + at];
    let row = |place: usize| std::array::from_fn(|at| column(place, at));
    let mut own: Vec<Row> = (0..null.len()).into_par_iter().map(row).collect();
    without_null(&mut own, &null);
    let (mut basis, mut next) = (Vec::new(), orthonormal(own)?.0);
    let most = MOST_BLOCKS.max(4 * wanted / COLUMNS);
    let mut projected = DMatrix::<f64>::zeros(0, 0);
    while basis.len() < most {
        let mut image = factor.solve(&next);
        basis.push(next);
        without_null(&mut image, &null);
        let size = basis.len() * COLUMNS;
        projected = projected.resize(size, size, 0.0);
        // The image has large shares in the last two blocks alone; after these are taken away the second time removes rounding.
        let near = basis.len().saturating_sub(2);
        for from in [near, 0] {
            for (at, block) in basis.iter().enumerate().skip(from) {
                let shares = products(block, &image);
                subtract(&mut image, block, &shares);
                let mut view =
                    projected.view_mut((at * COLUMNS, size - COLUMNS), (COLUMNS, COLUMNS));
                view += shares;
            }
        }
        let (orthogonal, lengths) = orthonormal(image)?;
        next = orthogonal;
        if size + 1 >= width + COLUMNS {
            let found = SymmetricEigen::new(upper(&projected));
            let mut order: Vec<usize> = (0..size).collect();
            order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
            // The inverse leaves of a vector a combination of the next columns; the matrix makes its residual of that.
            let image = without_neighbours(operator, &next);
            let gram = products(&image, &image);
            let left = |&at: &usize| {
                let last = found.eigenvectors.view((size - COLUMNS, at), (COLUMNS, 1));
                let shares = &lengths * last;
                (shares.transpose() * &gram * &shares)[0].max(0.0).sqrt() / found.eigenvalues[at]
            };
            if order[..wanted - 1].iter().all(|at| left(at) <= MARGIN * tolerance) {
                let by = found.eigenvectors.select_columns(&order[..width - 1]);
                return Some(combined(&null, &basis, &by));
            }
        }
    }
    None
}

/// 1 minus the operator on every column.
fn without_neighbours(operator: &Laplacian, rows: &[Row]) -> Vec<Row> {
    let of = |(place, own): (usize, &Row)| {
        let mut image = *own;
        for (other, weight) in operator.neighbours(place) {
            (0..COLUMNS).for_each(|at| image[at] -= weight * rows[other][at]);
        }
        image
    };
    rows.par_iter().enumerate().map(of).collect()
}

/// The symmetric matrix of which the upper part is given.
fn upper(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let mut all = matrix.upper_triangle();
    all.fill_lower_triangle_with_upper_triangle();
    all
}

/// The null vector, and the blocks combined by the columns of a matrix.
fn combined(null: &[f64], basis: &[Vec<Row>], by: &DMatrix<f64>) -> Block {
    let width = by.ncols() + 1;
    let weights: Vec<f64> = by.transpose().as_slice().to_vec();
    let mut values = vec![0.0; null.len() * width];
    values.par_chunks_mut(width).enumerate().for_each(|(place, into)| {
        into[0] = null[place];
        let row = basis.iter().flat_map(|block| &block[place]);
        for (value, weights) in row.zip(weights.chunks_exact(width - 1)) {
            into[1..].iter_mut().zip(weights).for_each(|(into, weight)| *into += value * weight);
        }
    });
    Block { width, values }
}

/// Takes the share of the null vector away.
fn without_null(rows: &mut [Row], null: &[f64]) {
    let share = |(rows, null): (&[Row], &[f64])| {
        let mut sums = [0.0; COLUMNS];
        for (row, weight) in rows.iter().zip(null) {
            (0..COLUMNS).for_each(|at| sums[at] += weight * row[at]);
        }
        sums
    };
    let parts: Vec<Row> = rows.par_chunks(CHUNK).zip(null.par_chunks(CHUNK)).map(share).collect();
    let total: Row = std::array::from_fn(|at| parts.iter().map(|part| part[at]).sum());
    rows.par_iter_mut().zip(null).for_each(|(row, weight)| {
        (0..COLUMNS).for_each(|at| row[at] -= weight * total[at]);
    });
}

/// The inner products of the columns of two blocks. Sums run over fixed chunks.
fn products(a: &[Row], b: &[Row]) -> DMatrix<f64> {
    let of_chunk = |(a, b): (&[Row], &[Row])| {
        let mut sums = [[0.0; COLUMNS]; COLUMNS];
        for (a, b) in a.iter().zip(b) {
            for (sums, a) in sums.iter_mut().zip(a) {
                (0..COLUMNS).for_each(|at| sums[at] += a * b[at]);
            }
        }
        sums
    };
    let parts: Vec<_> = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(of_chunk).collect();
    let sum = |row: usize, column: usize| parts.iter().map(|part| part[row][column]).sum();
    DMatrix::from_fn(COLUMNS, COLUMNS, sum)
}

/// Takes the columns of a block times a matrix away.
fn subtract(from: &mut [Row], block: &[Row], by: &DMatrix<f64>) {
    let by: [Row; COLUMNS] = std::array::from_fn(|row| std::array::from_fn(|at| by[(row, at)]));
    from.par_iter_mut().with_min_len(CHUNK).zip(block).for_each(|(into, row)| {
        for (value, weights) in row.iter().zip(&by) {
            (0..COLUMNS).for_each(|at| into[at] -= value * weights[at]);
        }
    });
}

/// Orthonormal columns of the same span, and the matrix by which they give the columns; `None` where columns hang on one another.
fn orthonormal(mut rows: Vec<Row>) -> Option<(Vec<Row>, DMatrix<f64>)> {
    let mut lengths = DMatrix::identity(COLUMNS, COLUMNS);
    // A Gram matrix has squared condition: the second time leaves rounding alone.
    for _ in 0..2 {
        let factor = products(&rows, &rows).cholesky()?;
        let upper = factor.l().transpose();
        let inverse = upper.clone().try_inverse()?;
        let most = upper.diagonal().max();
        if upper.diagonal().min() < INDEPENDENT * most {
            return None;
        }
        let by: [Row; COLUMNS] =
            std::array::from_fn(|row| std::array::from_fn(|at| inverse[(row, at)]));
        rows.par_iter_mut().with_min_len(CHUNK).for_each(|row| {
            let own = *row;
            *row = [0.0; COLUMNS];
            for (value, weights) in own.iter().zip(&by) {
                (0..COLUMNS).for_each(|at| row[at] += value * weights[at]);
            }
        });
        lengths = upper * lengths;
    }
    Some((rows, lengths))
}

/// Blocks at most; more where many vectors are wanted.
const MOST_BLOCKS: usize = 24;

/// Residuals that are foreseen are this share of the tolerance: rounding adds to them.
const MARGIN: f64 = 0.5;

/// Columns are independent where what is new of each is more than this share.
const INDEPENDENT: f64 = 1e-7;

//! Sums of products of rows of a block, from registers.

use nalgebra::DMatrix;

use super::LANES;

/// Adds the products of every two rows of a block to `sums`: those of rows i ≤ j at `i·rows + j`. The products
/// of a block are summed first, then those of the blocks, so that rounding grows with the logarithm of the
/// number of points when parts are joined pairwise.
pub(super) fn add_products(block: &[[f64; LANES]], sums: &mut [f64]) {
    debug_assert_eq!(sums.len(), block.len() * block.len());
    for (pair, (rows, sums)) in block.chunks(2).zip(sums.chunks_mut(2 * block.len())).enumerate() {
        let top = 2 * pair;
        let (first, second) = sums.split_at_mut(block.len());
        match rows {
            // The one product too many lies below the diagonal.
            [a, b] => add_pair([a, b], &block[top..], [&mut first[top..], &mut second[top..]]),
            [a] => first[top] += dot(a, a),
            _ => unreachable!("chunks of two hold one or two rows"),
        }
    }
}

/// The symmetric matrix of the sums of [`add_products`] over the first `count` of `rows` rows.
pub(super) fn leading(sums: &[f64], rows: usize, count: usize) -> DMatrix<f64> {
    DMatrix::from_fn(count, count, |i, j| sums[i.min(j) * rows + i.max(j)])
}

/// Adds the products of each of a pair of rows with every row of `others` to its sums.
pub(super) fn add_pair(pair: [&[f64; LANES]; 2], others: &[[f64; LANES]], sums: [&mut [f64]; 2]) {
    let [first, second] = sums;
    let sums = first.chunks_mut(TILE).zip(second.chunks_mut(TILE));
    for (others, (first, second)) in others.chunks(TILE).zip(sums) {
        let sums = [first, second];
        match others {
            [a] => add_tile(pair, [a], sums),
            [a, b] => add_tile(pair, [a, b], sums),
            [a, b, c] => add_tile(pair, [a, b, c], sums),
            [a, b, c, d] => add_tile(pair, [a, b, c, d], sums),
            _ => unreachable!("a tile has one to four rows"),
        }
    }
}

/// The products of two rows with up to four, each in two interleaved sums: what sixteen vector registers of
/// two numbers hold.
fn add_tile<const N: usize>(
    pair: [&[f64; LANES]; 2],
    others: [&[f64; LANES]; N],
    sums: [&mut [f64]; 2],
) {
    let mut products = [[[0.0; 2]; N]; 2];
    for k in (0..LANES).step_by(2) {
        for (products, a) in products.iter_mut().zip(pair) {
            for (product, b) in products.iter_mut().zip(others) {
                product[0] += a[k] * b[k];
                product[1] += a[k + 1] * b[k + 1];
            }
        }
    }
    for (sums, products) in sums.into_iter().zip(products) {
        for (sum, [even, odd]) in sums.iter_mut().zip(products) {
            *sum += even + odd;
        }
    }
}

/// The product of two rows, in two interleaved sums.
pub(super) fn dot(a: &[f64; LANES], b: &[f64; LANES]) -> f64 {
    let mut sum = [0.0; 2];
    for k in (0..LANES).step_by(2) {
        sum[0] += a[k] * b[k];
        sum[1] += a[k + 1] * b[k + 1];
    }
    sum[0] + sum[1]
}

const TILE: usize = 4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_the_products() {
        for rows in 1..14 {
            let block: Vec<[f64; LANES]> = (0..rows)
                .map(|j| {
                    std::array::from_fn(|k| ((j * 37 + k * 11 + j * j * k) % 23) as f64 - 11.0)
                })
                .collect();
            let mut sums = vec![0.0; rows * rows];
            add_products(&block, &mut sums);
            add_products(&block, &mut sums);
            let gram = leading(&sums, rows, rows);
            for i in 0..rows {
                for j in 0..rows {
                    let products = block[i].iter().zip(&block[j]).map(|(a, b)| a * b);
                    // Whole numbers: exact.
                    assert_eq!(gram[(i, j)], 2.0 * products.sum::<f64>(), "{rows}: {i} {j}");
                }
            }
        }
    }
}

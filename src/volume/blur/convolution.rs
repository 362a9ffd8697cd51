//! One block of a volume, blurred: the integral of its slope.

use super::BLOCK;
use crate::Samples;

/// A Gaussian and its derivative at whole numbers, from −reach to reach.
pub(super) struct Kernel {
    value: Vec<f32>,
    slope: Vec<f32>,
}

impl Kernel {
    pub(super) fn new(sigma: f64) -> Kernel {
        let reach = (4.0 * sigma).ceil() as i32;
        let gauss = |at: i32| (-f64::from(at * at) / (2.0 * sigma * sigma)).exp();
        let sum: f64 = (-reach..=reach).map(gauss).sum();
        // The slope of what grows by 1 a sample is 1.
        let moment: f64 = (-reach..=reach).map(|at| f64::from(at * at) * gauss(at)).sum();
        let value = (-reach..=reach).map(|at| (gauss(at) / sum) as f32).collect();
        let slope =
            (-reach..=reach).map(|at| (f64::from(at) * gauss(at) / moment) as f32).collect();
        Kernel { value, slope }
    }

    pub(super) fn reach(&self) -> usize {
        self.value.len() / 2
    }
}

/// The sum over one block whose lowest sample is `from`, on a grid 2^`level` times coarser; all in units of that grid. Its value is the
/// share of foreground in 2^`level` samples along each axis, and 0 is where the layer around the volume begins.
pub(super) fn block(samples: &Samples, kernel: &Kernel, from: [i64; 3], level: u32) -> f64 {
    let reach = kernel.reach();
    let side = BLOCK + 2 * reach;
    let first = from.map(|at| at - reach as i64);
    let mut values = vec![0_f32; side * side * side];
    let inside = fill(samples, &mut values, side, first, level);
    if inside == 0 || inside == values.len() << (3 * level) {
        return 0.0;
    }
    // Along z, then y, then x; each pass leaves BLOCK samples of its axis.
    let along = |values: &[f32], inner: usize, outer: usize, kernel: &[f32]| {
        convolved(values, inner, side, outer, kernel)
    };
    let [z_value, z_slope] =
        [&kernel.value, &kernel.slope].map(|k| along(&values, side * side, 1, k));
    let yz = |values: &[f32], k: &[f32]| along(values, side, BLOCK, k);
    let plain = yz(&z_value, &kernel.value);
    let (in_y, in_z) = (yz(&z_value, &kernel.slope), yz(&z_slope, &kernel.value));
    let x = |values: &[f32], k: &[f32]| along(values, 1, BLOCK * BLOCK, k);
    let gradient = [x(&plain, &kernel.slope), x(&in_y, &kernel.value), x(&in_z, &kernel.value)];
    let [in_x, in_y, in_z] = &gradient;
    let lengths = in_x.iter().zip(in_y).zip(in_z).map(|((a, b), c)| {
        let [a, b, c] = [a, b, c].map(|slope| f64::from(*slope));
        (a * a + b * b + c * c).sqrt()
    });
    lengths.sum()
}

/// Values convolved along one axis of `side` samples, of which the middle [`BLOCK`] are kept. Steps along the axis are `inner` apart; it
/// is repeated `outer` times.
fn convolved(values: &[f32], inner: usize, side: usize, outer: usize, kernel: &[f32]) -> Vec<f32> {
    let mut result = vec![0_f32; inner * BLOCK * outer];
    for part in 0..outer {
        let from = &values[part * inner * side..][..inner * side];
        let to = &mut result[part * inner * BLOCK..][..inner * BLOCK];
        if inner == 1 {
            // The same sums in the same order, many places at a time.
            for (step, &weight) in kernel.iter().enumerate() {
                for (sum, value) in to.iter_mut().zip(&from[step..step + BLOCK]) {
                    *sum += weight * value;
                }
            }
            continue;
        }
        for (at, line) in to.chunks_exact_mut(inner).enumerate() {
            for (step, &weight) in kernel.iter().enumerate() {
                let source = &from[(at + step) * inner..][..inner];
                for (sum, value) in line.iter_mut().zip(source) {
                    *sum += weight * value;
                }
            }
        }
    }
    result
}

/// Fills a cube of values with shares of foreground; gives back how many samples of it are foreground.
fn fill(samples: &Samples, values: &mut [f32], side: usize, first: [i64; 3], level: u32) -> usize {
    let finer = 1_i64 << level;
    let [_, rows, slices] = samples.size().map(|size| size as i64 + 2);
    // The samples of a value lie in one word, as 2^level divides 64.
    let (mask, share) = (u64::MAX >> (64 - finer), (-3.0 * f64::from(level)).exp2() as f32);
    let mut inside = 0;
    for z in 0..side as i64 * finer {
        for y in 0..side as i64 * finer {
            let [row_y, row_z] = [first[1] * finer + y, first[2] * finer + z];
            if row_y < 0 || row_z < 0 || row_y >= rows || row_z >= slices {
                continue;
            }
            let row = samples.row(row_y as usize, row_z as usize);
            let start = ((z / finer) as usize * side + (y / finer) as usize) * side;
            for (x, value) in values[start..][..side].iter_mut().enumerate() {
                let column = (first[0] + x as i64) * finer;
                if column >= 0 && column < row.len() as i64 * 64 {
                    let word = row[column as usize / 64] >> (column as usize % 64) & mask;
                    *value += word.count_ones() as f32 * share;
                    inside += word.count_ones() as usize;
                }
            }
        }
    }
    inside
}

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

/// A volume as it is blurred, on a grid 2^`level` times coarser.
///
/// Its value is the share of foreground in 2^`level` samples along each axis, and 0 is where the layer around the volume begins.
#[derive(Clone, Copy)]
pub(super) struct Field<'a> {
    pub(super) samples: &'a Samples,
    pub(super) level: u32,
    pub(super) mirrors: Mirrors,
}

/// The faces of a volume, by axis and end, beyond whose samples it goes on as its mirror image; there it counts up to these samples.
/// Background lies beyond the others.
pub(super) type Mirrors = [[bool; 2]; 3];

/// The sum over one block whose lowest value is `from`, in units of the grid of the field.
pub(super) fn block(field: Field<'_>, kernel: &Kernel, from: [i64; 3]) -> f64 {
    let reach = kernel.reach();
    let side = BLOCK + 2 * reach;
    let first = from.map(|at| at - reach as i64);
    let weights = [0, 1, 2].map(|axis| field.weights(axis, from[axis]));
    if weights.iter().any(|along| along.iter().all(|&weight| weight == 0.0)) {
        return 0.0;
    }
    let mut values = vec![0_f32; side * side * side];
    let inside = field.fill(&mut values, side, first);
    if inside == 0 || inside == values.len() << (3 * field.level) {
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
    if !field.is_mirrored() {
        return lengths.sum();
    }
    let weight = |at: usize| {
        let place = [at % BLOCK, at / BLOCK % BLOCK, at / BLOCK / BLOCK];
        (0..3).map(|axis| weights[axis][place[axis]]).product::<f64>()
    };
    lengths.enumerate().map(|(at, length)| weight(at) * length).sum()
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

impl Field<'_> {
    fn is_mirrored(self) -> bool {
        self.mirrors.as_flattened().contains(&true)
    }

    /// Share of the values of a block from `from` on along an axis that counts: all, or what lies before a mirror.
    fn weights(self, axis: usize, from: i64) -> [f64; BLOCK] {
        let finer = (1_i64 << self.level) as f64;
        // Samples count from 1, in the middle of what they stand for.
        let [first, last] = [1.0, self.samples.size()[axis] as f64];
        let [has_low, has_high] = self.mirrors[axis];
        let low = if has_low { first } else { f64::NEG_INFINITY };
        let high = if has_high { last } else { f64::INFINITY };
        std::array::from_fn(|at| {
            let start = (from + at as i64) as f64 * finer - 0.5;
            let within = (start + finer).min(high) - start.max(low);
            (within / finer).max(0.0)
        })
    }

    /// Fills a cube of values with shares of foreground; gives back how many samples of it are foreground.
    fn fill(self, values: &mut [f32], side: usize, first: [i64; 3]) -> usize {
        let Field { samples, level, .. } = self;
        let finer = 1_i64 << level;
        let [_, rows, slices] = samples.size().map(|size| size as i64 + 2);
        // The samples of a value lie in one word, as 2^level divides 64.
        let (mask, share) = (u64::MAX >> (64 - finer), (-3.0 * f64::from(level)).exp2() as f32);
        let mut inside = 0;
        for z in 0..side as i64 * finer {
            for y in 0..side as i64 * finer {
                let [row_y, row_z] = [(1, y), (2, z)]
                    .map(|(axis, at)| self.mirrored(axis, first[axis] * finer + at));
                if row_y < 0 || row_z < 0 || row_y >= rows || row_z >= slices {
                    continue;
                }
                let row = samples.row(row_y as usize, row_z as usize);
                let start = ((z / finer) as usize * side + (y / finer) as usize) * side;
                for (x, value) in values[start..][..side].iter_mut().enumerate() {
                    let column = (first[0] + x as i64) * finer;
                    let count = if self.mirrors[0].contains(&true) {
                        self.ones_mirrored(row, column..column + finer)
                    } else if column >= 0 && column < row.len() as i64 * 64 {
                        (row[column as usize / 64] >> (column as usize % 64) & mask).count_ones()
                    } else {
                        0
                    };
                    *value += count as f32 * share;
                    inside += count as usize;
                }
            }
        }
        inside
    }

    /// The samples of a row that are foreground, of a range that may leave it.
    fn ones_mirrored(self, row: &[u64], columns: std::ops::Range<i64>) -> u32 {
        let bits = columns.map(|column| {
            let at = self.mirrored(0, column);
            let word = usize::try_from(at / 64).ok().filter(|_| at >= 0).and_then(|at| row.get(at));
            word.map_or(0, |word| (word >> (at % 64) & 1) as u32)
        });
        bits.sum()
    }

    /// The sample that stands for one beyond a mirror, along an axis; it counts from 1, and may lie beyond a face without one.
    fn mirrored(self, axis: usize, mut at: i64) -> i64 {
        let last = self.samples.size()[axis] as i64;
        let [has_low, has_high] = self.mirrors[axis];
        if last == 1 && (has_low && at < 1 || has_high && at > 1) {
            return 1;
        }
        loop {
            at = match at {
                ..1 if has_low => 2 - at,
                _ if at > last && has_high => 2 * last - at,
                _ => return at,
            };
        }
    }
}

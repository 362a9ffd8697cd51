//! How the noise differs from place to place.
//!
//! Samples of a cell of some spacings differ by noise, for form is nearly a plane over it. So:
//!
//! 1. Cells are taken together in blocks; the median of the variances within the cells of a block is the block's. A
//!    defect smaller than half a block does not move it.
//! 2. About each block a plane is fitted to the logarithms of the variances of the blocks around (W. S. Cleveland,
//!    J. Am. Stat. Assoc. 74 (1979) 829-836, doi:10.1080/01621459.1979.10481038).
//! 3. Where these planes vary no more than they do of noise that is everywhere the same, it is taken to be so. Else
//!    they are shrunk by the share of their variance that such noise gives them.
//!
//! What is given is relative: 1 in half of the blocks, or more.

/// Noise relative to its median over the surface, on a grid of blocks.
#[derive(Clone, Debug)]
pub(super) struct NoiseField {
    low_mm: [f64; 2],
    pitch_mm: f64,
    size: [usize; 2],
    /// By block; empty where the noise is the same everywhere.
    shape: Vec<f64>,
}

/// Samples of a cell.
#[derive(Clone, Copy)]
pub(super) struct CellNoise {
    pub(super) place_mm: [f64; 2],
    /// Variance of the samples about their mean or plane, in any unit.
    pub(super) variance: f64,
}

impl NoiseField {
    /// The field over cells of a side within an extent.
    pub(super) fn of(
        cells: impl Iterator<Item = CellNoise>,
        low_mm: [f64; 2],
        extent_mm: [f64; 2],
        side_mm: f64,
    ) -> NoiseField {
        let pitch_mm = BLOCK * side_mm;
        let size = extent_mm.map(|extent| (extent / pitch_mm).floor() as usize + 1);
        let mut field = NoiseField { low_mm, pitch_mm, size, shape: Vec::new() };
        let mut variances = vec![Vec::new(); size[0] * size[1]];
        for CellNoise { place_mm, variance } in cells {
            let [column, row] = [0, 1].map(|axis| {
                let at = (place_mm[axis] - low_mm[axis]) / pitch_mm;
                (at as usize).min(size[axis] - 1)
            });
            variances[row * size[0] + column].push(variance);
        }
        let logarithms: Vec<Option<f64>> = variances
            .iter_mut()
            .map(|variances| {
                let middle = variances.len() / 2;
                (variances.len() >= CELLS_MIN)
                    .then(|| variances.select_nth_unstable_by(middle, f64::total_cmp).1.ln())
            })
            .collect();
        // A block without any noise has rounding only.
        if logarithms.iter().flatten().all(|value| value.is_finite()) {
            field.smooth(&logarithms);
        }
        field
    }

    fn smooth(&mut self, logarithms: &[Option<f64>]) {
        let mut known: Vec<f64> = logarithms.iter().copied().flatten().collect();
        if known.len() < BLOCKS_MIN {
            return;
        }
        let middle = known.len() / 2;
        let typical = *known.select_nth_unstable_by(middle, f64::total_cmp).1;
        let planes: Vec<Option<Plane>> =
            (0..logarithms.len()).map(|block| self.plane(logarithms, block)).collect();
        let (mut scatter, mut varied, mut leverage, mut count) = (Vec::new(), 0.0, 0.0, 0.0);
        for (plane, value) in planes.iter().zip(logarithms) {
            if let (Some(plane), Some(value)) = (plane, value) {
                scatter.push((value - plane.height).abs() / (1.0 - plane.own).max(0.1).sqrt());
                varied += (plane.height - typical).powi(2);
                leverage += plane.variance;
                count += 1.0;
            }
        }
        let Some(scatter) = super::tail::scale(&mut scatter) else { return };
        let by_chance = scatter * scatter * leverage / count;
        let varied = varied / count;
        if varied <= SURE * by_chance {
            return;
        }
        let share = 1.0 - by_chance / varied;
        let mut last = 0.0_f64;
        self.shape = planes
            .iter()
            .map(|plane| {
                last = plane.as_ref().map_or(last, |plane| share * (plane.height - typical));
                (0.5 * last).clamp(-MOST, MOST).exp()
            })
            .collect();
    }

    /// The plane about a block.
    fn plane(&self, logarithms: &[Option<f64>], block: usize) -> Option<Plane> {
        let at = [block % self.size[0], block / self.size[0]];
        let reach = REACH as usize;
        let about = |axis: usize| {
            at[axis].saturating_sub(reach)..(at[axis] + reach + 1).min(self.size[axis])
        };
        let mut matrix = nalgebra::Matrix3::zeros();
        let mut right = nalgebra::Vector3::zeros();
        let mut squares = nalgebra::Matrix3::zeros();
        let mut own = 0.0;
        let mut count = 0;
        for row in about(1) {
            for column in about(0) {
                let Some(value) = logarithms[row * self.size[0] + column] else { continue };
                let [x, y] = [column as f64 - at[0] as f64, row as f64 - at[1] as f64];
                let near = 1.0 - (x * x + y * y) / ((REACH + 0.5) * (REACH + 0.5));
                if near <= 0.0 {
                    continue;
                }
                let weight = near * near;
                let terms = nalgebra::Vector3::new(1.0, x, y);
                matrix += weight * terms * terms.transpose();
                squares += weight * weight * terms * terms.transpose();
                right += weight * value * terms;
                own += if [x, y] == [0.0; 2] { weight } else { 0.0 };
                count += 1;
            }
        }
        // A constant where the blocks about it do not tell a plane.
        let constant = |matrix: &nalgebra::Matrix3<f64>| {
            let total = matrix[(0, 0)];
            let plane = Plane {
                height: right[0] / total,
                variance: squares[(0, 0)] / (total * total),
                own: own / total,
            };
            (total > 0.0).then_some(plane)
        };
        if count < PLANE_MIN {
            return constant(&matrix);
        }
        let Some(inverse) = matrix.cholesky().map(|factor| factor.inverse()) else {
            return constant(&matrix);
        };
        let row = inverse.row(0).into_owned();
        let variance = (row * squares * row.transpose())[0];
        // At the corner of a surface a plane would tell less than a constant.
        if variance > VARIANCE_MOST {
            return constant(&matrix);
        }
        Some(Plane { height: (row * right)[0], variance, own: own * inverse[(0, 0)] })
    }

    /// The noise at a place over its median: bilinear between the middles of blocks.
    pub(super) fn at(&self, place_mm: [f64; 2]) -> f64 {
        if self.shape.is_empty() {
            return 1.0;
        }
        let at = [0, 1].map(|axis| {
            let at = (place_mm[axis] - self.low_mm[axis]) / self.pitch_mm - 0.5;
            let at = at.clamp(0.0, (self.size[axis] - 1) as f64);
            let below = (at as usize).min(self.size[axis].saturating_sub(2));
            (below, at - below as f64)
        });
        let [(i, u), (j, v)] = at;
        let of = |column: usize, row: usize| {
            self.shape[row.min(self.size[1] - 1) * self.size[0] + column.min(self.size[0] - 1)]
        };
        let along = |row: usize| (1.0 - u) * of(i, row) + u * of(i + 1, row);
        (1.0 - v) * along(j) + v * along(j + 1)
    }
}

/// The plane through the blocks about one, at that block.
struct Plane {
    height: f64,
    /// Its variance for blocks of variance 1.
    variance: f64,
    /// The weight of the block itself in its height.
    own: f64,
}

/// Cells along a block.
const BLOCK: f64 = 6.0;
/// Fewer cells tell no median.
const CELLS_MIN: usize = 12;
/// Fewer blocks tell nothing of places.
const BLOCKS_MIN: usize = 12;
/// Blocks to either side that take part in a plane.
const REACH: f64 = 2.0;
const PLANE_MIN: usize = 6;
const VARIANCE_MOST: f64 = 0.6;
/// How much more the planes vary than of uniform noise before it counts: once in some hundred surfaces by chance.
const SURE: f64 = 2.5;
/// Largest logarithm of a ratio to the median: a factor of 20.
const MOST: f64 = 3.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curvature::truth::Random;

    /// Cells of six samples of a noise over a square of 100 by 100.
    fn field(noise: impl Fn(f64, f64) -> f64) -> NoiseField {
        let mut random = Random::new(4);
        let cells: Vec<CellNoise> = (0..10_000)
            .map(|cell| {
                let place_mm = [cell % 100, cell / 100].map(|at| f64::from(at) + 0.5);
                let scale = noise(place_mm[0], place_mm[1]);
                let variance = (0..5).map(|_| (scale * random.normal()).powi(2)).sum::<f64>() / 5.0;
                CellNoise { place_mm, variance }
            })
            .collect();
        NoiseField::of(cells.into_iter(), [0.0; 2], [100.0; 2], 1.0)
    }

    #[test]
    fn noise_that_is_the_same_everywhere_is_told_so() {
        assert_eq!(field(|_, _| 3.0).at([20.0, 70.0]), 1.0);
    }

    #[test]
    fn noise_that_grows_is_followed() {
        let truth = |x: f64| 1.0 + 3.0 * (x / 100.0).powi(2);
        let found = field(|x, _| truth(x));
        let unit = found.at([50.0, 50.0]) / truth(50.0);
        for x in [5.0, 20.0, 35.0, 65.0, 80.0, 95.0] {
            let ratio = found.at([x, 30.0]) / truth(x) / unit;
            assert!((ratio - 1.0).abs() < 0.15, "{x} {ratio}");
        }
    }
}

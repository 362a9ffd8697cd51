//! Gaussian smoothing of grey values, which takes noise from the place of a surface.

use rayon::prelude::*;

/// Values smoothed by a Gaussian whose standard deviations along x, y and z are `sigma` samples; 0 leaves an axis alone.
///
/// A weight that would lie beyond the volume, or on a value that is not finite, is shared by the others. A value that is not finite
/// stays so. The kernel ends at four standard deviations. `O(n·σ)`; the result does not depend on threads.
///
/// # Panics
///
/// Where there are not as many values as `size` says.
pub fn smoothed(values: &[f32], size: [usize; 3], sigma: [f64; 3]) -> Vec<f32> {
    assert_eq!(values.len(), size.iter().product::<usize>(), "one value a sample");
    let mut now = values.to_vec();
    for axis in 0..3 {
        let kernel = half_kernel(sigma[axis]);
        if kernel.len() > 1 && size[axis] > 1 {
            now = along(&now, size, axis, &kernel);
        }
    }
    now
}

/// Weights at the distances 0, 1, 2 …; not normed.
fn half_kernel(sigma: f64) -> Vec<f64> {
    if sigma.is_nan() || sigma <= 0.0 {
        return vec![1.0];
    }
    let reach = (REACH * sigma).ceil() as usize;
    (0..=reach).map(|at| (-0.5 * (at as f64 / sigma).powi(2)).exp()).collect()
}

/// One pass. Rows of the result are made one by one; along y and z whole rows are added up, so memory is read in order.
fn along(values: &[f32], size: [usize; 3], axis: usize, kernel: &[f64]) -> Vec<f32> {
    let [nx, ny, _] = size;
    let mut result = vec![0.0_f32; values.len()];
    result.par_chunks_mut(nx).enumerate().for_each(|(row, out)| {
        let own = &values[row * nx..][..nx];
        let mut sums = vec![(0.0_f64, 0.0_f64); nx];
        let mut add = |x: usize, weight: f64, value: f32| {
            if value.is_finite() {
                sums[x].0 += weight * f64::from(value);
                sums[x].1 += weight;
            }
        };
        let (y, z) = (row % ny, row / ny);
        let at = [0, y, z][axis];
        let reach = kernel.len() as i64 - 1;
        for step in -reach..=reach {
            let weight = kernel[step.unsigned_abs() as usize];
            if axis == 0 {
                for x in 0..nx {
                    let from = x as i64 + step;
                    if (0..nx as i64).contains(&from) {
                        add(x, weight, own[from as usize]);
                    }
                }
                continue;
            }
            let from = at as i64 + step;
            if !(0..size[axis] as i64).contains(&from) {
                continue;
            }
            let start =
                if axis == 1 { z * ny + from as usize } else { from as usize * ny + y } * nx;
            let other = &values[start..start + nx];
            other.iter().enumerate().for_each(|(x, &value)| add(x, weight, value));
        }
        for (x, out) in out.iter_mut().enumerate() {
            *out = if own[x].is_finite() { (sums[x].0 / sums[x].1) as f32 } else { own[x] };
        }
    });
    result
}

/// Standard deviations at which the kernel ends.
const REACH: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// A single value becomes a Gaussian of the variance asked for, and keeps its sum.
    #[test]
    fn a_point_becomes_a_gaussian() {
        let size = [23, 21, 25];
        let mut values = vec![0.0; 23 * 21 * 25];
        values[(12 * 21 + 10) * 23 + 11] = 1000.0;
        let sigma = [1.0, 1.5, 2.0];
        let found = smoothed(&values, size, sigma);
        let sum: f64 = found.iter().map(|&value| f64::from(value)).sum();
        assert!((sum / 1000.0 - 1.0).abs() < 1e-5, "{sum}");
        for axis in 0..3 {
            let centre = [11.0, 10.0, 12.0][axis];
            let second: f64 = (0..found.len())
                .map(|index| {
                    let place = [index % 23, index / 23 % 21, index / (23 * 21)][axis] as f64;
                    f64::from(found[index]) * (place - centre).powi(2)
                })
                .sum();
            let variance = second / sum;
            assert!((variance / sigma[axis].powi(2) - 1.0).abs() < 2e-3, "{axis}: {variance}");
        }
    }

    #[test]
    fn a_constant_stays_beside_borders_and_missing_values() {
        let mut values = vec![7.0_f32; 5 * 4 * 3];
        values[17] = f32::NAN;
        let found = smoothed(&values, [5, 4, 3], [1.0, 2.0, 0.5]);
        assert!(found[17].is_nan());
        let others = found.iter().enumerate().filter(|(index, _)| *index != 17);
        assert!(others.clone().all(|(_, value)| (value - 7.0).abs() < 1e-5));
        assert_eq!(smoothed(&values[..5], [5, 1, 1], [0.0; 3]), &values[..5]);
    }

    #[test]
    fn threads_change_nothing() {
        let values: Vec<f32> = (0..4000).map(|i| ((i * 7919) % 1013) as f32).collect();
        let of = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| smoothed(&values, [20, 20, 10], [1.0; 3]))
        };
        assert_eq!(of(1), of(3));
    }
}

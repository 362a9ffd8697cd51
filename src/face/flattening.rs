//! What blur takes off the form: the curvature of the deviation, and the noise of a face from which it is taken back.
//!
//! Blur of variance σ² moves a nearly plane edge as the heat equation does: a form d becomes d + σ²·∇²d/2 and so on. The Laplacian of d
//! comes from a paraboloid through the points within a few standard deviations of the blur, by least squares. It is a weighted sum
//! of the deviations, so the noise that it brings along is known.

use asphera_geometry::{BoundsMm, place};
use nalgebra::{Matrix6, Vector6};
use rayon::prelude::*;

use asphera_geometry::vector::{Vector, cross, dot, minus, unit};

/// A point of a face in the part frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bent {
    pub(crate) place_mm: Vector,
    /// Unit normal of the design.
    pub(crate) normal: Vector,
    /// Deviation from the design along it.
    pub(crate) deviation_mm: f64,
}

/// The points of a face, sorted into squares of their x and y.
pub(crate) struct Sheet {
    points: Vec<Bent>,
    reach_mm: f64,
    /// Points by square, row by row.
    squares: Vec<Vec<u32>>,
    columns: usize,
    rows: usize,
    low_mm: [f64; 2],
}

impl Sheet {
    /// Points whose paraboloids reach `reach_mm` far.
    pub(crate) fn new(points: Vec<Bent>, reach_mm: f64) -> Sheet {
        let bounds = BoundsMm::about(points.iter().map(|point| place(point.place_mm)));
        let low_mm = bounds.low;
        let count = |axis: usize| {
            let span_mm = bounds.size_mm()[axis].max(0.0);
            if span_mm.is_finite() { (span_mm / reach_mm) as usize + 1 } else { 1 }
        };
        let (columns, rows) = (count(0), count(1));
        let mut sheet = Sheet {
            points,
            reach_mm,
            squares: vec![Vec::new(); columns * rows],
            columns,
            rows,
            low_mm,
        };
        for index in 0..sheet.points.len() {
            let [column, row] = sheet.square(sheet.points[index].place_mm);
            sheet.squares[row * columns + column].push(index as u32);
        }
        sheet
    }

    fn square(&self, [x, y, _]: Vector) -> [usize; 2] {
        let at = |from_mm: f64, most: usize| ((from_mm / self.reach_mm) as usize).min(most - 1);
        [at(x - self.low_mm[0], self.columns), at(y - self.low_mm[1], self.rows)]
    }

    /// The Laplacian of the deviation at each point, 1/mm; 0 where too few points lie about it.
    pub(crate) fn laplacians_per_mm(&self) -> Vec<f64> {
        let of_one = |index: usize| -> f64 {
            let weights = self.weights(index);
            weights.iter().map(|(other, weight)| weight * self.points[*other].deviation_mm).sum()
        };
        (0..self.points.len()).into_par_iter().map(of_one).collect()
    }

    /// By how much the variance of the noise grows, as a mean over the face, where `share_mm2` times the Laplacian is taken off each
    /// point. The noise of two points is correlated by exp(−h²/(2ℓ²)), ℓ being `length_mm`.
    pub(crate) fn noise_gain(&self, share_mm2: f64, length_mm: f64) -> f64 {
        let count = self.points.len();
        let every = count.div_ceil(LOOKS).max(1);
        let of_one = |index: usize| -> f64 {
            let mut terms: Vec<(usize, f64)> = self.weights(index);
            terms.iter_mut().for_each(|(_, weight)| *weight *= -share_mm2);
            terms.push((index, 1.0));
            let product = |&(a, weight_a): &(usize, f64), &(b, weight_b): &(usize, f64)| {
                let apart = minus(self.points[a].place_mm, self.points[b].place_mm);
                weight_a * weight_b * (-0.5 * dot(apart, apart) / (length_mm * length_mm)).exp()
            };
            terms.iter().map(|a| terms.iter().map(|b| product(a, b)).sum::<f64>()).sum()
        };
        let looks: Vec<f64> =
            (0..count).step_by(every).collect::<Vec<_>>().into_par_iter().map(of_one).collect();
        if looks.is_empty() { 1.0 } else { looks.iter().sum::<f64>() / looks.len() as f64 }
    }

    /// Points and weights whose sum is the Laplacian at a point; none where too few points lie about it.
    fn weights(&self, index: usize) -> Vec<(usize, f64)> {
        let own = &self.points[index];
        let [nx, ny, nz] = own.normal;
        // A tangent that is never parallel to the normal, which looks along z.
        let Some(u) = unit([nz, 0.0, -nx]) else { return Vec::new() };
        let v = cross([nx, ny, nz], u);
        let near = self.near(own.place_mm);
        let basis = |other: usize| {
            let from = minus(self.points[other].place_mm, own.place_mm);
            let (a, b) = (dot(from, u) / self.reach_mm, dot(from, v) / self.reach_mm);
            Vector6::new(1.0, a, b, a * a, a * b, b * b)
        };
        if near.len() < LEAST {
            return Vec::new();
        }
        let rows: Vec<Vector6<f64>> = near.iter().map(|&other| basis(other)).collect();
        let normal: Matrix6<f64> = rows.iter().map(|row| row * row.transpose()).sum();
        let scale = 2.0 / (self.reach_mm * self.reach_mm);
        let asked = Vector6::new(0.0, 0.0, 0.0, scale, 0.0, scale);
        let Some(solved) = solve(&normal, &asked) else { return Vec::new() };
        near.into_iter().zip(&rows).map(|(other, row)| (other, row.dot(&solved))).collect()
    }

    /// Points within the reach, in the order of the squares.
    fn near(&self, place_mm: Vector) -> Vec<usize> {
        let [column, row] = self.square(place_mm);
        let mut near = Vec::new();
        for row in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
            for column in column.saturating_sub(1)..=(column + 1).min(self.columns - 1) {
                let all = self.squares[row * self.columns + column].iter();
                near.extend(all.map(|&other| other as usize).filter(|&other| {
                    let apart = minus(self.points[other].place_mm, place_mm);
                    dot(apart, apart) <= self.reach_mm * self.reach_mm
                }));
            }
        }
        near
    }
}

/// The solution of a symmetric positive definite system; `None` where it is singular.
fn solve(matrix: &Matrix6<f64>, right: &Vector6<f64>) -> Option<Vector6<f64>> {
    let factor = matrix.cholesky()?;
    let pivots = factor.l_dirty().diagonal();
    let is_sound = (0..6).all(|i| pivots[i] * pivots[i] > SINGULAR * matrix[(i, i)]);
    is_sound.then(|| factor.solve(right))
}

/// Points that a paraboloid needs.
const LEAST: usize = 20;
/// Places at which the noise is looked at.
const LOOKS: usize = 400;
/// Pivots below this share of their diagonal are rounding.
const SINGULAR: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use rand_core::{Rng, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    use super::*;

    /// Points of a grid of 0.1 mm on a sphere of 20 mm, with a deviation.
    fn sheet(deviation_mm: impl Fn(f64, f64) -> f64) -> Sheet {
        let mut points = Vec::new();
        for j in -30..=30 {
            for i in -30..=30 {
                let (x, y) = (0.1 * f64::from(i), 0.1 * f64::from(j));
                let z = (400.0 - x * x - y * y).sqrt();
                let normal = [x / 20.0, y / 20.0, z / 20.0];
                points.push(Bent { place_mm: [x, y, z], normal, deviation_mm: deviation_mm(x, y) });
            }
        }
        Sheet::new(points, 0.6)
    }

    /// A wave loses as much of its Laplacian as the paraboloid over a disc takes: (k·R)²/16 in the first order.
    #[test]
    fn laplacians_are_those_of_the_deviation() {
        let bend = sheet(|x, y| 3e-3 * x * x - 1e-3 * x * y + 0.5e-3 * y * y);
        let found = bend.laplacians_per_mm();
        // A length along the sphere is longer than along x and y: at the corners squares by 5 %.
        let off = found.iter().map(|value| (value / 7e-3 - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < 0.08, "{off}");
        let k = 1.5;
        let wave = sheet(|x, _| 1e-3 * (k * x).cos());
        let middle = 30 * 61 + 30;
        let share = wave.laplacians_per_mm()[middle] / (-1e-3 * k * k);
        let expected = 1.0 - (k * 0.6_f64).powi(2) / 16.0;
        assert!((share - expected).abs() < 0.02, "{share} {expected}");
    }

    /// The variance of noise with a known correlation, drawn many times.
    #[test]
    fn noise_grows_as_its_draws_do() {
        let flat = sheet(|_, _| 0.0);
        let mut random = Pcg64Mcg::seed_from_u64(5);
        let share_mm2 = 0.02;
        let told = flat.noise_gain(share_mm2, 1e-3);
        let uniform =
            |random: &mut Pcg64Mcg| (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let (mut squares, mut count) = (0.0, 0.0);
        for _ in 0..12 {
            let mut noisy = sheet(|_, _| 0.0);
            for point in &mut noisy.points {
                let sum: f64 = (0..12).map(|_| uniform(&mut random)).sum();
                point.deviation_mm = sum - 6.0;
            }
            for (point, laplacian) in noisy.points.iter().zip(noisy.laplacians_per_mm()) {
                squares += (point.deviation_mm - share_mm2 * laplacian).powi(2);
                count += 1.0;
            }
        }
        let found = squares / count;
        assert!((found / told - 1.0).abs() < 0.03, "{found} {told}");
        assert!(told > 1.02, "{told}");
    }

    #[test]
    fn too_few_points_have_no_laplacian() {
        let alone = Bent { place_mm: [0.0; 3], normal: [0.0, 0.0, 1.0], deviation_mm: 1.0 };
        let sheet = Sheet::new(vec![alone; 30], 1.0);
        assert_eq!(sheet.laplacians_per_mm(), vec![0.0; 30]);
        assert_eq!(sheet.noise_gain(0.1, 1.0), 1.0);
        assert!(Sheet::new(Vec::new(), 1.0).laplacians_per_mm().is_empty());
    }
}

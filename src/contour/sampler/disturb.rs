//! Noise and outliers.

use std::f64::consts::TAU;

use asphera_geometry::Numbers;

use super::{SampledLine, TrueCurve};
use crate::PlaceMm;

/// How samples are disturbed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Radius of the disc within which every sample is moved, over the diagonal of the box round the curve.
    pub of_box: f64,
    /// Largest way along the normal over the local feature size.
    pub of_lfs: f64,
    /// Points anywhere in the box, in % of the samples.
    pub outliers_percent: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Disturbed samples.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Disturbed {
    /// The samples of all lines in order, then the outliers, mm.
    pub points_mm: Vec<PlaceMm>,
    /// The true edges between them, by rows.
    pub edges: Vec<[u32; 2]>,
    /// How many of the points are outliers.
    pub outliers: usize,
}

impl Disturbance {
    /// The samples of a curve, disturbed; the same seed gives the same points. All random numbers are even in their range.
    pub fn apply(&self, curve: &TrueCurve, lines: &[SampledLine]) -> Disturbed {
        let [radius, angle, normal, outlier] =
            [0, 1, 2, 3].map(|stream| Numbers::new(self.seed, 0, stream));
        let mut disturbed = Disturbed::default();
        for line in lines {
            let first = disturbed.points_mm.len();
            for (index, &[x, y]) in line.places_mm.iter().enumerate() {
                let row = first + index;
                let (sin, cos) = (TAU * angle.uniform(row)).sin_cos();
                // The root makes all places of the disc equally likely.
                let by_box = self.of_box * curve.diagonal_mm() * radius.uniform(row).sqrt();
                let by_lfs = self.of_lfs * line.lfs_mm[index] * (2.0 * normal.uniform(row) - 1.0);
                let [nx, ny] = line.normals[index];
                let by_lfs = if by_lfs.is_finite() { by_lfs } else { 0.0 };
                disturbed
                    .points_mm
                    .push([x + by_box * cos + by_lfs * nx, y + by_box * sin + by_lfs * ny]);
            }
            let end = disturbed.points_mm.len();
            let rows = first as u32..end as u32;
            disturbed.edges.extend(rows.clone().zip(rows.skip(1)).map(|(row, next)| [row, next]));
            if line.closed && end - first > 2 {
                disturbed.edges.push([first as u32, end as u32 - 1]);
            }
        }
        disturbed.edges.sort_unstable();
        let [low, high] = curve.bounds_mm();
        disturbed.outliers =
            (0.01 * self.outliers_percent * disturbed.points_mm.len() as f64).round() as usize;
        let place = |index: usize, axis: usize| {
            low[axis] + (high[axis] - low[axis]) * outlier.uniform(2 * index + axis)
        };
        disturbed
            .points_mm
            .extend((0..disturbed.outliers).map(|index| [place(index, 0), place(index, 1)]));
        disturbed
    }
}

//! Principal axes of points in space.

use asphera_geometry::{PointMm, Sum};
use nalgebra::{Matrix3, SymmetricEigen, Vector3};

/// Centre and principal axes of a set of points.
pub(crate) struct Principal {
    /// Mean of the points in mm.
    pub(crate) centre_mm: PointMm,
    /// Unit vectors, that of the largest spread first.
    pub(crate) axes: [[f64; 3]; 3],
    /// Standard deviation of the points along each axis in mm.
    pub(crate) spread_mm: [f64; 3],
}

impl Principal {
    /// `None` without points, or if a coordinate is not finite.
    ///
    /// The covariance is that of the deviations from the mean in units of the largest: neither
    /// the distance from the origin nor the unit of length matters, but for the rounding of the
    /// points themselves.
    pub(crate) fn of(points: &[PointMm]) -> Option<Principal> {
        let first = *points.first()?;
        if !points.as_flattened().iter().all(|coordinate| coordinate.is_finite()) {
            return None;
        }
        let count = points.len() as f64;
        let centre_mm: PointMm = std::array::from_fn(|axis| {
            let mut sum = Sum::default();
            points.iter().for_each(|point| sum.add(point[axis] - first[axis]));
            first[axis] + sum.total() / count
        });
        let deviation = |point: &PointMm| Vector3::from_fn(|axis, _| point[axis] - centre_mm[axis]);
        let size_mm = points.iter().map(|point| deviation(point).amax()).fold(0.0, f64::max);
        let mut moments = Matrix3::zeros();
        if size_mm > 0.0 {
            for point in points {
                let share = deviation(point) / size_mm;
                moments += share * share.transpose();
            }
        }
        // Without a limit of steps the decomposition always succeeds; a 3 × 3 one takes a few.
        let eigen = SymmetricEigen::new(moments / count);
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
        Some(Principal {
            centre_mm,
            axes: order.map(|i| eigen.eigenvectors.column(i).into_owned().into()),
            spread_mm: order.map(|i| size_mm * eigen.eigenvalues[i].max(0.0).sqrt()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_axes_of_a_box() {
        let corners =
            (0..8).map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
        let points: Vec<PointMm> = corners
            .map(|[x, y, z]: PointMm| [3.0 + 2.0 * x, 4.0 + 7.0 * y, 5.0 + 0.5 * z])
            .collect();
        let found = Principal::of(&points).unwrap();
        assert_eq!(found.centre_mm, [3.0, 4.0, 5.0]);
        for (spread, expected) in found.spread_mm.into_iter().zip([7.0, 2.0, 0.5]) {
            assert!((spread - expected).abs() < 1e-14, "{spread}");
        }
        assert_eq!(
            found.axes.map(|axis| axis.map(f64::abs).map(f64::round)),
            [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
        );
    }

    #[test]
    fn no_points_and_broken_ones() {
        assert!(Principal::of(&[]).is_none());
        assert!(Principal::of(&[[0.0, f64::NAN, 0.0]]).is_none());
        assert_eq!(Principal::of(&[[1e6, 2.0, 3.0]; 4]).unwrap().spread_mm, [0.0; 3]);
    }
}

//! The plane nearest to points, and how far they stand off it.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::PointMm;

/// The plane with the smallest sum of squared orthogonal distances: it goes through the centroid and its
/// normal is the eigenvector of the smallest eigenvalue of the second moments (Pearson, Phil. Mag. 2 (1901)
/// 559).
#[derive(Clone, Copy, Debug)]
pub(crate) struct BestPlane {
    pub(crate) centroid: Vector3<f64>,
    /// Unit length, z not negative.
    pub(crate) normal: Vector3<f64>,
    /// Root mean square distance of the points in mm.
    pub(crate) rms_mm: f64,
    /// Root mean square distance of the points from the centroid in mm.
    pub(crate) extent_mm: f64,
}

impl BestPlane {
    /// `None` if the points determine no plane or their squares overflow.
    pub(crate) fn of(points: &[PointMm]) -> Option<BestPlane> {
        let count = points.len() as f64;
        let centroid = centroid(points);
        let mut moments = Matrix3::zeros();
        for point in points {
            let from = Vector3::from(*point) - centroid;
            moments += from * from.transpose();
        }
        if !moments.iter().all(|moment| moment.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::try_new(moments, f64::EPSILON, STEPS)?;
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        if eigen.eigenvalues[order[1]] <= FLAT * eigen.eigenvalues[order[2]] {
            return None;
        }
        let mut normal: Vector3<f64> = eigen.eigenvectors.column(order[0]).into_owned();
        if normal.z < 0.0 {
            normal = -normal;
        }
        // Not the root of the eigenvalue, which is only known to the rounding of the largest.
        let distance = |point: &PointMm| normal.dot(&(Vector3::from(*point) - centroid));
        let square: f64 = points.iter().map(|point| distance(point).powi(2)).sum();
        Some(BestPlane {
            centroid,
            normal,
            rms_mm: (square / count).sqrt(),
            extent_mm: (moments.trace() / count).sqrt(),
        })
    }

    /// Whether the points stand off the plane by more than rounding: those of a line in space, however curved, do not.
    pub(crate) fn has_relief(&self) -> bool {
        self.rms_mm > ROUNDING * self.extent_mm
    }
}

/// Mean of the points; NaN without any.
pub(crate) fn centroid(points: &[PointMm]) -> Vector3<f64> {
    let sum: Vector3<f64> = points.iter().map(|&point| Vector3::from(point)).sum();
    sum / points.len() as f64
}

/// Directions with a smaller share of the extent are not determined.
const FLAT: f64 = 1e-12;
/// Below this share of the extent a distance may be rounding.
const ROUNDING: f64 = 1e-12;
/// Far more than a matrix of three columns needs.
const STEPS: usize = 10_000;

//! How far noise turns a facet.

use asphera_geometry::{PointMm, Triangle};

use super::Noise;

/// By what angle in rad noise turns the facet of these three corners, root mean square, to first
/// order: a value that is not small against 1 says that its direction is lost.
///
/// The plane through three points is linear in their deviations δᵢ along its normal: its gradient
/// is Σ δᵢ ∇λᵢ with the barycentric coordinates λᵢ, and |∇λᵢ| = eᵢ / 2A with eᵢ the side opposite
/// corner i and A the area. With independent deviations of standard deviation σ
///
/// ```text
///     tilt² = σ² (e₁² + e₂² + e₃²) / 4A²
/// ```
///
/// for both components of the tilt together. That is (2σ/h)² for half a square of side h and for an
/// equilateral triangle of side h. Noise along z counts with its part along the facet's normal.
/// `None` for a triangle without area, or with a coordinate that is not finite.
pub fn facet_tilt_rad(corners: [PointMm; 3], noise: Noise) -> Option<f64> {
    let triangle = Triangle::new(&corners, [0, 1, 2]);
    let area_mm2 = triangle.area_mm2();
    // Written so that NaN fails.
    if !(area_mm2 > 0.0 && area_mm2.is_finite()) {
        return None;
    }
    let cosine = triangle.projected_area_mm2().abs() / area_mm2;
    let squares_mm2: f64 = (0..3)
        .flat_map(|i| (0..3).map(move |axis| corners[i][axis] - corners[(i + 1) % 3][axis]))
        .map(|part| part * part)
        .sum();
    Some(noise.along_normal_mm(cosine) * squares_mm2.sqrt() / (2.0 * area_mm2))
}

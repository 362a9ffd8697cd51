//! Vectors in space.

use asphera_geometry::PointMm;
pub(crate) use asphera_geometry::vector::{cross, dot, minus};

#[inline(always)]
pub(crate) fn scaled(a: PointMm, factor: f64) -> PointMm {
    a.map(|side| side * factor)
}

/// The direction of a vector; `None` of one too short to have one.
#[inline(always)]
pub(crate) fn unit(a: PointMm) -> Option<PointMm> {
    let length = dot(a, a).sqrt();
    (length > f64::MIN_POSITIVE && length.is_finite()).then(|| scaled(a, 1.0 / length))
}

/// Twice the area of a triangle, as a vector along its normal.
#[inline(always)]
pub(crate) fn double_area([a, b, c]: [PointMm; 3]) -> PointMm {
    cross(minus(b, a), minus(c, a))
}

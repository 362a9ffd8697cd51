//! Vectors and boxes in space.

pub(crate) use asphera_geometry::vector::{cross, dot, minus, plus};
use asphera_geometry::{BoxMm, PointMm, greater, lesser};

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

/// Square of the distance of two places.
#[inline(always)]
pub(crate) fn squared(p: PointMm, q: PointMm) -> f64 {
    let way = minus(p, q);
    dot(way, way)
}

/// Square of the distance of two boxes.
#[inline(always)]
pub(crate) fn gap(a: &BoxMm, b: &BoxMm) -> f64 {
    let mut sum = 0.0;
    for axis in 0..3 {
        let way = greater(a.low[axis] - b.high[axis], b.low[axis] - a.high[axis]);
        let way = greater(way, 0.0);
        sum += way * way;
    }
    sum
}

/// The box of two boxes.
#[inline(always)]
pub(crate) fn joined(a: &BoxMm, b: &BoxMm) -> BoxMm {
    BoxMm {
        low: [0, 1, 2].map(|axis| lesser(a.low[axis], b.low[axis])),
        high: [0, 1, 2].map(|axis| greater(a.high[axis], b.high[axis])),
    }
}

//! Vectors in space, as far as medial balls need them.

use asphera_geometry::PointMm;

pub(super) fn minus(p: PointMm, q: PointMm) -> [f64; 3] {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

pub(super) fn distance(p: PointMm, q: PointMm) -> f64 {
    norm(minus(p, q))
}

/// The point that lies `way` along `direction` from `p`.
pub(super) fn along(p: PointMm, direction: [f64; 3], way: f64) -> PointMm {
    [p[0] + way * direction[0], p[1] + way * direction[1], p[2] + way * direction[2]]
}

/// The direction of a vector; `None` if it is not finite or too short to have one.
pub(super) fn unit(a: [f64; 3]) -> Option<[f64; 3]> {
    let length = norm(a);
    (length.is_finite() && length > f64::MIN_POSITIVE.sqrt()).then(|| a.map(|part| part / length))
}

//! Vectors in space, as far as medial balls need them.

use asphera_geometry::PointMm;
pub(super) use asphera_geometry::vector::{cross, dot, length as norm, minus};

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

//! Cubic Bézier curves.

use crate::PlaceMm;

/// The place of a curve at a parameter from 0 to 1.
pub(crate) fn at([a, b, c, d]: &[PlaceMm; 4], t: f64) -> PlaceMm {
    let s = 1.0 - t;
    let [u, v, w, z] = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    std::array::from_fn(|axis| u * a[axis] + v * b[axis] + w * c[axis] + z * d[axis])
}

/// The derivative at a parameter.
pub(crate) fn slope([a, b, c, d]: &[PlaceMm; 4], t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    std::array::from_fn(|axis| {
        3.0 * (s * s * (b[axis] - a[axis])
            + 2.0 * s * t * (c[axis] - b[axis])
            + t * t * (d[axis] - c[axis]))
    })
}

/// The second derivative at a parameter.
pub(crate) fn bend([a, b, c, d]: &[PlaceMm; 4], t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    std::array::from_fn(|axis| {
        6.0 * (s * (c[axis] - 2.0 * b[axis] + a[axis]) + t * (d[axis] - 2.0 * c[axis] + b[axis]))
    })
}

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

/// The direction of a curve at a parameter, of length 1; that of its next control point where the derivative is zero at an end, and 0
/// of a curve that is a place.
pub(crate) fn direction(piece: &[PlaceMm; 4], t: f64) -> [f64; 2] {
    let [a, b, c, d] = *piece;
    let way = |p: PlaceMm, q: PlaceMm| [q[0] - p[0], q[1] - p[1]];
    let further = if t < 0.5 { [way(a, c), way(a, d)] } else { [way(b, d), way(a, d)] };
    let ways = [slope(piece, t), further[0], further[1]];
    let lengths = ways.map(|[x, y]| x.hypot(y));
    let found = ways.iter().zip(lengths).find(|(_, length)| *length > 0.0);
    found.map_or([0.0; 2], |([x, y], length)| [x / length, y / length])
}

//! Questions about places in the plane, decided exactly.
//!
//! A place is x and y in mm. Coordinates must be zero or at least [`crate::TINY_MM`] in size, and at most
//! [`crate::RANGE_MM`]: then no answer depends on rounding.

use std::cmp::Ordering;

use crate::exact::{self, lengths};

/// Side of the directed line from `a` to `b` on which `c` lies: `Greater` is left, `Less` right, `Equal` on the line.
#[inline]
pub fn orientation(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Ordering {
    exact::orientation(a, b, c)
}

/// Position of `d` about the circle through `a`, `b`, `c`, which must turn counter-clockwise: `Greater` is inside, `Less`
/// outside, `Equal` on the circle.
#[inline]
pub fn in_circle(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> Ordering {
    exact::in_circle(a, b, c, d)
}

/// Comparison of the distance from `a` to `b` with that from `c` to `d`.
#[inline]
pub fn compare_distances(a: [f64; 2], b: [f64; 2], c: [f64; 2], d: [f64; 2]) -> Ordering {
    lengths::compare_distances(a, b, c, d)
}

/// Sign of the scalar product of the ways from `apex` to `a` and to `b`: `Greater` is an acute angle, `Equal` a right one,
/// `Less` an obtuse one.
#[inline]
pub fn scalar_product(apex: [f64; 2], a: [f64; 2], b: [f64; 2]) -> Ordering {
    lengths::scalar_product(apex, a, b)
}

/// Comparison of the sum of the angles at `r` and `s` over the edge from `p` to `q` with a right angle.
///
/// `r` and `s` must lie on different sides of the edge, and the sum must be at most 180°, as it is of two triangles of a
/// Delaunay triangulation.
#[inline]
pub fn compare_angle_sum(p: [f64; 2], q: [f64; 2], r: [f64; 2], s: [f64; 2]) -> Ordering {
    lengths::compare_angle_sum(p, q, r, s)
}

/// Comparison of the distance from `p` to `q` with the sum of those from `p` to `a` and from `q` to `b`.
#[inline]
pub fn compare_with_sum(p: [f64; 2], q: [f64; 2], a: [f64; 2], b: [f64; 2]) -> Ordering {
    lengths::compare_with_sum(p, q, a, b)
}

/// Order of places by x, then y, by which the mesh decides ties.
#[inline]
pub fn by_x_then_y(p: [f64; 2], q: [f64; 2]) -> Ordering {
    exact::by_x_then_y(p, q)
}

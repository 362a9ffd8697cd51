//! Spheres of tetrahedra and smallest balls of triangles: their diameters compared with a length, and places in them.
//!
//! Each is first computed in doubles. With u half a unit in the last place of 1 a form of products of up to six differences has
//! a relative error of at most 30u of the sum of sizes of its terms; 64u is taken. Then whole numbers decide.

use std::cmp::Ordering;

use super::limbs::Limbs;
use super::space::Place3;
use super::unrounded::by_size;
use super::{UNIT_ROUNDOFF, sign};

/// Comparison of the diameter of the sphere through four places with `diameter_mm`, which must not be negative.
///
/// Of coplanar places the diameter is infinite: `Greater`. With the differences a, b, c from `d` the diameter is the length of
/// |a|²·b×c + |b|²·c×a + |c|²·a×b over the determinant of a, b, c.
pub fn compare_sphere([a, b, c, d]: [Place3; 4], diameter_mm: f64) -> Ordering {
    let [u, v, w] = [a, b, c].map(|p| minus(p, d));
    let (mut top, mut top_size) = (0.0, 0.0);
    for axis in 0..3 {
        let (mut value, mut size) = (0.0, 0.0);
        for (raised, p, q) in [(u, v, w), (v, w, u), (w, u, v)] {
            let (minor, minor_size) = minor(p, q, axis);
            value += lift(raised) * minor;
            size += lift(raised) * minor_size;
        }
        top += value * value;
        top_size += size * size;
    }
    let (mut det, mut det_size) = (0.0, 0.0);
    for (axis, part) in u.into_iter().enumerate() {
        let (minor, minor_size) = minor(v, w, axis);
        det += part * minor;
        det_size += part.abs() * minor_size;
    }
    let squared = diameter_mm * diameter_mm;
    let rest = top - squared * det * det;
    if rest.abs() > BOUND * (top_size + squared * det_size * det_size) {
        return sign(rest);
    }
    let [ax, ay, az] = pairs(a, d);
    let [bx, by, bz] = pairs(b, d);
    let [cx, cy, cz] = pairs(c, d);
    by_size(
        [ax, ay, az, bx, by, bz, cx, cy, cz, [diameter_mm, 0.0]],
        sphere_order::<1, 2, 3, 4, 6, 8>,
        sphere_order::<2, 4, 6, 8, 12, 16>,
        sphere_order::<4, 8, 12, 16, 24, 32>,
        sphere_order::<33, 66, 99, 132, 198, 264>,
    )
}

/// Comparison of the diameter of the circle through three places in space with `diameter_mm`, which must not be negative.
///
/// It is the product of the sides over the length of the cross product of two: infinite on a line, hence `Greater`.
pub fn compare_facet_circle([a, b, c]: [Place3; 3], diameter_mm: f64) -> Ordering {
    let [u, v] = [minus(a, c), minus(b, c)];
    let sides = lift(u) * lift(v) * lift(minus(a, b));
    let (mut area, mut size) = (0.0, 0.0);
    for axis in 0..3 {
        let (minor, minor_size) = minor(u, v, axis);
        area += minor * minor;
        size += minor_size * minor_size;
    }
    let squared = diameter_mm * diameter_mm;
    let rest = sides - squared * area;
    if rest.abs() > BOUND * (sides + squared * size) {
        return sign(rest);
    }
    let [ax, ay, az] = pairs(a, c);
    let [bx, by, bz] = pairs(b, c);
    let [cx, cy, cz] = pairs(a, b);
    by_size(
        [ax, ay, az, bx, by, bz, cx, cy, cz, [diameter_mm, 0.0]],
        circle_order::<1, 2, 4, 6>,
        circle_order::<2, 4, 8, 12>,
        circle_order::<4, 8, 16, 24>,
        circle_order::<33, 66, 132, 198>,
    )
}

/// Position of `d` about the smallest ball with `a`, `b`, `c` on its sphere: `Greater` is inside, `Equal` on the sphere.
///
/// The three must not lie on a line. With differences from `c` and n = a×b the sign is that of
/// d·((|a|²·b − |b|²·a)×n) − |d|²·|n|².
pub fn in_facet_ball([a, b, c]: [Place3; 3], d: Place3) -> Ordering {
    let [u, v, w] = [a, b, d].map(|p| minus(p, c));
    let (mut n, mut n_size, mut g, mut g_size) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]);
    for axis in 0..3 {
        (n[axis], n_size[axis]) = minor(u, v, axis);
        let (left, right) = (lift(u) * v[axis], lift(v) * u[axis]);
        (g[axis], g_size[axis]) = (left - right, left.abs() + right.abs());
    }
    let (mut value, mut size) = (-lift(w) * lift(n), lift(w) * lift(n_size));
    for (axis, part) in w.into_iter().enumerate() {
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        value += part * (g[i] * n[j] - g[j] * n[i]);
        size += part.abs() * (g_size[i] * n_size[j] + g_size[j] * n_size[i]);
    }
    if value.abs() > BOUND * size {
        return sign(value);
    }
    let [ax, ay, az] = pairs(a, c);
    let [bx, by, bz] = pairs(b, c);
    let [dx, dy, dz] = pairs(d, c);
    by_size(
        [ax, ay, az, bx, by, bz, dx, dy, dz],
        ball_sign::<1, 2, 3, 4, 5, 6>,
        ball_sign::<2, 4, 6, 8, 10, 12>,
        ball_sign::<4, 8, 12, 16, 20, 24>,
        ball_sign::<33, 66, 99, 132, 165, 198>,
    )
}

#[inline(always)]
fn minus(a: Place3, b: Place3) -> Place3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn lift(p: Place3) -> f64 {
    p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
}

/// A component of p × q, and the sum of the sizes of its terms.
#[inline(always)]
fn minor(p: Place3, q: Place3, axis: usize) -> (f64, f64) {
    let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
    let (left, right) = (p[i] * q[j], p[j] * q[i]);
    (left - right, left.abs() + right.abs())
}

fn pairs(from: Place3, to: Place3) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|axis| [from[axis], to[axis]])
}

type Whole<const D: usize> = [Limbs<D>; 3];

fn whole_cross<const D: usize, const E: usize, const S: usize>(
    p: Whole<D>,
    q: Whole<E>,
) -> Whole<S> {
    [(1, 2), (2, 0), (0, 1)]
        .map(|(i, j)| p[i].product::<E, S>(q[j]).minus(p[j].product::<E, S>(q[i])))
}

fn whole_dot<const D: usize, const E: usize, const S: usize>(p: Whole<D>, q: Whole<E>) -> Limbs<S> {
    let [x, y, z] = [0, 1, 2].map(|axis| p[axis].product::<E, S>(q[axis]));
    x.plus(y).plus(z)
}

/// For differences of at most B = 2⁶⁴ᴰ⁻²: the numerator is at most 18B⁴ along an axis, its square 972B⁸; the determinant 6B³, its
/// square times that of the diameter 36B⁸. Both are below 2⁵¹²ᴰ⁻² and fit 8D limbs.
fn sphere_order<
    const D: usize,
    const P: usize,
    const T: usize,
    const Q: usize,
    const S: usize,
    const E: usize,
>(
    [ax, ay, az, bx, by, bz, cx, cy, cz, diameter]: [Limbs<D>; 10],
) -> Ordering {
    let rows: [Whole<D>; 3] = [[ax, ay, az], [bx, by, bz], [cx, cy, cz]];
    let term = |i: usize| -> Whole<Q> {
        let lift: Limbs<P> = whole_dot(rows[i], rows[i]);
        let cross: Whole<P> = whole_cross(rows[(i + 1) % 3], rows[(i + 2) % 3]);
        cross.map(|part| part.product(lift))
    };
    let [a, b, c] = [term(0), term(1), term(2)];
    let top: Whole<Q> = [0, 1, 2].map(|axis| a[axis].plus(b[axis]).plus(c[axis]));
    let cross: Whole<P> = whole_cross(rows[1], rows[2]);
    let det: Limbs<T> = whole_dot(rows[0], cross);
    let det_squared: Limbs<S> = det.product(det);
    let squared: Limbs<P> = diameter.product(diameter);
    whole_dot::<Q, Q, E>(top, top).minus(det_squared.product(squared)).sign()
}

/// For differences of at most B = 2⁶⁴ᴰ⁻²: both products are at most 27B⁶, below 2³⁸⁴ᴰ⁻⁷, and fit 6D limbs.
fn circle_order<const D: usize, const P: usize, const Q: usize, const S: usize>(
    [ax, ay, az, bx, by, bz, cx, cy, cz, diameter]: [Limbs<D>; 10],
) -> Ordering {
    let [a, b, c]: [Whole<D>; 3] = [[ax, ay, az], [bx, by, bz], [cx, cy, cz]];
    let two: Limbs<Q> = whole_dot::<D, D, P>(a, a).product(whole_dot::<D, D, P>(b, b));
    let sides: Limbs<S> = two.product(whole_dot::<D, D, P>(c, c));
    let cross: Whole<P> = whole_cross(a, b);
    let area: Limbs<Q> = whole_dot(cross, cross);
    sides.minus(area.product(diameter.product::<D, P>(diameter))).sign()
}

/// For differences of at most B = 2⁶⁴ᴰ⁻²: the form is at most 108B⁶, below 2³⁸⁴ᴰ⁻⁵, and fits 6D limbs.
fn ball_sign<
    const D: usize,
    const P: usize,
    const T: usize,
    const Q: usize,
    const F: usize,
    const S: usize,
>(
    [ax, ay, az, bx, by, bz, dx, dy, dz]: [Limbs<D>; 9],
) -> Ordering {
    let [a, b, d]: [Whole<D>; 3] = [[ax, ay, az], [bx, by, bz], [dx, dy, dz]];
    let n: Whole<P> = whole_cross(a, b);
    let [a_lift, b_lift, d_lift]: [Limbs<P>; 3] = [a, b, d].map(|p| whole_dot(p, p));
    let g: Whole<T> = [0, 1, 2]
        .map(|axis| b[axis].product::<P, T>(a_lift).minus(a[axis].product::<P, T>(b_lift)));
    let centre: Whole<F> = whole_cross(g, n);
    let n_lift: Limbs<Q> = whole_dot(n, n);
    whole_dot::<D, F, S>(d, centre).minus(n_lift.product(d_lift)).sign()
}

/// Of the sum of the sizes of the terms.
const BOUND: f64 = 64.0 * UNIT_ROUNDOFF;

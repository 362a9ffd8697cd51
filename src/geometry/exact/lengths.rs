//! Predicates of lengths and angles: distances compared, and signs of forms of up to the fourth degree in the differences.
//!
//! Each is first computed in doubles with a bound of its rounding, and only where that leaves the sign open in whole numbers
//! ([`super::unrounded`]). The bounds are coarse: with u half a unit in the last place of 1 a difference has a relative
//! error of u, a product of two differences of 3u, and a sum of two such of 4u of the sum of their sizes. A product of two of
//! those has at most 9u, sums and differences of them at most 12u of the sum of sizes; 16u is taken.
//! As with [`super::orientation`] no product may underflow.

use std::cmp::Ordering;

use super::limbs::Limbs;
use super::unrounded::{Form, decide};
use super::{Place, UNIT_ROUNDOFF, sign};

/// How the distance from `a` to `b` compares with that from `c` to `d`.
#[inline]
pub fn compare_distances(a: Place, b: Place, c: Place, d: Place) -> Ordering {
    if let Some(order) = certain_distances(squared_distance(a, b), squared_distance(c, d)) {
        return order;
    }
    if (a == c && b == d) || (a == d && b == c) {
        return Ordering::Equal;
    }
    decide::<DistanceForm, 4>([[a[0], b[0]], [a[1], b[1]], [c[0], d[0]], [c[1], d[1]]])
}

/// How two distances compare by their squares as [`squared_distance`] gives them; none where rounding leaves that open, which
/// [`compare_distances`] decides.
///
/// Who compares many distances computes each square once.
#[inline(always)]
pub fn certain_distances(squared_ab: f64, squared_cd: f64) -> Option<Ordering> {
    let rest = squared_ab - squared_cd;
    (rest.abs() > QUADRATIC_BOUND * (squared_ab + squared_cd)).then(|| sign(rest))
}

/// The squared distance in doubles, within a relative 4u.
#[inline(always)]
pub fn squared_distance(a: Place, b: Place) -> f64 {
    let [x, y] = [a[0] - b[0], a[1] - b[1]];
    x * x + y * y
}

/// The sign of the scalar product of the ways from `apex` to `a` and to `b`: `Greater` says that the angle at `apex` is
/// acute, `Equal` that it is right (or a way is zero), `Less` that it is obtuse.
#[inline]
pub fn scalar_product(apex: Place, a: Place, b: Place) -> Ordering {
    let [ax, ay, bx, by] = [a[0] - apex[0], a[1] - apex[1], b[0] - apex[0], b[1] - apex[1]];
    let (left, right) = (ax * bx, ay * by);
    let sum = left + right;
    if sum.abs() > QUADRATIC_BOUND * (left.abs() + right.abs()) {
        return sign(sum);
    }
    decide::<ScalarForm, 4>([[a[0], apex[0]], [a[1], apex[1]], [b[0], apex[0]], [b[1], apex[1]]])
}

/// How the sum of the angles under which `r` and `s`, on different sides, see the edge from `p` to `q` compares with a
/// right angle.
///
/// The sum must be at most 180°, as it is where both triangles are of a Delaunay triangulation. Its cosine has the sign of
/// d·d' - c·c', where d and d' are the scalar products at `r` and `s`, c and c' the sizes of their cross products.
pub fn compare_angle_sum(p: Place, q: Place, r: Place, s: Place) -> Ordering {
    let ways = |apex: Place| [p[0] - apex[0], p[1] - apex[1], q[0] - apex[0], q[1] - apex[1]];
    let parts = |[px, py, qx, qy]: [f64; 4]| {
        let dot = (px * qx + py * qy, (px * qx).abs() + (py * qy).abs());
        let cross = (px * qy - py * qx, (px * qy).abs() + (py * qx).abs());
        (dot, cross)
    };
    let ((dot_r, dot_r_size), (cross_r, cross_r_size)) = parts(ways(r));
    let ((dot_s, dot_s_size), (cross_s, cross_s_size)) = parts(ways(s));
    // On different sides the cross products have different signs, so that c·c' is minus their product.
    let cosine = dot_r * dot_s + cross_r * cross_s;
    let size = dot_r_size * dot_s_size + cross_r_size * cross_s_size;
    if cosine.abs() > QUARTIC_BOUND * size {
        return sign(cosine).reverse();
    }
    let pairs = |apex: Place| [[p[0], apex[0]], [p[1], apex[1]], [q[0], apex[0]], [q[1], apex[1]]];
    let ([a, b, c, d], [e, f, g, h]) = (pairs(r), pairs(s));
    decide::<AngleForm, 8>([a, b, c, d, e, f, g, h]).reverse()
}

/// How the distance from `p` to `q` compares with the sum of those from `p` to `a` and from `q` to `b`.
///
/// With the squares C, A and B of the three: c > a + b where C - A - B > 0 and (C - A - B)² > 4·A·B.
pub fn compare_with_sum(p: Place, q: Place, a: Place, b: Place) -> Ordering {
    let [pq, pa, qb] = [squared_distance(p, q), squared_distance(p, a), squared_distance(q, b)];
    let rest = pq - pa - qb;
    let size = pq + pa + qb;
    if rest < -QUADRATIC_BOUND * size {
        return Ordering::Less;
    }
    let difference = rest * rest - 4.0 * pa * qb;
    if rest > QUADRATIC_BOUND * size && difference.abs() > QUARTIC_BOUND * size * size {
        return sign(difference);
    }
    decide::<SumForm, 6>([
        [p[0], q[0]],
        [p[1], q[1]],
        [p[0], a[0]],
        [p[1], a[1]],
        [q[0], b[0]],
        [q[1], b[1]],
    ])
}

/// x² + y² of the first two less that of the last: at most 2B² in size.
struct DistanceForm;

impl Form<4> for DistanceForm {
    fn sign<const D: usize, const P: usize, const Q: usize>(
        [ax, ay, bx, by]: [Limbs<D>; 4],
    ) -> Ordering {
        lift::<D, P>(ax, ay).minus(lift(bx, by)).sign()
    }
}

/// The scalar product: at most 2B² in size.
struct ScalarForm;

impl Form<4> for ScalarForm {
    fn sign<const D: usize, const P: usize, const Q: usize>(
        [ax, ay, bx, by]: [Limbs<D>; 4],
    ) -> Ordering {
        scalar::<D, P>(ax, ay, bx, by).sign()
    }
}

/// Scalar products times each other and cross products times each other: 8B⁴ at most.
struct AngleForm;

impl Form<8> for AngleForm {
    fn sign<const D: usize, const P: usize, const Q: usize>(
        [a, b, c, d, e, f, g, h]: [Limbs<D>; 8],
    ) -> Ordering {
        let cross = |px: Limbs<D>, py: Limbs<D>, qx: Limbs<D>, qy: Limbs<D>| -> Limbs<P> {
            px.times::<P>(qy).minus(py.times(qx))
        };
        let dots: Limbs<Q> = scalar::<D, P>(a, b, c, d).times(scalar::<D, P>(e, f, g, h));
        dots.plus(cross(a, b, c, d).times(cross(e, f, g, h))).sign()
    }
}

/// C - A - B is at most 4B² in size, its square 16B⁴, as is 4·A·B: their difference is below 2⁴·B⁴.
struct SumForm;

impl Form<6> for SumForm {
    fn sign<const D: usize, const P: usize, const Q: usize>(
        [cx, cy, ax, ay, bx, by]: [Limbs<D>; 6],
    ) -> Ordering {
        let [c, a, b]: [Limbs<P>; 3] = [lift(cx, cy), lift(ax, ay), lift(bx, by)];
        let rest = c.minus(a).minus(b);
        if rest.sign().is_lt() {
            return Ordering::Less;
        }
        let twice: Limbs<Q> = a.times(b);
        let twice = twice.plus(twice);
        rest.times::<Q>(rest).minus(twice.plus(twice)).sign()
    }
}

fn lift<const D: usize, const P: usize>(x: Limbs<D>, y: Limbs<D>) -> Limbs<P> {
    x.times::<P>(x).plus(y.times(y))
}

fn scalar<const D: usize, const P: usize>(
    ax: Limbs<D>,
    ay: Limbs<D>,
    bx: Limbs<D>,
    by: Limbs<D>,
) -> Limbs<P> {
    ax.times::<P>(bx).plus(ay.times(by))
}

/// Of the sum of the sizes of products of two differences.
const QUADRATIC_BOUND: f64 = 8.0 * UNIT_ROUNDOFF;
/// Of the sum of the sizes of products of four.
const QUARTIC_BOUND: f64 = 32.0 * UNIT_ROUNDOFF;

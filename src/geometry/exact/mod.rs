//! The geometric predicates of the mesh, decided exactly for any doubles it admits.
//!
//! A predicate is first computed in plain doubles with the rounding-error bound of J. R. Shewchuk,
//! *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, Discrete &
//! Computational Geometry 18 (1997) 305-363, doi:10.1007/PL00009321, sections 4.2 and 4.3. Only if
//! the bound does not decide the sign is the determinant computed without rounding ([`unrounded`]).
//! Unlike Shewchuk's that is done in whole numbers of fixed size, not in expansions of doubles: on
//! a raster the neighbours of a point lie exactly or nearly on circles, so that the unrounded
//! computation is the rule there and must be cheap.
//!
//! The bounds hold as long as no product underflows: coordinates must be zero or at least 2⁻¹⁴² in
//! size, of which [`crate::TINY_MM`] is well inside. Products that overflow leave the decision to
//! the whole numbers, which hold any finite doubles.

pub(crate) mod balls;
pub(crate) mod lengths;
pub(crate) mod limbs;
pub(crate) mod radius;
pub(crate) mod space;
pub(crate) mod sphere;
pub(crate) mod unrounded;

use std::cmp::Ordering;

/// A place in the plane: x and y in mm.
pub type Place = [f64; 2];

/// On which side of the directed line from `a` to `b` the place `c` lies: `Greater` is left
/// (`a`, `b`, `c` turn counter-clockwise), `Less` is right, `Equal` is exactly on the line.
#[inline]
pub fn orientation(a: Place, b: Place, c: Place) -> Ordering {
    let (det, bound) = estimated_orientation(a, b, c);
    if det.abs() >= bound { sign(det) } else { unrounded::orientation(a, b, c) }
}

/// Whether `c` lies strictly left of the directed line from `a` to `b`.
#[inline]
pub fn left_of(a: Place, b: Place, c: Place) -> bool {
    let (det, bound) = estimated_orientation(a, b, c);
    if det.abs() >= bound { det > 0.0 } else { unrounded::orientation(a, b, c).is_gt() }
}

/// Whether a boundary edge of a convex hull that runs from `a` to `b` with the hull on its right
/// must give way to `p`: `p` lies strictly left of it, or on it strictly between its ends.
///
/// `a` and `b` must differ.
#[inline]
pub fn outside_edge(a: Place, b: Place, p: Place) -> bool {
    match orientation(a, b, p) {
        Ordering::Greater => true,
        Ordering::Less => false,
        Ordering::Equal => {
            // Along an axis in which the ends differ the order on the line is that of coordinates.
            let axis = usize::from(a[0] == b[0]);
            (a[axis] < p[axis] && p[axis] < b[axis]) || (b[axis] < p[axis] && p[axis] < a[axis])
        }
    }
}

/// Where `d` lies about the circle through `a`, `b`, `c`, which must turn counter-clockwise:
/// `Greater` is inside, `Less` outside, `Equal` exactly on the circle.
#[inline]
pub fn in_circle(a: Place, b: Place, c: Place, d: Place) -> Ordering {
    let (det, bound) = estimated_in_circle(a, b, c, d);
    if det.abs() > bound { sign(det) } else { unrounded::in_circle([a, b, c], d) }
}

/// Whether `d` lies inside the circle through `a`, `b`, `c`, which must turn counter-clockwise,
/// where no four places count as lying on one circle. `d` must differ from the other three.
///
/// The Delaunay triangulation is that of the lower convex hull of the places lifted to
/// z = x² + y². Of places on one circle it is not unique. Here every place counts as lifted by an
/// infinitesimal amount more, that of a place infinitely larger than those of all places that
/// precede it by x, then y. So of four on one circle the last lies outside the circle of the
/// others, the diagonal that avoids it belongs to the triangulation, and the triangulation of any
/// places is unique, whatever their order of arrival. The rule asks for coordinates alone: moving
/// all by one vector without rounding changes nothing. It is the perturbation of O. Devillers and
/// M. Teillaud, *Perturbations for Delaunay and weighted Delaunay 3D triangulations*, Computational
/// Geometry 44 (2011) 160-168, doi:10.1016/j.comgeo.2010.09.010, in the plane.
#[inline]
pub fn encloses(a: Place, b: Place, c: Place, d: Place) -> bool {
    let (det, bound) = estimated_in_circle(a, b, c, d);
    if det.abs() > bound { det > 0.0 } else { encloses_unrounded(a, b, c, d) }
}

#[inline(never)]
fn encloses_unrounded(a: Place, b: Place, c: Place, d: Place) -> bool {
    match unrounded::in_circle([a, b, c], d) {
        Ordering::Greater => true,
        Ordering::Less => false,
        Ordering::Equal => encloses_on_circle(a, b, c, d),
    }
}

/// [`encloses`] for four different places on one circle.
///
/// If the last of the four is `d`, it lies outside. Else take it for `c`; the circle may be turned.
/// Since `c` is raised, it lies outside the circle of the others, and their triangle belongs to the
/// triangulation of the four. If `a`, `b`, `d` turn left, that triangle lies on the same side of
/// the edge from `a` to `b` as the given one, which hence does not belong: it encloses `d`. If they
/// turn right, both lie on different sides of the edge, which is the diagonal: both belong.
///
/// ```text
///     d --- c = last            c = last
///     | \   |                  / \
///     |   \ |                 a---b
///     a --- b                  \ /
///                               d
///   encloses: the diagonal    does not: the
///   is that from b to d       diagonal is a-b
/// ```
fn encloses_on_circle(a: Place, b: Place, c: Place, d: Place) -> bool {
    let last = if by_x_then_y(a, b).is_lt() { b } else { a };
    let last = if by_x_then_y(last, c).is_lt() { c } else { last };
    if by_x_then_y(last, d).is_lt() {
        false
    } else if last == a {
        left_of(d, b, c)
    } else if last == b {
        left_of(a, d, c)
    } else {
        left_of(a, b, d)
    }
}

/// The order by x, then y, by which ties are decided.
#[inline]
pub fn by_x_then_y(p: Place, q: Place) -> Ordering {
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1]))
}

/// The determinant of the orientation in doubles, and a bound: at or above it the sign is right.
///
/// A bound of zero means that both products are zero, which only factors of zero make them. Then
/// the determinant is zero without rounding, too: so for places along an axis.
#[inline(always)]
pub fn estimated_orientation(a: Place, b: Place, c: Place) -> (f64, f64) {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    (left - right, ORIENTATION_BOUND * (left.abs() + right.abs()))
}

/// The determinant of the circle in doubles, and a bound: above it the sign is right.
#[inline(always)]
pub fn estimated_in_circle(a: Place, b: Place, c: Place, d: Place) -> (f64, f64) {
    let [adx, bdx, cdx] = [a, b, c].map(|p| p[0] - d[0]);
    let [ady, bdy, cdy] = [a, b, c].map(|p| p[1] - d[1]);
    let lift = [adx * adx + ady * ady, bdx * bdx + bdy * bdy, cdx * cdx + cdy * cdy];
    let minors = [(bdx * cdy, bdy * cdx), (cdx * ady, cdy * adx), (adx * bdy, ady * bdx)];
    let (mut det, mut permanent) = (0.0, 0.0);
    for (lift, (left, right)) in lift.into_iter().zip(minors) {
        det += lift * (left - right);
        permanent += lift * (left.abs() + right.abs());
    }
    (det, IN_CIRCLE_BOUND * permanent)
}

/// The sign of a double that is not NaN.
#[inline]
fn sign(value: f64) -> Ordering {
    value.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

/// Half a unit in the last place of 1.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// Shewchuk's `ccwerrboundA`.
const ORIENTATION_BOUND: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;
/// Shewchuk's `iccerrboundA`.
const IN_CIRCLE_BOUND: f64 = (10.0 + 96.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

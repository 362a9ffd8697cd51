//! The sphere through four places, and one rule for ties.
//!
//! First in doubles with J. R. Shewchuk's bound `isperrboundA` (1997, doi:10.1007/PL00009321, section 4.4), then in whole numbers.

use std::cmp::Ordering;

use super::limbs::Limbs;
use super::space::{Place3, orientation_in_space};
use super::unrounded::by_size;
use super::{UNIT_ROUNDOFF, sign};

/// Position of `e` about the sphere through `a`, `b`, `c`, `d`: `Greater` is inside, `Less` outside, `Equal` on it.
///
/// [`orientation_in_space`] of the four must be `Greater`.
#[inline]
pub fn in_sphere(a: Place3, b: Place3, c: Place3, d: Place3, e: Place3) -> Ordering {
    let sides = sides([a, b, c, d], e);
    checked(determinant(sides), sides, [a, b, c, d], e)
}

#[inline(always)]
fn sides(corners: [Place3; 4], e: Place3) -> [Place3; 4] {
    corners.map(|p| [p[0] - e[0], p[1] - e[1], p[2] - e[2]])
}

/// The sign of the determinant of some sides, if their sizes say that it is certain; else that of whole numbers.
#[inline]
fn checked(det: f64, sides: [Place3; 4], corners: [Place3; 4], e: Place3) -> Ordering {
    // One instruction, where `f64::max` takes four: of sides that are no numbers the sum of sizes decides.
    let larger = |p: f64, q: f64| if p > q { p } else { q };
    let widest = |axis: usize| {
        let [a, b, c, d] = sides.map(|p| p[axis].abs());
        larger(larger(a, b), larger(c, d))
    };
    let [x, y, z] = [widest(0), widest(1), widest(2)];
    let long = larger(larger(x, y), z);
    // The sum of sizes is at most 72 times this product.
    if det.abs() > 72.5 * BOUND * (x * y * z) * (long * long) {
        return sign(det);
    }
    let bound = BOUND * sum_of_sizes(sides);
    if det.abs() > bound { sign(det) } else { unrounded(corners, e) }
}

/// Whether `e` lies inside the sphere through `a`, `b`, `c`, `d`, where no five places count as lying on one sphere.
///
/// All five must differ, and [`orientation_in_space`] of the first four must be `Greater`. Every place counts as lifted to
/// x² + y² + z² and an infinitesimal amount more, that of a place infinitely larger than those of all places before it by x, y, z.
/// So the Delaunay triangulation of any places is unique, whatever their order (O. Devillers, M. Teillaud,
/// doi:10.1016/j.comgeo.2010.09.010). No tetrahedron of it is flat.
#[inline]
pub fn sphere_encloses(a: Place3, b: Place3, c: Place3, d: Place3, e: Place3) -> bool {
    // Nothing is certain by an unknown box.
    sphere_in_box_encloses(f64::INFINITY, [a, b, c, d], e)
}

/// What the determinant of a sphere through places in a box of sizes `size` must exceed for its sign to be certain.
///
/// Their differences are no larger, rounded or not, so one comparison decides nearly all spheres of a scan.
pub fn certain_sphere(size: Place3) -> f64 {
    let [x, y, z] = size;
    let long = x.max(y).max(z);
    72.5 * BOUND * (x * y * z) * (long * long)
}

/// [`sphere_encloses`] of places in a box for which [`certain_sphere`] was asked.
#[inline(always)]
pub fn sphere_in_box_encloses(certain: f64, corners: [Place3; 4], e: Place3) -> bool {
    let sides = sides(corners, e);
    let det = determinant(sides);
    if det.abs() > certain {
        return det > 0.0;
    }
    match checked(det, sides, corners, e) {
        Ordering::Greater => true,
        Ordering::Less => false,
        Ordering::Equal => encloses_on_sphere(corners, e),
    }
}

/// The order of places by x, y, z, by which ties are decided.
#[inline]
pub fn by_x_y_z(p: Place3, q: Place3) -> Ordering {
    p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(p[2].total_cmp(&q[2]))
}

/// [`sphere_encloses`] for five different places on one sphere.
///
/// The last place is outside the sphere of the others. If it is not `e`, raising it moves the sphere towards its side of the
/// facet across: `e` is inside where it may take the place of the last. If that makes a flat tetrahedron the place before decides.
/// It cannot do so too: a line meets a sphere twice at most.
#[inline(never)]
fn encloses_on_sphere(corners: [Place3; 4], e: Place3) -> bool {
    let mut order = [0, 1, 2, 3, 4];
    let at = |index: usize| corners.get(index).copied().unwrap_or(e);
    order.sort_unstable_by(|&i, &j| by_x_y_z(at(j), at(i)));
    for index in order {
        let Some(corner) = (index < 4).then_some(index) else { return false };
        let mut replaced = corners;
        replaced[corner] = e;
        let [a, b, c, d] = replaced;
        match orientation_in_space(a, b, c, d) {
            Ordering::Equal => {}
            side => return side.is_gt(),
        }
    }
    false
}

/// The determinant of the lifted differences, as Shewchuk expands it.
#[inline(always)]
fn determinant([a, b, c, d]: [Place3; 4]) -> f64 {
    let minor = |p: Place3, q: Place3| p[0] * q[1] - q[0] * p[1];
    let [ab, bc, cd, da, ac, bd] =
        [minor(a, b), minor(b, c), minor(c, d), minor(d, a), minor(a, c), minor(b, d)];
    let abc = a[2] * bc - b[2] * ac + c[2] * ab;
    let bcd = b[2] * cd - c[2] * bd + d[2] * bc;
    let cda = c[2] * da + d[2] * ac + a[2] * cd;
    let dab = d[2] * ab + a[2] * bd + b[2] * da;
    (lift(d) * abc - lift(c) * dab) + (lift(b) * cda - lift(a) * bcd)
}

#[inline(never)]
fn sum_of_sizes([a, b, c, d]: [Place3; 4]) -> f64 {
    let minor = |p: Place3, q: Place3| (p[0] * q[1]).abs() + (q[0] * p[1]).abs();
    let [ab, bc, cd, da, ac, bd] =
        [minor(a, b), minor(b, c), minor(c, d), minor(d, a), minor(a, c), minor(b, d)];
    let [az, bz, cz, dz] = [a, b, c, d].map(|p| p[2].abs());
    (cd * bz + bd * cz + bc * dz) * lift(a)
        + (da * cz + ac * dz + cd * az) * lift(b)
        + (ab * dz + bd * az + da * bz) * lift(c)
        + (bc * az + ac * bz + ab * cz) * lift(d)
}

#[inline(always)]
fn lift(p: Place3) -> f64 {
    p[0] * p[0] + p[1] * p[1] + p[2] * p[2]
}

#[inline(never)]
fn unrounded(corners: [Place3; 4], e: Place3) -> Ordering {
    let mut pairs = [[0.0; 2]; 12];
    for (corner, pairs) in corners.iter().zip(pairs.chunks_exact_mut(3)) {
        for axis in 0..3 {
            pairs[axis] = [corner[axis], e[axis]];
        }
    }
    by_size(
        pairs,
        sphere::<1, 2, 3, 5>,
        sphere::<2, 4, 6, 10>,
        sphere::<4, 8, 12, 20>,
        sphere::<33, 66, 99, 165>,
    )
}

/// The sign for differences of at most B = 2⁶⁴ᴰ⁻²; the others are 2`D`, 3`D` and 5`D`.
///
/// Minors and lifts are at most 3B², the determinants of three rows 6B³, their products 18B⁵ and the sum of four 72B⁵. That is
/// below 2³²⁰ᴰ⁻³ and fits 5D limbs.
fn sphere<const D: usize, const P: usize, const T: usize, const F: usize>(
    differences: [Limbs<D>; 12],
) -> Ordering {
    let [ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz] = differences;
    let minor = |px: Limbs<D>, py: Limbs<D>, qx: Limbs<D>, qy: Limbs<D>| -> Limbs<P> {
        px.product::<D, P>(qy).minus(qx.product(py))
    };
    let lift = |x: Limbs<D>, y: Limbs<D>, z: Limbs<D>| -> Limbs<P> {
        x.product::<D, P>(x).plus(y.product(y)).plus(z.product(z))
    };
    let term = |minor: Limbs<P>, z: Limbs<D>| -> Limbs<T> { minor.product(z) };
    let (ab, bc) = (minor(ax, ay, bx, by), minor(bx, by, cx, cy));
    let (cd, da) = (minor(cx, cy, dx, dy), minor(dx, dy, ax, ay));
    let (ac, bd) = (minor(ax, ay, cx, cy), minor(bx, by, dx, dy));
    let abc = term(bc, az).minus(term(ac, bz)).plus(term(ab, cz));
    let bcd = term(cd, bz).minus(term(bd, cz)).plus(term(bc, dz));
    let cda = term(da, cz).plus(term(ac, dz)).plus(term(cd, az));
    let dab = term(ab, dz).plus(term(bd, az)).plus(term(da, bz));
    let raised = |rows: Limbs<T>, lift: Limbs<P>| -> Limbs<F> { rows.product(lift) };
    let left = raised(abc, lift(dx, dy, dz)).minus(raised(dab, lift(cx, cy, cz)));
    let right = raised(cda, lift(bx, by, bz)).minus(raised(bcd, lift(ax, ay, az)));
    left.plus(right).sign()
}

/// Shewchuk's `isperrboundA`.
const BOUND: f64 = (16.0 + 224.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

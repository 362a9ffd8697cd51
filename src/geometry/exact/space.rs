//! The orientation of four places in space.
//!
//! First in doubles with J. R. Shewchuk's bound `o3derrboundA` (1997, doi:10.1007/PL00009321, section 4.3), then in whole numbers
//! ([`super::unrounded`]). Places with a common coordinate, as on the flat sides of a part, cost no arithmetic.

use std::cmp::Ordering;

use super::limbs::Limbs;
use super::unrounded::{Form, decide};
use super::{UNIT_ROUNDOFF, sign};

/// A place in space: x, y and z in mm.
pub(crate) type Place3 = [f64; 3];

/// Side of the plane through `a`, `b`, `c` on which `d` lies: `Greater` is where they turn clockwise, `Less` where they turn
/// counter-clockwise, `Equal` on the plane.
#[inline]
pub fn orientation_in_space(a: Place3, b: Place3, c: Place3, d: Place3) -> Ordering {
    let (det, bound) = estimated(a, b, c, d);
    if det.abs() > bound { sign(det) } else { unrounded(a, b, c, d) }
}

#[inline(never)]
fn unrounded(a: Place3, b: Place3, c: Place3, d: Place3) -> Ordering {
    if (0..3).any(|axis| a[axis] == d[axis] && b[axis] == d[axis] && c[axis] == d[axis]) {
        return Ordering::Equal;
    }
    let pair = |from: Place3, axis: usize| [from[axis], d[axis]];
    let [ax, ay, az] = [0, 1, 2].map(|axis| pair(a, axis));
    let [bx, by, bz] = [0, 1, 2].map(|axis| pair(b, axis));
    let [cx, cy, cz] = [0, 1, 2].map(|axis| pair(c, axis));
    decide::<SpaceForm, 9>([ax, ay, az, bx, by, bz, cx, cy, cz])
}

/// The determinant in doubles, and a bound above which its sign is right.
#[inline(always)]
fn estimated(a: Place3, b: Place3, c: Place3, d: Place3) -> (f64, f64) {
    let [adx, ady, adz] = [a[0] - d[0], a[1] - d[1], a[2] - d[2]];
    let [bdx, bdy, bdz] = [b[0] - d[0], b[1] - d[1], b[2] - d[2]];
    let [cdx, cdy, cdz] = [c[0] - d[0], c[1] - d[1], c[2] - d[2]];
    let minors = [(bdx * cdy, bdy * cdx), (cdx * ady, cdy * adx), (adx * bdy, ady * bdx)];
    let (mut det, mut permanent) = (0.0, 0.0);
    for (height, (left, right)) in [adz, bdz, cdz].into_iter().zip(minors) {
        det += height * (left - right);
        permanent += height.abs() * (left.abs() + right.abs());
    }
    (det, BOUND * permanent)
}

/// Three products of a minor of at most 2B² and a difference: 6B³ at most.
struct SpaceForm;

impl Form<9> for SpaceForm {
    fn sign<const D: usize, const P: usize, const Q: usize>(
        [ax, ay, az, bx, by, bz, cx, cy, cz]: [Limbs<D>; 9],
    ) -> Ordering {
        let minor = |px: Limbs<D>, py: Limbs<D>, qx: Limbs<D>, qy: Limbs<D>| -> Limbs<P> {
            px.times::<P>(qy).minus(py.times(qx))
        };
        let term =
            |minor: Limbs<P>, height: Limbs<D>| -> Limbs<Q> { minor.times(height.widened()) };
        term(minor(bx, by, cx, cy), az)
            .plus(term(minor(cx, cy, ax, ay), bz))
            .plus(term(minor(ax, ay, bx, by), cz))
            .sign()
    }
}

/// Shewchuk's `o3derrboundA`.
const BOUND: f64 = (7.0 + 56.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

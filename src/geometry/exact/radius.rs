//! The radius of the circle through three places, compared with a length.

use std::cmp::Ordering;

use super::limbs::Limbs;
use super::unrounded::by_size;
use super::{Place, UNIT_ROUNDOFF};

/// How the radius of the circle through `a`, `b`, `c` compares with `radius_mm`, which is above 0.
///
/// Of three places on a line the radius is infinite: `Greater`. R = l₁·l₂·l₃ / (2·|c|) with the lengths l of the sides and
/// the cross product c of two of them, so the squares l₁²·l₂²·l₃² and (2·R·c)² are compared. Both are of the sixth degree in
/// differences and the radius. First they are computed in doubles: a square of a length has a relative error of 4u, the product
/// of three at most 16u, the cross product an absolute one of 4u of the sum of sizes of its terms. 64u is taken, and only where
/// that leaves the order open whole numbers decide.
pub fn compare_circumradius([a, b, c]: [Place; 3], radius_mm: f64) -> Ordering {
    let [ux, uy] = [b[0] - a[0], b[1] - a[1]];
    let [vx, vy] = [c[0] - a[0], c[1] - a[1]];
    let [wx, wy] = [c[0] - b[0], c[1] - b[1]];
    let sides = (ux * ux + uy * uy) * (vx * vx + vy * vy) * (wx * wx + wy * wy);
    let cross = (ux * vy - uy * vx).abs();
    let error = BOUND * ((ux * vy).abs() + (uy * vx).abs());
    let squared = |cross: f64| 4.0 * (radius_mm * cross) * (radius_mm * cross);
    if sides > squared(cross + error) * (1.0 + BOUND) {
        return Ordering::Greater;
    }
    if cross > error && sides < squared(cross - error) * (1.0 - BOUND) {
        return Ordering::Less;
    }
    let pairs = [
        [b[0], a[0]],
        [b[1], a[1]],
        [c[0], a[0]],
        [c[1], a[1]],
        [c[0], b[0]],
        [c[1], b[1]],
        [radius_mm, 0.0],
    ];
    by_size(
        pairs,
        order::<1, 2, 4, 8>,
        order::<2, 4, 8, 16>,
        order::<4, 8, 16, 32>,
        order::<33, 66, 132, 264>,
    )
}

/// The order for differences of at most B = 2⁶⁴ᴰ⁻²: the product of the squares is at most 8B⁶, that of the radius and the cross
/// product, doubled and squared, 16B⁶, which is 2³⁸⁴ᴰ⁻⁸ and fits 8D limbs.
fn order<const D: usize, const P: usize, const Q: usize, const R: usize>(
    [ux, uy, vx, vy, wx, wy, radius]: [Limbs<D>; 7],
) -> Ordering {
    let lift = |x: Limbs<D>, y: Limbs<D>| -> Limbs<P> { x.times::<P>(x).plus(y.times(y)) };
    let two: Limbs<Q> = lift(ux, uy).times(lift(vx, vy));
    let sides: Limbs<R> = two.times(lift(wx, wy).widened::<Q>());
    let cross: Limbs<P> = ux.times::<P>(vy).minus(uy.times(vx));
    let half: Limbs<Q> = radius.widened::<P>().times(cross);
    let whole = half.plus(half);
    sides.minus(whole.times::<R>(whole)).sign()
}

/// Of sums and products of sizes.
const BOUND: f64 = 64.0 * UNIT_ROUNDOFF;

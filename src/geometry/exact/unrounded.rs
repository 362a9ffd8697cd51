//! The determinants of the predicates without rounding, in whole numbers.
//!
//! Doubles are whole multiples of a power of two, their unit, and the sign of a determinant that is
//! homogeneous in the coordinates does not depend on it. Two ways lead to whole numbers:
//!
//! 1. The coordinate differences, if doubles hold them. So it is on rasters, near and far.
//! 2. Else the coordinates, in as many 64-bit limbs as their range of magnitudes asks for.
//!
//! The corners of a rectangle along the axes, the commonest four of a raster, are on a circle
//! without any arithmetic. Where one place is far from three that are near one another, doubles decide as a rule if
//! differences are taken from one of the three.
//!
//! Why no result overflows. Let the differences be at most B in size. A product of two is at most
//! B², hence |orientation| ≤ 2B². In the determinant of the circle a lift x² + y² and a minor
//! x·y' - y·x' are at most 2B² in size each, the product of both 4B⁴ and the sum of three 12B⁴,
//! which is below 2⁴·B⁴.
//!
//! - Differences of D limbs are kept to B ≤ 2⁶⁴ᴰ⁻²: minors and lifts are at most 2¹²⁸ᴰ⁻³ and fit
//!   2D limbs (2¹²⁸ᴰ⁻¹); the determinant is below 2²⁵⁶ᴰ⁻⁴ and fits 4D limbs (2²⁵⁶ᴰ⁻¹).
//! - Differences with B ≤ 2³⁰: minors and lifts are at most 2⁶¹ and fit an i64; the determinant is
//!   below 2¹²⁴ and fits an i128.

use std::cmp::Ordering;

use super::limbs::{Limbs, odd_part};
use super::{Place, estimated_in_circle, sign};

/// See [`super::orientation`].
#[inline(never)]
pub(crate) fn orientation(a: Place, b: Place, c: Place) -> Ordering {
    let pairs = [[a[0], c[0]], [a[1], c[1]], [b[0], c[0]], [b[1], c[1]]];
    if let Some([ax, ay, bx, by]) = whole_differences(pairs) {
        // At most 2¹²⁴ each.
        let product = |left: i64, right: i64| i128::from(left) * i128::from(right);
        return product(ax, by).cmp(&product(ay, bx));
    }
    let unit = Unit::of(&pairs);
    if unit.bits <= BITS_OF_TWO {
        turn::<2, 4>(unit.differences(pairs))
    } else if unit.bits <= BITS_OF_FOUR {
        turn::<4, 8>(unit.differences(pairs))
    } else {
        turn::<33, 66>(unit.differences(pairs))
    }
}

/// See [`super::in_circle`].
#[inline(never)]
pub(crate) fn in_circle([a, b, c]: [Place; 3], d: Place) -> Ordering {
    if is_rectangle([a, b, c], d) {
        return Ordering::Equal;
    }
    if is_far([a, b, c], d)
        && let Some(sign) = circle_of_doubles(b, c, d, a)
    {
        return sign.reverse();
    }
    circle_of_any([a, b, c], d)
}

/// The same of any places, in whole numbers.
///
/// A function of its own, as it needs a frame on the stack that costs more than the cases above.
#[inline(never)]
fn circle_of_any([a, b, c]: [Place; 3], d: Place) -> Ordering {
    let pairs =
        [[a[0], d[0]], [a[1], d[1]], [b[0], d[0]], [b[1], d[1]], [c[0], d[0]], [c[1], d[1]]];
    if let Some(differences) = whole_differences(pairs) {
        return match halved(differences) {
            Some(small) => circle_of_i64(small),
            None => circle::<1, 2, 4>(differences.map(Limbs::from)),
        };
    }
    if let Some(decided) = about_another([a, b, c], d) {
        return decided;
    }
    let unit = Unit::of(&pairs);
    if unit.bits <= BITS_OF_TWO {
        circle::<2, 4, 8>(unit.differences(pairs))
    } else if unit.bits <= BITS_OF_FOUR {
        circle::<4, 8, 16>(unit.differences(pairs))
    } else {
        circle::<33, 66, 132>(unit.differences(pairs))
    }
}

/// Whether `d` lies many times as far from a corner as the other two do.
///
/// Along a curve that is traced a new point sees thousands of such triangles beyond those that it tears down. Differences
/// from the corner decide them at once.
#[inline]
fn is_far([a, b, c]: [Place; 3], d: Place) -> bool {
    let distance = |p: Place| (p[0] - a[0]).abs() + (p[1] - a[1]).abs();
    FAR * (distance(b) + distance(c)) < distance(d)
}

/// Farther than by this factor rounding takes what differences from `d` tell. On rasters, where whole numbers are the rule,
/// hardly any four are like that.
const FAR: f64 = 16.0;

/// The sign of the circle's determinant in doubles, where it is sure for differences from another corner than `d`.
///
/// Where three corners lie near one another and `d` far from them, the differences from `d` are all but the same, and what
/// tells is rounded away. Those from one of the three are not. Each turn of the four by one place changes the sign.
fn about_another([a, b, c]: [Place; 3], d: Place) -> Option<Ordering> {
    let turns = [(b, c, d, a, true), (c, d, a, b, false), (d, a, b, c, true)];
    turns.into_iter().find_map(|(a, b, c, d, is_changed)| {
        let sign = circle_of_doubles(a, b, c, d)?;
        Some(if is_changed { sign.reverse() } else { sign })
    })
}

/// The sign of the circle's determinant for differences from `d` in doubles, where it is sure.
#[inline]
fn circle_of_doubles(a: Place, b: Place, c: Place, d: Place) -> Option<Ordering> {
    let (det, bound) = estimated_in_circle(a, b, c, d);
    (det.abs() > bound).then(|| sign(det))
}

/// A form in coordinate differences, homogeneous so that its sign does not depend on their unit.
///
/// Differences are at most 2⁶⁴ᴰ⁻² in size; `P` is 2`D` and `Q` is 2`P`. A form must be below 2⁵·B⁴ for differences of
/// at most B, which is at most 2²⁵⁶ᴰ⁻³ and fits 4D limbs; a part of the second degree must be at most 4B², which fits 2D.
pub(crate) trait Form<const N: usize> {
    /// The sign of the form.
    fn sign<const D: usize, const P: usize, const Q: usize>(differences: [Limbs<D>; N])
    -> Ordering;
}

/// The sign of a form for the differences `from - to` of each pair.
#[inline(never)]
pub(crate) fn decide<F: Form<N>, const N: usize>(pairs: [[f64; 2]; N]) -> Ordering {
    by_size(
        pairs,
        F::sign::<1, 2, 4>,
        F::sign::<2, 4, 8>,
        F::sign::<4, 8, 16>,
        F::sign::<33, 66, 132>,
    )
}

/// The order that one of four functions finds of the differences `from - to` of each pair, the one for as few limbs as hold
/// them: 1, 2, 4 or 33 limbs of at most 2⁶⁴ᴰ⁻² in size.
pub(crate) fn by_size<const N: usize>(
    pairs: [[f64; 2]; N],
    one: impl Fn([Limbs<1>; N]) -> Ordering,
    two: impl Fn([Limbs<2>; N]) -> Ordering,
    four: impl Fn([Limbs<4>; N]) -> Ordering,
    any: impl Fn([Limbs<33>; N]) -> Ordering,
) -> Ordering {
    if let Some(differences) = whole_differences(pairs) {
        return one(differences.map(Limbs::from));
    }
    let unit = Unit::of(&pairs);
    if unit.bits <= BITS_OF_TWO {
        two(unit.differences(pairs))
    } else if unit.bits <= BITS_OF_FOUR {
        four(unit.differences(pairs))
    } else {
        any(unit.differences(pairs))
    }
}

/// Whether `d` completes the others to a rectangle along the axes: no arithmetic is asked for.
#[inline]
fn is_rectangle([a, b, c]: [Place; 3], d: Place) -> bool {
    let opposite = |o: Place, p: Place, q: Place| {
        (p == [o[0], d[1]] && q == [d[0], o[1]]) || (p == [d[0], o[1]] && q == [o[0], d[1]])
    };
    opposite(a, b, c) || opposite(b, c, a) || opposite(c, a, b)
}

/// `from - to` of each pair as whole numbers of a common unit, below 2⁶² in size, if doubles hold
/// the differences and they fit.
#[inline]
fn whole_differences<const N: usize>(pairs: [[f64; 2]; N]) -> Option<[i64; N]> {
    let differences = pairs.map(|[from, to]| from - to);
    let mut rounded = false;
    let mut largest = 0.0_f64;
    for ([from, to], difference) in pairs.into_iter().zip(differences) {
        rounded |= tail(from, to, difference) != 0.0;
        largest = largest.max(difference.abs());
    }
    let exponent = (largest.to_bits() >> 52) as i32 - 1023;
    // Beyond these the scale would be no double, or below one, which might make small ones vanish.
    if rounded || !(-900..=61).contains(&exponent) {
        return None;
    }
    // The scale brings the largest between 2⁶¹ and 2⁶².
    let scale = f64::from_bits(((61 - exponent + 1023) as u64) << 52);
    let mut fit = true;
    let whole = differences.map(|difference| {
        let scaled = difference * scale;
        let whole = scaled as i64;
        fit &= whole as f64 == scaled;
        whole
    });
    fit.then_some(whole)
}

/// What rounding took from `difference`, the rounded `from - to` (D. E. Knuth, *The Art of Computer
/// Programming* 2, section 4.2.2, theorem B).
#[inline]
fn tail(from: f64, to: f64, difference: f64) -> f64 {
    let virtual_to = from - difference;
    let virtual_from = difference + virtual_to;
    (from - virtual_from) + (virtual_to - to)
}

/// The same differences, below 2⁶² in size, divided by as large a power of two as divides all, if
/// that leaves them at most 2³⁰ in size.
#[inline]
fn halved(differences: [i64; 6]) -> Option<[i64; 6]> {
    let zeros = differences.into_iter().fold(0, |bits, whole| bits | whole).trailing_zeros();
    // Below 2⁶² / 2³².
    (zeros >= 32).then(|| differences.map(|whole| whole >> zeros))
}

/// The sign of the circle's determinant for differences [ax, ay, bx, by, cx, cy] of at most 2³⁰.
#[inline]
fn circle_of_i64([ax, ay, bx, by, cx, cy]: [i64; 6]) -> Ordering {
    let term = |lift: i64, minor: i64| i128::from(lift) * i128::from(minor);
    let det = term(ax * ax + ay * ay, bx * cy - by * cx)
        + term(bx * bx + by * by, cx * ay - cy * ax)
        + term(cx * cx + cy * cy, ax * by - ay * bx);
    det.cmp(&0)
}

/// The sign of the circle's determinant for differences [ax, ay, bx, by, cx, cy] of at most
/// 2⁶⁴ᴰ⁻²; `P` is 2`D` and `Q` is 2`P`.
#[inline]
fn circle<const D: usize, const P: usize, const Q: usize>(
    [ax, ay, bx, by, cx, cy]: [Limbs<D>; 6],
) -> Ordering {
    let lift = |x: Limbs<D>, y: Limbs<D>| -> Limbs<P> { x.times::<P>(x).plus(y.times(y)) };
    let term = |lift: Limbs<P>, minor: Limbs<P>| -> Limbs<Q> { lift.times(minor) };
    let det = term(lift(ax, ay), minor(bx, by, cx, cy))
        .plus(term(lift(bx, by), minor(cx, cy, ax, ay)))
        .plus(term(lift(cx, cy), minor(ax, ay, bx, by)));
    det.sign()
}

/// The sign of the orientation's determinant for differences [ax, ay, bx, by] of at most 2⁶⁴ᴰ⁻²;
/// `P` is 2`D`.
fn turn<const D: usize, const P: usize>([ax, ay, bx, by]: [Limbs<D>; 4]) -> Ordering {
    minor::<D, P>(ax, ay, bx, by).sign()
}

#[inline]
fn minor<const D: usize, const P: usize>(
    px: Limbs<D>,
    py: Limbs<D>,
    qx: Limbs<D>,
    qy: Limbs<D>,
) -> Limbs<P> {
    px.times::<P>(qy).minus(py.times(qx))
}

/// The largest power of two of which some doubles are whole multiples.
struct Unit {
    exponent: i32,
    /// The multiples are below 2^bits in size.
    bits: u32,
}

impl Unit {
    fn of(pairs: &[[f64; 2]]) -> Self {
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for (odd, exponent) in pairs.as_flattened().iter().filter_map(|&value| odd_part(value)) {
            low = low.min(exponent);
            high = high.max(exponent + 64 - odd.leading_zeros() as i32);
        }
        // Only if all are zero there is none.
        Self { exponent: low, bits: high.saturating_sub(low).max(0) as u32 }
    }

    /// `from - to` of each pair, in units.
    fn differences<const D: usize, const N: usize>(&self, pairs: [[f64; 2]; N]) -> [Limbs<D>; N] {
        pairs.map(|pair| {
            let [from, to] = pair.map(|value| Limbs::from_double(value, self.exponent));
            from.minus(to)
        })
    }
}

/// Coordinates of up to so many bits have differences of at most 2¹²⁶, as two limbs ask for.
const BITS_OF_TWO: u32 = 125;
/// Coordinates of up to so many bits have differences of at most 2²⁵⁴, as four limbs ask for. All
/// that the mesh admits do: they are below 2⁴⁰ and multiples of 2⁻¹⁸⁵. Any finite doubles have less
/// than the 2109 bits that 33 limbs ask for, as they are below 2¹⁰²⁴ and multiples of 2⁻¹⁰⁷⁴.
const BITS_OF_FOUR: u32 = 253;

//! The two geometric predicates, decided exactly for any doubles the mesh admits.
//!
//! A predicate is first computed in plain doubles with the rounding-error bound of J. R. Shewchuk,
//! *Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates*, Discrete &
//! Computational Geometry 18 (1997) 305-363, doi:10.1007/PL00009321, sections 4.2 and 4.3. Only if
//! the bound does not decide the sign is the determinant computed without rounding, as a
//! non-overlapping expansion (same paper, section 2). Unlike Shewchuk's there are no stages in
//! between, but for one: an orientation whose coordinate differences are exact, which is the rule
//! on a raster, compares two exact products.
//!
//! Exactness needs coordinates that are zero or between 2⁻¹⁴² and 2²⁰¹ in size, so that no product
//! underflows or overflows; [`crate::RANGE_MM`] and [`crate::TINY_MM`] lie well inside.

use std::cmp::Ordering;

/// A place in the plane: x and y in mm.
pub(crate) type Place = [f64; 2];

/// On which side of the directed line from `a` to `b` the place `c` lies: `Greater` is left
/// (`a`, `b`, `c` turn counter-clockwise), `Less` is right, `Equal` is exactly on the line.
pub(crate) fn orientation(a: Place, b: Place, c: Place) -> Ordering {
    let (acx, bcx) = (a[0] - c[0], b[0] - c[0]);
    let (acy, bcy) = (a[1] - c[1], b[1] - c[1]);
    let (left, right) = (acx * bcy, acy * bcx);
    let det = left - right;
    if det.abs() > ORIENTATION_BOUND * (left.abs() + right.abs()) {
        return sign(det);
    }
    let rounded = [(a[0], c[0], acx), (b[0], c[0], bcx), (a[1], c[1], acy), (b[1], c[1], bcy)]
        .into_iter()
        .any(|(from, to, difference)| difference_tail(from, to, difference) != 0.0);
    if rounded {
        let [acx, acy] = [difference(a[0], c[0]), difference(a[1], c[1])];
        let [bcx, bcy] = [difference(b[0], c[0]), difference(b[1], c[1])];
        return acx.times(&bcy).minus(&acy.times(&bcx)).sign();
    }
    let (left, left_tail) = two_product(acx, bcy);
    let (right, right_tail) = two_product(acy, bcx);
    // Both pairs are non-overlapping and rounded to nearest: their order is lexicographic.
    sign(left - right).then(sign(left_tail - right_tail))
}

/// Where `d` lies about the circle through `a`, `b`, `c`, which must turn counter-clockwise:
/// `Greater` is inside, `Less` outside, `Equal` exactly on the circle.
pub(crate) fn in_circle(a: Place, b: Place, c: Place, d: Place) -> Ordering {
    let [adx, bdx, cdx] = [a, b, c].map(|p| p[0] - d[0]);
    let [ady, bdy, cdy] = [a, b, c].map(|p| p[1] - d[1]);
    let lift = [adx * adx + ady * ady, bdx * bdx + bdy * bdy, cdx * cdx + cdy * cdy];
    let minors = [(bdx * cdy, bdy * cdx), (cdx * ady, cdy * adx), (adx * bdy, ady * bdx)];
    let (mut det, mut permanent) = (0.0, 0.0);
    for (lift, (left, right)) in lift.into_iter().zip(minors) {
        det += lift * (left - right);
        permanent += lift * (left.abs() + right.abs());
    }
    if det.abs() > IN_CIRCLE_BOUND * permanent {
        return sign(det);
    }
    in_circle_exactly([a, b, c], d)
}

/// The determinant of [`in_circle`] without rounding.
fn in_circle_exactly(circle: [Place; 3], d: Place) -> Ordering {
    let x = circle.map(|p| difference(p[0], d[0]));
    let y = circle.map(|p| difference(p[1], d[1]));
    let mut det = Expansion::default();
    for row in 0..3 {
        let (next, last) = ((row + 1) % 3, (row + 2) % 3);
        let lift = x[row].times(&x[row]).plus(&y[row].times(&y[row]));
        let minor = x[next].times(&y[last]).minus(&y[next].times(&x[last]));
        det = det.plus(&lift.times(&minor));
    }
    det.sign()
}

/// A number as a sum of doubles that do not overlap, smallest first, none zero.
#[derive(Default)]
struct Expansion(Vec<f64>);

impl Expansion {
    /// Adds one double (Shewchuk, figure 6, GROW-EXPANSION with zeros eliminated).
    fn grow(&mut self, term: f64) {
        let mut sum = term;
        self.0.retain_mut(|component| {
            let tail;
            (sum, tail) = two_sum(sum, *component);
            *component = tail;
            tail != 0.0
        });
        if sum != 0.0 {
            self.0.push(sum);
        }
    }

    fn plus(&self, other: &Expansion) -> Expansion {
        let mut sum = Expansion(self.0.clone());
        other.0.iter().for_each(|&term| sum.grow(term));
        sum
    }

    fn minus(&self, other: &Expansion) -> Expansion {
        let mut rest = Expansion(self.0.clone());
        other.0.iter().for_each(|&term| rest.grow(-term));
        rest
    }

    fn times(&self, other: &Expansion) -> Expansion {
        let mut product = Expansion::default();
        for &left in &self.0 {
            for &right in &other.0 {
                let (high, low) = two_product(left, right);
                product.grow(low);
                product.grow(high);
            }
        }
        product
    }

    /// The sign of the largest component is that of the sum, since no two overlap.
    fn sign(&self) -> Ordering {
        self.0.last().map_or(Ordering::Equal, |&largest| sign(largest))
    }
}

/// `from - to` without rounding.
fn difference(from: f64, to: f64) -> Expansion {
    let (rounded, tail) = two_sum(from, -to);
    Expansion([tail, rounded].into_iter().filter(|&part| part != 0.0).collect())
}

/// What rounding took from `rounded`, the rounded `from - to`.
fn difference_tail(from: f64, to: f64, rounded: f64) -> f64 {
    let virtual_to = from - rounded;
    let virtual_from = rounded + virtual_to;
    (from - virtual_from) + (virtual_to - to)
}

/// The rounded sum and what rounding took from it (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let virtual_b = sum - a;
    let virtual_a = sum - virtual_b;
    (sum, (a - virtual_a) + (b - virtual_b))
}

/// The rounded product and what rounding took from it.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let product = a * b;
    (product, a.mul_add(b, -product))
}

/// The sign of a double that is not NaN.
fn sign(value: f64) -> Ordering {
    value.partial_cmp(&0.0).unwrap_or(Ordering::Equal)
}

/// Half a unit in the last place of 1.
const UNIT_ROUNDOFF: f64 = f64::EPSILON / 2.0;
/// Shewchuk's `ccwerrboundA`.
const ORIENTATION_BOUND: f64 = (3.0 + 16.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;
/// Shewchuk's `iccerrboundA`.
const IN_CIRCLE_BOUND: f64 = (10.0 + 96.0 * UNIT_ROUNDOFF) * UNIT_ROUNDOFF;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::regressions::beside_source;

    /// Coordinates that are small multiples of 2⁻³⁰ around a far centre: differences are exact as
    /// integers, but the plain determinants drown in rounding.
    fn nearly_degenerate() -> impl Strategy<Value = [[i64; 2]; 4]> {
        let steps = prop::array::uniform2(-3_i64..=3);
        (prop::array::uniform4(steps), 1_i64..=1 << 26).prop_map(|(steps, scale)| {
            let corners = [[0, 0], [scale, 0], [scale, scale], [0, scale]];
            std::array::from_fn(|i| std::array::from_fn(|axis| corners[i][axis] + steps[i][axis]))
        })
    }

    fn to_place(place: [i64; 2]) -> Place {
        place.map(|count| 1024.0 + count as f64 / (1_u64 << 40) as f64)
    }

    fn integer_orientation([a, b, c]: [[i128; 2]; 3]) -> Ordering {
        ((a[0] - c[0]) * (b[1] - c[1])).cmp(&((a[1] - c[1]) * (b[0] - c[0])))
    }

    fn integer_in_circle([a, b, c, d]: [[i128; 2]; 4]) -> Ordering {
        let [a, b, c] = [a, b, c].map(|p| [p[0] - d[0], p[1] - d[1]]);
        let lift = |p: [i128; 2]| p[0] * p[0] + p[1] * p[1];
        let minor = |p: [i128; 2], q: [i128; 2]| p[0] * q[1] - p[1] * q[0];
        (lift(a) * minor(b, c) + lift(b) * minor(c, a) + lift(c) * minor(a, b)).cmp(&0)
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn agrees_with_integers(places in nearly_degenerate()) {
            let [a, b, c, d] = places.map(to_place);
            let [ia, ib, ic, id] = places.map(|place| place.map(i128::from));
            prop_assert_eq!(orientation(a, b, c), integer_orientation([ia, ib, ic]));
            prop_assert_eq!(orientation(a, c, d), integer_orientation([ia, ic, id]));
            prop_assert_eq!(in_circle(a, b, c, d), integer_in_circle([ia, ib, ic, id]));
        }

        #[test]
        fn turns_with_its_arguments(places in prop::array::uniform3(prop::array::uniform2(-1e3..1e3))) {
            let [a, b, c] = places;
            prop_assert_eq!(orientation(a, b, c), orientation(b, c, a));
            prop_assert_eq!(orientation(a, b, c), orientation(b, a, c).reverse());
        }
    }

    #[test]
    fn sees_one_unit_in_the_last_place() {
        let (a, b) = ([0.1, 0.1], [0.3, 0.3]);
        let above = 0.2_f64.next_up();
        assert_eq!(orientation(a, b, [0.2, 0.2]), Ordering::Equal);
        assert_eq!(orientation(a, b, [0.2, above]), Ordering::Greater);
        assert_eq!(orientation(a, b, [above, 0.2]), Ordering::Less);
        let circle = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        let [p, q, r] = circle;
        assert_eq!(in_circle(p, q, r, [0.0, 1.0]), Ordering::Equal);
        assert_eq!(in_circle(p, q, r, [0.0, 1.0_f64.next_down()]), Ordering::Greater);
        assert_eq!(in_circle(p, q, r, [0.0, 1.0_f64.next_up()]), Ordering::Less);
    }

    #[test]
    fn differences_that_round_are_still_exact() {
        // 1e6 - 1e-3 is not a double; the three places are collinear but for that rounding.
        let (a, b) = ([1e-3, 1e-3], [1e6, 1e6]);
        assert_eq!(orientation(a, b, [3.0, 3.0]), Ordering::Equal);
        assert_eq!(orientation(a, b, [3.0, 3.0_f64.next_up()]), Ordering::Greater);
    }

    #[test]
    fn circles_larger_than_any_difference_holds() {
        // Through (±M, 0) and (0, M) runs the circle of radius M = 2^60 about the origin. The places
        // next to (0, -M) differ from it by far less than the differences can hold.
        let m = (1_u64 << 60) as f64;
        let circle = [[m, 0.0], [0.0, m], [-m, 0.0]];
        let about = |d: Place| in_circle(circle[0], circle[1], circle[2], d);
        assert_eq!(about([0.0, -m]), Ordering::Equal);
        assert_eq!(about([1e-12, -m]), Ordering::Less);
        assert_eq!(about([0.0, -m.next_down()]), Ordering::Greater);
    }

    proptest! {
        #![proptest_config(beside_source())]

        #[test]
        fn orientation_is_exact_over_many_magnitudes(
            mantissas in prop::array::uniform6(-15_i64..=15),
            exponents in prop::array::uniform6(0_u32..57),
        ) {
            let counts: [i64; 6] = std::array::from_fn(|i| mantissas[i] << exponents[i]);
            let [a, b, c] = [0, 2, 4].map(|i| [counts[i], counts[i + 1]]);
            let [pa, pb, pc] = [a, b, c].map(|place| place.map(|count| count as f64));
            let expected = integer_orientation([a, b, c].map(|place| place.map(i128::from)));
            prop_assert_eq!(orientation(pa, pb, pc), expected);
        }
    }
}

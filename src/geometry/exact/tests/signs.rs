//! The signs of the unrounded determinants: integers, the crate `robust` and analytic truths.

use std::cmp::Ordering;

use proptest::prelude::*;

use super::{Whole, integer_orientation, near_place};
use crate::exact::*;
use crate::regressions::beside_source;

/// Coordinates that are small multiples of 2⁻³⁰ around a far centre: differences are exact as
/// integers, but the plain determinants drown in rounding.
fn nearly_degenerate() -> impl Strategy<Value = Whole<4>> {
    let steps = prop::array::uniform2(-3_i64..=3);
    (prop::array::uniform4(steps), 1_i64..=1 << 26).prop_map(|(steps, scale)| {
        let corners = [[0, 0], [scale, 0], [scale, scale], [0, scale]];
        std::array::from_fn(|i| std::array::from_fn(|axis| corners[i][axis] + steps[i][axis]))
    })
}

fn far_place(place: [i64; 2]) -> Place {
    place.map(|count| 1024.0 + count as f64 / (1_u64 << 40) as f64)
}

fn integer_in_circle(places: Whole<4>) -> Ordering {
    let [a, b, c, d] = places.map(|place| place.map(i128::from));
    let [a, b, c] = [a, b, c].map(|p| [p[0] - d[0], p[1] - d[1]]);
    let lift = |p: [i128; 2]| p[0] * p[0] + p[1] * p[1];
    let minor = |p: [i128; 2], q: [i128; 2]| p[0] * q[1] - p[1] * q[0];
    (lift(a) * minor(b, c) + lift(b) * minor(c, a) + lift(c) * minor(a, b)).cmp(&0)
}

fn robust_orientation(places: [Place; 3]) -> Ordering {
    let [a, b, c] = places.map(|[x, y]| robust::Coord { x, y });
    robust::orient2d(a, b, c).partial_cmp(&0.0).unwrap()
}

fn robust_in_circle(places: [Place; 4]) -> Ordering {
    let [a, b, c, d] = places.map(|[x, y]| robust::Coord { x, y });
    robust::incircle(a, b, c, d).partial_cmp(&0.0).unwrap()
}

/// Both ways to decide, which must agree.
fn orientation_both_ways([a, b, c]: [Place; 3]) -> Ordering {
    let unrounded = unrounded::orientation(a, b, c);
    assert_eq!(orientation(a, b, c), unrounded);
    assert_eq!(left_of(a, b, c), unrounded.is_gt());
    unrounded
}

/// Both ways to decide, which must agree.
fn in_circle_both_ways([a, b, c, d]: [Place; 4]) -> Ordering {
    let unrounded = unrounded::in_circle([a, b, c], d);
    assert_eq!(in_circle(a, b, c, d), unrounded);
    unrounded
}

/// A double of any size from 2^`low` to below 2^`high`, or zero.
fn double(low: i32, high: i32) -> impl Strategy<Value = f64> {
    (1_i64 << 52..1 << 53, low - 52..high - 52, -8_i32..=8).prop_map(
        |(mantissa, exponent, sign)| {
            f64::from(sign.signum()) * mantissa as f64 * 2.0_f64.powi(exponent)
        },
    )
}

fn places(low: i32, high: i32) -> impl Strategy<Value = [Place; 4]> {
    prop::array::uniform4((double(low, high), double(low, high)).prop_map(|(x, y)| [x, y]))
}

/// Places near one another on a circle, and such far away on another.
fn far_clusters() -> impl Strategy<Value = [Place; 4]> {
    let on_circle = (0.0..1e-3_f64, any::<bool>());
    (prop::array::uniform4(on_circle), 10.0..1e5_f64, 0.0..std::f64::consts::TAU).prop_map(
        |(places, apart, turn)| {
            places.map(|(step, is_far)| {
                let (sin, cos) = (turn + step).sin_cos();
                let moved = if is_far { apart } else { 0.0 };
                [cos + moved, sin + 0.3 * moved]
            })
        },
    )
}

/// Three places of a circle near one another, and a fourth many times as far away, on it or next to it.
fn three_and_far() -> impl Strategy<Value = [Place; 4]> {
    let (middle, radius) = (prop::array::uniform2(-1e3..1e3_f64), 0.01..1e6_f64);
    let angles = (0.0..std::f64::consts::TAU, 0.1..6.0_f64);
    let near = (prop::array::uniform3(-1.0..1.0_f64), -40_i32..2);
    (middle, radius, angles, near, (0_usize..2, -1_i32..=1), -60_i32..=2).prop_map(
        |(middle, radius, (turn, away), (steps, size), (axis, step), off)| {
            let at = |radius: f64, angle: f64| {
                [middle[0] + radius * angle.cos(), middle[1] + radius * angle.sin()]
            };
            let [a, b, c] = steps.map(|step| at(radius, turn + step * 2.0_f64.powi(size)));
            let radius = radius * (1.0 + f64::from(step) * 2.0_f64.powi(off));
            [a, b, c, nudged(at(radius, turn + away), axis, step)]
        },
    )
}

/// As near a neighbour as doubles have, above or below, or the place itself.
fn nudged(place: Place, axis: usize, step: i32) -> Place {
    let mut nudged = place;
    nudged[axis] = match step {
        0 => place[axis],
        1 => place[axis].next_up(),
        _ => place[axis].next_down(),
    };
    nudged
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn agrees_with_integers(whole in nearly_degenerate()) {
        let [a, b, c, d] = whole;
        for places in [whole.map(far_place), whole.map(near_place)] {
            let [pa, pb, pc, pd] = places;
            prop_assert_eq!(orientation_both_ways([pa, pb, pc]), integer_orientation([a, b, c]));
            prop_assert_eq!(orientation_both_ways([pa, pc, pd]), integer_orientation([a, c, d]));
            prop_assert_eq!(in_circle_both_ways(places), integer_in_circle(whole));
        }
    }

    #[test]
    fn orientation_is_exact_over_many_magnitudes(
        mantissas in prop::array::uniform6(-15_i64..=15),
        exponents in prop::array::uniform6(0_u32..57),
    ) {
        let counts: [i64; 6] = std::array::from_fn(|i| mantissas[i] << exponents[i]);
        let whole = [0, 2, 4].map(|i| [counts[i], counts[i + 1]]);
        prop_assert_eq!(orientation_both_ways(whole.map(near_place)), integer_orientation(whole));
    }

    #[test]
    fn agrees_with_robust_on_far_clusters(places in far_clusters()) {
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
    }

    /// Any of the four may be the far one.
    #[test]
    fn agrees_with_robust_on_three_places_and_one_far(
        mut places in three_and_far(),
        turns in 0_usize..4,
    ) {
        places.rotate_left(turns);
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
        places.swap(0, 1);
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
    }

    /// All that the mesh admits.
    #[test]
    fn agrees_with_robust_over_admitted_magnitudes(places in places(-132, 40)) {
        let [a, b, c, _] = places;
        prop_assert_eq!(orientation_both_ways([a, b, c]), robust_orientation([a, b, c]));
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
    }

    /// All for which the bounds of the plain computation hold.
    #[test]
    fn agrees_with_robust_over_all_magnitudes(places in places(-142, 201)) {
        let [a, b, c, _] = places;
        prop_assert_eq!(orientation_both_ways([a, b, c]), robust_orientation([a, b, c]));
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
    }

    /// Sizes on either side of what one i128 and one limb hold.
    #[test]
    fn agrees_with_robust_near_rectangles_of_all_sizes(
        sides in prop::array::uniform2((1_i64..1 << 53, 0_u32..52)),
        steps in prop::array::uniform4(prop::array::uniform2(-2_i64..=2)),
        exponent in -130_i32..-20,
    ) {
        let [width, height] = sides.map(|(side, shift)| 1 + (side >> shift));
        let corners = [[0, 0], [width, 0], [width, height], [0, height]];
        let unit = 2.0_f64.powi(exponent);
        let places: [Place; 4] = std::array::from_fn(|i| {
            std::array::from_fn(|axis| (corners[i][axis] + steps[i][axis]) as f64 * unit)
        });
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
    }

    /// Four places on a circle whose two coordinates differ in size by up to 2³⁴⁰, and next to it.
    #[test]
    fn agrees_with_robust_next_to_circles_of_two_magnitudes(
        x in double(-142, 201).prop_map(|x| if x == 0.0 { 1.0 } else { x }),
        y in double(-142, 201).prop_map(|y| if y == 0.0 { 3.0 } else { y }),
        (which, axis, step) in (0_usize..4, 0_usize..2, -1_i32..=1),
    ) {
        prop_assume!(x.abs() != y.abs());
        let mut places = [[x, y], [-y, x], [x, -y], [y, x]];
        places[which] = nudged(places[which], axis, step);
        let sign = in_circle_both_ways(places);
        prop_assert_eq!(sign, robust_in_circle(places));
        prop_assert_eq!(sign == Ordering::Equal, step == 0);
    }

    /// Places as near a line as doubles come, so far apart that their differences round.
    #[test]
    fn agrees_with_robust_next_to_lines(
        ends in prop::array::uniform2(prop::array::uniform2(-1e3..1e3)),
        (share, size) in (-2.0..2.0, -20_i32..0),
        (axis, step) in (0_usize..2, -1_i32..=1),
    ) {
        let [a, end] = ends;
        let along = |share: f64| [0, 1].map(|axis| a[axis] + share * (end[axis] - a[axis]));
        let (b, c) = (along(2.0_f64.powi(size)), nudged(along(share), axis, step));
        for places in [[a, b, c], [c, a, b], [b, c, a]] {
            prop_assert_eq!(orientation_both_ways(places), robust_orientation(places));
        }
    }

    /// Quadruples of a raster whose pitch is no double, near and far, about which the differences
    /// are exact or not.
    #[test]
    fn agrees_with_robust_on_decimal_rasters(
        shape in prop::array::uniform4(prop::array::uniform2(0_i32..6)),
        first in prop::array::uniform2(prop::sample::select(vec![-3, 0, 2_000, 333_333_333])),
        stretch in prop::sample::select(vec![1, 7, 1000]),
    ) {
        let places = shape.map(|place| -> Place {
            std::array::from_fn(|axis| f64::from(first[axis] + stretch * place[axis]) * 0.003)
        });
        let [a, b, c, _] = places;
        prop_assert_eq!(orientation_both_ways([a, b, c]), robust_orientation([a, b, c]));
        prop_assert_eq!(in_circle_both_ways(places), robust_in_circle(places));
    }

    #[test]
    fn signs_turn_with_the_arguments(places in places(-132, 40)) {
        let [a, b, c, d] = places;
        prop_assert_eq!(orientation(a, b, c), orientation(b, c, a));
        prop_assert_eq!(orientation(a, b, c), orientation(b, a, c).reverse());
        prop_assert_eq!(in_circle(a, b, c, d), in_circle(b, c, a, d));
        prop_assert_eq!(in_circle(a, b, c, d), in_circle(b, a, c, d).reverse());
        prop_assert_eq!(in_circle(a, b, c, d), in_circle(b, c, d, a).reverse());
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
    // Through (±M, 0) and (0, M) runs the circle of radius M about the origin. The places next to
    // (0, -M) differ from it by far less than the differences can hold. The tiny steps ask for two
    // limbs, four limbs and more.
    for (exponent, tiny) in [(60, 1e-2), (60, 1e-12), (39, 1e-40), (200, 1e-42)] {
        let m = 2.0_f64.powi(exponent);
        let about = |d: Place| in_circle_both_ways([[m, 0.0], [0.0, m], [-m, 0.0], d]);
        assert_eq!(about([0.0, -m]), Ordering::Equal);
        assert_eq!(about([tiny, -m]), Ordering::Less);
        assert_eq!(about([-tiny, -m]), Ordering::Less);
        assert_eq!(about([0.0, -m.next_down()]), Ordering::Greater);
    }
}

#[test]
fn the_largest_determinants_do_not_overflow() {
    // The corners of a square of half side B about d make lifts and minors of 2B². B grows through
    // the limits of every size of whole number; the small step in one corner spoils the halving.
    for exponent in 0..200 {
        let b = 2.0_f64.powi(exponent);
        for b in [b, b.next_down()] {
            for step in [0.0, 1.0, 2.0_f64.powi(-100)] {
                let square = [[b, b + step], [-b, b], [-b, -b]];
                let [p, q, r] = square;
                assert_eq!(unrounded::in_circle(square, [0.0, 0.0]), Ordering::Greater);
                assert_eq!(unrounded::in_circle([q, p, r], [0.0, 0.0]), Ordering::Less);
                assert_eq!(unrounded::orientation(p, q, r), Ordering::Greater);
                assert_eq!(unrounded::orientation(q, p, r), Ordering::Less);
            }
        }
    }
}

#[test]
fn equal_places_are_on_every_line_and_circle() {
    for size in [0.0, 1e-40, 0.1, 1e12] {
        let p = [size, -size];
        assert_eq!(orientation_both_ways([p, p, p]), Ordering::Equal);
        assert_eq!(in_circle_both_ways([p, p, p, p]), Ordering::Equal);
        assert_eq!(in_circle_both_ways([[1.0, 2.0], [3.0, 4.0], p, p]), Ordering::Equal);
    }
}

#[test]
fn no_double_makes_a_predicate_panic() {
    let sizes = [f64::NAN, f64::INFINITY, f64::MAX, f64::MIN_POSITIVE / 4.0, -0.0, -1.0, -f64::MAX];
    for bits in 0..sizes.len().pow(4) {
        let size = |digit: u32| sizes[bits / sizes.len().pow(digit) % sizes.len()];
        let [a, b, c, d] = [[size(0), size(1)], [size(1), size(2)], [size(3), 1.0], [0.1, size(3)]];
        let _ = orientation(a, b, c);
        let _ = unrounded::orientation(a, b, c);
        let _ = unrounded::in_circle([a, b, c], d);
        let _ = encloses(a, b, c, d);
        let _ = outside_edge(a, b, c);
    }
}

//! Lengths and angles against whole numbers, near ties and at the limits of the range.

use std::cmp::Ordering;

use proptest::prelude::*;

use super::{Whole, near_place};
use crate::exact::Place;
use crate::exact::lengths::{
    compare_angle_sum, compare_distances, compare_with_sum, scalar_product,
};
use crate::regressions::beside_source;

fn square([ax, ay]: [i64; 2], [bx, by]: [i64; 2]) -> i128 {
    let [x, y] = [i128::from(ax - bx), i128::from(ay - by)];
    x * x + y * y
}

fn dot([ax, ay]: [i64; 2], [bx, by]: [i64; 2], [cx, cy]: [i64; 2]) -> i128 {
    i128::from(bx - ax) * i128::from(cx - ax) + i128::from(by - ay) * i128::from(cy - ay)
}

fn cross([ax, ay]: [i64; 2], [bx, by]: [i64; 2], [cx, cy]: [i64; 2]) -> i128 {
    i128::from(bx - ax) * i128::from(cy - ay) - i128::from(by - ay) * i128::from(cx - ax)
}

/// A small lattice, where ties are common, and one far larger than its spacing.
fn places<const N: usize>() -> impl Strategy<Value = Whole<N>> {
    let small = [-3_i64..4, -3..4];
    let large = [-1_000_000_i64..1_000_000, -1_000_000..1_000_000];
    prop_oneof![
        proptest::array::uniform::<_, N>(small).boxed(),
        proptest::array::uniform::<_, N>(large).boxed(),
    ]
}

/// Moved so far that differences are whole but coordinates have no room for products, and by fractions that a double
/// of that size cannot hold together.
fn moved<const N: usize>(places: Whole<N>) -> [[Place; N]; 3] {
    let near = places.map(near_place);
    let far = near.map(|[x, y]| [x + 1e12 - 2e6, y - 1e11]);
    let tiny = near.map(|[x, y]| [x * 2_f64.powi(-120), y * 2_f64.powi(-120)]);
    [near, far, tiny]
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn they_agree_with_whole_numbers(places in places::<4>()) {
        let [a, b, c, d] = places;
        for [p, q, r, s] in moved(places) {
            prop_assert_eq!(compare_distances(p, q, r, s), square(a, b).cmp(&square(c, d)));
            prop_assert_eq!(scalar_product(p, q, r), dot(a, b, c).cmp(&0));
            let (c2, a2, b2) = (square(a, b), square(a, c), square(b, d));
            let rest = c2 - a2 - b2;
            let expected = if rest < 0 { Ordering::Less } else { (rest * rest).cmp(&(4 * a2 * b2)) };
            prop_assert_eq!(compare_with_sum(p, q, r, s), expected);
            if cross(a, b, c) > 0 && cross(a, b, d) < 0 {
                let (left, right) = (cross(c, a, b), -cross(d, a, b));
                let cosine = dot(c, a, b) * dot(d, a, b) - left * right;
                prop_assert_eq!(compare_angle_sum(p, q, r, s), 0.cmp(&cosine));
            }
        }
    }
}

#[test]
fn the_last_bit_of_a_coordinate_decides() {
    let next = 1.0_f64.next_up();
    let zero = [0.0, 0.0];
    assert_eq!(compare_distances(zero, [next, 0.0], zero, [0.0, 1.0]), Ordering::Greater);
    assert_eq!(compare_distances(zero, [1.0, 1e-40], zero, [0.0, 1.0]), Ordering::Greater);
    assert_eq!(scalar_product(zero, [1.0, 1e-40], [-1e-40, 1.0]), Ordering::Equal);
    assert_eq!(scalar_product(zero, [1.0, 1e-40], [-2e-40, 1.0]), Ordering::Less);
    // On a line 1 + 1 = 2; a step aside makes the way longer than the sum.
    assert_eq!(compare_with_sum(zero, [2.0, 0.0], [1.0, 0.0], [2.0, 1.0]), Ordering::Equal);
    assert_eq!(compare_with_sum(zero, [2.0, 1e-40], [1.0, 0.0], [2.0, -1.0]), Ordering::Less);
    assert_eq!(compare_with_sum(zero, [2.0, 1e-40], [1.0, 0.0], [3.0, 1e-40]), Ordering::Greater);
    // A square: 45° and 45°.
    let [p, q, r, s] = [[0.0, 0.0], [1.0, 1.0], [0.0, 1.0], [1.0, 0.0]];
    assert_eq!(compare_angle_sum(p, q, r, s), Ordering::Greater);
    let [r, s] = [[-1.0, 2.0], [2.0, -1.0]];
    assert_eq!(compare_angle_sum(p, q, r, s), Ordering::Less);
    // Tangents 1/2 and 2 of half the edge over the heights: 2·atan(1/(1+√2))·2 is 90°.
    let up = 2.0_f64.sqrt() + 1.0;
    let [p, q] = [[-1.0, 0.0], [1.0, 0.0]];
    assert_eq!(compare_angle_sum(p, q, [0.0, up.next_up()], [0.0, -up]), Ordering::Less);
    assert_eq!(
        compare_angle_sum(p, q, [0.0, up.next_down()], [0.0, -up.next_down()]),
        Ordering::Greater
    );
}

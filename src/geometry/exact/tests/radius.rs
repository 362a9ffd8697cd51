//! Radii of circles against whole numbers, near ties and at the limits of the range.

use std::cmp::Ordering;

use proptest::prelude::*;

use super::near_place;
use crate::exact::radius::compare_circumradius;
use crate::regressions::beside_source;

fn square([ax, ay]: [i64; 2], [bx, by]: [i64; 2]) -> i128 {
    let [x, y] = [i128::from(ax - bx), i128::from(ay - by)];
    x * x + y * y
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn they_agree_with_whole_numbers(
        places in proptest::array::uniform3([-40_i64..40, -40..40]),
        radius in 1_i64..60,
    ) {
        let [a, b, c] = places;
        let cross = i128::from(b[0] - a[0]) * i128::from(c[1] - a[1])
            - i128::from(b[1] - a[1]) * i128::from(c[0] - a[0]);
        prop_assume!(a != b && b != c && c != a);
        let sides = square(a, b) * square(b, c) * square(c, a);
        let whole = 2 * i128::from(radius) * cross;
        let expected = sides.cmp(&(whole * whole));
        let near = places.map(near_place);
        let far = near.map(|[x, y]| [x + 1e12 - 2e6, y - 1e11]);
        let size = 2_f64.powi(-120);
        let tiny = near.map(|[x, y]| [x * size, y * size]);
        prop_assert_eq!(compare_circumradius(near, radius as f64), expected);
        prop_assert_eq!(compare_circumradius(far, radius as f64), expected);
        prop_assert_eq!(compare_circumradius(tiny, radius as f64 * size), expected);
        prop_assert_eq!(compare_circumradius([near[2], near[0], near[1]], radius as f64), expected);
    }
}

#[test]
fn the_last_bit_decides() {
    // 3, 4, 5: half the longest side.
    let right = [[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]];
    assert_eq!(compare_circumradius(right, 2.5), Ordering::Equal);
    assert_eq!(compare_circumradius(right, 2.5_f64.next_up()), Ordering::Less);
    assert_eq!(compare_circumradius(right, 2.5_f64.next_down()), Ordering::Greater);
    let [a, b, c] = right;
    let moved = [a, b, [c[0], c[1].next_up()]];
    assert_eq!(compare_circumradius(moved, 2.5), Ordering::Greater);
    // Half a chord is the least radius: any other angle opposite makes it larger, one a bit above 90° and one below.
    for aside in [1e-40, -1e-40] {
        assert_eq!(compare_circumradius([[aside, 0.0], b, c], 2.5), Ordering::Greater);
    }
}

#[test]
fn a_line_has_no_radius() {
    let line = [[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]];
    assert_eq!(compare_circumradius(line, 1e12), Ordering::Greater);
    let nearly = [[0.0, 0.0], [1.0, 1.0], [3.0, 3.0_f64.next_up()]];
    assert_eq!(compare_circumradius(nearly, 1e12), Ordering::Greater);
    assert_eq!(compare_circumradius(nearly, 1e30), Ordering::Less);
}

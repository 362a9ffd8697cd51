//! The orientation in space: whole numbers, the crate `robust` and analytic truths.

use std::cmp::Ordering;

use proptest::prelude::*;

use crate::exact::space::orientation_in_space;
use crate::regressions::beside_source;

fn whole([a, b, c, d]: [[i64; 3]; 4]) -> Ordering {
    let [a, b, c] = [a, b, c].map(|p| [0, 1, 2].map(|axis| i128::from(p[axis] - d[axis])));
    let minor = |p: [i128; 3], q: [i128; 3]| p[0] * q[1] - p[1] * q[0];
    (a[2] * minor(b, c) + b[2] * minor(c, a) + c[2] * minor(a, b)).cmp(&0)
}

fn robust_sign(places: [[f64; 3]; 4]) -> Ordering {
    let [a, b, c, d] = places.map(|[x, y, z]| robust::Coord3D { x, y, z });
    robust::orient3d(a, b, c, d).partial_cmp(&0.0).unwrap()
}

#[test]
fn the_side_where_three_turn_clockwise_is_greater() {
    let [a, b, c] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    for (z, side) in [(-1e-30, Ordering::Greater), (0.0, Ordering::Equal), (1.0, Ordering::Less)] {
        assert_eq!(orientation_in_space(a, b, c, [0.3, 0.3, z]), side);
    }
    // Far from the origin, out of a plane by a last bit.
    let far = [1e9, 1e9, 1e9];
    let [p, q] = [[1e9 + 1.0, 1e9, 1e9], [1e9, 1e9 + 1.0, 1e9]];
    let above = [1e9 + 7.0, 1e9 + 9.0, 1e9_f64.next_up()];
    assert_eq!(orientation_in_space(far, p, q, above), Ordering::Less);
    assert_eq!(orientation_in_space(far, q, p, above), Ordering::Greater);
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn nearly_coplanar_places_agree_with_whole_numbers_and_robust(
        steps in prop::array::uniform4(prop::array::uniform3(-2_i64..=2)),
        scale in 1_i64..1 << 26,
    ) {
        let corners = [[0, 0, 0], [scale, 0, scale], [0, scale, scale], [scale, scale, 2 * scale]];
        let places: [[i64; 3]; 4] =
            std::array::from_fn(|i| std::array::from_fn(|axis| corners[i][axis] + steps[i][axis]));
        let doubles = places.map(|p| p.map(|count| 512.0 + count as f64 / (1_u64 << 40) as f64));
        let [a, b, c, d] = doubles;
        prop_assert_eq!(orientation_in_space(a, b, c, d), whole(places));
        prop_assert_eq!(orientation_in_space(a, b, c, d), robust_sign(doubles));
        prop_assert_eq!(orientation_in_space(b, a, c, d), whole(places).reverse());
    }

    #[test]
    fn sizes_of_any_kind_agree_with_robust(
        places in prop::array::uniform4(prop::array::uniform3((-1.0_f64..1.0, -60_i32..20))),
    ) {
        let places = places.map(|p| p.map(|(value, power)| value * 2_f64.powi(power)));
        let [a, b, c, d] = places;
        prop_assert_eq!(orientation_in_space(a, b, c, d), robust_sign(places));
    }
}

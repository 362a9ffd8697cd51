//! Spheres of tetrahedra and balls of triangles against whole numbers and analytic truths.

use std::cmp::Ordering;

use proptest::prelude::*;

use crate::exact::balls::{compare_facet_circle, compare_sphere, in_facet_ball};
use crate::regressions::beside_source;

type Whole = [i128; 3];

fn dot(a: Whole, b: Whole) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: Whole, b: Whole) -> Whole {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: Whole, b: Whole) -> Whole {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[test]
fn diameters_of_a_cube_and_a_right_triangle() {
    let far = 1e9;
    let [o, x, y, z] =
        [[far; 3], [far + 2.0, far, far], [far, far + 2.0, far], [far, far, far + 1.0]];
    for (diameter, order) in
        [(2.999_999_999_999, Ordering::Greater), (3.0, Ordering::Equal), (3.1, Ordering::Less)]
    {
        assert_eq!(compare_sphere([o, x, y, z], diameter), order);
    }
    let [x, y] = [[far + 3.0, far, far], [far, far + 4.0, far]];
    for (diameter, order) in
        [(4.999_999_999_999, Ordering::Greater), (5.0, Ordering::Equal), (5.1, Ordering::Less)]
    {
        assert_eq!(compare_facet_circle([o, x, y], diameter), order);
    }
    assert_eq!(compare_sphere([o, x, y, [far + 1.0, far + 1.0, far]], 1e11), Ordering::Greater);
    assert_eq!(compare_facet_circle([o, x, [far + 7.0, far, far]], 1e11), Ordering::Greater);
    let corner = [far + 3.0, far + 4.0, far];
    assert_eq!(in_facet_ball([o, x, y], corner), Ordering::Equal);
    assert_eq!(
        in_facet_ball([o, x, y], [corner[0].next_down(), corner[1], far]),
        Ordering::Greater
    );
    assert_eq!(in_facet_ball([o, x, y], [corner[0], corner[1], far.next_up()]), Ordering::Less);
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn whole_numbers_agree(
        places in prop::array::uniform4(prop::array::uniform3(-6_i64..6)),
        diameter in 0_i64..12,
        power in 0_i32..40,
    ) {
        let scale = 2_f64.powi(-power);
        let doubles = places.map(|place| place.map(|value| 1.0 + value as f64 * scale));
        let whole = places.map(|place| place.map(i128::from));
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| minus(whole[i], whole[3]));
        prop_assert_eq!(d, [0; 3]);
        let numerator = [(a, b, c), (b, c, a), (c, a, b)]
            .map(|(p, q, r)| cross(q, r).map(|part| dot(p, p) * part));
        let numerator: Whole = std::array::from_fn(|axis| numerator.iter().map(|part| part[axis]).sum());
        let det = dot(a, cross(b, c));
        let squared = i128::from(diameter).pow(2);
        let expected = dot(numerator, numerator).cmp(&(squared * det * det));
        let diameter_mm = diameter as f64 * scale;
        prop_assert_eq!(compare_sphere(doubles, diameter_mm), expected);

        let [u, v, w, t] = [minus(whole[0], whole[2]), minus(whole[1], whole[2]), minus(whole[0], whole[1]), minus(whole[3], whole[2])];
        let n = cross(u, v);
        let sides = dot(u, u) * dot(v, v) * dot(w, w);
        let corners = [doubles[0], doubles[1], doubles[2]];
        prop_assert_eq!(compare_facet_circle(corners, diameter_mm), sides.cmp(&(squared * dot(n, n))));
        // The centre is (|u|²·v − |v|²·u)×n / 2|n|² from the third corner; the power of the place about it.
        let g: Whole = std::array::from_fn(|axis| dot(u, u) * v[axis] - dot(v, v) * u[axis]);
        let power = dot(t, t) * dot(n, n) - dot(t, cross(g, n));
        prop_assert_eq!(in_facet_ball(corners, doubles[3]), 0.cmp(&power));
    }
}

//! The sphere through four places: whole numbers, the crate `robust`, and ties by heights that are really raised.

use std::cmp::Ordering;

use proptest::prelude::*;

use crate::BoxMm;
use crate::exact::space::orientation_in_space;
use crate::exact::sphere::{
    by_x_y_z, certain_sphere, in_sphere, sphere_encloses, sphere_in_box_encloses,
};
use crate::regressions::beside_source;

fn robust_sign([a, b, c, d, e]: [[f64; 3]; 5]) -> Ordering {
    let [a, b, c, d, e] = [a, b, c, d, e].map(|[x, y, z]| robust::Coord3D { x, y, z });
    robust::insphere(a, b, c, d, e).partial_cmp(&0.0).unwrap()
}

fn determinant<const N: usize>(rows: [[i128; N]; N]) -> i128 {
    // Permutations of up to five columns.
    fn expand(rows: &[&[i128]], used: usize) -> i128 {
        let Some((first, rest)) = rows.split_first() else { return 1 };
        let (mut sum, mut sign) = (0, 1);
        for (column, value) in
            first.iter().enumerate().filter(|(column, _)| used >> column & 1 == 0)
        {
            if *value != 0 {
                sum += sign * value * expand(rest, used | 1 << column);
            }
            sign = -sign;
        }
        sum
    }
    expand(&rows.each_ref().map(|row| &row[..]), 0)
}

/// The sign where place `i` is raised by `raise[i]` on top of its lift.
fn raised(places: [[i64; 3]; 5], raise: [i128; 5]) -> Ordering {
    let rows = [0, 1, 2, 3, 4].map(|i| {
        let [x, y, z] = places[i].map(i128::from);
        [x, y, z, (x * x + y * y + z * z) * UNIT + raise[i], 1]
    });
    determinant(rows).cmp(&0)
}

/// A lift counts so many times as much as the least raise.
const UNIT: i128 = 1 << 80;

fn turned(mut places: [[i64; 3]; 5]) -> Option<[[i64; 3]; 5]> {
    let [a, b, c, d, _] = places.map(|place| place.map(|value| value as f64));
    match orientation_in_space(a, b, c, d) {
        Ordering::Equal => None,
        Ordering::Greater => Some(places),
        Ordering::Less => {
            places.swap(0, 1);
            Some(places)
        }
    }
}

#[test]
fn a_place_inside_outside_and_on_the_sphere() {
    let corners = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]];
    let [a, b, c, d] = corners;
    assert_eq!(orientation_in_space(a, b, c, d), Ordering::Greater);
    for (z, side) in
        [(-1.0 + 1e-16, Ordering::Greater), (-1.0, Ordering::Equal), (-1.0 - 1e-15, Ordering::Less)]
    {
        assert_eq!(in_sphere(a, b, c, d, [0.0, 0.0, z]), side);
    }
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn nearly_cospherical_places_agree_with_robust(
        angles in prop::array::uniform5((0.0_f64..6.3, -1.0_f64..1.0)),
        far in -3_i32..20,
    ) {
        let offset = 2_f64.powi(far);
        let places = angles.map(|(turn, z)| {
            let out = (1.0 - z * z).sqrt();
            [offset + out * turn.cos(), out * turn.sin() - offset, z]
        });
        let [a, b, c, d, e] = places;
        if orientation_in_space(a, b, c, d).is_gt() {
            prop_assert_eq!(in_sphere(a, b, c, d, e), robust_sign(places));
        }
    }

    #[test]
    fn sizes_of_any_kind_agree_with_robust(
        places in prop::array::uniform5(prop::array::uniform3((-1.0_f64..1.0, -25_i32..20))),
    ) {
        let places = places.map(|p| p.map(|(value, power)| value * 2_f64.powi(power)));
        let [a, b, c, d, e] = places;
        if orientation_in_space(a, b, c, d).is_gt() {
            prop_assert_eq!(in_sphere(a, b, c, d, e), robust_sign(places));
            let certain = certain_sphere(BoxMm::about(places.into_iter()).size_mm());
            let found = sphere_in_box_encloses(certain, [a, b, c, d], e);
            prop_assert_eq!(found, sphere_encloses(a, b, c, d, e));
        }
    }

    #[test]
    fn ties_fall_as_if_the_last_places_were_raised(
        places in prop::array::uniform5(prop::array::uniform3(0_i64..3)),
    ) {
        let mut sorted = places;
        sorted.sort_unstable();
        prop_assume!(sorted.windows(2).all(|pair| pair[0] != pair[1]));
        let Some(places) = turned(places) else { return Ok(()) };
        let rank = |place: [i64; 3]| sorted.iter().position(|&other| other == place).unwrap();
        let raise = places.map(|place| 1_i128 << (16 * rank(place)));
        let [a, b, c, d, e] = places.map(|place| place.map(|value| value as f64));
        // The sign of the determinant for a place far outside: the convention of the rows.
        let outside = raised([places[0], places[1], places[2], places[3], [1000, 1000, 1000]], [0; 5]);
        let found = raised(places, raise);
        prop_assert_ne!(found, Ordering::Equal);
        prop_assert_eq!(sphere_encloses(a, b, c, d, e), found != outside);
        let certain = certain_sphere([2.0; 3]);
        prop_assert_eq!(sphere_in_box_encloses(certain, [a, b, c, d], e), found != outside);
        prop_assert_eq!(by_x_y_z(a, b), places[0].cmp(&places[1]));
    }
}

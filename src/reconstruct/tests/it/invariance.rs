//! Facets by places: they must not depend on the order of points, on units that are powers of two, or on quarter turns.

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    Reconstruction, loc_cocone, natural, robust_cocone, super_cocone, tangential, wrap,
};
use proptest::prelude::*;

use crate::shapes::{ball, places, shuffle, torus, uniform};

type Method = fn(&[PointMm]) -> Reconstruction;

const METHODS: [(&str, Method); 6] = [
    ("wrap", |points| wrap(points, None).unwrap().surface),
    ("natural", |points| natural(points).unwrap().surface),
    ("robust-cocone", |points| robust_cocone(points).unwrap().surface),
    ("loccocone", |points| loc_cocone(points, 200).unwrap().cocone.surface),
    ("super-cocone", |points| super_cocone(points, 200).unwrap().cocone.surface),
    ("tangential", |points| tangential(points).unwrap().surface),
];

/// Facets of changed points, by the places that the corners had before.
fn facets(
    method: Method,
    points: &[PointMm],
    change: impl Fn(PointMm) -> PointMm,
) -> Vec<[[u64; 3]; 3]> {
    let changed: Vec<PointMm> = points.iter().copied().map(change).collect();
    places(points, &method(&changed).facets)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn order_power_of_two_and_quarter_turn_change_nothing(seed in 0_u64..1000, power in -20_i32..20) {
        // A ball and a torus beside it, no two places symmetric.
        let mut random = <rand_pcg::Pcg64 as rand_core::SeedableRng>::seed_from_u64(seed);
        let mut points = ball(300, 0.02, seed);
        points.extend(torus(24, 12).0.iter().map(|place| place.map(|value| {
            0.7 * value + 12.0 + 0.01 * uniform(&mut random)
        })));
        for (name, method) in METHODS {
            let expected = facets(method, &points, |place| place);
            prop_assert!(expected.len() > 1_000, "{}", name);
            let mut shuffled = points.clone();
            shuffle(&mut shuffled, seed);
            prop_assert_eq!(&facets(method, &shuffled, |place| place), &expected, "{}", name);
            let scale = 2_f64.powi(power);
            let scaled = facets(method, &points, |place| place.map(|value| value * scale));
            prop_assert_eq!(&scaled, &expected, "{}", name);
            let turned = facets(method, &points, |[x, y, z]| [-y, x, z]);
            prop_assert_eq!(&turned, &expected, "{}", name);
        }
    }
}

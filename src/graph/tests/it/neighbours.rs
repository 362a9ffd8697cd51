//! Neighbours against a look at all places.

use asphera_graph::{Cloud, PlaceId};
use proptest::prelude::*;

fn square<const D: usize>(p: &[f64; D], q: &[f64; D]) -> f64 {
    (0..D).map(|axis| (p[axis] - q[axis]).powi(2)).sum()
}

fn compare<const D: usize>(points: &[[f64; D]], k: usize, radius: f64) {
    let cloud = Cloud::new(points).unwrap();
    let places = cloud.places();
    let nearest = cloud.nearest(k).unwrap();
    let within = cloud.within(radius).unwrap();
    for (row, point) in points.iter().enumerate() {
        assert_eq!(places[cloud.places_of_rows()[row] as usize], *point);
    }
    for (at, place) in places.iter().enumerate() {
        let others = (0..).zip(places).filter(|(other, _)| *other as usize != at);
        let mut all: Vec<(f64, PlaceId)> =
            others.map(|(other, position)| (square(place, position), other)).collect();
        let near = all.iter().filter(|(square, _)| *square < radius * radius);
        let near: Vec<PlaceId> = near.map(|(_, other)| *other).collect();
        assert_eq!(within.neighbours(at as u32), near);
        all.sort_by(|a, b| a.partial_cmp(b).unwrap());
        all.truncate(k);
        assert_eq!(
            nearest.neighbours(at as u32),
            all.iter().map(|(_, id)| *id).collect::<Vec<_>>()
        );
        let distances: Vec<f64> = all.iter().map(|(square, _)| square.sqrt()).collect();
        assert_eq!(nearest.distances_mm(at as u32), distances);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn neighbours_are_those_of_a_look_at_all(
        // A coarse lattice: many copies and equal distances.
        points in prop::collection::vec(prop::array::uniform4(-4_i8..4), 0..300),
        k in 1_usize..20,
        radius in 0.5_f64..4.0,
    ) {
        let points: Vec<[f64; 4]> = points.into_iter().map(|p| p.map(f64::from)).collect();
        compare(&points, k, radius);
        compare(&points.iter().map(|p| [p[0], p[1], p[2]]).collect::<Vec<_>>(), k, radius);
        compare(&points.iter().map(|p| [p[0], p[1]]).collect::<Vec<_>>(), k, radius);
    }

    #[test]
    fn places_do_not_depend_on_the_order_of_points(
        points in prop::collection::vec(prop::array::uniform3(-9_i8..9), 1..400),
        turn in 0_usize..400,
    ) {
        let points: Vec<[f64; 3]> = points.into_iter().map(|p| p.map(f64::from)).collect();
        let mut turned = points.clone();
        turned.rotate_left(turn % points.len());
        turned.reverse();
        let [one, other] = [&points, &turned].map(|points| Cloud::new(points).unwrap());
        prop_assert_eq!(one.places(), other.places());
        prop_assert_eq!(one.centre_mm(), other.centre_mm());
        prop_assert_eq!(one.spacing_mm(), other.spacing_mm());
    }
}

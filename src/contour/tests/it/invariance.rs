//! The same edges whatever the order of the points, a quarter turn or a scale by a power of two.

use asphera_contour::{Method, Parameters, PlaceMm};
use proptest::prelude::*;

use crate::places::{Random, by_row, triangulation};

fn edges(method: Method, points: &[PlaceMm]) -> Vec<[u32; 2]> {
    let set = triangulation(points);
    by_row(&method.run(&set, &Parameters::new()).unwrap(), &set)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn turned_scaled_and_shuffled(
        points in prop::collection::vec([-10.0_f64..10.0, -10.0..10.0], 3..80),
        seed in 0_u64..1000,
    ) {
        let mut rows: Vec<u32> = (0..points.len() as u32).collect();
        Random::new(seed).shuffle(&mut rows);
        let shuffled: Vec<PlaceMm> = rows.iter().map(|&row| points[row as usize]).collect();
        let turned: Vec<PlaceMm> = points.iter().map(|&[x, y]| [-y, x]).collect();
        let scaled: Vec<PlaceMm> = points.iter().map(|place| place.map(|value| value * 2_f64.powi(-13))).collect();
        for method in Method::ALL {
            let expected = edges(method, &points);
            let mut of_shuffled: Vec<[u32; 2]> = edges(method, &shuffled)
                .into_iter()
                .map(|edge| edge.map(|row| rows[row as usize]))
                .map(|[p, q]| [p.min(q), p.max(q)])
                .collect();
            of_shuffled.sort_unstable();
            prop_assert_eq!(&of_shuffled, &expected, "{} shuffled", method.name());
            prop_assert_eq!(edges(method, &turned), expected.clone(), "{} turned", method.name());
            prop_assert_eq!(edges(method, &scaled), expected, "{} scaled", method.name());
        }
    }

    #[test]
    fn shuffled_lattices(points in prop::collection::vec([0_i8..6, 0..6], 1..60), seed in 0_u64..1000) {
        // No row twice: of repeated points the first row stands for all.
        let mut points: Vec<PlaceMm> = points.into_iter().map(|place| place.map(f64::from)).collect();
        points.sort_by(|p, q| p.partial_cmp(q).unwrap());
        points.dedup();
        let mut rows: Vec<u32> = (0..points.len() as u32).collect();
        Random::new(seed).shuffle(&mut rows);
        let shuffled: Vec<PlaceMm> = rows.iter().map(|&row| points[row as usize]).collect();
        for method in Method::ALL {
            let mut of_shuffled: Vec<[u32; 2]> = edges(method, &shuffled)
                .into_iter()
                .map(|edge| edge.map(|row| rows[row as usize]))
                .map(|[p, q]| [p.min(q), p.max(q)])
                .collect();
            of_shuffled.sort_unstable();
            prop_assert_eq!(of_shuffled, edges(method, &points), "{}", method.name());
        }
    }
}

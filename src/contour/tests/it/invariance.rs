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

/// Both ends of Lenz's first edge reach the edge [9, 10] here, from other sides.
#[test]
fn the_probe_does_not_ask_which_end_has_the_smaller_number() {
    let points = [
        [-7.456223650323161, 7.222374741041062],
        [0.9740183478721809, 0.0],
        [6.2591390429240965, -3.4005429909964358],
        [7.309246880528447, -3.353852602991604],
        [9.004639788169726, -2.309487906756882],
        [-6.154112870215634, 0.0],
        [4.868132398745881, 7.633769512329431],
        [9.16318368291558, 0.0],
        [-5.66280020180236, 8.137394489883851],
        [-1.5985593737290453, 8.784025857882217],
        [0.0, 7.750358364333466],
        [4.887105325877666, -1.968742259904801],
        [2.9736528567111944, 9.49866413928907],
        [-7.749139931454296, 2.349950132157115],
        [7.524580780880311, 5.325581303274951],
    ];
    let turned: Vec<PlaceMm> = points.iter().map(|&[x, y]| [-y, x]).collect();
    assert_eq!(edges(Method::Lenz, &turned), edges(Method::Lenz, &points));
}

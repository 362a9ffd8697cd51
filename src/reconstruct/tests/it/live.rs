//! The graph method in batches: after each, what all points give at once by priority, bit for bit.

use asphera_geometry::PointMm;
use asphera_reconstruct::{GraphChoices, GraphError, LandmarkOrder, LiveGraph, PointGraph};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::batches::{CLOUDS, batch_sizes};
use crate::graph::{any_choices, one_of, random_torus};
use crate::shapes::{ball, shuffle, torus};

fn assert_same(live: &LiveGraph, points: &[PointMm], kappa: usize, choices: &GraphChoices) {
    let graph = PointGraph::new(points, kappa, &mut |_| {}).unwrap();
    let expected = graph.surface(choices, &mut |_| {}).unwrap();
    let found = live.surface(choices.threshold, choices.faces);
    assert_eq!(found.map.landmarks, expected.map.landmarks, "after {} points", points.len());
    assert_eq!(found.map.cells, expected.map.cells, "after {} points", points.len());
    assert_eq!(found, expected, "after {} points", points.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    #[test]
    fn after_every_batch_the_map_is_that_of_all_points(seed in 0_u64..100_000) {
        for (_, cloud) in CLOUDS {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut points = cloud(&mut random);
            if random.next_u64() % 2 == 0 {
                shuffle(&mut points, seed);
            }
            let (choices, kappa) = any_choices(&mut random, LandmarkOrder::Priority);
            let most = one_of(&mut random, &[1, 10, 60, 300, 2_000]) as usize;
            let mut live = LiveGraph::new(kappa, choices.hops).unwrap();
            let (mut count, mut since) = (0, 0);
            for size in batch_sizes(&mut random, points.len(), most) {
                live.insert(&points[count..count + size]).unwrap();
                count += size;
                since += size;
                if since > 150 || most == 10 && count < 80 || count == points.len() {
                    since = 0;
                    assert_same(&live, &points[..count], kappa, &choices);
                }
            }
            prop_assert_eq!(live.received(), points.len());
        }
    }
}

#[test]
fn balls_and_tori_grow_as_they_are_scanned_and_at_random() {
    let choices = GraphChoices { order: LandmarkOrder::Priority, ..GraphChoices::default() };
    let mut scattered = ball(12_000, 1e-3, 2);
    shuffle(&mut scattered, 5);
    for points in [ball(12_000, 1e-3, 2), scattered, torus(200, 60).0, random_torus(12_000, 3)] {
        let mut live = LiveGraph::new(15, choices.hops).unwrap();
        for (batch, number) in points.chunks(500).zip(1..) {
            live.insert(batch).unwrap();
            if number % 4 == 0 {
                assert_same(&live, &points[..500 * number], 15, &choices);
            }
        }
    }
}

#[test]
fn numbers_out_of_range_are_refused() {
    let refused = LiveGraph::new(0, 5).err();
    assert_eq!(refused, Some(GraphError::Neighbours { found: 0 }));
    assert_eq!(LiveGraph::new(15, 0).err(), Some(GraphError::Hops { found: 0 }));
}

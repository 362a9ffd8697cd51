//! Pieces, arcs and loops against their definitions.

use asphera_geometry::Sets;
use asphera_graph::{Choices, Cloud, PointGraph, Strips, extract, functions, tau_components};
use proptest::prelude::*;

use crate::bodies::{Body, Random};

/// Pieces by all pairs, numbered by their smallest places.
fn by_pairs(places: &[[f64; 3]], strips: &[usize], tau: f64) -> Vec<u32> {
    let mut sets = Sets::new(places.len());
    for_pairs(places, tau, |a, b| {
        if strips[a] == strips[b] {
            sets.join(a, b);
        }
    });
    (0..places.len()).map(|place| sets.root(place) as u32).collect()
}

fn for_pairs(places: &[[f64; 3]], tau: f64, mut take: impl FnMut(usize, usize)) {
    for a in 0..places.len() {
        for b in 0..places.len() {
            let square: f64 = (0..3).map(|axis| (places[a][axis] - places[b][axis]).powi(2)).sum();
            if a != b && square < tau * tau {
                take(a, b);
            }
        }
    }
}

/// The smallest member of each place's piece.
fn smallest(of_place: &[u32]) -> Vec<u32> {
    let first = |piece: &u32| of_place.iter().position(|other| other == piece).unwrap() as u32;
    of_place.iter().map(first).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_graph_is_its_definition(
        points in prop::collection::vec(prop::array::uniform3(0_u16..1000), 1..220),
        tau in prop_oneof![Just(100.0), 20.0..400.0_f64],
        count in 1_usize..12,
    ) {
        let points: Vec<[f64; 3]> = points.into_iter().map(|p| p.map(f64::from)).collect();
        let cloud = Cloud::new(&points).unwrap();
        let (places, field) = (cloud.places(), functions::height(&cloud, [1.0, 0.0, 0.0]).unwrap());
        let [low, high] = field.range().unwrap();
        let strips = Strips::uniform(low, high, count).unwrap();
        let of: Vec<usize> = field.values.iter().map(|&value| strips.strip_of(value)).collect();
        let graph = PointGraph::new(&cloud, &field.values, strips, tau).unwrap();
        let nodes = graph.nodes_of_places();
        prop_assert_eq!(smallest(nodes), by_pairs(places, &of, tau));
        let mut arcs = std::collections::BTreeMap::new();
        for_pairs(places, tau, |a, b| {
            if of[a] + 1 == of[b] {
                let square: f64 = (0..3).map(|axis| (places[a][axis] - places[b][axis]).powi(2)).sum();
                let least = arcs.entry([nodes[a], nodes[b]]).or_insert(f64::INFINITY);
                *least = least.min(square.sqrt());
            }
        });
        let found: Vec<_> = graph.arcs().iter().map(|arc| (arc.nodes, arc.distance_mm)).collect();
        prop_assert_eq!(found, arcs.into_iter().collect::<Vec<_>>());
        let components = graph.components().1 as usize;
        prop_assert_eq!(graph.loops().len(), graph.arcs().len() + components - graph.nodes().len());
        let whole = tau_components(&cloud, tau).unwrap();
        prop_assert_eq!(smallest(&whole.0), by_pairs(places, &vec![0; places.len()], tau));
    }
}

#[test]
fn order_and_threads_change_no_bit() {
    let mut random = Random::new(5);
    let points = Body::row(2).sample(40_000, &mut random);
    let mut shuffled = points.clone();
    random.shuffle(&mut shuffled);
    let graph = |points: &[[f64; 3]], threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let cloud = Cloud::new(points).unwrap();
            let field = functions::principal_height(&cloud, 1).unwrap();
            let [low, high] = field.range().unwrap();
            let strips = Strips::uniform(low, high, 60).unwrap();
            let graph = PointGraph::new(&cloud, &field.values, strips, 0.08).unwrap();
            let found = extract(&cloud, &field, &Choices::default()).unwrap();
            let loops = (found.loops, found.minor_loops);
            (graph.nodes().to_vec(), graph.arcs().to_vec(), graph.nodes_of_places().to_vec(), loops)
        })
    };
    let expected = graph(&points, 1);
    assert_eq!(graph(&shuffled, 1), expected);
    assert_eq!(graph(&shuffled, 3), expected);
}

#[test]
fn the_range_of_a_loop_is_that_of_the_hole() {
    // A ring in the plane of radius 1 and a smaller one beside it, joined by a line.
    let ring = |x: f64, radius: f64| {
        (0..2000).map(move |step| {
            let angle = f64::from(step) * std::f64::consts::TAU / 2000.0;
            [x + radius * angle.cos(), radius * angle.sin()]
        })
    };
    let line = (0..500).map(|step| [1.0 + 0.002 * f64::from(step), 0.0]);
    let points: Vec<[f64; 2]> = ring(0.0, 1.0).chain(ring(2.5, 0.5)).chain(line).collect();
    let cloud = Cloud::new(&points).unwrap();
    let field = functions::height(&cloud, [1.0, 0.0]).unwrap();
    let strips = Strips::uniform(-1.0, 3.0, 80).unwrap();
    let graph = PointGraph::new(&cloud, &field.values, strips, 0.03).unwrap();
    let loops = graph.loops();
    assert_eq!(loops.len(), 2);
    for (found, truth) in loops.iter().zip([[-1.0, 1.0], [2.0, 3.0]]) {
        for (end, truth) in found.range.iter().zip(truth) {
            assert!((end - truth).abs() <= 0.1 + 1e-9, "{:?} {truth:?}", found.range);
        }
    }
    let segments = graph.segments();
    // The line between the rings, and each ring from where the line touches it back to there.
    assert_eq!(segments.len(), 3, "{segments:?}");
    let is_closed = segments.iter().filter(|segment| segment.nodes.first() == segment.nodes.last());
    assert_eq!(is_closed.count(), 2);
}

//! Graphs of several resolutions are consistent, and the finest one is the graph of its strips.

use std::collections::BTreeSet;

use asphera_graph::{Cloud, ExtractError, PointGraph, Strips, auto_tau_mm, functions, resolutions};
use proptest::prelude::*;

use crate::bodies::{Body, Random};

/// Whether the finer graph maps onto the coarser one: places stay together, arcs follow arcs, strips follow strips.
fn assert_maps<const D: usize>(fine: &PointGraph<D>, holders: &[u32], coarse: &PointGraph<D>) {
    assert_eq!(holders.len(), fine.nodes().len());
    for (&node, &holder) in fine.nodes_of_places().iter().zip(coarse.nodes_of_places()) {
        assert_eq!(holders[node as usize], holder);
    }
    let arcs: BTreeSet<[u32; 2]> = coarse.arcs().iter().map(|arc| arc.nodes).collect();
    for arc in fine.arcs() {
        let ends = arc.nodes.map(|node| holders[node as usize]);
        assert!(ends[0] == ends[1] || arcs.contains(&ends), "{arc:?} to {ends:?}");
    }
    // Every piece is the sum of its parts.
    let mut places = vec![0; coarse.nodes().len()];
    for (node, &holder) in fine.nodes().iter().zip(holders) {
        places[holder as usize] += node.places;
        let [fine, coarse] = [fine.strips(), coarse.strips()].map(Strips::bounds);
        let holder = &coarse[coarse_strip(coarse, fine[node.strip as usize])..];
        assert!(fine[node.strip as usize + 1] <= holder[1]);
    }
    let expected: Vec<u32> = coarse.nodes().iter().map(|node| node.places).collect();
    assert_eq!(places, expected);
}

/// The strip that begins at a value. That of a constant function ends where it begins.
fn coarse_strip(bounds: &[f64], value: f64) -> usize {
    (bounds.partition_point(|&bound| bound <= value) - 1).min(bounds.len() - 2)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn finer_graphs_map_onto_coarser_ones(
        points in prop::collection::vec(prop::array::uniform2(0_u8..40), 2..250),
        tau in 1.0..6.0_f64,
        count in 1_usize..5,
        halvings in 0_u32..5,
    ) {
        let points: Vec<[f64; 2]> = points.into_iter().map(|p| p.map(f64::from)).collect();
        let cloud = Cloud::new(&points).unwrap();
        let field = functions::height(&cloud, [1.0, 0.0]).unwrap();
        let [low, high] = field.range().unwrap();
        let coarsest = Strips::uniform(low, high, count).unwrap();
        let found = resolutions(&cloud, &field, &coarsest, tau, halvings).unwrap();
        prop_assert_eq!(found.len(), halvings as usize + 1);
        prop_assert!(found[0].coarser.is_empty());
        for pair in found.windows(2) {
            assert_maps(&pair[1].graph, &pair[1].coarser, &pair[0].graph);
        }
        let finest = &found[halvings as usize].graph;
        let alone = PointGraph::new(&cloud, &field.values, finest.strips().clone(), tau).unwrap();
        prop_assert_eq!(finest.nodes(), alone.nodes());
        prop_assert_eq!(finest.arcs(), alone.arcs());
    }
}

/// Coarse strips do not part the branches of a hole; finer ones do, once they are thinner than the hole is long.
#[test]
fn holes_appear_as_strips_get_thinner() {
    let points = Body::row(3).sample(60_000, &mut Random::new(31));
    let cloud = Cloud::new(&points).unwrap();
    let field = functions::height(&cloud, [1.0, 0.2, 0.1]).unwrap();
    let [low, high] = field.range().unwrap();
    let tau_mm = auto_tau_mm(&cloud).unwrap();
    let coarsest = Strips::uniform(low, high, 1).unwrap();
    let found = resolutions(&cloud, &field, &coarsest, tau_mm, 5).unwrap();
    let loops: Vec<usize> = found.iter().map(|one| one.graph.loops().len()).collect();
    assert_eq!(loops[0], 0);
    assert_eq!(loops[5], 3, "{loops:?}");
    assert!(loops.windows(2).all(|pair| pair[0] <= pair[1]), "{loops:?}");
    let strips: Vec<usize> = found.iter().map(|one| one.graph.strips().count()).collect();
    assert_eq!(strips, [1, 2, 4, 8, 16, 32]);
    let thin = Strips::uniform(low, high, 600_000).unwrap();
    let many = resolutions(&cloud, &field, &thin, tau_mm, 1);
    assert!(matches!(many, Err(ExtractError::Strips(_))), "more strips than there may be");
}

//! TSP and edge exchange: steps that were left, shortest tours by search, and bounds.

use std::collections::BTreeSet;

use asphera_contour::curves::{
    MOST_FOR_EXCHANGE, MOST_FOR_TOUR, connect2d, edge_exchange, hiyoshi, tsp,
};
use asphera_contour::graphs::emst;
use asphera_contour::{Graph, Method, MethodError, Parameters, PlaceMm, SampleId, Triangulation};

use crate::places::{by_row, circle, closed, distance, lattice, scattered, triangulation};

fn length(graph: &Graph, set: &Triangulation) -> f64 {
    graph.edges().iter().map(|&[p, q]| distance(set.place(p), set.place(q))).sum()
}

/// Length of the shortest tour, by trying all.
fn shortest(at: &[PlaceMm]) -> f64 {
    fn search(at: &[PlaceMm], way: &mut Vec<usize>, sum: f64, best: &mut f64) {
        let last = way[way.len() - 1];
        if way.len() == at.len() {
            *best = best.min(sum + distance(at[last], at[0]));
        }
        for next in 1..at.len() {
            let sum = sum + distance(at[last], at[next]);
            if sum < *best && !way.contains(&next) {
                way.push(next);
                search(at, way, sum, best);
                way.pop();
            }
        }
    }
    let mut best = f64::INFINITY;
    search(at, &mut vec![0], 0.0, &mut best);
    best
}

#[test]
fn tours_of_few_samples_are_nearly_always_the_shortest() {
    let (mut same, mut tried) = (0, 0);
    for seed in 0..120 {
        let set = triangulation(&scattered(5 + seed as usize % 5, seed + 2000));
        let found = length(&tsp(&set).unwrap(), &set);
        let best = shortest(set.samples().places());
        assert!(found >= best - 1e-9 && found < 1.15 * best, "seed {seed}: {found}, {best}");
        same += u32::from(found < best + 1e-9);
        tried += 1;
    }
    println!("{same} of {tried} tours are the shortest");
    assert!(same >= 110, "{same}");
}

/// The samples of a tour in order.
fn order(graph: &Graph, set: &Triangulation) -> Vec<usize> {
    let chains = graph.chains(set.len());
    assert!(chains.len() == 1 && chains[0].closed && chains[0].samples.len() == set.len());
    chains[0].samples.iter().map(|&sample| sample as usize).collect()
}

#[test]
fn no_reversal_and_no_shift_shortens_a_tour_of_nine() {
    // Of nine samples each has all others among its eight nearest.
    for seed in 0..60 {
        let set = triangulation(&scattered(9, seed + 2500));
        let at = set.samples().places();
        let graph = tsp(&set).unwrap();
        let tour = order(&graph, &set);
        let of = |tour: &[usize]| -> f64 {
            let next = tour.iter().cycle().skip(1);
            tour.iter().zip(next).map(|(&p, &q)| distance(at[p], at[q])).sum()
        };
        let found = of(&tour);
        for turn in 0..9 {
            let mut turned = tour.clone();
            turned.rotate_left(turn);
            for end in 2..9 {
                let mut reversed = turned.clone();
                reversed[..end].reverse();
                assert!(of(&reversed) >= found - 1e-9, "seed {seed}");
            }
            for count in 1..=3 {
                let (piece, others) = turned.split_at(count);
                for place in 1..others.len() {
                    for is_reversed in [false, true] {
                        let mut piece = piece.to_vec();
                        if is_reversed {
                            piece.reverse();
                        }
                        let mut shifted = others.to_vec();
                        shifted.splice(place..place, piece);
                        assert!(of(&shifted) >= found - 1e-9, "seed {seed}");
                    }
                }
            }
        }
    }
}

#[test]
fn tours_join_all_samples_between_their_bounds() {
    for seed in 0..12 {
        let points = if seed % 2 == 0 { scattered(200, seed) } else { lattice(60, seed) };
        let set = triangulation(&points);
        let tour = tsp(&set).unwrap();
        assert_eq!(order(&tour, &set).len(), set.len());
        // Edges of a tour need not be Delaunay edges, so of points at random only the tour with such edges is bounded below.
        if tour.edges().iter().all(|&[p, q]| set.edge_between(p, q).is_some()) {
            assert!(length(&tour, &set) >= length(&hiyoshi(&set).unwrap(), &set) - 1e-9);
        }
        let begun = connect2d(&set);
        if begun.alone(set.len()).is_empty() {
            assert!(length(&tour, &set) <= length(&begun, &set) + 1e-9);
        }
    }
}

#[test]
fn a_clean_outline_is_its_own_tour() {
    let wavy: Vec<PlaceMm> = (0..300)
        .map(|step| {
            let angle = f64::from(step) * std::f64::consts::TAU / 300.0;
            let radius = 10.0 + 2.0 * (5.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let set = triangulation(&wavy);
    assert_eq!(by_row(&tsp(&set).unwrap(), &set), closed(300));
    assert_eq!(by_row(&edge_exchange(&set).unwrap(), &set), closed(300));
}

/// How far the samples are from two edges each.
fn excess(degrees: &[u32]) -> u32 {
    degrees.iter().map(|degree| degree.abs_diff(2)).sum()
}

fn is_connected(edges: &BTreeSet<[SampleId; 2]>, count: usize) -> bool {
    let mut met = BTreeSet::from([0]);
    loop {
        let before = met.len();
        for &[p, q] in edges {
            if met.contains(&p) || met.contains(&q) {
                met.extend([p, q]);
            }
        }
        if met.len() == before {
            return before == count;
        }
    }
}

#[test]
fn edge_exchange_ends_where_no_snap_move_or_swap_is_left() {
    for seed in 0..25 {
        let points = if seed % 5 == 0 { lattice(25, seed) } else { scattered(25, seed + 3000) };
        let set = triangulation(&points);
        let count = set.len();
        let found = edge_exchange(&set).unwrap();
        let edges: BTreeSet<[SampleId; 2]> = found.edges().iter().copied().collect();
        assert!(is_connected(&edges, count));
        let of = |edges: &BTreeSet<[SampleId; 2]>| Graph::new(edges.iter().copied());
        let degrees = found.degrees(count);
        assert!(excess(&degrees) <= excess(&emst(&set).degrees(count)));
        let all: Vec<[SampleId; 2]> = set.edges().iter().map(|edge| edge.ends).collect();
        for come in all.iter().filter(|come| !edges.contains(*come)) {
            let mut snapped = edges.clone();
            snapped.insert(*come);
            assert!(excess(&of(&snapped).degrees(count)) + 2 > excess(&degrees), "seed {seed}");
            for go in &edges {
                let mut moved = snapped.clone();
                moved.remove(go);
                let shares = come.iter().any(|end| go.contains(end));
                if shares && is_connected(&moved, count) {
                    let left = excess(&of(&moved).degrees(count));
                    assert!(left + 2 > excess(&degrees), "seed {seed}: {come:?} for {go:?}");
                }
            }
        }
    }
}

#[test]
fn more_samples_than_the_limit_are_refused() {
    let set = triangulation(&circle(MOST_FOR_EXCHANGE + 1));
    let refused = Method::EdgeExchange.run(&set, &Parameters::new()).unwrap_err();
    let most = MOST_FOR_EXCHANGE;
    assert_eq!(refused, MethodError::TooMany { method: "edge-exchange", most, found: most + 1 });
    let set = triangulation(&circle(MOST_FOR_TOUR + 1));
    let refused = Method::Tsp.run(&set, &Parameters::new()).unwrap_err();
    let most = MOST_FOR_TOUR;
    assert_eq!(refused, MethodError::TooMany { method: "tsp", most, found: most + 1 });
}

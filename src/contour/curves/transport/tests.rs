//! The greedy steps against all that could be done, and costs against transport that is added up in small steps.

use super::ends::{Ends, doubled_area_mm2, is_left_turn};
use super::load::Cost;
use super::planar::{Planar, next};
use super::star::{Collapses, Star};
use super::*;
use crate::{PlaceMm, Samples};

/// Points at random in a square of 1 mm.
fn scattered(count: usize, seed: u64) -> Vec<PlaceMm> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut share = || {
        state = state.wrapping_mul(0x5851_F42D_4C95_7F2D).wrapping_add(0x1405_7B7E_F767_814F);
        (state >> 11) as f64 * 2_f64.powi(-53)
    };
    (0..count).map(|_| [share(), share()]).collect()
}

fn planar_of(points: &[PlaceMm]) -> Planar {
    Planar::new(&Triangulation::new(Samples::new(points).unwrap()))
}

/// The cost of all points, edge by edge.
fn total_mm2(planar: &Planar) -> f64 {
    planar.loaded().map(|(_, load)| load.cost_mm2).sum()
}

/// Every point is carried once, and the triangles fill the square without a fold.
fn check(planar: &Planar, extent_mm: f64) {
    let own = (0..planar.len() as u32).filter(|&sample| planar.has_own(sample));
    let loads = planar.loaded().flat_map(|(_, load)| load.samples.iter().copied());
    let mut carried: Vec<u32> = own.chain(loads).collect();
    carried.sort_unstable();
    assert_eq!(carried, (0..planar.len() as u32).collect::<Vec<_>>());
    let mut spokes = Vec::new();
    let mut doubled_mm2 = 0.0;
    for vertex in (0..planar.len() as u32).filter(|&vertex| planar.is_there(vertex)) {
        planar.spokes(vertex, &mut spokes);
        for &spoke in &spokes {
            let corners = [spoke, next(spoke), next(next(spoke))].map(|half| planar.origin(half));
            let [a, b, c] = corners.map(|corner| planar.place(corner));
            assert!(is_left_turn(a, b, c), "{corners:?}");
            let within = corners.iter().filter(|&&corner| !planar.is_corner(corner)).count();
            doubled_mm2 += doubled_area_mm2(a, b, c) / within as f64;
        }
    }
    // Triangles of corners alone hold no vertex, and there are none beside the square's sides while samples have an area.
    let square_mm2 = (4.0 * extent_mm).powi(2);
    assert!((0.5 * doubled_mm2 - square_mm2).abs() < 1e-9 * square_mm2, "{doubled_mm2}");
}

#[test]
fn every_step_is_the_cheapest_of_all_and_costs_what_it_says() {
    for seed in 0..6 {
        let points = scattered(60, seed + 1);
        let mut planar = planar_of(&points);
        let span = |axis: usize| {
            let values = points.iter().map(|place| place[axis]);
            let [l, h] = values.fold([1.0_f64, 0.0_f64], |[l, h], v| [l.min(v), h.max(v)]);
            h - l
        };
        let extent_mm = span(0).max(span(1));
        check(&planar, extent_mm);
        let mut queue = Queue::new(&planar);
        let mut steps = 0;
        while let Some((from, to)) = queue.next(&planar) {
            let star = Star::collapsed(&planar, from, to).unwrap();
            let mut spokes = Vec::new();
            let mut least_mm2 = f64::INFINITY;
            for vertex in (0..60).filter(|&vertex| planar.is_there(vertex)) {
                planar.spokes(vertex, &mut spokes);
                let others = spokes.iter().map(|&spoke| planar.origin(next(spoke)));
                for other in others.filter(|&other| !planar.is_corner(other)) {
                    if let Some(other) = Star::collapsed(&planar, vertex, other) {
                        least_mm2 = least_mm2.min(other.added_mm2);
                    }
                }
            }
            assert!(star.added_mm2 <= least_mm2 + 1e-12, "{} {least_mm2}", star.added_mm2);
            let before_mm2 = total_mm2(&planar);
            let mut touched = planar.collapse(&star);
            let after_mm2 = total_mm2(&planar);
            assert!((after_mm2 - before_mm2 - star.added_mm2).abs() < 1e-12);
            check(&planar, extent_mm);
            if let Some(star) = Star::moved(&planar, to) {
                touched.extend(planar.relocate(&star));
                assert!(star.added_mm2 < 0.0);
                assert!((total_mm2(&planar) - after_mm2 - star.added_mm2).abs() < 1e-12);
                check(&planar, extent_mm);
            }
            touched.sort_unstable();
            touched.dedup();
            queue.renew(&planar, &touched);
            steps += 1;
        }
        assert!(steps >= 55, "seed {seed}: {steps} steps");
    }
}

/// The cost onto an edge is that of the monotone plan: the edge in small pieces of equal mass, each filled from the next point.
#[test]
fn the_cost_onto_an_edge_is_that_of_the_best_plan() {
    const PIECES: usize = 2000;
    for seed in 0..10 {
        let points = scattered(7, seed + 50);
        let [from, to] = [[0.1, -0.2], [0.9, 0.7]];
        let ends = Ends::new(from, to);
        let found = Cost::of(&ends, points.iter().copied(), &mut Vec::new());
        let toward = |place: PlaceMm| (to[0] - from[0]) * place[0] + (to[1] - from[1]) * place[1];
        let mut sorted = points.clone();
        sorted.sort_by(|&p, &q| toward(p).total_cmp(&toward(q)));
        let mut sum_mm2 = 0.0;
        for piece in 0..7 * PIECES {
            let share = (piece as f64 + 0.5) / (7 * PIECES) as f64;
            let at = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
            let [x, y] = sorted[piece / PIECES];
            sum_mm2 += ((at[0] - x).powi(2) + (at[1] - y).powi(2)) / PIECES as f64;
        }
        let nearer = |&[x, y]: &PlaceMm| {
            let to_end = |end: PlaceMm| (x - end[0]).powi(2) + (y - end[1]).powi(2);
            to_end(from).min(to_end(to))
        };
        let to_ends_mm2: f64 = points.iter().map(nearer).sum();
        let least_mm2 = sum_mm2.min(to_ends_mm2);
        assert!((found.least_mm2() - least_mm2).abs() < 1e-6 * least_mm2, "seed {seed}");
    }
}

#[test]
fn a_vertex_that_is_gone_collapses_no_more() {
    let mut planar = planar_of(&scattered(20, 3));
    let (to, _) = Collapses::new(&planar).cheapest(5).unwrap();
    let star = Star::collapsed(&planar, 5, to).unwrap();
    planar.collapse(&star);
    assert!(Collapses::new(&planar).cheapest(5).is_none());
    assert!(Star::collapsed(&planar, to, 5).is_none());
}

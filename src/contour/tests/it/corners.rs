//! GathanG: corners of polygons, pieces between them, and what it shares with Gathan.

use asphera_contour::curves::{gathan, gathan_g, nn_crust};
use asphera_contour::{Graph, PlaceMm, Triangulation};

use crate::places::{Random, by_row, circle, closed, distance, lattice, scattered, triangulation};
use crate::smooth::{Condition, Curve};

/// Samples of a closed polygon about half a millimetre apart, evenly along each side, from a share of the step after each corner on.
fn sampled(corners: &[PlaceMm], first: f64) -> Vec<PlaceMm> {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    sides
        .flat_map(|(&from, &to)| {
            let steps = (2.0 * distance(from, to)).round() as u32;
            (0..steps).map(move |step| {
                let share = (f64::from(step) + first) / f64::from(steps);
                [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
            })
        })
        .collect()
}

/// A star whose inner corners lie on a circle of another radius.
fn star(points: u32, inner: f64) -> Vec<PlaceMm> {
    let corner = |index: u32| {
        let (sin, cos) = (f64::from(index) * std::f64::consts::PI / f64::from(points)).sin_cos();
        let radius = if index.is_multiple_of(2) { 10.0 } else { inner };
        [radius * cos, radius * sin]
    };
    (0..2 * points).map(corner).collect()
}

/// Share of the edges of the polygon that a graph has.
fn recall(graph: &Graph, set: &Triangulation) -> f64 {
    let (found, wanted) = (by_row(graph, set), closed(set.len()));
    wanted.iter().filter(|edge| found.contains(edge)).count() as f64 / wanted.len() as f64
}

#[test]
fn polygons_with_a_sample_in_each_corner_and_without() {
    let square = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    let bracket = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 3.0], [3.0, 3.0], [3.0, 10.0], [0.0, 10.0]];
    let triangle = vec![[0.0, 0.0], [10.0, 1.0], [4.0, 8.0]];
    for (name, corners) in
        [("square", square), ("bracket", bracket), ("triangle", triangle), ("star", star(5, 5.0))]
    {
        for first in [0.0, 0.5] {
            let set = triangulation(&sampled(&corners, first));
            let graph = gathan_g(&set, 35.0, 0.5);
            let [here, plain, nearest] =
                [&graph, &gathan(&set, 35.0, 0.5), &nn_crust(&set)].map(|it| recall(it, &set));
            println!(
                "{name} {first}: gathan-g {here:.3}, gathan {plain:.3}, nn-crust {nearest:.3}"
            );
            assert!(here >= plain, "{name} {first}: {here}");
            // Without a sample in it, a corner of less than 60° may lose the edge across.
            assert!(here >= 0.95, "{name} {first}: {here}");
            assert!(name == "star" || first > 0.0 || here == 1.0, "{name} {first}: {here}");
        }
    }
}

#[test]
fn smooth_curves_are_closed() {
    let mut random = Random::new(21);
    let (mut tried, mut wrong) = (0, 0);
    while tried < 20 {
        let curve = Curve::random(&mut random, 600);
        let Some(points) = curve.samples(Condition::Epsilon(0.2), &mut random) else { continue };
        let set = triangulation(&points);
        wrong += usize::from(by_row(&gathan_g(&set, 35.0, 0.5), &set) != closed(points.len()));
        tried += 1;
    }
    assert_eq!(wrong, 0);
}

#[test]
fn no_sample_has_three_edges() {
    for seed in 0..20 {
        for points in [scattered(120, seed), lattice(50, seed)] {
            let set = triangulation(&points);
            let graph = gathan_g(&set, 35.0, 0.5);
            assert!(graph.degrees(set.len()).into_iter().all(|degree| degree <= 2));
            // Each edge joins Delaunay neighbours.
            assert!(graph.edges().iter().all(|&[p, q]| set.edge_between(p, q).is_some()));
        }
    }
}

#[test]
fn gaps_stay_open() {
    // Three sides of a square, with a gap of ten steps where the fourth would be, and a circle without a quarter.
    let bracket = sampled(&[[0.0, 10.0], [0.0, 0.0], [5.0, 0.0], [5.0, 10.0]], 0.0);
    let ring: Vec<PlaceMm> = circle(80)[..60].to_vec();
    for points in [bracket[..51].to_vec(), ring] {
        let set = triangulation(&points);
        let path: Vec<[u32; 2]> = (1..points.len() as u32).map(|row| [row - 1, row]).collect();
        let found = by_row(&gathan_g(&set, 35.0, 0.5), &set);
        let extra: Vec<_> = found.iter().filter(|edge| !path.contains(edge)).collect();
        let missing: Vec<_> = path.iter().filter(|edge| !found.contains(edge)).collect();
        assert!(extra.is_empty() && missing.is_empty(), "{extra:?} {missing:?}");
    }
}

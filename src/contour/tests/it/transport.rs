//! Optimal transport: few edges for many points, beside noise and without outliers.

use std::f64::consts::TAU;

use asphera_contour::{FoundCurve, Method, Parameters, PlaceMm, Triangulation};
use asphera_geometry::Numbers;

use crate::places::{Random, distance, triangulation};

fn run(set: &Triangulation, parameters: &str) -> FoundCurve {
    Method::OptimalTransport.curve(set, &Parameters::parse(parameters).unwrap()).unwrap()
}

/// The places of the vertices of the only chain.
fn only_chain(set: &Triangulation, found: &FoundCurve, is_closed: bool) -> Vec<PlaceMm> {
    let chains = found.graph.chains(set.len());
    assert_eq!(chains.len(), 1, "{chains:?}");
    assert_eq!(chains[0].closed, is_closed);
    let places = found.places_mm.as_ref().unwrap();
    chains[0].samples.iter().map(|&sample| places[sample as usize]).collect()
}

/// Noise of 10 µm on a square of 10 mm: four corners, each within a third of the spacing.
#[test]
fn a_noisy_square_has_four_corners() {
    for draw in 0..5 {
        let numbers = Numbers::new(31, draw, 0);
        let points: Vec<PlaceMm> = (0..400)
            .map(|index| {
                let along = (index % 100) as f64 / 10.0;
                let [x, y] = match index / 100 {
                    0 => [along, 0.0],
                    1 => [10.0, along],
                    2 => [10.0 - along, 10.0],
                    _ => [0.0, 10.0 - along],
                };
                [x + 0.01 * numbers.normal(2 * index), y + 0.01 * numbers.normal(2 * index + 1)]
            })
            .collect();
        let set = triangulation(&points);
        for parameters in ["", "vertices=4"] {
            let found = run(&set, parameters);
            let corners = only_chain(&set, &found, true);
            assert_eq!(corners.len(), 4, "{parameters}");
            for corner in corners {
                let truth = corner.map(|value| if value < 5.0 { 0.0 } else { 10.0 });
                assert!(distance(corner, truth) < 0.03, "{corner:?}");
            }
            let sigma_mm = found.sigma_mm.unwrap();
            assert!((0.008..0.016).contains(&sigma_mm), "{sigma_mm}");
        }
    }
}

/// One outlier to seven points of a noisy circle: they carry no edge.
#[test]
fn outliers_carry_no_edge() {
    for seed in 0..5 {
        let mut random = Random::new(seed + 400);
        let numbers = Numbers::new(32, seed as u32, 0);
        let mut points: Vec<PlaceMm> = (0..300)
            .map(|index| {
                let (sin, cos) = (TAU * index as f64 / 300.0).sin_cos();
                let radius = 5.0 + 0.02 * numbers.normal(index);
                [radius * cos, radius * sin]
            })
            .collect();
        points.extend((0..45).map(|_| [random.between(-7.0, 7.0), random.between(-7.0, 7.0)]));
        let set = triangulation(&points);
        let found = run(&set, "");
        let places = found.places_mm.as_ref().unwrap();
        let radius = |vertex: u32| {
            let [x, y] = places[vertex as usize];
            x.hypot(y)
        };
        let far = found.graph.edges().as_flattened().iter().filter(|&&vertex| {
            // Edges of so many corners leave the circle by 0.1 mm.
            (radius(vertex) - 5.0).abs() > 0.2
        });
        assert_eq!(far.count(), 0, "seed {seed}");
        let lengths = found
            .graph
            .edges()
            .iter()
            .map(|&[p, q]| distance(places[p as usize], places[q as usize]));
        let length: f64 = lengths.sum();
        assert!(length > 0.9 * TAU * 5.0, "seed {seed}: {length}");
    }
}

/// The tolerance holds, and more vertices are not worse.
#[test]
fn the_distance_of_the_points_falls_with_the_tolerance() {
    let points: Vec<PlaceMm> = (0..600)
        .map(|index| (TAU * index as f64 / 600.0).sin_cos())
        .map(|(s, c)| [8.0 * c, 3.0 * s])
        .collect();
    let set = triangulation(&points);
    let mut before = usize::MAX;
    for tolerance in [0.05, 0.1, 0.2, 0.4] {
        let found = run(&set, &format!("tolerance_mm={tolerance}"));
        let line = only_chain(&set, &found, true);
        assert!(line.len() < before, "{tolerance}: {} vertices", line.len());
        before = line.len();
        let sides = (0..line.len()).map(|it| [line[it], line[(it + 1) % line.len()]]);
        let sides: Vec<[PlaceMm; 2]> = sides.collect();
        let squares: f64 = points.iter().map(|&p| to_nearest(p, &sides).powi(2)).sum();
        assert!((squares / 600.0).sqrt() <= tolerance);
    }
}

fn to_nearest(p: PlaceMm, sides: &[[PlaceMm; 2]]) -> f64 {
    let to_side = |[a, b]: &[PlaceMm; 2]| {
        let along = [b[0] - a[0], b[1] - a[1]];
        let share = ((p[0] - a[0]) * along[0] + (p[1] - a[1]) * along[1])
            / (along[0] * along[0] + along[1] * along[1]);
        let share = share.clamp(0.0, 1.0);
        distance(p, [a[0] + share * along[0], a[1] + share * along[1]])
    };
    sides.iter().map(to_side).fold(f64::INFINITY, f64::min)
}

#[test]
fn an_open_line_stays_open_and_a_far_one_is_the_same() {
    let near: Vec<PlaceMm> = (0..100)
        .map(|index| {
            [f64::from(index) / 8.0, ((f64::from(index) / 8.0).sin() * 1024.0).round() / 1024.0]
        })
        .collect();
    let far: Vec<PlaceMm> = near.iter().map(|[x, y]| [x + 3e11, y - 2e11]).collect();
    let [near, far] = [near, far].map(|points| triangulation(&points));
    let [at_home, away] = [&near, &far].map(|set| run(set, ""));
    assert_eq!(at_home.graph, away.graph);
    let [here, there] =
        [(&near, &at_home), (&far, &away)].map(|(set, found)| only_chain(set, found, false));
    assert!((4..20).contains(&here.len()), "{}", here.len());
    for (p, q) in here.iter().zip(&there) {
        assert!(distance(*p, [q[0] - 3e11, q[1] + 2e11]) < 1e-3);
    }
}

#[test]
fn few_points_and_points_on_a_line_or_raster() {
    for points in [vec![], vec![[1.0, 2.0]], vec![[1.0, 2.0]; 4], vec![[0.0, 0.0], [1.0, 0.0]]] {
        let set = triangulation(&points);
        assert!(run(&set, "").graph.edges().is_empty());
        assert!(run(&set, "vertices=2").graph.edges().is_empty());
    }
    let line: Vec<PlaceMm> =
        (0..50).map(|index| [f64::from(index), 2.0 * f64::from(index)]).collect();
    let set = triangulation(&line);
    // The whole line is one edge, and its ends stay within half a spacing.
    let found = run(&set, "vertices=2");
    let ends = only_chain(&set, &found, false);
    assert_eq!(ends.len(), 2);
    assert!(distance(ends[0], line[0]).min(distance(ends[0], line[49])) < 1.2, "{ends:?}");
    let raster: Vec<PlaceMm> =
        (0..100).map(|at| [f64::from(at % 10), f64::from(at / 10)]).collect();
    let twice = [raster.clone(), raster.clone()].concat();
    let [once, twice] = [raster, twice].map(|points| run(&triangulation(&points), "vertices=20"));
    assert_eq!(once, twice, "repeated points count once");
}

#[test]
fn wrong_parameters_are_refused() {
    let set = triangulation(&crate::places::circle(20));
    let refused = |text: &str| {
        let parameters = Parameters::parse(text).unwrap();
        Method::OptimalTransport.run(&set, &parameters).unwrap_err().to_string()
    };
    assert_eq!(
        refused("vertices=-1"),
        "optimal-transport: expected vertices from 0 to 100000000, found -1"
    );
    assert_eq!(
        refused("tolerance=1"),
        "optimal-transport has no parameter `tolerance`: expected vertices, tolerance_mm, relevance"
    );
}

/// Found by a fuzzer: beside a point 3 km away these lie in one place, and rounding says nothing of the triangles between them.
#[test]
fn places_that_rounding_makes_one_end() {
    let points = [
        [3.0, 5.0],
        [0.0, -1.0],
        [5.0, 5.0],
        [-7.0, 1.0],
        [1.0, 1.0],
        [-3.1957145e-10, -3.1957145e-10],
        [6.3023e-41, -1.7256332e-29],
        [-1.9973216e-11, -3.1957145e-10],
        [-3.1957145e-10, 3156.3552],
        [0.0, 7.0],
        [-1.0, 0.0],
        [7.28359e-39, 472_883_700.0],
        [7.0, 7.0],
        [5.0, 7.0],
        [5.0, -2.0],
    ];
    let set = triangulation(&points);
    for parameters in ["", "vertices=2", "vertices=5", "tolerance_mm=63"] {
        let found = run(&set, parameters);
        assert!(found.places_mm.unwrap().as_flattened().iter().all(|value| value.is_finite()));
    }
}

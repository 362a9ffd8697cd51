//! Hiyoshi's 2-factor against all others, and where it is proven.

use asphera_contour::curves::{MOST_FOR_MATCHING, connect2d, hiyoshi};
use asphera_contour::{Graph, Method, MethodError, Parameters, SampleId, Triangulation};

use crate::places::{Random, by_row, circle, closed, distance, lattice, scattered, triangulation};
use crate::smooth::{Condition, Curve};

fn length(graph: &Graph, set: &Triangulation) -> f64 {
    graph.edges().iter().map(|&[p, q]| distance(set.place(p), set.place(q))).sum()
}

/// Least length of Delaunay edges that give every sample two, by search; infinite if there are none.
fn least(set: &Triangulation) -> f64 {
    fn search(set: &Triangulation, degrees: &mut [u8], best: &mut f64, sum: f64, edge: usize) {
        if sum >= *best {
            return;
        }
        let Some(sample) = degrees.iter().position(|&degree| degree < 2) else {
            *best = sum;
            return;
        };
        // Edges are sorted by their smaller end: later ones do not reach this sample from above.
        for next in edge..set.edges().len() {
            let [p, q] = set.edges()[next].ends.map(|end| end as usize);
            if p > sample {
                return;
            }
            if degrees[p] < 2 && degrees[q] < 2 {
                degrees[p] += 1;
                degrees[q] += 1;
                let more = distance(set.place(p as SampleId), set.place(q as SampleId));
                search(set, degrees, best, sum + more, next + 1);
                degrees[p] -= 1;
                degrees[q] -= 1;
            }
        }
    }
    let mut best = f64::INFINITY;
    search(set, &mut vec![0; set.len()], &mut best, 0.0, 0);
    best
}

#[test]
fn no_other_two_factor_is_shorter() {
    let (mut compared, mut several) = (0, 0);
    for seed in 0..150 {
        let count = 6 + (seed as usize % 12);
        for points in [scattered(count, seed + 1300), lattice(count, seed + 1300)] {
            let set = triangulation(&points);
            let graph = hiyoshi(&set).unwrap();
            let expected = least(&set);
            if expected.is_finite() {
                let degrees = graph.degrees(set.len());
                assert!(degrees.iter().all(|&degree| degree == 2), "seed {seed}: {degrees:?}");
                let found = length(&graph, &set);
                assert!((found - expected).abs() < 1e-9, "seed {seed}: {found}, {expected}");
                compared += 1;
                several += usize::from(graph.chains(set.len()).len() > 1);
            }
        }
    }
    println!("{compared} sets compared, {several} of them in several curves");
    assert!(compared > 250 && several > 50);
}

#[test]
fn no_tour_is_shorter() {
    for seed in 0..4 {
        let set = triangulation(&scattered(300, seed + 50));
        let graph = hiyoshi(&set).unwrap();
        assert!(graph.degrees(set.len()).iter().all(|&degree| degree == 2));
        let tour = connect2d(&set);
        if tour.alone(set.len()).is_empty() {
            assert!(length(&graph, &set) <= length(&tour, &set));
        }
    }
}

#[test]
fn even_samples_of_smooth_curves_are_joined_rightly() {
    let mut random = Random::new(31);
    let (mut tried, mut wrong) = (0, 0);
    while tried < 30 {
        let curve = Curve::random(&mut random, 2000);
        let Some(points) = curve.samples(Condition::Epsilon(0.3), &mut random) else { continue };
        let edges: Vec<f64> = (0..points.len())
            .map(|row| distance(points[row], points[(row + 1) % points.len()]))
            .collect();
        let ratio = |row: usize| {
            let [here, next] = [edges[row], edges[(row + 1) % edges.len()]];
            (here / next).max(next / here)
        };
        if (0..edges.len()).any(|row| ratio(row) >= 1.46) {
            // Uneven samples are not what is proven: places evenly apart along the parameter are.
            let even: Vec<_> =
                curve.places.iter().step_by(2000 / (6 * points.len())).copied().collect();
            let set = triangulation(&even);
            wrong += usize::from(by_row(&hiyoshi(&set).unwrap(), &set) != closed(even.len()));
        } else {
            let set = triangulation(&points);
            wrong += usize::from(by_row(&hiyoshi(&set).unwrap(), &set) != closed(points.len()));
        }
        tried += 1;
    }
    assert_eq!(wrong, 0);
}

#[test]
fn parts_are_solved_for_themselves_and_one_too_large_is_refused() {
    let mut points = circle(MOST_FOR_MATCHING / 2);
    for step in 1..4 {
        let shift = 20.0 * f64::from(step);
        points.extend(circle(MOST_FOR_MATCHING / 2 - 1).into_iter().map(|[x, y]| [x + shift, y]));
    }
    let set = triangulation(&points);
    let graph = hiyoshi(&set).unwrap();
    let chains = graph.chains(set.len());
    assert!(chains.len() == 4 && chains.iter().all(|chain| chain.closed));
    let set = triangulation(&circle(MOST_FOR_MATCHING + 1));
    let refused = Method::Hiyoshi.run(&set, &Parameters::new()).unwrap_err();
    let most = MOST_FOR_MATCHING;
    assert_eq!(refused, MethodError::TooMany { method: "hiyoshi", most, found: 2001 });
    assert!(refused.to_string().contains("expected at most 2000 places, found 2001"), "{refused}");
}

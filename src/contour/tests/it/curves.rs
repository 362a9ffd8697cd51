//! Curves against their definitions, and on shapes whose curve is known.

use asphera_contour::curves::{
    connect2d, conservative_crust, crawl, crust, discur, emst_curve, gathan, hnn_crust, lenz,
    nn_crust, one_sided_hnn_crust, one_step_crust, peel, regular_shape, sig_connect2d, vicur,
    voronoi_labelling,
};
use asphera_contour::graphs::{delaunay, gabriel};
use asphera_contour::{Graph, Kind, Method, Parameters, PlaceMm, SampleId, Triangulation};

use crate::places::{by_row, circle, closed, distance, lattice, scattered, thins, triangulation};

/// All methods that join every sample of a circle.
fn curves() -> impl Iterator<Item = Method> {
    let joins_all = |method: &Method| method.kind() == Kind::Curve && !thins(method);
    Method::ALL.into_iter().filter(joins_all)
}

fn run(method: Method, set: &Triangulation) -> Graph {
    method.run(set, &Parameters::new()).unwrap()
}

#[test]
fn every_method_finds_a_circle() {
    for count in [12, 40, 333] {
        let set = triangulation(&circle(count));
        for method in curves() {
            assert_eq!(
                by_row(&run(method, &set), &set),
                closed(count),
                "{} {count}",
                method.name()
            );
        }
    }
}

#[test]
fn crusts_lie_in_each_other() {
    for seed in 0..20 {
        for points in [scattered(60, seed), lattice(50, seed), scattered(900, seed)] {
            let set = triangulation(&points);
            let one_step = one_step_crust(&set).crust;
            assert!(one_step.is_part_of(&gabriel(&set)));
            assert!(conservative_crust(&set, 1.0).is_part_of(&gabriel(&set)));
            assert!(hnn_crust(set.samples()).is_part_of(&one_sided_hnn_crust(set.samples())));
            assert!(peel(&set, 0.0).is_part_of(&delaunay(&set)));
        }
        // Rounded Voronoi vertices may fall on either side where four samples lie on a circle: not on lattices.
        let set = triangulation(&scattered(300, seed));
        assert!(crust(&set).is_part_of(&one_step_crust(&set).crust));
    }
}

#[test]
fn the_nearest_neighbour_crusts_agree_with_all_pairs() {
    for seed in 0..20 {
        let set = triangulation(&scattered(60, seed));
        let at = set.samples().places();
        let count = at.len();
        let by_distance = |p: usize| {
            let mut others: Vec<usize> = (0..count).filter(|&q| q != p).collect();
            others.sort_by(|&a, &b| distance(at[p], at[a]).total_cmp(&distance(at[p], at[b])));
            others
        };
        let mut chosen: Vec<Vec<usize>> = Vec::new();
        let mut nearest = Vec::new();
        for p in 0..count {
            let others = by_distance(p);
            let found: Vec<SampleId> = set.nearby(p as SampleId).collect();
            assert_eq!(found, others.iter().map(|&q| q as SampleId).collect::<Vec<_>>());
            let q = others[0];
            let is_next = |&&s: &&usize| {
                distance(at[q], at[s]) > distance(at[p], at[q])
                    && distance(at[q], at[s]) > distance(at[p], at[s])
            };
            let second = others[1..].iter().find(is_next).copied();
            chosen.push([Some(q), second].into_iter().flatten().collect());
            let behind = others.iter().copied().find(|&s| {
                let dot = (at[q][0] - at[p][0]) * (at[s][0] - at[p][0])
                    + (at[q][1] - at[p][1]) * (at[s][1] - at[p][1]);
                dot < 0.0 && set.edge_between(p as SampleId, s as SampleId).is_some()
            });
            nearest.extend(
                [Some(q), behind].into_iter().flatten().map(|s| [p, s].map(|end| end as SampleId)),
            );
        }
        assert_eq!(nn_crust(&set), Graph::new(nearest));
        let edge = |p: usize, q: usize| [p as SampleId, q as SampleId];
        let all = (0..count).flat_map(|p| chosen[p].iter().map(move |&q| (p, q)));
        assert_eq!(
            one_sided_hnn_crust(set.samples()),
            Graph::new(all.clone().map(|(p, q)| edge(p, q)))
        );
        let both = all.filter(|&(p, q)| chosen[q].contains(&p)).map(|(p, q)| edge(p, q));
        assert_eq!(hnn_crust(set.samples()), Graph::new(both));
    }
}

#[test]
fn the_crust_agrees_with_its_definition() {
    // An edge is one if the interval of empty discs through its ends, by their centres along the bisector, leaves room
    // beside every sample and every Voronoi vertex.
    for seed in 0..10 {
        let set = triangulation(&scattered(40, seed + 100));
        let at = set.samples().places();
        let all: Vec<PlaceMm> = at.iter().chain(set.centres_mm()).copied().collect();
        let is_edge = |p: usize, q: usize| {
            let [mx, my] = [0.5 * (at[p][0] + at[q][0]), 0.5 * (at[p][1] + at[q][1])];
            let half = 0.5 * distance(at[p], at[q]);
            let [nx, ny] =
                [(at[p][1] - at[q][1]) / (2.0 * half), (at[q][0] - at[p][0]) / (2.0 * half)];
            let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
            for x in all.iter().filter(|&&x| x != at[p] && x != at[q]) {
                // |x - m - t·n|² ≥ half² + t²: a bound of t that x sets.
                let [dx, dy] = [x[0] - mx, x[1] - my];
                let (off, rest) = (dx * nx + dy * ny, dx * dx + dy * dy - half * half);
                if off > 0.0 {
                    high = high.min(rest / (2.0 * off));
                } else {
                    low = low.max(rest / (2.0 * off));
                }
            }
            low < high
        };
        let pairs = (0..at.len()).flat_map(|p| (p + 1..at.len()).map(move |q| [p, q]));
        let expected =
            pairs.filter(|&[p, q]| is_edge(p, q)).map(|pair| pair.map(|end| end as SampleId));
        assert_eq!(crust(&set), Graph::new(expected));
    }
}

#[test]
fn the_one_step_crust_is_a_sum_of_angles_and_its_skeleton_the_middle_of_a_strip() {
    for seed in 0..10 {
        let set = triangulation(&scattered(60, seed + 50));
        let angle = |apex: SampleId, ends: [SampleId; 2]| {
            let [x, p, q] =
                [apex, ends[0], ends[1]].map(|sample| set.samples().places()[sample as usize]);
            let ways = [[p[0] - x[0], p[1] - x[1]], [q[0] - x[0], q[1] - x[1]]];
            let [a, b] = ways;
            (a[0] * b[1] - a[1] * b[0]).abs().atan2(a[0] * b[0] + a[1] * b[1])
        };
        let is_crust = |&[p, q]: &[SampleId; 2]| {
            let edge = set.edge_between(p, q).unwrap();
            let sum: f64 =
                set.opposite(edge).into_iter().flatten().map(|apex| angle(apex, [p, q])).sum();
            sum <= std::f64::consts::FRAC_PI_2
        };
        let expected = delaunay(&set).edges().iter().copied().filter(is_crust).collect::<Vec<_>>();
        assert_eq!(one_step_crust(&set).crust, Graph::new(expected));
    }
    // Two lines 2 mm apart, sampled every 0.3 mm: between them the skeleton runs along y = 1.
    let lines =
        (0..60).flat_map(|index| [[0.3 * f64::from(index), 0.0], [0.3 * f64::from(index), 2.0]]);
    let skeleton = one_step_crust(&triangulation(&lines.collect::<Vec<_>>())).skeleton_mm;
    let within = skeleton.as_flattened().iter().filter(|[_, y]| (0.0..=2.0).contains(y));
    assert!(within.clone().count() > 50 && within.clone().all(|[_, y]| (y - 1.0).abs() < 1e-9));
}

#[test]
fn connect2d_is_one_closed_curve_through_the_samples() {
    let mut alone = 0;
    for seed in 0..60 {
        let points = if seed % 2 == 0 { scattered(200, seed) } else { lattice(50, seed) };
        let set = triangulation(&points);
        let graph = connect2d(&set);
        let degrees = graph.degrees(set.len());
        assert!(degrees.iter().all(|&degree| degree == 0 || degree == 2), "seed {seed}");
        let chains = graph.chains(set.len());
        assert!(chains.len() == 1 && chains[0].closed, "seed {seed}: {} chains", chains.len());
        let here = graph.alone(set.len()).len();
        assert!(seed % 2 == 0 || here == 0, "seed {seed}");
        alone += here;
    }
    println!("{alone} of 6000 scattered samples lie off the curve");
    assert!(alone <= 30, "{alone}");
}

#[test]
fn sig_connect2d_tells_a_ring_from_a_disc() {
    let mut points = circle(120);
    points.extend(circle(60).into_iter().map(|place| place.map(|value| 0.5 * value)));
    points.extend(circle(30).into_iter().map(|[x, y]| [x + 20.0, y]));
    let set = triangulation(&points);
    for graph in [
        sig_connect2d(&set),
        crust(&set),
        hnn_crust(set.samples()),
        nn_crust(&set),
        peel(&set, 0.0),
        crawl(&set),
    ] {
        let chains = graph.chains(set.len());
        let mut sizes: Vec<(usize, bool)> =
            chains.iter().map(|chain| (chain.samples.len(), chain.closed)).collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [(30, true), (60, true), (120, true)]);
    }
}

/// The graph joins every second sample of a bent curve, too; a sample is missing.
#[test]
fn sig_connect2d_follows_a_wavy_curve_and_closes_its_gap() {
    let fine: Vec<PlaceMm> = (0..20_000)
        .map(|step| {
            let angle = f64::from(step) * std::f64::consts::TAU / 20_000.0;
            let radius = 10.0 + 2.0 * (5.0 * angle).cos();
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let mut points = vec![fine[0]];
    for &place in &fine {
        if distance(place, points[points.len() - 1]) >= 0.4 {
            points.push(place);
        }
    }
    points.pop();
    points.remove(40);
    let set = triangulation(&points);
    assert_eq!(by_row(&sig_connect2d(&set), &set), closed(points.len()));
}

#[test]
fn open_curves_stay_open_and_outliers_alone() {
    let arc: Vec<PlaceMm> = circle(360)[..60].to_vec();
    let expected: Vec<[u32; 2]> = (0..59).map(|row| [row, row + 1]).collect();
    let mut with_outlier = arc.clone();
    with_outlier.push([40.0, 3.0]);
    let set = triangulation(&arc);
    for graph in
        [crust(&set), hnn_crust(set.samples()), nn_crust(&set), conservative_crust(&set, 1.0)]
    {
        assert_eq!(by_row(&graph, &set), expected);
        assert_eq!((graph.ends(60).len(), graph.junctions(60).len()), (2, 0));
        assert_eq!(graph.chains(60).len(), 1);
    }
    let set = triangulation(&with_outlier);
    for graph in [conservative_crust(&set, 1.0), hnn_crust(set.samples())] {
        assert_eq!(by_row(&graph, &set), expected);
        assert_eq!(graph.alone(61), [set.samples().of_row(60)]);
    }
}

#[test]
fn peel_restores_a_junction() {
    // A line, and one that ends 1.2 mm above its middle.
    let line = (-7..8).map(|step| [f64::from(step), 0.0]);
    let stem = (0..8).map(|step| [0.0, 1.2 + f64::from(step)]);
    let set = triangulation(&line.chain(stem).collect::<Vec<_>>());
    let [plain, restored] = [0.0, 2.0].map(|delta| by_row(&peel(&set, delta), &set));
    let path = |from: u32, to: u32| (from..to).map(|row| [row, row + 1]);
    let mut expected: Vec<[u32; 2]> = path(0, 14).chain(path(15, 22)).collect();
    assert_eq!(plain, expected);
    // Row 7 is the middle of the line, row 15 the end of the stem.
    expected.push([7, 15]);
    expected.sort_unstable();
    assert_eq!(restored, expected);
}

#[test]
fn open_curves_are_found_by_what_grows_them() {
    // A spiral, whose spacing grows along it.
    let spiral: Vec<PlaceMm> = (0..80)
        .map(|step| {
            let angle = 0.08 * f64::from(step);
            let radius = 2.0 * (0.12 * angle).exp();
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let path: Vec<[u32; 2]> = (0..79).map(|row| [row, row + 1]).collect();
    let set = triangulation(&spiral);
    for method in ["discur", "vicur", "emst-curve", "nn-crust", "hnn-crust", "lenz", "crust"] {
        let found = by_row(&run(Method::from_name(method).unwrap(), &set), &set);
        let missing = path.iter().filter(|edge| !found.contains(edge)).count();
        assert_eq!(missing, 0, "{method}: {found:?}");
    }
    for graph in [discur(&set), vicur(&set, 0.7), emst_curve(&set)] {
        assert!(graph.degrees(80).into_iter().all(|degree| degree <= 2));
    }
    assert_eq!(by_row(&emst_curve(&set), &set), path);
}

#[test]
fn corners_of_a_square_and_a_star_are_kept_by_gathan() {
    // A star of five points, its sides sampled evenly with a sample in every corner.
    let corners: Vec<PlaceMm> = (0..10)
        .map(|index| {
            let (sin, cos) = (f64::from(index) * std::f64::consts::PI / 5.0).sin_cos();
            let radius = if index % 2 == 0 { 10.0 } else { 5.0 };
            [radius * cos, radius * sin]
        })
        .collect();
    let square = vec![[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    for (corners, least) in [(square, 1.0), (corners, 0.9)] {
        let mut points = Vec::new();
        for (index, from) in corners.iter().enumerate() {
            let to = corners[(index + 1) % corners.len()];
            points.extend((0..20).map(|step| {
                let share = f64::from(step) / 20.0;
                [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
            }));
        }
        let set = triangulation(&points);
        let expected = closed(points.len());
        let share = |graph: &Graph| {
            let found = by_row(graph, &set);
            expected.iter().filter(|edge| found.contains(edge)).count() as f64
                / expected.len() as f64
        };
        let found = gathan(&set, 35.0, 0.5);
        assert!(found.degrees(set.len()).into_iter().all(|degree| degree <= 2));
        println!("gathan {:.3}, nn-crust {:.3}", share(&found), share(&nn_crust(&set)));
        assert!(share(&found) >= least, "{}", share(&found));
    }
}

#[test]
fn lenz_goes_through_a_crossing() {
    // Two lines that cross in a sample they share.
    let arms = (-8..9).flat_map(|step| {
        let along = f64::from(step);
        if step == 0 { vec![[0.0, 0.0]] } else { vec![[along, 0.1 * along], [-0.1 * along, along]] }
    });
    let points: Vec<PlaceMm> = arms.collect();
    let set = triangulation(&points);
    let graph = lenz(&set, 2.5, 45.0);
    let middle = points.iter().position(|&place| place == [0.0, 0.0]).unwrap();
    let degrees = graph.degrees(set.len());
    assert_eq!(degrees[set.samples().of_row(middle) as usize], 4);
    assert_eq!(graph.edges().len(), 32);
    assert_eq!(graph.ends(set.len()).len(), 4);
}

#[test]
fn regular_shapes_follow_the_sum_of_angles() {
    for seed in 0..10 {
        let set = triangulation(&scattered(80, seed + 300));
        let [small, half, large] =
            [1.0, std::f64::consts::FRAC_PI_2, 2.5].map(|delta| regular_shape(&set, delta));
        assert!(small.is_part_of(&half) && half.is_part_of(&large));
        // But for ties the default is the one-step crust.
        assert_eq!(half, one_step_crust(&set).crust);
    }
}

/// Bays that open outwards are found, a bay with a narrow mouth is not: nothing outside the hull leads there.
#[test]
fn voronoi_labels_spread_into_open_bays() {
    for lobes in [2.0, 3.0, 7.0] {
        let count = 600;
        let points: Vec<PlaceMm> = (0..count)
            .map(|at| {
                let turn = f64::from(at) / f64::from(count) * std::f64::consts::TAU;
                let radius = 10.0 + 1.7 * (lobes * turn).cos();
                [radius * turn.cos() + 0.013 * turn, radius * turn.sin()]
            })
            .collect();
        let set = triangulation(&points);
        assert_eq!(by_row(&voronoi_labelling(&set), &set), closed(count as usize), "{lobes}");
    }
    // Two samples near to each other within a ring: no vertex beyond the hull sees them.
    let mut ring = circle(60);
    let outside = by_row(&voronoi_labelling(&triangulation(&ring)), &triangulation(&ring));
    ring.extend([[0.1, 0.2], [0.15, 0.17]]);
    let set = triangulation(&ring);
    assert_eq!(by_row(&voronoi_labelling(&set), &set), outside);
    // On one line the samples that follow each other are joined.
    let line = triangulation(&[[0.0, 0.0], [1.0, 1.0], [3.0, 3.0]]);
    assert_eq!(by_row(&voronoi_labelling(&line), &line), [[0, 1], [1, 2]]);
}

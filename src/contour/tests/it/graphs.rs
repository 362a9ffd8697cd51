//! Proximity graphs against their definitions over all pairs, and against each other.

use asphera_contour::graphs::{
    MOST_FOR_PAIRS, bc0, beta_skeleton, delaunay, emst, gabriel, gamma_neighbourhood,
    lune_beta_skeleton, rng, sig, sigdt,
};
use asphera_contour::{Graph, SampleId, Triangulation};

use crate::places::{circle, distance, lattice, scattered, triangulation};

/// Whole coordinates, so that squares are exact in i64.
fn whole(of: &Triangulation) -> Vec<[i64; 2]> {
    of.samples()
        .places()
        .iter()
        .map(|place| place.map(|value| (value * 1e6).round() as i64))
        .collect()
}

fn square(p: [i64; 2], q: [i64; 2]) -> i64 {
    (p[0] - q[0]).pow(2) + (p[1] - q[1]).pow(2)
}

/// Sets of at most 60 points: scattered on a fine raster, and lattices.
fn sets() -> Vec<Triangulation> {
    let fine = |seed| {
        let points = scattered(60, seed).into_iter();
        points.map(|place| place.map(|value| (value * 1e6).round() / 1e6)).collect::<Vec<_>>()
    };
    let mut sets: Vec<Triangulation> = (0..12).map(|seed| triangulation(&fine(seed))).collect();
    sets.extend((0..12).map(|seed| triangulation(&lattice(50, seed))));
    sets.extend([2, 3, 5].map(|count| triangulation(&fine(90)[..count])));
    sets
}

/// All pairs for which a test is true.
fn pairs(of: &Triangulation, is_edge: impl Fn(usize, usize) -> bool) -> Graph {
    let count = of.len();
    let all = (0..count).flat_map(|p| (p + 1..count).map(move |q| [p, q]));
    Graph::new(all.filter(|&[p, q]| is_edge(p, q)).map(|pair| pair.map(|end| end as SampleId)))
}

#[test]
fn the_nearest_wanted_is_the_first_of_all_by_distance() {
    for set in sets() {
        for sample in 0..set.len() as SampleId {
            for modulus in 1..=3 {
                // Neighbours of a lattice tie, and those wanted may lie behind others.
                let is_wanted = |other: SampleId| (7 * other + sample).is_multiple_of(modulus);
                let first = set.nearby(sample).find(|&other| is_wanted(other));
                let has_one = set.spokes(sample).iter().any(|spoke| is_wanted(spoke.to));
                assert_eq!(set.nearest_of(sample, is_wanted), first.filter(|_| has_one));
            }
        }
    }
}

#[test]
fn each_agrees_with_its_definition_over_all_pairs() {
    for set in sets() {
        let at = whole(&set);
        let others = |p: usize, q: usize| (0..at.len()).filter(move |&x| x != p && x != q);
        let relative = pairs(&set, |p, q| {
            let length = square(at[p], at[q]);
            others(p, q).all(|x| square(at[p], at[x]).max(square(at[q], at[x])) >= length)
        });
        assert_eq!(rng(&set), relative);
        let discs = pairs(&set, |p, q| {
            let length = square(at[p], at[q]);
            others(p, q).all(|x| square(at[p], at[x]) + square(at[q], at[x]) >= length)
        });
        let ours = gabriel(&set);
        assert!(ours.is_part_of(&discs));
        // Of a diagonal with samples on its circle the triangulation holds one of two at most.
        let strict = pairs(&set, |p, q| {
            let length = square(at[p], at[q]);
            others(p, q).all(|x| square(at[p], at[x]) + square(at[q], at[x]) > length)
        });
        assert!(strict.is_part_of(&ours));
        let radius = |p: usize| {
            let squares = (0..at.len()).filter(|&x| x != p).map(|x| square(at[p], at[x]));
            squares.min().map_or(0.0, |square| (square as f64).sqrt())
        };
        let spheres = pairs(&set, |p, q| {
            let length = (square(at[p], at[q]) as f64).sqrt();
            length <= (radius(p) + radius(q)) * (1.0 + 1e-14)
        });
        assert_eq!(sig(&set), spheres);
        let in_mesh =
            spheres.edges().iter().copied().filter(|&[p, q]| set.edge_between(p, q).is_some());
        assert_eq!(sigdt(&set), Graph::new(in_mesh));
    }
}

#[test]
fn the_spanning_tree_is_as_short_as_prims() {
    for set in sets() {
        let at = set.samples().places();
        let mut nearest: Vec<f64> = at.iter().map(|&q| distance(at[0], q)).collect();
        let mut reached = vec![false; at.len()];
        let mut expected = 0.0;
        for _ in 0..at.len() {
            let open = (0..at.len()).filter(|&p| !reached[p]);
            let next = open.min_by(|&p, &q| nearest[p].total_cmp(&nearest[q])).unwrap();
            expected += nearest[next];
            reached[next] = true;
            for (other, &place) in at.iter().enumerate() {
                nearest[other] = nearest[other].min(distance(at[next], place));
            }
        }
        let tree = emst(&set);
        assert_eq!(tree.edges().len(), at.len() - 1);
        let length: f64 =
            tree.edges().iter().map(|&[p, q]| distance(at[p as usize], at[q as usize])).sum();
        assert!((length - expected).abs() < 1e-9, "{length} {expected}");
    }
}

#[test]
fn each_lies_in_the_next() {
    let many = [triangulation(&scattered(3000, 5)), triangulation(&lattice(400, 5))];
    for set in sets().into_iter().chain(many) {
        let nearest = Graph::new(
            (0..set.len() as SampleId).filter_map(|sample| Some([sample, set.nearest(sample)?.to])),
        );
        let [tree, relative, discs, mesh] = [emst(&set), rng(&set), gabriel(&set), delaunay(&set)];
        let inclusions =
            [(&nearest, &tree), (&tree, &relative), (&relative, &discs), (&discs, &mesh)];
        for (small, large) in inclusions {
            assert!(small.is_part_of(large));
        }
        assert!(nearest.is_part_of(&sig(&set)) && tree.is_part_of(&bc0(&set)));
        assert!(sig(&set).edges().len() <= 15 * set.len());
        if !set.triangles().is_empty() {
            assert!(bc0(&set).degrees(set.len()).into_iter().all(|degree| degree >= 2));
        }
    }
}

#[test]
fn gamma_and_beta_are_what_they_unite() {
    for set in sets() {
        let gamma = |gammas| gamma_neighbourhood(&set, gammas).unwrap();
        assert_eq!(gamma([0.0, 0.0]), gabriel(&set));
        for beta in [0.5, 0.9, 1.0, 1.3, 2.0, 4.0] {
            let value = if beta >= 1.0 { 1.0 - 1.0 / beta } else { beta - 1.0 };
            assert_eq!(beta_skeleton(&set, beta).unwrap(), gamma([value, value]));
        }
        let hull = (0..).zip(set.edges()).filter(|(_, edge)| edge.triangles().contains(&None));
        assert_eq!(gamma([1.0, -1.0]), Graph::new(hull.map(|(_, edge)| edge.ends)));
        assert_eq!(lune_beta_skeleton(&set, 1.0), gabriel(&set));
        assert_eq!(lune_beta_skeleton(&set, 2.0), rng(&set));
        let [wide, narrow] = [1.4, 1.8].map(|beta| lune_beta_skeleton(&set, beta));
        assert!(narrow.is_part_of(&wide) && rng(&set).is_part_of(&narrow));
    }
}

#[test]
fn one_disc_of_gamma_gives_the_edges_of_an_alpha_shape() {
    // Scattered points alone: on lattices the circles pass through many.
    for seed in 0..6 {
        let set = triangulation(&scattered(50, seed));
        let at = set.samples().places();
        let share: f64 = 0.4;
        let graph = gamma_neighbourhood(&set, [share, -share]).unwrap();
        let expected = pairs(&set, |p, q| {
            let length = distance(at[p], at[q]);
            let radius = length / (2.0 * (1.0 - share));
            let off = (radius * radius - length * length / 4.0).sqrt();
            let [nx, ny] = [(at[p][1] - at[q][1]) / length, (at[q][0] - at[p][0]) / length];
            [off, -off].into_iter().any(|off| {
                let centre = [
                    0.5 * (at[p][0] + at[q][0]) + off * nx,
                    0.5 * (at[p][1] + at[q][1]) + off * ny,
                ];
                (0..at.len())
                    .filter(|&x| x != p && x != q)
                    .all(|x| distance(at[x], centre) >= radius)
            })
        });
        assert_eq!(graph, expected);
    }
}

#[test]
fn the_lune_of_any_beta_is_that_of_its_definition() {
    for seed in 0..6 {
        let set = triangulation(&scattered(50, seed + 40));
        let at = set.samples().places();
        for beta in [1.2, 1.7, 3.0] {
            let expected = pairs(&set, |p, q| {
                let towards = |p: [f64; 2], q: [f64; 2]| {
                    [p[0] + 0.5 * beta * (q[0] - p[0]), p[1] + 0.5 * beta * (q[1] - p[1])]
                };
                let radius = 0.5 * beta * distance(at[p], at[q]);
                let centres = [towards(at[p], at[q]), towards(at[q], at[p])];
                (0..at.len())
                    .filter(|&x| x != p && x != q)
                    .all(|x| centres.iter().any(|&centre| distance(at[x], centre) >= radius))
            });
            assert_eq!(lune_beta_skeleton(&set, beta), expected);
        }
    }
}

#[test]
fn pairs_are_not_asked_about_without_bound() {
    let set = triangulation(&circle(MOST_FOR_PAIRS + 1));
    assert!(beta_skeleton(&set, 0.9).is_none() && beta_skeleton(&set, 1.1).is_some());
}

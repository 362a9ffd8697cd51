//! The graph method against its definition, by looks at all pairs, and on bodies that are known.

use std::collections::{BTreeMap, BTreeSet};

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    FaceRule, GraphChoices, GraphError, GraphSurface, LandmarkOrder, LeftOut, NoSurface,
    PointGraph, prove,
};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64;

use crate::shapes::{ball, torus, uniform};

pub(crate) fn surface(points: &[PointMm], choices: &GraphChoices) -> GraphSurface {
    let graph = PointGraph::new(points, 15, &mut |_| {}).unwrap();
    graph.surface(choices, &mut |_| {}).unwrap()
}

/// Hops between all points of the graph of the 15 nearest, by Floyd and Warshall; ties of distances do not occur.
fn all_hops(points: &[PointMm]) -> Vec<Vec<u32>> {
    let len = points.len();
    let square = |p: usize, q: usize| -> f64 {
        (0..3).map(|axis| (points[p][axis] - points[q][axis]).powi(2)).sum()
    };
    let mut near = vec![];
    for p in 0..len {
        let mut others: Vec<usize> = (0..len).filter(|&q| q != p).collect();
        others.sort_by(|&q, &r| square(p, q).total_cmp(&square(p, r)));
        near.extend(others[..15].iter().map(|&q| [p, q]));
    }
    let mut hops = vec![vec![u32::MAX / 2; len]; len];
    for [p, q] in near {
        (hops[p][q], hops[q][p], hops[p][p]) = (1, 1, 0);
    }
    for via in 0..len {
        for p in 0..len {
            for q in 0..len {
                hops[p][q] = hops[p][q].min(hops[p][via] + hops[via][q]);
            }
        }
    }
    hops
}

#[test]
fn landmarks_cells_and_contacts_are_those_of_the_definition() {
    for (seed, apart, order) in [
        (1, 3, LandmarkOrder::Sweep),
        (2, 2, LandmarkOrder::Priority),
        (3, 4, LandmarkOrder::Sweep),
    ] {
        let points = ball(300, 0.3, seed);
        let hops = all_hops(&points);
        let made = surface(
            &points,
            &GraphChoices { hops: apart, threshold: 3, order, faces: FaceRule::Any },
        )
        .map;
        let landmarks: Vec<usize> = made.landmarks.iter().map(|&point| point as usize).collect();
        for (rank, &one) in landmarks.iter().enumerate() {
            assert!(landmarks[..rank].iter().all(|&other| hops[one][other] >= u32::from(apart)));
        }
        let mut touching: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let owner = |p: usize| made.cells[p].unwrap().landmark;
        for (p, from) in hops.iter().enumerate() {
            // The first of the nearest, as `min_by_key` takes; none is farther than another could be.
            let nearest = *landmarks.iter().min_by_key(|&&landmark| from[landmark]).unwrap();
            assert_eq!(owner(p) as usize, nearest);
            assert_eq!(u32::from(made.cells[p].unwrap().hops), from[nearest]);
            assert!(from[nearest] < u32::from(apart), "the set is maximal");
            let others: BTreeSet<u32> =
                (0..points.len()).filter(|&q| from[q] == 1).map(owner).collect();
            for other in others.into_iter().filter(|&other| other != owner(p)) {
                *touching.entry([owner(p).min(other), owner(p).max(other)]).or_default() += 1;
            }
        }
        let found: BTreeMap<[u32; 2], u32> = made
            .contacts
            .iter()
            .map(|contact| {
                let [a, b] = contact.landmarks;
                ([a.min(b), a.max(b)], contact.points)
            })
            .collect();
        assert_eq!(found, touching);
        assert_eq!(made.edges, touching.values().filter(|&&points| points > 3).count());
        assert_faces(&made.faces, &touching, 3);
    }
}

/// Faces are cycles of the map's edges without a vertex twice, and no edge is in more than two.
fn assert_faces(faces: &[Vec<u32>], contacts: &BTreeMap<[u32; 2], u32>, threshold: u32) {
    let mut uses: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for face in faces {
        assert_eq!(face.iter().collect::<BTreeSet<_>>().len(), face.len());
        for (at, &one) in face.iter().enumerate() {
            let other = face[(at + 1) % face.len()];
            let edge = [one.min(other), one.max(other)];
            assert!(contacts[&edge] > threshold);
            *uses.entry(edge).or_default() += 1;
        }
    }
    assert!(!faces.is_empty() && uses.values().all(|&count| count <= 2));
    assert!(faces.windows(2).all(|pair| pair[0].len() <= pair[1].len()));
}

fn assert_closed(points: &[PointMm], choices: &GraphChoices, genus: i64) {
    let made = surface(points, choices);
    let facets = &made.reconstruction.facets;
    let proof = prove(points, facets).unwrap();
    assert_eq!((proof.is_closed, proof.genus, proof.components), (true, Some(genus), 1));
    assert!((made.map.genus() - genus as f64).abs() < 1e-9);
    assert!(proof.is_oriented && proof.volume_mm3.unwrap() > 0.0);
    assert_eq!(proof.vertices + made.reconstruction.left_out.len(), points.len());
}

/// Some choices of the graph method, and neighbours of a point.
pub(crate) fn any_choices(random: &mut Pcg64, order: LandmarkOrder) -> (GraphChoices, usize) {
    let choices = GraphChoices {
        hops: one_of(random, &[1, 2, 3, 4, 5, 9]) as u8,
        threshold: one_of(random, &[0, 2, 7]),
        order,
        faces: if one_of(random, &[0, 1]) == 0 { FaceRule::Filled } else { FaceRule::Any },
    };
    (choices, one_of(random, &[1, 4, 8, 15, 15, 40]) as usize)
}

pub(crate) fn one_of(random: &mut Pcg64, choices: &[u32]) -> u32 {
    choices[random.next_u64() as usize % choices.len()]
}

/// Points of a torus at random, of equal density.
pub(crate) fn random_torus(count: usize, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut turn = || std::f64::consts::TAU * uniform(&mut random);
    let mut points = Vec::new();
    while points.len() < count {
        let (u, v, chance) = (turn(), turn(), turn() / std::f64::consts::TAU);
        let out = 3.0 + v.cos();
        if 4.0 * chance < out {
            points.push([out * u.cos(), out * u.sin(), v.sin()]);
        }
    }
    points
}

#[test]
fn a_ball_and_tori_are_closed_with_their_handles() {
    let priority = GraphChoices { order: LandmarkOrder::Priority, ..GraphChoices::default() };
    for choices in [GraphChoices::default(), priority] {
        assert_closed(&ball(20_000, 0.0, 1), &choices, 0);
        assert_closed(&ball(20_000, 1e-3, 2), &choices, 0);
        assert_closed(&torus(300, 100).0, &choices, 1);
        assert_closed(&random_torus(20_000, 3), &choices, 1);
    }
}

#[test]
fn two_balls_are_two_parts() {
    let mut points = ball(8_000, 1e-3, 5);
    points.extend(ball(8_000, 1e-3, 6).into_iter().map(|[x, y, z]| [x + 20.0, y, z]));
    let made = surface(&points, &GraphChoices::default());
    let proof = prove(&points, &made.reconstruction.facets).unwrap();
    assert_eq!((proof.components, proof.is_closed, proof.genus), (2, true, Some(0)));
    assert_eq!(made.map.components, 2);
    assert!(made.map.genus().abs() < 1e-9);
}

/// The facets by the bits of their corners, in an order of their own.
fn places(points: &[PointMm], made: &GraphSurface) -> Vec<[[u64; 3]; 3]> {
    let facets = made.reconstruction.facets.iter();
    let mut places: Vec<[[u64; 3]; 3]> = facets
        .map(|facet| {
            let mut places = facet.map(|corner| points[corner as usize].map(f64::to_bits));
            places.sort_unstable();
            places
        })
        .collect();
    places.sort_unstable();
    places
}

#[test]
fn the_order_of_points_and_the_threads_change_nothing() {
    let (mut points, _) = torus(120, 40);
    for order in [LandmarkOrder::Sweep, LandmarkOrder::Priority] {
        let choices = GraphChoices { hops: 3, order, ..GraphChoices::default() };
        let first = surface(&points, &choices);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| surface(&points, &choices)), first);
        let before = places(&points, &first);
        let mut random = Pcg64::seed_from_u64(7);
        for last in (1..points.len()).rev() {
            points.swap(last, (random.next_u64() % (last as u64 + 1)) as usize);
        }
        assert_eq!(places(&points, &surface(&points, &choices)), before);
    }
}

#[test]
fn quarter_turns_about_z_and_powers_of_two_change_nothing() {
    let points = random_torus(6_000, 8);
    let turned: Vec<PointMm> = points.iter().map(|&[x, y, z]| [-y, x, z]).collect();
    let doubled: Vec<PointMm> =
        points.iter().map(|point| point.map(|value| value * 64.0)).collect();
    let sweep = GraphChoices { hops: 3, ..GraphChoices::default() };
    let first = surface(&points, &sweep);
    assert_eq!(first.map, surface(&turned, &sweep).map);
    assert_eq!(first.reconstruction, surface(&turned, &sweep).reconstruction);
    let priority = GraphChoices { order: LandmarkOrder::Priority, ..sweep };
    for choices in [sweep, priority] {
        assert_eq!(surface(&points, &choices), surface(&doubled, &choices));
    }
}

#[test]
fn points_of_no_surface_say_why() {
    let choices = GraphChoices::default();
    let of = |points: &[PointMm]| {
        let made = surface(points, &choices);
        assert_eq!(made.reconstruction.facets, [] as [[u32; 3]; 0]);
        assert_eq!(made.reconstruction.left_out.len(), points.len());
        made.no_surface.unwrap()
    };
    assert_eq!(of(&[]), NoSurface::FewPoints);
    assert_eq!(of(&[[1.0; 3]]), NoSurface::FewPoints);
    assert_eq!(of(&[[1.0; 3]; 500]), NoSurface::FewPoints);
    assert_eq!(of(&[[f64::NAN; 3]; 9]), NoSurface::FewPoints);
    assert_eq!(of(&ball(20, 0.0, 1)), NoSurface::FewLandmarks);
    let line: Vec<PointMm> = (0..2_000).map(|at| [f64::from(at), 0.0, 0.0]).collect();
    assert_eq!(of(&line), NoSurface::NoFaces);
}

#[test]
fn a_sheet_is_never_closed() {
    let mut random = Pcg64::seed_from_u64(9);
    for side in [10, 14, 18, 22, 26, 30, 40, 60] {
        let lattice: Vec<PointMm> = (0..side)
            .flat_map(|x| (0..side).map(move |y| [f64::from(x), f64::from(y), 7.0]))
            .collect();
        let mut scattered = || [uniform(&mut random), uniform(&mut random), 0.5];
        let scattered: Vec<PointMm> = (0..side * side).map(|_| scattered()).collect();
        for points in [lattice, scattered] {
            let made = surface(&points, &GraphChoices::default());
            let proof = prove(&points, &made.reconstruction.facets).unwrap();
            assert!(!proof.is_closed, "{side}: {} facets", proof.facets);
        }
    }
}

#[test]
fn duplicates_and_points_without_place_are_listed_and_change_nothing() {
    let mut points = ball(4_000, 1e-3, 10);
    let choices = GraphChoices { hops: 3, ..GraphChoices::default() };
    let first = surface(&points, &choices);
    points.push(points[5]);
    points.push([0.0, f64::NAN, 0.0]);
    points.push([0.0, 0.0, 1e13]);
    let second = surface(&points, &choices);
    assert_eq!(first.reconstruction.facets, second.reconstruction.facets);
    let reasons: Vec<LeftOut> = second
        .reconstruction
        .left_out
        .iter()
        .filter(|left| left.0 >= 4_000)
        .map(|left| left.1)
        .collect();
    assert_eq!(reasons, [LeftOut::Duplicate, LeftOut::NoPlace, LeftOut::NoPlace]);
}

#[test]
fn a_huge_offset_keeps_the_topology() {
    let points: Vec<PointMm> =
        ball(8_000, 1e-3, 11).into_iter().map(|point| point.map(|value| value + 1e9)).collect();
    assert_closed(&points, &GraphChoices::default(), 0);
}

#[test]
fn numbers_out_of_range_are_refused() {
    let points = ball(100, 0.0, 1);
    let none = PointGraph::new(&points, 0, &mut |_| {}).err();
    assert_eq!(none, Some(GraphError::Neighbours { found: 0 }));
    let graph = PointGraph::new(&points, 15, &mut |_| {}).unwrap();
    let choices = GraphChoices { hops: 0, ..GraphChoices::default() };
    assert_eq!(graph.surface(&choices, &mut |_| {}), Err(GraphError::Hops { found: 0 }));
}

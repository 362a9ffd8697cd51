//! Facets by local stars.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_reconstruct::{LeftOut, Proof, local, prove};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, moebius, places, shuffle, torus, uniform};

/// The proof of what points make, all of them being vertices.
fn proven(points: &[PointMm]) -> Proof {
    let made = local(points).unwrap();
    let proof = prove(points, &made.facets).unwrap();
    assert_eq!(made.left_out, []);
    proof
}

fn assert_closed(points: &[PointMm], genus: i64) {
    let proof = proven(points);
    let expected = 2 * points.len() as i64 - 4 + 4 * genus;
    assert_eq!(proof.facets as i64, expected);
    assert_eq!(proof.genus, Some(genus));
    assert!(proof.is_closed && proof.is_oriented && proof.volume_mm3.unwrap() > 0.0);
    assert_eq!(proof.self_intersections.count, 0);
}

#[test]
fn a_ball_of_n_points_has_2n_minus_4_facets() {
    assert_closed(&ball(20_000, 0.0, 1), 0);
    assert_closed(&ball(20_000, 5e-6, 2), 0);
}

#[test]
fn a_torus_of_exact_and_noisy_rings_has_2n_facets_and_a_handle() {
    let (mut points, _) = torus(300, 100);
    assert_closed(&points, 1);
    let mut random = Pcg64::seed_from_u64(3);
    for value in points.as_flattened_mut() {
        *value += 1e-6 * uniform(&mut random);
    }
    assert_closed(&points, 1);
}

#[test]
fn a_moebius_band_stays_one_sided() {
    let (points, facets) = moebius(240, 15);
    let proof = proven(&points);
    assert_eq!((proof.facets, proof.is_orientable), (facets.len(), false));
    assert_eq!((proof.border_loops.len(), proof.betti), (1, Some([1, 1, 0])));
}

#[test]
fn a_raster_on_a_cylinder_keeps_two_borders() {
    for noise in [0.0, 1e-4] {
        let mut random = Pcg64::seed_from_u64(4);
        let points: Vec<PointMm> = (0..100)
            .flat_map(|i| (0..40).map(move |j| (i, j)))
            .map(|(i, j)| {
                let turn = TAU * f64::from(i) / 100.0;
                [5.0 * turn.cos(), 5.0 * turn.sin(), 0.3 * f64::from(j)]
                    .map(|value| value + noise * uniform(&mut random))
            })
            .collect();
        let proof = proven(&points);
        assert_eq!((proof.border_loops.len(), proof.euler, proof.facets), (2, 0, 100 * 39 * 2));
    }
}

#[test]
fn two_spheres_half_a_millimetre_apart_stay_two() {
    let mut points = ball(20_000, 0.0, 5);
    points.extend(ball(16_000, 0.0, 6).into_iter().map(|point| point.map(|value| 0.9 * value)));
    let proof = proven(&points);
    assert_eq!((proof.components, proof.facets, proof.is_closed), (2, 71_992, true));
}

#[test]
fn the_order_of_points_and_the_threads_change_nothing() {
    let (mut points, _) = torus(120, 40);
    let made = |points: &[PointMm]| places(points, &local(points).unwrap().facets);
    let expected = made(&points);
    shuffle(&mut points, 7);
    assert_eq!(made(&points), expected);
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| local(&points)), local(&points));
}

#[test]
fn bad_points_make_no_surface_that_is_not_there() {
    let none: [&[PointMm]; 4] = [&[], &[[1.0; 3]], &[[0.0; 3], [1.0; 3]], &[[2.0; 3]; 50]];
    for points in none {
        let made = local(points).unwrap();
        assert_eq!((made.facets.len(), made.left_out.len()), (0, points.len()));
    }
    let line: Vec<PointMm> = (0..100).map(|at| [f64::from(at), 2.0 * f64::from(at), 0.0]).collect();
    let made = local(&line).unwrap();
    assert!(
        made.left_out.iter().all(|&(_, why)| why == LeftOut::NoPlane) && made.facets.is_empty()
    );
    let odd = [[f64::NAN; 3], [1e308; 3], [1e-300; 3], [0.0; 3], [f64::INFINITY, 0.0, 0.0]];
    let made = local(&odd).unwrap();
    assert_eq!(made.left_out[3], (3, LeftOut::Duplicate));
    assert_eq!(made.left_out[0], (0, LeftOut::NoPlace));
    // An exact lattice in a plane, far from the origin.
    let flat: Vec<PointMm> =
        (0..400).map(|at| [1e9 + f64::from(at % 20), 1e9 + f64::from(at / 20), 1e9]).collect();
    let proof = proven(&flat);
    assert_eq!((proof.facets, proof.border_loops.len(), proof.euler), (2 * 19 * 19, 1, 1));
}

/// Points of a ball at random: many stars disagree.
fn scattered_ball(count: usize, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    (0..count)
        .map(|_| {
            let (z, turn) = (2.0 * uniform(&mut random) - 1.0, TAU * uniform(&mut random));
            let radius = (1.0 - z * z).max(0.0).sqrt();
            [10.0 * radius * turn.cos(), 10.0 * radius * turn.sin(), 10.0 * z]
        })
        .collect()
}

#[test]
fn a_ball_of_random_points_is_closed() {
    for seed in 1..=4 {
        assert_closed(&scattered_ball(5_000, seed), 0);
    }
}

#[test]
fn fillings_depend_on_places_alone() {
    let points = scattered_ball(3_000, 9);
    let facets = |points: &[PointMm]| {
        let made = local(points).unwrap();
        let mut places: Vec<_> = made
            .facets
            .iter()
            .map(|facet| {
                let mut corners = facet.map(|at| points[at as usize].map(f64::to_bits));
                corners.sort_unstable();
                corners
            })
            .collect();
        places.sort_unstable();
        places
    };
    let expected = facets(&points);
    let backwards: Vec<PointMm> = points.iter().rev().copied().collect();
    assert_eq!(facets(&backwards), expected);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(pool.install(|| facets(&points)), expected);
}

#[test]
fn a_hole_wider_than_a_point_sees_stays_and_a_bowl_stays_open() {
    let lattice = |hole: f64| -> Vec<PointMm> {
        (0..40)
            .flat_map(|i| (0..40).map(move |j| [f64::from(i), f64::from(j), 0.0]))
            .filter(|&[x, y, _]| (x - 20.0).hypot(y - 20.0) >= hole)
            .collect()
    };
    for (hole, borders) in [(0.5, 1), (8.0, 2)] {
        let points = lattice(hole);
        let proof = prove(&points, &local(&points).unwrap().facets).unwrap();
        assert_eq!(proof.border_loops.len(), borders, "hole of {hole} mm");
    }
    let bowl: Vec<PointMm> = ball(4_000, 0.0, 1).into_iter().filter(|&[_, _, z]| z < 0.0).collect();
    let proof = prove(&bowl, &local(&bowl).unwrap().facets).unwrap();
    assert_eq!((proof.border_loops.len(), proof.components, proof.is_closed), (1, 1, false));
}

//! Tangential complexes of surfaces whose topology is known.

use asphera_geometry::PointMm;
use asphera_reconstruct::{NoDelaunay, Tangential, natural, prove, tangential};

use crate::shapes::{ball, moebius, places, torus};

fn assert_closed(points: &[PointMm], genus: i64, components: usize) -> Tangential {
    let made = tangential(points).unwrap();
    let proof = prove(points, &made.surface.facets).unwrap();
    assert_eq!((proof.is_closed, proof.is_manifold, proof.components), (true, true, components));
    let facets = 2 * points.len() as i64 - 4 * components as i64 + 4 * genus;
    assert_eq!((proof.genus, proof.facets as i64), (Some(genus), facets));
    assert_eq!((proof.self_intersections.count, made.inconsistent), (0, 0));
    assert_eq!(made.surface.left_out, []);
    made
}

#[test]
fn balls_and_two_spheres_are_manifolds() {
    for noise in [0.0, 1e-3] {
        let points = ball(5_000, noise, 71);
        let made = assert_closed(&points, 0, 1);
        assert!(made.sampling.is_met());
        // Another way to the restricted Delaunay triangulation finds the same facets, but for near ties.
        let other = places(&points, &natural(&points).unwrap().surface.facets);
        let found = places(&points, &made.surface.facets);
        let common = found.iter().filter(|facet| other.binary_search(facet).is_ok()).count();
        assert!(common * 100 > 99 * found.len(), "{common} of {}", found.len());
    }
    let mut two = ball(20_000, 1e-6, 72);
    two.extend(ball(16_000, 1e-6, 73).into_iter().map(|point| point.map(|value| 0.9 * value)));
    assert_closed(&two, 0, 2);
}

#[test]
fn weights_make_the_stars_of_exact_lattices_agree() {
    let (points, _) = torus(150, 50);
    let made = assert_closed(&points, 1, 1);
    assert!(made.weighted > 1_000 && made.rounds > 0);
    let (band, facets) = moebius(240, 15);
    let made = tangential(&band).unwrap();
    let proof = prove(&band, &made.surface.facets).unwrap();
    assert!(made.inconsistent == 0 && made.surface.left_out.is_empty());
    assert_eq!((proof.is_manifold, proof.is_orientable, proof.facets), (true, false, facets.len()));
    assert_eq!((proof.border_loops.len(), proof.euler), (1, 0));
}

#[test]
fn what_no_weights_can_mend_is_counted_and_open() {
    let lattice: Vec<PointMm> =
        (0..512).map(|at| [at % 8, at / 8 % 8, at / 64].map(f64::from)).collect();
    for points in [&ball(2_000, 0.5, 74), &lattice] {
        let made = tangential(points).unwrap();
        let proof = prove(points, &made.surface.facets).unwrap();
        assert!(made.inconsistent > 100 && !made.sampling.is_met() && !proof.is_closed);
    }
    let flat: Vec<PointMm> =
        (0..99).map(|at| [f64::from(at % 9), f64::from(at / 9), 2.0]).collect();
    assert!(matches!(tangential(&flat), Err(NoDelaunay::InAPlane { .. })));
}

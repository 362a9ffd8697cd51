//! Cocone by cells of an octree against Cocone over one triangulation.

use asphera_geometry::PointMm;
use asphera_reconstruct::{NoDelaunay, cocone, loc_cocone, prove, super_cocone};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, places, shuffle, torus, uniform};

/// Facets, candidates and flat points are those of Cocone.
fn assert_same(points: &[PointMm], most_in_cell: usize) {
    let expected = cocone(points).unwrap();
    let made = loc_cocone(points, most_in_cell).unwrap();
    assert!(made.cells * most_in_cell >= points.len() && made.cells > 1);
    let of = |facets| places(points, facets);
    assert!(of(&made.cocone.surface.facets) == of(&expected.surface.facets));
    assert_eq!(made.cocone.surface.left_out, expected.surface.left_out);
    assert_eq!(made.cocone.candidates, expected.candidates);
    assert_eq!((made.cocone.pruned, made.cocone.not_flat), (expected.pruned, expected.not_flat));
    let [one, other] = [&made.cocone.sampling, &expected.sampling].map(|found| found.largest);
    assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
}

#[test]
fn cells_give_the_facets_of_cocone() {
    assert_same(&ball(3_000, 0.0, 81), 700);
    assert_same(&ball(3_000, 1e-3, 82), 700);
    let mut random = Pcg64::seed_from_u64(83);
    let mut noisy = torus(90, 40).0;
    noisy.as_flattened_mut().iter_mut().for_each(|value| *value += 1e-3 * uniform(&mut random));
    assert_same(&noisy, 500);
    let bowl: Vec<PointMm> =
        ball(3_000, 1e-6, 84).into_iter().filter(|&[_, _, z]| z < 1.0).collect();
    assert_same(&bowl, 500);
    let mut two = ball(4_000, 1e-6, 85);
    two.extend(ball(2_000, 1e-6, 86).into_iter().map(|point| point.map(|value| 0.8 * value)));
    assert_same(&two, 900);
}

#[test]
fn missing_points_are_found_for_poles_far_away() {
    let made = loc_cocone(&ball(8_000, 1e-3, 87), 1_000).unwrap();
    assert!(made.rounds > 0 && made.cocone.sampling.is_met());
    assert_eq!(super_cocone(&ball(4_000, 1e-3, 87), 500).unwrap().rounds, 0);
}

#[test]
fn a_margin_gives_the_same_topology_on_dense_points() {
    for (points, genus) in [(ball(5_000, 1e-3, 88), 0), (torus(120, 45).0, 1)] {
        let made = super_cocone(&points, 600).unwrap();
        let proof = prove(&points, &made.cocone.surface.facets).unwrap();
        assert_eq!((proof.is_closed, proof.genus, proof.is_manifold), (true, Some(genus), true));
        assert_eq!((proof.self_intersections.count, proof.components), (0, 1));
        assert_eq!(made.cocone.surface.left_out, []);
    }
}

#[test]
fn the_order_of_points_changes_nothing_and_bad_input_is_refused() {
    let mut points = ball(1_500, 0.01, 89);
    points.push([f64::NAN; 3]);
    points.push(points[7]);
    let made = |points: &[PointMm]| {
        [loc_cocone, super_cocone]
            .map(|method| places(points, &method(points, 300).unwrap().cocone.surface.facets))
    };
    let expected = made(&points);
    assert_eq!(loc_cocone(&points, 300).unwrap().cocone.surface.left_out.len(), 2);
    shuffle(&mut points, 90);
    assert!(made(&points) == expected);
    let flat: Vec<PointMm> = points.iter().map(|&[x, y, _]| [x, y, 1.0]).collect();
    assert!(matches!(loc_cocone(&flat, 300), Err(NoDelaunay::InAPlane { .. })));
    assert!(matches!(super_cocone(&flat[..3], 300), Err(NoDelaunay::TooFew { .. })));
}

/// A cell whose points lie in a plane: a face of a box.
#[test]
fn a_flat_face_fills_a_cell() {
    let side = 14;
    let grid = (0..side * side * side)
        .map(|at| [at % side, at / side % side, at / side / side])
        .filter(|place| place.iter().any(|&step| step == 0 || step == side - 1));
    let points: Vec<PointMm> = grid.map(|place| place.map(f64::from)).collect();
    for method in [loc_cocone, super_cocone] {
        let made = method(&points, 40).unwrap();
        assert!(made.cells > 20 && !made.cocone.sampling.is_met());
        assert!(made.cocone.surface.facets.len() > points.len());
    }
}

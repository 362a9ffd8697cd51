//! Surfaces by cocones and by convection: bodies whose topology is known.

use asphera_geometry::PointMm;
use asphera_reconstruct::{Cocone, LeftOut, Proof, cocone, convection, prove, sculpture};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, moebius, places, shuffle, torus, uniform};

fn proven(points: &[PointMm]) -> (Cocone, Proof) {
    let made = cocone(points).unwrap();
    let proof = prove(points, &made.surface.facets).unwrap();
    assert_eq!(made.surface.left_out, []);
    assert_eq!(proof.self_intersections.count, 0);
    assert!(proof.is_manifold);
    (made, proof)
}

fn assert_closed(points: &[PointMm], genus: i64) -> Cocone {
    let (made, proof) = proven(points);
    assert_eq!((proof.is_closed, proof.genus, proof.components), (true, Some(genus), 1));
    assert_eq!(proof.facets as i64, 2 * points.len() as i64 - 4 + 4 * genus);
    made
}

fn noisy_torus(noise: f64) -> Vec<PointMm> {
    let (mut points, _) = torus(200, 70);
    let mut random = Pcg64::seed_from_u64(21);
    for value in points.as_flattened_mut() {
        *value += noise * uniform(&mut random);
    }
    points
}

#[test]
fn balls_and_tori_are_closed_exact_or_noisy() {
    for noise in [0.0, 5e-6, 1e-3] {
        assert_closed(&ball(8_000, noise, 20), 0);
        let made = assert_closed(&noisy_torus(noise), 1);
        assert!(made.candidates >= made.pruned && made.pruned >= made.surface.facets.len());
    }
}

#[test]
fn the_sampling_ratio_of_a_ball_is_known() {
    // The medial axis of a ball is its centre: 5 mm from every point. A spiral of n points has some √(4π/n) between points.
    for (count, is_met) in [(4_000, true), (200, false)] {
        let made = assert_closed(&ball(count, 1e-7, 22), 0);
        let spacing = (4.0 * std::f64::consts::PI / count as f64).sqrt();
        let ratio = made.sampling.largest / spacing;
        assert!((0.5..1.0).contains(&ratio), "{ratio}");
        assert_eq!(made.sampling.is_met(), is_met);
        assert_eq!(made.sampling.worst.is_empty(), is_met);
    }
}

#[test]
fn two_spheres_stay_two_and_each_has_its_facets() {
    let mut points = ball(20_000, 1e-6, 23);
    points.extend(ball(16_000, 1e-6, 24).into_iter().map(|point| point.map(|value| 0.9 * value)));
    let (_, proof) = proven(&points);
    assert_eq!((proof.components, proof.facets, proof.is_closed), (2, 71_992, true));
}

#[test]
fn a_bowl_keeps_its_border_and_a_band_meets_no_condition() {
    let bowl: Vec<PointMm> =
        ball(6_000, 1e-6, 25).into_iter().filter(|&[_, _, z]| z < 1.0).collect();
    let (made, proof) = proven(&bowl);
    assert_eq!((proof.border_loops.len(), proof.euler, proof.components), (1, 1, 1));
    assert!(made.not_flat > 0);
    let (points, _) = moebius(240, 15);
    let made = cocone(&points).unwrap();
    let proof = prove(&points, &made.surface.facets).unwrap();
    // At its borders poles are no normals: points are left out there, and no condition is said to be met.
    assert!(!proof.is_closed && !made.sampling.is_met() && made.not_flat > 240);
    assert!(!made.surface.left_out.is_empty());
}

#[test]
fn the_order_of_points_changes_nothing() {
    let (mut points, _) = torus(60, 30);
    points.extend(ball(500, 0.0, 26).iter().map(|p| p.map(|value| 0.2 * value)));
    let made = |points: &[PointMm]| places(points, &cocone(points).unwrap().surface.facets);
    let expected = made(&points);
    shuffle(&mut points, 27);
    assert_eq!(made(&points), expected);
}

#[test]
fn noise_above_the_spacing_is_no_closed_surface_and_says_so() {
    let points = ball(4_000, 0.5, 28);
    let made = cocone(&points).unwrap();
    assert!(!made.sampling.is_met());
    assert!(made.surface.left_out.iter().any(|&(_, why)| why == LeftOut::NoFacet));
}

#[test]
fn convection_closes_balls_and_tori() {
    for (points, genus) in [(ball(8_000, 1e-3, 29), 0), (noisy_torus(1e-3), 1)] {
        let made = convection(&points).unwrap();
        let proof = prove(&points, &made.facets).unwrap();
        assert_eq!((proof.is_closed, proof.genus, proof.components), (true, Some(genus), 1));
        assert_eq!((proof.self_intersections.count, made.left_out.len()), (0, 0));
    }
}

#[test]
fn sculpture_makes_a_sphere_through_all_points_whatever_they_are() {
    let mut random = Pcg64::seed_from_u64(30);
    let cloud: Vec<PointMm> = (0..2_000).map(|_| [0; 3].map(|_| uniform(&mut random))).collect();
    // A bean: a ball bent in on one side, so that the hull is not enough.
    let bean: Vec<PointMm> = ball(4_000, 1e-3, 31)
        .into_iter()
        .map(|[x, y, z]| [x, y, if z > 0.0 { 0.3 * z + 0.06 * (x * x + y * y) } else { z }])
        .collect();
    for (points, is_smooth) in [(&bean, true), (&cloud, false)] {
        let made = sculpture(points).unwrap();
        let proof = prove(points, &made.facets).unwrap();
        assert_eq!((proof.is_closed, proof.genus, proof.components), (true, Some(0), 1));
        assert_eq!((proof.is_manifold, proof.self_intersections.count), (true, 0));
        let vertices = points.len() - made.left_out.len();
        assert_eq!(proof.facets, 2 * vertices - 4);
        if is_smooth {
            assert_eq!(made.left_out, []);
            // Nearly flat tetrahedra may stay or go: the bodies agree all the same.
            let (_, other) = proven(points);
            let [one, other] = [&proof, &other].map(|proof| proof.volume_mm3.unwrap());
            assert!((one / other - 1.0).abs() < 1e-3, "{one} {other}");
        }
    }
}

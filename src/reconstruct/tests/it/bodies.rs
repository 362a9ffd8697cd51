//! Surfaces of bodies that have an inside: by natural neighbours and by Robust Cocone.

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    LeftOut, NoDelaunay, Proof, Reconstruction, natural, prove, robust_cocone,
};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, moebius, torus, uniform};

fn proven(points: &[PointMm], made: &Reconstruction) -> Proof {
    let proof = prove(points, &made.facets).unwrap();
    assert_eq!(proof.self_intersections.count, 0);
    proof
}

fn assert_closed(points: &[PointMm], genus: i64, components: usize) {
    let facets = 2 * points.len() as i64 - 4 * components as i64 + 4 * genus;
    for made in [natural(points).unwrap().surface, robust_cocone(points).unwrap().surface] {
        let proof = proven(points, &made);
        assert_eq!(
            (proof.is_closed, proof.is_manifold, proof.components),
            (true, true, components)
        );
        assert_eq!((proof.genus, proof.facets as i64), (Some(genus), facets));
        assert_eq!(made.left_out, []);
        assert!(proof.volume_mm3.unwrap() > 0.0);
    }
}

#[test]
fn balls_tori_and_a_hollow_ball_are_closed() {
    for noise in [0.0, 1e-3] {
        assert_closed(&ball(5_000, noise, 61), 0, 1);
    }
    assert_closed(&torus(120, 45).0, 1, 1);
    // The shell between two spheres is the inside; what the inner one holds is outside.
    let mut hollow = ball(12_000, 1e-6, 62);
    hollow.extend(ball(10_000, 1e-6, 63).into_iter().map(|point| point.map(|value| 0.9 * value)));
    assert_closed(&hollow, 0, 2);
}

#[test]
fn the_condition_is_met_where_the_points_are_dense() {
    let made = natural(&ball(3_000, 1e-6, 64)).unwrap();
    assert!(made.sampling.is_met() && made.mixed == 0 && made.one_sided == 0 && made.lids == 0);
    assert!(!natural(&ball(60, 1e-6, 64)).unwrap().sampling.is_met());
}

#[test]
fn noise_is_left_out_and_what_is_left_is_a_ball() {
    // The noise is as large as the spacing.
    let points = ball(8_000, 0.2, 65);
    let made = robust_cocone(&points).unwrap();
    let proof = proven(&points, &made.surface);
    assert_eq!((proof.is_closed, proof.genus, proof.components), (true, Some(0), 1));
    assert!(made.noise > 2_000 && !made.sampling.is_met());
    let noise = made.surface.left_out.iter().filter(|&&(_, why)| why == LeftOut::Noise);
    assert_eq!(noise.count(), made.noise);
    // It passes the outermost points: a little outside of the ball.
    let ball_mm3 = 4.0 / 3.0 * std::f64::consts::PI * 125.0;
    let ratio = proof.volume_mm3.unwrap() / ball_mm3;
    assert!((1.0..1.1).contains(&ratio), "{ratio}");
    // Natural neighbours take the noise for form, and say so.
    assert!(!natural(&points).unwrap().sampling.is_met());
}

#[test]
fn open_surfaces_get_no_lid_and_a_band_is_no_body() {
    let bowl: Vec<PointMm> =
        ball(6_000, 1e-6, 66).into_iter().filter(|&[_, _, z]| z < 1.0).collect();
    for made in [natural(&bowl).unwrap().surface, robust_cocone(&bowl).unwrap().surface] {
        let proof = proven(&bowl, &made);
        assert_eq!((proof.border_loops.len(), proof.euler, proof.is_manifold), (1, 1, true));
    }
    let (band, _) = moebius(240, 15);
    for made in [natural(&band).unwrap().surface, robust_cocone(&band).unwrap().surface] {
        assert!(!prove(&band, &made.facets).unwrap().is_closed);
    }
    assert!(natural(&band).unwrap().one_sided > 100);
}

#[test]
fn volumes_meet_no_condition_and_planes_are_refused() {
    let mut random = Pcg64::seed_from_u64(67);
    let cloud: Vec<PointMm> = (0..800).map(|_| [0; 3].map(|_| uniform(&mut random))).collect();
    let lattice: Vec<PointMm> =
        (0..512).map(|at| [at % 8, at / 8 % 8, at / 64].map(f64::from)).collect();
    for points in [&cloud, &lattice] {
        assert!(!natural(points).unwrap().sampling.is_met());
        assert!(!robust_cocone(points).unwrap().sampling.is_met());
    }
    let flat: Vec<PointMm> = cloud.iter().map(|&[x, y, _]| [x, y, 2.0]).collect();
    assert!(matches!(natural(&flat), Err(NoDelaunay::InAPlane { .. })));
    assert!(matches!(robust_cocone(&flat), Err(NoDelaunay::InAPlane { .. })));
    let row: Vec<PointMm> = (0..9).map(|at| [f64::from(at); 3]).collect();
    assert!(matches!(robust_cocone(&row), Err(NoDelaunay::OnALine { .. })));
}

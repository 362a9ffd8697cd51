//! Wrap: Betti numbers against those of the alpha complex by matrices, and surfaces whose topology is known.

use asphera_geometry::PointMm;
use asphera_reconstruct::{AlphaError, Delaunay, NoDelaunay, prove, wrap};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::complexes::{alpha_complex, betti};
use crate::shapes::{ball, moebius, torus, uniform};

#[test]
fn the_complex_has_the_betti_numbers_of_the_alpha_complex() {
    let mut random = Pcg64::seed_from_u64(41);
    let mut seen = [false; 3];
    for round in 0..6 {
        // In space, and near a sphere of radius 0.5, which has a cavity.
        let points: Vec<PointMm> = (0..70)
            .map(|_| {
                let way = [0; 3].map(|_| uniform(&mut random) - 0.5);
                let length = way.iter().map(|value| value * value).sum::<f64>().sqrt();
                let out = 0.5 + 0.02 * uniform(&mut random);
                if round % 2 == 0 { way } else { way.map(|value| out * value / length) }
            })
            .collect();
        let tetrahedra = Delaunay::new(&points).unwrap().tetrahedra();
        for diameter in [0.0, 0.1, 0.2, 0.3, 0.35, 0.4, 0.5, 0.6, 0.8, 0.99, 1.5, 1e3] {
            let made = wrap(&points, Some(diameter)).unwrap();
            let complex = alpha_complex(&points, &tetrahedra, diameter);
            assert_eq!(made.betti, betti(&complex), "{round} {diameter}");
            let euler: i64 =
                [1, -1, 1, -1].iter().zip(made.simplices).map(|(s, n)| s * n as i64).sum();
            assert_eq!(euler, made.betti[0] - made.betti[1] + made.betti[2]);
            // The alpha complex collapses to it.
            let larger = [1, 2, 3, 4].map(|len| complex.iter().filter(|s| s.len() == len).count());
            assert!(made.simplices.iter().zip(larger).all(|(few, many)| *few <= many));
            for (seen, number) in
                seen.iter_mut().zip([made.betti[0] - 1, made.betti[1], made.betti[2]])
            {
                *seen |= number > 0;
            }
        }
    }
    assert_eq!(seen, [true; 3]);
}

#[test]
fn lattices_have_the_betti_numbers_of_their_boxes() {
    // Steps of 3, 4 and 12: sides within 3, 4 and 12; the faces within 5; the boxes within 13.
    let points: Vec<PointMm> = (0..60)
        .map(|at| [at % 3, at / 3 % 4, at / 12].map(f64::from))
        .map(|[x, y, z]| [1e6 + 3.0 * x, 4.0 * y - 1e6, 12.0 * z])
        .collect();
    let of = |diameter: f64| wrap(&points, Some(diameter)).unwrap().betti;
    assert_eq!(of(2.9), [60, 0, 0]);
    assert_eq!(of(3.0), [20, 0, 0]);
    // Meshes of 3 × 4 places in 5 layers, 2 × 3 rings in each.
    assert_eq!(of(4.0), [5, 30, 0]);
    assert_eq!(of(5.0), [5, 0, 0]);
    assert_eq!(of(12.0), [1, 44, 0]);
    // Diagonals of 3 × 12 and of 4 × 12: all boxes are hollow.
    assert_eq!(of(12.99), [1, 0, 24]);
    assert_eq!(of(13.0), [1, 0, 0]);
}

fn assert_closed(points: &[PointMm], genus: i64, components: usize) {
    let made = wrap(points, None).unwrap();
    let proof = prove(points, &made.surface.facets).unwrap();
    assert_eq!((proof.is_closed, proof.is_manifold), (true, true));
    assert_eq!((proof.genus, proof.components), (Some(genus), components));
    assert_eq!((proof.self_intersections.count, made.surface.left_out.len()), (0, 0));
    let parts = components as i64;
    assert_eq!(proof.facets as i64, 2 * points.len() as i64 - 4 * parts + 4 * genus);
}

#[test]
fn balls_tori_and_two_spheres_are_closed() {
    for noise in [0.0, 1e-3] {
        assert_closed(&ball(6_000, noise, 42), 0, 1);
    }
    assert_closed(&torus(150, 50).0, 1, 1);
    let mut two = ball(12_000, 1e-6, 43);
    two.extend(ball(10_000, 1e-6, 44).into_iter().map(|point| point.map(|value| 0.9 * value)));
    assert_closed(&two, 0, 2);
}

#[test]
fn open_surfaces_get_no_lid() {
    let bowl: Vec<PointMm> =
        ball(6_000, 1e-6, 45).into_iter().filter(|&[_, _, z]| z < 1.0).collect();
    let made = wrap(&bowl, None).unwrap();
    let proof = prove(&bowl, &made.surface.facets).unwrap();
    assert_eq!((proof.border_loops.len(), proof.euler, proof.is_manifold), (1, 1, true));
    assert_eq!(made.surface.left_out, []);
    let (band, _) = moebius(240, 15);
    let made = wrap(&band, None).unwrap();
    let proof = prove(&band, &made.surface.facets).unwrap();
    assert!(!proof.is_closed && made.surface.left_out.is_empty());
    assert!(!made.sampling.unwrap().is_met());
}

#[test]
fn noise_and_volumes_meet_no_condition_and_bad_input_is_refused() {
    let mut random = Pcg64::seed_from_u64(46);
    let cloud: Vec<PointMm> = (0..800).map(|_| [0; 3].map(|_| uniform(&mut random))).collect();
    for points in [&ball(2_000, 0.5, 47), &cloud] {
        let made = wrap(points, None).unwrap();
        assert!(!made.sampling.unwrap().is_met());
        assert!(!prove(points, &made.surface.facets).unwrap().is_closed);
    }
    assert!(matches!(wrap(&cloud, Some(-1.0)), Err(AlphaError::Diameter { .. })));
    let flat: Vec<PointMm> = cloud.iter().map(|&[x, y, _]| [x, y, 2.0]).collect();
    let refused = wrap(&flat, None).unwrap_err();
    assert!(matches!(refused, AlphaError::NoDelaunay(NoDelaunay::InAPlane { .. })));
}

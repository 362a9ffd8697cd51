//! The proof of meshes whose topology is known.

use std::f64::consts::PI;

use asphera_geometry::PointMm;
use asphera_reconstruct::{ProofError, prove};

use crate::shapes::{moebius, torus};

const TETRAHEDRON: [PointMm; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const SIDES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

#[test]
fn a_tetrahedron_is_a_closed_ball() {
    let proof = prove(&TETRAHEDRON, &SIDES).unwrap();
    assert_eq!((proof.vertices, proof.edges, proof.facets, proof.euler), (4, 6, 4, 2));
    assert!(proof.is_closed && proof.is_manifold && proof.is_orientable && proof.is_oriented);
    assert_eq!((proof.genus, proof.betti), (Some(0), Some([1, 0, 1])));
    assert_eq!(proof.self_intersections.count, 0);
    assert!((proof.volume_mm3.unwrap() - 1.0 / 6.0).abs() < 1e-15);
    assert!((proof.area_mm2 - (1.5 + 3_f64.sqrt() / 2.0)).abs() < 1e-14);
    let mut turned = SIDES;
    turned[2].swap(0, 1);
    let proof = prove(&TETRAHEDRON, &turned).unwrap();
    assert!(proof.is_orientable && !proof.is_oriented && proof.volume_mm3.is_none());
}

#[test]
fn a_torus_has_a_handle_and_pappus_area_and_volume() {
    let (points, facets) = torus(300, 100);
    let proof = prove(&points, &facets).unwrap();
    assert_eq!((proof.facets, proof.euler, proof.genus), (60_000, 0, Some(1)));
    assert_eq!(proof.betti, Some([1, 2, 1]));
    assert_eq!(proof.self_intersections.count, 0);
    // Pappus: 4π²·3·1 and 2π²·3·1², approached from inside as the square of the steps.
    assert!((proof.area_mm2 / (12.0 * PI * PI) - 1.0).abs() < 2e-3);
    assert!((proof.volume_mm3.unwrap().abs() / (6.0 * PI * PI) - 1.0).abs() < 2e-3);
}

#[test]
fn a_moebius_band_has_one_side_and_one_border() {
    let (points, facets) = moebius(60, 5);
    let proof = prove(&points, &facets).unwrap();
    assert!(!proof.is_orientable && proof.is_manifold && !proof.is_closed);
    assert_eq!((proof.genus, proof.border_loops.len()), (None, 1));
    assert_eq!(proof.betti, Some([1, 1, 0]));
    assert_eq!((proof.border_loops[0].edges, proof.border_edges), (120, 120));
    assert_eq!(proof.self_intersections.count, 0);
}

#[test]
fn a_shared_corner_is_singular_and_a_shared_edge_is_not_manifold() {
    // Two tetrahedra, the second mirrored in the corner 0.
    let mut points = TETRAHEDRON.to_vec();
    points.extend(TETRAHEDRON[1..].iter().map(|point| point.map(|value| -value)));
    let other = |corner: u32| if corner == 0 { 0 } else { corner + 3 };
    let mut facets = SIDES.to_vec();
    facets.extend(SIDES.map(|side| side.map(other)));
    let proof = prove(&points, &facets).unwrap();
    assert_eq!((proof.singular_vertices.count, &proof.singular_vertices.first[..]), (1, &[0][..]));
    assert_eq!((proof.components, proof.is_manifold, proof.genus), (1, false, None));
    assert_eq!(proof.betti, Some([1, 0, 2]));
    assert_eq!(proof.self_intersections.count, 0);
    // Three triangles over one edge: no closed set. With two more tetrahedra's worth there are cavities.
    let fan = [[0, 1, 2], [0, 1, 3], [0, 1, 6]];
    let proof = prove(&points, &fan).unwrap();
    assert_eq!(proof.nonmanifold_edges.first, [[0, 1]]);
    assert_eq!(proof.betti, Some([1, 0, 0]));
    // A tetrahedron with a wall inside, over a fifth corner: two cavities, as of a bubble in a bubble.
    let points = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, -4.0]];
    let walls = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3], [0, 1, 4], [1, 2, 4], [0, 2, 4]];
    let proof = prove(&points, &walls).unwrap();
    assert_eq!((proof.nonmanifold_edges.count, proof.betti), (3, Some([1, 0, 2])));
}

#[test]
fn triangles_that_cross_touch_or_cover_are_found() {
    let base: [PointMm; 3] = [[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let meet = |other: [PointMm; 3]| {
        let points: Vec<PointMm> = base.into_iter().chain(other).collect();
        prove(&points, &[[0, 1, 2], [3, 4, 5]]).unwrap().self_intersections.count
    };
    let cases: [([PointMm; 3], usize); 7] = [
        ([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [9.0, 9.0, 0.0]], 1),
        // A corner that touches the inside, an edge, and one that stays off by a last bit.
        ([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]], 1),
        ([[2.0, 2.0, 0.0], [5.0, 5.0, 1.0], [5.0, 5.0, -1.0]], 1),
        ([[2.0, 2.0_f64.next_up(), 0.0], [5.0, 5.0, 1.0], [5.0, 5.0, -1.0]], 0),
        // In its plane: inside, across, beside.
        ([[0.5, 0.5, 0.0], [1.0, 0.5, 0.0], [0.5, 1.0, 0.0]], 1),
        ([[-1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [9.0, 1.5, 0.0]], 1),
        ([[5.0, 5.0, 0.0], [6.0, 5.0, 0.0], [5.0, 6.0, 0.0]], 0),
    ];
    for (other, expected) in cases {
        assert_eq!(meet(other), expected, "{other:?}");
    }
    // Over a common edge: folded flat, and merely sharp. At a common corner: beside, and through.
    let mut points = base.to_vec();
    points.extend([
        [1.0, 1.0, 0.0],
        [1.0, 1.0, 1e-300],
        [-1.0, -1.0, 0.0],
        [4.0, 4.0, 1.0],
        [4.0, 4.0, -1.0],
    ]);
    let of = |facets: &[[u32; 3]]| prove(&points, facets).unwrap().self_intersections.count;
    assert_eq!(of(&[[0, 1, 2], [0, 1, 3]]), 1);
    assert_eq!(of(&[[0, 1, 2], [0, 1, 4]]), 0);
    assert_eq!(of(&[[0, 1, 2], [0, 1, 5]]), 0);
    assert_eq!(of(&[[0, 1, 2], [0, 6, 7]]), 1);
    assert_eq!(of(&[[0, 1, 2], [0, 1, 2]]), 1);
}

#[test]
fn what_is_no_mesh_is_refused_or_counted() {
    let empty = prove(&[], &[]).unwrap();
    assert!(!empty.is_closed && empty.is_manifold);
    assert_eq!((empty.components, empty.betti), (0, Some([0, 0, 0])));
    let missing = prove(&TETRAHEDRON, &[[0, 1, 4]]).unwrap_err();
    assert_eq!(missing, ProofError::NoSuchPoint { facet: 0, corner: 4, points: 4 });
    let nan = prove(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, f64::NAN, 0.0]], &[[0, 1, 2]]);
    assert!(nan.unwrap_err().to_string().starts_with("point 2: expected coordinates from"));
    // A triangle on a line, and one of a single corner.
    let line = [[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]];
    let proof = prove(&line, &[[0, 1, 2], [1, 1, 1]]).unwrap();
    assert_eq!((proof.degenerate_facets.count, proof.is_manifold), (2, false));
}

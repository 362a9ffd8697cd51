//! Alpha shapes: against balls rolled over every three points, and on a lattice whose diameters are whole.

use asphera_geometry::PointMm;
use asphera_reconstruct::{AlphaError, AlphaStanding, Delaunay, alpha_shape, prove};
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, uniform};

fn dot(a: PointMm, b: PointMm) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn minus(a: PointMm, b: PointMm) -> PointMm {
    [0, 1, 2].map(|axis| a[axis] - b[axis])
}

fn cross(a: PointMm, b: PointMm) -> PointMm {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Facets on which a ball of the diameter can rest without a point inside: on one side regular, on both singular.
fn rolled(points: &[PointMm], diameter: f64) -> Vec<([u32; 3], AlphaStanding)> {
    let n = points.len();
    let mut found = Vec::new();
    for (a, b, c) in
        (0..n).flat_map(|a| (a + 1..n).flat_map(move |b| (b + 1..n).map(move |c| (a, b, c))))
    {
        let [u, v] = [minus(points[a], points[c]), minus(points[b], points[c])];
        let normal = cross(u, v);
        let square = dot(normal, normal);
        let lifted = [0, 1, 2].map(|axis| dot(u, u) * v[axis] - dot(v, v) * u[axis]);
        let way = cross(lifted, normal).map(|part| part / (2.0 * square));
        let up = diameter * diameter / 4.0 - dot(way, way);
        if up < 0.0 {
            continue;
        }
        let rests = |side: f64| {
            let step = side * (up / square).sqrt();
            let centre = [0, 1, 2].map(|axis| points[c][axis] + way[axis] + step * normal[axis]);
            let is_inside = |at: &usize| {
                let way = minus(points[*at], centre);
                dot(way, way) < diameter * diameter / 4.0
            };
            !(0..n).filter(|at| ![a, b, c].contains(at)).any(|at| is_inside(&at))
        };
        let corners = [a, b, c].map(|corner| corner as u32);
        match (rests(1.0), rests(-1.0)) {
            (true, true) => found.push((corners, AlphaStanding::Singular)),
            (false, false) => {}
            _ => found.push((corners, AlphaStanding::Regular)),
        }
    }
    found
}

#[test]
fn balls_rest_on_the_facets_of_the_shape_and_on_no_others() {
    let mut random = Pcg64::seed_from_u64(11);
    let (mut singular, mut regular) = (0, 0);
    for diameter in [0.2, 0.4, 0.5, 0.6, 0.8, 1.5, 30.0] {
        let points: Vec<PointMm> = (0..60).map(|_| [0; 3].map(|_| uniform(&mut random))).collect();
        let mut found = Delaunay::new(&points).unwrap().alpha_facets(diameter).unwrap();
        found.retain(|(_, standing)| *standing != AlphaStanding::Interior);
        assert_eq!(found, rolled(&points, diameter));
        let shape = alpha_shape(&points, diameter).unwrap();
        assert_eq!(shape.surface.facets.len(), shape.singular + shape.regular);
        assert_eq!(found.len(), shape.surface.facets.len());
        singular += shape.singular;
        regular += shape.regular;
    }
    assert!(singular > 30 && regular > 500, "{singular} {regular}");
}

#[test]
fn a_lattice_is_filled_from_its_diagonal_on() {
    // Steps of 3, 4 and 12: the sphere of a box has diameter 13, the circle of its least side 5. The offset is exact.
    let points: Vec<PointMm> = (0..125)
        .map(|at| [at % 5, at / 5 % 5, at / 25].map(f64::from))
        .map(|[x, y, z]| [1e6 + 3.0 * x, 4.0 * y - 1e6, 12.0 * z])
        .collect();
    let of = |diameter: f64| alpha_shape(&points, diameter).unwrap();
    let full = of(13.0);
    assert_eq!((full.tetrahedra, full.singular, full.regular), (6 * 64, 0, 6 * 2 * 16));
    let proof = prove(&points, &full.surface.facets).unwrap();
    assert_eq!(
        (proof.is_closed, proof.genus, proof.volume_mm3),
        (true, Some(0), Some(64.0 * 144.0))
    );
    let below = of(13.0_f64.next_down());
    assert_eq!((below.tetrahedra, below.regular), (0, 0));
    assert_eq!(of(5.0).singular, 5 * 16 * 2);
    assert_eq!(of(5.0_f64.next_down()).singular, 0);
}

#[test]
fn a_ball_is_closed_and_bad_diameters_are_refused() {
    let points = ball(3_000, 1e-4, 12);
    let shape = alpha_shape(&points, 1.0).unwrap();
    let proof = prove(&points, &shape.surface.facets).unwrap();
    // A ball of 1 mm does not fit through the surface, but fits inside.
    assert_eq!((proof.components, proof.self_intersections.count), (1, 0));
    assert_eq!(shape.surface.left_out, []);
    for wrong in [-1.0, f64::NAN, f64::INFINITY, 2e12] {
        assert!(matches!(alpha_shape(&points, wrong), Err(AlphaError::Diameter { .. })));
    }
    assert!(matches!(alpha_shape(&points[..3], 1.0), Err(AlphaError::NoDelaunay(_))));
}

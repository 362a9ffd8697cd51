//! Interpolation: natural neighbours against another implementation and by hand, and linear fields.

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Location, Mesh};
use proptest::prelude::*;
use spade::{DelaunayTriangulation, Point2, Triangulation};

use crate::patterns::{PITCH_MM, jittered_raster, raster, sag_mm, scattered};

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    mesh
}

/// The weights must not be negative, and have the sum one and the place as the mean of places.
fn assert_coordinates(mesh: &Mesh, [x, y]: [f64; 2], weights: &[(VertexId, f64)]) {
    let sum: f64 = weights.iter().map(|&(_, weight)| weight).sum();
    assert!((sum - 1.0).abs() < 4.0 * f64::EPSILON, "{sum} at {x} {y}");
    let (mut missed, mut reach) = ([0.0; 2], 0.0_f64);
    for &(vertex, weight) in weights {
        assert!(weight > 0.0, "{weights:?}");
        let [px, py, _] = mesh.points()[vertex as usize];
        missed = [missed[0] + weight * (px - x), missed[1] + weight * (py - y)];
        reach = reach.max((px - x).hypot(py - y));
    }
    let rounding = 8.0 * f64::EPSILON * x.abs().max(y.abs());
    assert!(
        missed[0].hypot(missed[1]) <= 1e-9 * reach + rounding,
        "{missed:?} at {x} {y}: {weights:?}"
    );
}

/// The largest difference to the weights that the crate `spade` finds.
fn worst_difference(points: &[PointMm], places: &[[f64; 2]]) -> f64 {
    let mesh = meshed(points);
    let mut other: DelaunayTriangulation<Point2<f64>> = DelaunayTriangulation::new();
    let handles: Vec<_> = points
        .iter()
        .map(|&[x, y, _]| other.insert(Point2::new(x, y)).expect("it is finite").index())
        .collect();
    let natural = other.natural_neighbor();
    let mut found = Vec::new();
    let mut worst = 0.0_f64;
    for &[x, y] in places {
        let weights = mesh.natural_coordinates(x, y);
        natural.get_weights(Point2::new(x, y), &mut found);
        if weights.is_empty() {
            assert!(matches!(mesh.locate(x, y), Location::Outside { .. }));
            continue;
        }
        assert_coordinates(&mesh, [x, y], &weights);
        for vertex in 0..points.len() as VertexId {
            let of_ours = weights.iter().find(|&&(other, _)| other == vertex);
            let of_other =
                found.iter().find(|(handle, _)| handle.index() == handles[vertex as usize]);
            let [ours, theirs] =
                [of_ours.map_or(0.0, |found| found.1), of_other.map_or(0.0, |found| found.1)];
            worst = worst.max((ours - theirs).abs());
        }
    }
    worst
}

fn places(count: usize, side_mm: f64, seed: u64) -> Vec<[f64; 2]> {
    scattered(count, side_mm, seed).into_iter().map(|[x, y, _]| [x, y]).collect()
}

#[test]
fn weights_of_another_implementation() {
    let scattered = worst_difference(&scattered(300, 1.0, 1), &places(600, 1.0, 2));
    assert!(scattered < 1e-12, "{scattered:e}");
    let side_mm = 17.0 * PITCH_MM;
    let jittered = worst_difference(&jittered_raster(18, 0.3, 3), &places(600, side_mm, 4));
    assert!(jittered < 1e-12, "{jittered:e}");
    let exact = worst_difference(&raster(18), &places(600, side_mm, 5));
    assert!(exact < 1e-12, "{exact:e}");
}

/// In the middle of a square, and of an edge, where the shares can be computed by hand: they are
/// triangles and squares of the cell's corners (1/4, 1/2), (1/2, 5/8), …
#[test]
fn weights_on_a_lattice() {
    let points: Vec<PointMm> =
        (0..49).map(|i| [f64::from(i % 7) - 3.0, f64::from(i / 7) - 3.0, 0.0]).collect();
    let mesh = meshed(&points);
    let weight = |weights: &[(VertexId, f64)], x: f64, y: f64| {
        let there = weights.iter().find(|(v, _)| mesh.points()[*v as usize] == [x, y, 0.0]);
        there.map_or(0.0, |&(_, weight)| weight)
    };
    let centre = mesh.natural_coordinates(0.5, 0.5);
    assert_eq!(centre.len(), 4);
    assert!(centre.iter().all(|&(_, weight)| weight == 0.25), "{centre:?}");
    let middle = mesh.natural_coordinates(0.5, 0.0);
    assert_eq!(middle.len(), 6);
    for x in [0.0, 1.0] {
        assert!((weight(&middle, x, 0.0) - 4.0 / 9.0).abs() < 1e-15);
        assert!((weight(&middle, x, 1.0) - 1.0 / 36.0).abs() < 1e-15);
        assert!((weight(&middle, x, -1.0) - 1.0 / 36.0).abs() < 1e-15);
    }
    // The same far away and small: coordinates are multiples of powers of two.
    let far: Vec<PointMm> =
        points.iter().map(|[x, y, _]| [1e6 + x / 1024.0, y / 1024.0 - 1e6, 0.0]).collect();
    let far = meshed(&far).natural_coordinates(1e6 + 0.5 / 1024.0, -1e6);
    assert_eq!(far, middle);
}

#[test]
fn vertices_the_hull_and_beyond() {
    let points = raster(12);
    let mesh = meshed(&points);
    for (vertex, &[x, y, z]) in (0..).zip(&points) {
        assert_eq!(mesh.natural_coordinates(x, y), [(vertex, 1.0)]);
        assert_eq!(mesh.interpolate_linear(x, y), Some(z));
    }
    // The second and the third point of the first row, at a quarter of the way.
    let weights = mesh.natural_coordinates(1.25 * PITCH_MM, 0.0);
    assert_eq!(weights.iter().map(|&(vertex, _)| vertex).collect::<Vec<_>>(), [1, 2]);
    assert!((weights[0].1 - 0.75).abs() < 1e-14);
    assert_eq!(
        mesh.interpolate_natural(1.25 * PITCH_MM, -f64::MIN_POSITIVE.sqrt()),
        mesh.interpolate_natural(1.25 * PITCH_MM, 0.0)
    );
    assert_eq!(mesh.interpolate_natural(1.25 * PITCH_MM, -1e-20), None);
    assert_eq!(mesh.interpolate_linear(-1e-20, 0.0), None);
    // From well inside to next to nothing off the hull the value goes over into that on it.
    let on_hull = mesh.interpolate_natural(1.25 * PITCH_MM, 0.0).unwrap();
    for exponent in 4..40 {
        let off = 10_f64.powi(-exponent);
        let value = mesh.interpolate_natural(1.25 * PITCH_MM, off).unwrap();
        assert!((value - on_hull).abs() < 2.0 * off + 1e-15, "{value} at {off:e}");
    }
}

#[test]
fn a_line_is_interpolated_along_itself() {
    let mesh = meshed(&[[0.0, 0.0, 1.0], [4.0, 2.0, 3.0], [2.0, 1.0, 0.0]]);
    assert_eq!(mesh.interpolate_linear(3.0, 1.5), Some(1.5));
    assert_eq!(mesh.interpolate_natural(1.0, 0.5), Some(0.5));
    assert_eq!(mesh.interpolate_natural(1.0, 0.6), None);
    assert_eq!(mesh.interpolate_natural(6.0, 3.0), None);
    assert_eq!(Mesh::new().interpolate_linear(0.0, 0.0), None);
}

#[test]
fn values_lie_between_those_of_the_neighbours() {
    let mesh = meshed(&scattered(500, 1.0, 6));
    for [x, y] in places(500, 1.0, 7) {
        if let Some(constant) = mesh.interpolate_natural_of(x, y, |_| 0.1) {
            assert_eq!(constant, 0.1);
            assert_eq!(mesh.interpolate_linear_of(x, y, |_| 0.1), Some(0.1));
        }
        let ones = |vertex: VertexId| f64::from(vertex % 2);
        for value in
            [mesh.interpolate_natural_of(x, y, ones), mesh.interpolate_linear_of(x, y, ones)]
                .into_iter()
                .flatten()
        {
            assert!((-1e-15..=1.0 + 1e-15).contains(&value));
        }
    }
}

/// On a smooth surface both are second order, inside: within a share of the sag of one pitch.
#[test]
fn a_sphere_is_met() {
    for points in [raster(60), jittered_raster(60, 0.2, 8)] {
        let mesh = meshed(&points);
        for place in places(2_000, 53.0 * PITCH_MM, 9) {
            let [x, y] = place.map(|coordinate| coordinate + 3.0 * PITCH_MM);
            for height in [mesh.interpolate_natural(x, y), mesh.interpolate_linear(x, y)] {
                let off = height.unwrap() - sag_mm(x, y);
                assert!(off.abs() < PITCH_MM * PITCH_MM / 100.0, "{off:e} at {x} {y}");
            }
        }
    }
}

proptest! {
    /// Whatever the points: lattices, lines, flat triangles, far away.
    #[test]
    fn linear_fields_are_reproduced(
        nodes in prop::collection::vec(
            (prop::array::uniform2(-6_i32..=6), prop::array::uniform2(-1_i32..=1)),
            1..50,
        ),
        places in prop::collection::vec(prop::array::uniform2(-6.5_f64..6.5), 1..40),
        noise in prop::sample::select(vec![0.0, 1e-15, 1e-9, 1e-3, 0.3]),
        scale in prop::sample::select(vec![1e-3, 1.0, 1e9]),
        offset in prop::sample::select(vec![0.0, 1.0, 1e6]),
    ) {
        let points: Vec<PointMm> = nodes
            .iter()
            .map(|(node, wobble)| {
                let [x, y] = [0, 1].map(|axis| {
                    offset + scale * (f64::from(node[axis]) + noise * f64::from(wobble[axis]))
                });
                [x, y, x - 2.0 * y]
            })
            .collect();
        let mesh = meshed(&points);
        let halves = |coordinate: f64| (2.0 * coordinate).round() / 2.0;
        let near = |&[x, y]: &[f64; 2]| {
            [[x, y], [x.round(), y], [x.round(), y.round()], [halves(x), halves(y)]]
        };
        for [x, y] in places.iter().flat_map(near) {
            let [x, y] = [offset + scale * x, offset + scale * y];
            let natural = mesh.natural_coordinates(x, y);
            let linear = mesh.linear_coordinates(x, y);
            prop_assert_eq!(natural.is_empty(), linear.is_empty());
            let outside =
                matches!(mesh.locate(x, y), Location::Outside { .. } | Location::OffLine);
            prop_assert_eq!(natural.is_empty(), outside);
            if !outside {
                assert_coordinates(&mesh, [x, y], &natural);
                assert_coordinates(&mesh, [x, y], &linear);
            }
        }
    }
}

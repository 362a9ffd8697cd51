//! Gap, ε and coverage against surfaces whose figures are known.

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, area};
use asphera_surface::{Criteria, Sampling, State, StateCounts, assess};
use proptest::prelude::*;

use crate::patterns::{PITCH_MM, jittered_raster, raster, scattered};

fn meshed(points: impl IntoIterator<Item = PointMm>) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.extend(points);
    mesh.flush();
    mesh
}

fn flat(_x: f64, _y: f64) -> f64 {
    f64::INFINITY
}

fn figures(mesh: &Mesh, criteria: &Criteria, lfs_mm: impl Fn(f64, f64) -> f64) -> Sampling {
    *assess(mesh.points(), mesh.triangles(), criteria, lfs_mm).sampling()
}

fn near(found: Option<f64>, expected: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() <= 1e-6 * expected.abs())
}

fn close(found: Option<f64>, expected: f64) -> bool {
    found.is_some_and(|found| (found - expected).abs() <= 1e-12 * expected.abs())
}

#[test]
fn a_flat_raster() {
    let mesh = meshed((0..100).map(|i| [f64::from(i % 10), f64::from(i / 10), 2.0]));
    let criteria = Criteria { gap_limit_mm: Some(0.8), ..Criteria::default() };
    let sampling = figures(&mesh, &criteria, flat);
    // Every triangle is half a unit square: its gap is half the diagonal.
    assert!(close(sampling.gap_max_mm, 0.5_f64.sqrt()));
    assert_eq!(sampling.triangles, StateCounts { good: 162, ..StateCounts::default() });
    assert_eq!((sampling.area_mm2, sampling.projected_area_mm2), (81.0, 81.0));
    assert_eq!((sampling.epsilon_max, sampling.epsilon_p99), (Some(0.0), Some(0.0)));
    assert_eq!((sampling.coverage, sampling.undersampled_area_mm2), (Some(1.0), 0.0));

    let criteria = Criteria { aperture_area_mm2: Some(162.0), ..criteria };
    let sampling = figures(&mesh, &criteria, flat);
    assert_eq!(sampling.coverage, Some(0.5));
}

#[test]
fn a_limit_is_inclusive_and_the_gap_comes_first() {
    let points = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let state = |gap_limit_mm, epsilon_limit| {
        let criteria = Criteria { gap_limit_mm, epsilon_limit, aperture_area_mm2: None };
        let survey = assess(&points, [[0, 1, 2]], &criteria, |_, _| 50.0);
        let states: Vec<([VertexId; 3], State)> = survey.triangles().collect();
        assert_eq!(survey.good().count(), usize::from(states[0].1 == State::Good));
        states[0].1
    };
    // Gap 2.5 mm, ε 0.05.
    assert_eq!(state(Some(2.5), Some(0.05)), State::Good);
    assert_eq!(state(Some(2.4), Some(0.05)), State::OverGap);
    assert_eq!(state(Some(2.5), Some(0.04)), State::OverEpsilon);
    assert_eq!(state(None, Some(0.04)), State::OverEpsilon);
    assert_eq!(state(Some(2.4), Some(0.04)), State::OverGap);
    assert_eq!(state(None, None), State::Good);
}

#[test]
fn epsilon_takes_the_smallest_feature_size_it_sees() {
    let points = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
    let epsilon = |lfs: &dyn Fn(f64, f64) -> f64| {
        assess(&points, [[0, 1, 2]], &Criteria::default(), lfs).sampling().epsilon_max.unwrap()
    };
    assert_eq!(epsilon(&|_, _| 10.0), 0.25);
    assert_eq!(epsilon(&|x, _| if x == 3.0 { 5.0 } else { 10.0 }), 0.5);
    assert_eq!(epsilon(&|_, y| if y == 4.0 { 2.5 } else { 10.0 }), 1.0);
    for without in [0.0, -1.0, f64::NAN] {
        assert_eq!(epsilon(&|x, _| if x == 3.0 { without } else { 10.0 }), f64::INFINITY);
    }
}

#[test]
fn a_hole_is_not_bridged() {
    // A raster of 41 × 41 nodes without those strictly inside a square hole of 20 × 20 steps.
    let hole = |i: i32| (11..30).contains(&i);
    let nodes = (0..41 * 41).map(|n| (n % 41, n / 41)).filter(|&(i, j)| !(hole(i) && hole(j)));
    let mesh = meshed(nodes.map(|(i, j)| [f64::from(i), f64::from(j), 0.0]));
    let criteria = Criteria { gap_limit_mm: Some(1.0), ..Criteria::default() };
    let sampling = figures(&mesh, &criteria, flat);
    // Triangles over the hole that touch its rim at two neighbours are thin and have small gaps
    // near the rim; the gap limit finds the others. No place of the hole is farther than 10 from
    // the rim, and its middle is exactly that far.
    assert!(close(sampling.gap_max_mm, 10.0), "{sampling:?}");
    assert_eq!(sampling.area_mm2, 1600.0);
    // Within 1 of a sample is what half a unit disc reaches over from each side.
    let strip = 0.5 * 0.75_f64.sqrt() + 0.5_f64.asin();
    let beyond = (20.0 - 2.0 * strip).powi(2);
    assert!(
        (sampling.undersampled_area_mm2 / beyond - 1.0).abs() < 0.02,
        "{sampling:?}, not {beyond}"
    );
    let covered = 1.0 - sampling.undersampled_area_mm2 / 1600.0;
    assert!(close(sampling.coverage, covered), "{sampling:?}");
}

#[test]
fn thin_triangles_along_the_outline_are_no_gaps() {
    let points = jittered_raster(100, 0.02, 11);
    let mesh = meshed(points.iter().copied());
    let sampling = figures(&mesh, &Criteria::default(), flat);
    let thinnest = mesh
        .triangles()
        .into_iter()
        .map(|corners| area(mesh.points(), [corners]).projected_mm2)
        .fold(f64::INFINITY, f64::min);
    assert!(thinnest < 0.02 * PITCH_MM * PITCH_MM, "there should be thin ones: {thinnest}");
    let diagonal_mm = 0.5_f64.sqrt() * PITCH_MM;
    assert!(sampling.gap_max_mm.is_some_and(|gap| gap < 1.2 * diagonal_mm), "{sampling:?}");
}

#[test]
fn the_percentile_is_by_area() {
    // Two strips of the same raster: x below 98 with feature size 10, above with feature size 1.
    let mesh = meshed((0..1010).map(|i| [f64::from(i % 101), f64::from(i / 101), 0.0]));
    let lfs = |edge: f64| move |x: f64, _y: f64| if x <= edge { 10.0 } else { 1.0 };
    let gap = 0.5_f64.sqrt();
    let rough = figures(&mesh, &Criteria::default(), lfs(98.0));
    // A hundredth is half of the strip: what is beyond the discs that fill the other half.
    let half = (0.5 / std::f64::consts::PI).sqrt();
    assert!(near(rough.epsilon_p99, half) && close(rough.epsilon_max, gap));
    let rough = figures(&mesh, &Criteria::default(), lfs(99.0));
    // The strip is a hundredth: nearly all of the rest is below.
    let p99 = rough.epsilon_p99.unwrap();
    assert!((0.98..1.0).contains(&(p99 * 10.0 / gap)) && close(rough.epsilon_max, gap), "{p99}");
}

#[test]
fn nothing_to_assess() {
    let criteria = Criteria { gap_limit_mm: Some(1.0), ..Criteria::default() };
    let nothing = |criteria: &Criteria| *assess(&[], [], criteria, flat).sampling();
    assert_eq!(nothing(&criteria), Sampling::default());
    let criteria = Criteria { aperture_area_mm2: Some(3.0), ..criteria };
    assert_eq!(nothing(&criteria), Sampling { coverage: Some(0.0), ..Sampling::default() });
    for area_mm2 in [0.0, -1.0, f64::NAN] {
        let criteria = Criteria { aperture_area_mm2: Some(area_mm2), ..criteria };
        assert_eq!(nothing(&criteria).coverage, None);
    }
}

/// The largest distance from a place of the mesh to the nearest of all samples, over a lattice of
/// 66 places of each triangle.
fn farthest_place_mm(mesh: &Mesh) -> f64 {
    let points = mesh.points();
    let distance =
        |p: PointMm, q: PointMm| (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt();
    let shares = (0..=10).flat_map(|u| (0..=10 - u).map(move |v| (u, v)));
    let shares: Vec<(f64, f64)> =
        shares.map(|(u, v)| (f64::from(u) / 10.0, f64::from(v) / 10.0)).collect();
    let mut farthest = 0.0_f64;
    for corners in mesh.triangles() {
        let [p, q, r] = corners.map(|corner| points[corner as usize]);
        for &(u, v) in &shares {
            let place: PointMm = std::array::from_fn(|axis| {
                p[axis] + u * (q[axis] - p[axis]) + v * (r[axis] - p[axis])
            });
            let nearest = points.iter().map(|&point| distance(place, point));
            farthest = farthest.max(nearest.fold(f64::INFINITY, f64::min));
        }
    }
    farthest
}

#[test]
fn the_gap_is_a_close_bound_of_the_distance_to_the_nearest_sample() {
    let wavy = scattered(300, 2.0, 12).into_iter().map(|[x, y, _]| [x, y, (3.0 * x).sin()]);
    let rows = jittered_raster(18, 0.01, 13).into_iter();
    for mesh in [meshed(wavy), meshed(rows)] {
        let farthest_mm = farthest_place_mm(&mesh);
        let gap_mm = figures(&mesh, &Criteria::default(), flat).gap_max_mm.unwrap();
        assert!(farthest_mm <= gap_mm * (1.0 + 1e-12), "{farthest_mm} above {gap_mm}");
        assert!(farthest_mm >= 0.8 * gap_mm, "{farthest_mm} far below {gap_mm}");
    }
}

proptest! {
    #[test]
    fn figures_move_and_scale_with_the_surface(
        seed in 0_u64..1_000,
        angle in 0.0..6.0_f64,
        shift in prop::array::uniform3(-100.0..100.0),
        scale in 0.01..100.0_f64,
    ) {
        let mesh = meshed(scattered(200, 1.0, seed));
        let triangles: Vec<[VertexId; 3]> = mesh.triangles();
        let (sin, cos) = angle.sin_cos();
        let moved: Vec<PointMm> = mesh
            .points()
            .iter()
            .map(|&[x, y, z]| {
                let turned = [cos * x - sin * y, sin * x + cos * y, z];
                std::array::from_fn(|axis| scale * turned[axis] + shift[axis])
            })
            .collect();
        let still = figures(&mesh, &Criteria::default(), |_, _| 7.0);
        let moved = *assess(&moved, triangles, &Criteria::default(), |_, _| 7.0 * scale).sampling();
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-6;
        prop_assert!(near(moved.gap_max_mm.unwrap(), scale * still.gap_max_mm.unwrap()));
        prop_assert!(near(moved.epsilon_max.unwrap(), still.epsilon_max.unwrap()));
        prop_assert!(near(moved.epsilon_p99.unwrap(), still.epsilon_p99.unwrap()));
        prop_assert!(near(moved.area_mm2, scale * scale * still.area_mm2));
        prop_assert!(near(moved.coverage.unwrap(), 1.0));
    }
}

#[test]
fn the_areas_agree_with_those_of_the_mesh() {
    let mesh = meshed(raster(60));
    let sampling = figures(&mesh, &Criteria::default(), flat);
    let area = mesh.area();
    assert_eq!(sampling.area_mm2, area.lifted_mm2);
    assert_eq!(sampling.projected_area_mm2, area.projected_mm2);
}

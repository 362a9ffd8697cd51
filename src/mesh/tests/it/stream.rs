//! Points as instruments send them: scan patterns, repeats, conflicts, nonsense, and nothing.

use std::f64::consts::TAU;

use asphera_geometry::{PointMm, RANGE_MM, Rejection};
use asphera_mesh::{Area, BATCH_POINTS, Counts, Mesh, Outcome, check};
use proptest::prelude::*;

use crate::patterns::{PITCH_MM, jittered_raster, raster, scattered, spiral};

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.extend(points.iter().copied());
    mesh.flush();
    mesh
}

fn assert_sound(mesh: &Mesh) {
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
    let counts = mesh.counts();
    assert_eq!(mesh.triangles().len() as u64, counts.triangles);
    assert_eq!(
        counts.pushed,
        counts.vertices + counts.duplicates + counts.conflicts + counts.rejected + counts.pending
    );
}

#[test]
fn an_exact_raster() {
    let side = 200;
    let mesh = meshed(&raster(side));
    assert_sound(&mesh);
    let cells = (side as u64 - 1).pow(2);
    let counts = mesh.counts();
    assert_eq!((counts.vertices, counts.triangles), (40_000, 2 * cells));
    assert_eq!(counts.hull, 4 * (side as u64 - 1));
    let square_mm2 = (199.0 * PITCH_MM).powi(2);
    assert!((mesh.area().projected_mm2 - square_mm2).abs() < 1e-14);
    assert!(mesh.projectable());
}

#[test]
fn rings_about_a_centre() {
    let mut points = vec![[0.0; 3]];
    for ring in 1..=40 {
        let radius = f64::from(ring) * 0.1;
        points.extend((0..360).map(|step| {
            let angle = TAU * f64::from(step) / 360.0;
            [radius * angle.cos(), radius * angle.sin(), 0.01 * radius]
        }));
    }
    let mesh = meshed(&points);
    assert_sound(&mesh);
    let counts = mesh.counts();
    assert_eq!((counts.vertices, counts.triangles), (14_401, 360 * 79));
    assert_eq!(counts.hull, 360);
    // The regular 360-gon of circumradius 4.
    let polygon_mm2 = 180.0 * 16.0 * (TAU / 360.0).sin();
    assert!((mesh.area().projected_mm2 - polygon_mm2).abs() < 1e-12);
}

#[test]
fn a_fine_raster_far_away() {
    let points: Vec<PointMm> = (0..2_500)
        .map(|i| [1e6 + f64::from(i % 50) * 1e-3, -1e6 + f64::from(i / 50) * 1e-3, 5e5])
        .collect();
    let mesh = meshed(&points);
    assert_sound(&mesh);
    // Rounded to 1e-10 mm the rows bend: hull triangles thinner than that may come on top.
    assert!(mesh.counts().triangles >= 2 * 49 * 49, "{:?}", mesh.counts());
    let Area { lifted_mm2, projected_mm2 } = mesh.area();
    assert!((projected_mm2 - 0.049 * 0.049).abs() < 1e-10, "{projected_mm2}");
    assert!((lifted_mm2 - projected_mm2).abs() < 1e-15);
}

#[test]
fn counts_read_in_between_change_nothing() {
    for points in
        [raster(70), jittered_raster(70, 0.05, 1), spiral(5_000), scattered(5_000, 1.0, 2)]
    {
        let at_once = meshed(&points);
        let mut one_by_one = Mesh::new();
        for (index, &point) in points.iter().enumerate() {
            one_by_one.push(point);
            let counts = one_by_one.counts();
            assert_eq!(counts.pushed, index as u64 + 1);
            assert_eq!(counts.pending, counts.pushed % BATCH_POINTS as u64);
            assert_eq!(counts.vertices + counts.pending, counts.pushed);
        }
        one_by_one.flush();
        one_by_one.flush();
        assert_eq!(one_by_one.points(), at_once.points());
        assert!(one_by_one.triangles() == at_once.triangles());
        assert_sound(&at_once);
    }
}

#[test]
fn the_first_to_arrive_is_the_vertex() {
    // The middle of a batch is inserted before its fourth point, yet arrives later.
    let mut points = scattered(BATCH_POINTS, 1.0, 3);
    points[3] = [0.5, 0.5, 1.0];
    points[BATCH_POINTS / 2] = [0.5, 0.5, 1.0 + 0.9e-4];
    points[BATCH_POINTS / 2 + 1] = [0.5, 0.5, 1.25];
    points[BATCH_POINTS - 1] = [0.5, 0.5, 0.75];
    let mut mesh = Mesh::new();
    mesh.extend(points);
    mesh.push([0.5, 0.5, 1.0]);
    assert_eq!(mesh.outcome(BATCH_POINTS), Some(Outcome::Pending));
    mesh.flush();
    assert_eq!(mesh.outcome(3), Some(Outcome::Vertex(3)));
    assert_eq!(mesh.outcome(BATCH_POINTS / 2), Some(Outcome::Duplicate { of: 3 }));
    let above = Outcome::Conflict { of: 3, height_mm: 0.25 };
    assert_eq!(mesh.outcome(BATCH_POINTS / 2 + 1), Some(above));
    // The three that are no vertices leave no hole in the numbers.
    assert_eq!(mesh.outcome(BATCH_POINTS - 2), Some(Outcome::Vertex(BATCH_POINTS as u32 - 4)));
    let below = Outcome::Conflict { of: 3, height_mm: -0.25 };
    assert_eq!(mesh.outcome(BATCH_POINTS - 1), Some(below));
    assert_eq!(mesh.outcome(BATCH_POINTS), Some(Outcome::Duplicate { of: 3 }));
    assert_eq!(mesh.outcome(BATCH_POINTS + 1), None);
    let counts = mesh.counts();
    assert_eq!((counts.duplicates, counts.conflicts), (2, 2));
    assert!(!mesh.projectable());
    assert_sound(&mesh);
}

#[test]
fn the_tolerance_is_inclusive_and_a_setting() {
    let outcome = |tolerance_mm: f64| {
        let mut mesh = Mesh::with_conflict_tolerance(tolerance_mm);
        mesh.extend([[0.0, 0.0, 0.0], [-0.0, 0.0, 0.5]]);
        mesh.flush();
        mesh.outcome(1)
    };
    assert_eq!(outcome(0.5), Some(Outcome::Duplicate { of: 0 }));
    for tolerance_mm in [0.499, 0.0, -1.0, f64::NAN] {
        assert_eq!(outcome(tolerance_mm), Some(Outcome::Conflict { of: 0, height_mm: 0.5 }));
    }
}

#[test]
fn nothing_and_next_to_nothing() {
    let mut mesh = Mesh::default();
    mesh.flush();
    assert_eq!(mesh.counts(), Counts::default());
    assert_eq!((mesh.triangles().len(), mesh.area()), (0, Area::default()));
    assert_eq!(mesh.outcome(0), None);
    assert!(mesh.projectable());

    mesh.push([1.0, 2.0, 3.0]);
    mesh.flush();
    let one = Counts { pushed: 1, vertices: 1, hull: 1, ..Counts::default() };
    assert_eq!(mesh.counts(), one);

    mesh.push([1.0, 3.0, 3.0]);
    mesh.flush();
    assert_eq!(mesh.counts(), Counts { pushed: 2, vertices: 2, edges: 1, hull: 2, ..one });

    mesh.push([0.0, 0.0, 0.0]);
    mesh.flush();
    let three = Counts { pushed: 3, vertices: 3, triangles: 1, edges: 3, hull: 3, ..one };
    assert_eq!(mesh.counts(), three);
    assert_eq!(mesh.triangles().len(), 1);
    assert_sound(&mesh);
}

#[test]
fn nonsense_is_counted_and_changes_nothing() {
    let points = raster(40);
    let mut mesh = Mesh::new();
    for &point in &points {
        mesh.push([f64::NAN, 0.0, 0.0]);
        mesh.push(point);
        mesh.push([0.0, 2.0 * RANGE_MM, 0.0]);
    }
    mesh.flush();
    let clean = meshed(&points);
    assert!(mesh.triangles() == clean.triangles());
    assert_eq!(mesh.counts(), Counts { pushed: 4_800, rejected: 3_200, ..clean.counts() });
    assert_eq!(mesh.outcome(0), Some(Outcome::Rejected(Rejection::NotFinite)));
    assert_eq!(mesh.outcome(1), Some(Outcome::Vertex(0)));
    assert_eq!(mesh.outcome(2), Some(Outcome::Rejected(Rejection::OutOfRange)));
}

#[test]
fn the_ends_of_the_range() {
    let mut mesh = meshed(&[
        [RANGE_MM, RANGE_MM, RANGE_MM],
        [-RANGE_MM, RANGE_MM, -RANGE_MM],
        [0.0, -RANGE_MM, 0.0],
        [1e-300, 0.0, 0.0],
        [1e-39, 1e-39, 0.0],
        [-1e-39, 1e-39, 1e-39],
    ]);
    assert_sound(&mesh);
    assert_eq!(mesh.points()[3], [0.0; 3]);
    assert!(mesh.area().lifted_mm2.is_finite());
    mesh.push([0.0, -1e-300, 0.0]);
    mesh.flush();
    assert_eq!(mesh.outcome(6), Some(Outcome::Duplicate { of: 3 }));
}

#[test]
fn a_long_profile_and_then_a_surface() {
    let count: u32 = 100_000;
    let mut mesh = Mesh::new();
    // Back and forth: the second pass repeats the first.
    let profile = (0..count).chain((0..count).rev());
    mesh.extend(profile.map(|i| [f64::from(i) * 0.25, f64::from(i) * 0.5, 0.0]));
    mesh.flush();
    let line = mesh.counts();
    let count = u64::from(count);
    assert_eq!((line.vertices, line.duplicates, line.triangles), (count, count, 0));
    assert_eq!((line.edges, line.hull), (count - 1, count));
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));

    mesh.push([0.0, 1e4, 0.0]);
    mesh.flush();
    assert_sound(&mesh);
    let fan = mesh.counts();
    assert_eq!((fan.triangles, fan.hull), (count - 1, count + 1));

    mesh.extend((0..5_000).map(|i| [f64::from(i) * 0.25 + 1.0, f64::from(i) * 0.5, 0.0]));
    mesh.flush();
    assert_sound(&mesh);
    assert_eq!(mesh.counts().vertices, count + 5_001);
}

proptest! {
    #[test]
    fn every_point_is_accounted_for(
        pushed in prop::collection::vec(
            (0_u8..6, 0_u8..6, prop::sample::select(vec![0.0, 0.5, f64::NAN, 1e13])),
            0..100,
        ),
        flush_every in 1_usize..50,
    ) {
        let mut mesh = Mesh::with_conflict_tolerance(0.1);
        for (index, &(x, y, z)) in pushed.iter().enumerate() {
            mesh.push([x.into(), y.into(), z]);
            if index % flush_every == 0 {
                mesh.flush();
            }
        }
        mesh.flush();
        assert_sound(&mesh);
        let mut vertices = 0;
        for (index, &(x, y, z)) in pushed.iter().enumerate() {
            match mesh.outcome(index).unwrap() {
                Outcome::Vertex(id) => {
                    prop_assert_eq!(id, vertices);
                    prop_assert_eq!(mesh.points()[id as usize], [x.into(), y.into(), z]);
                    vertices += 1;
                }
                Outcome::Duplicate { of } => {
                    prop_assert_eq!(mesh.points()[of as usize], [x.into(), y.into(), z]);
                }
                Outcome::Conflict { of, height_mm } => {
                    let below = mesh.points()[of as usize];
                    prop_assert_eq!(below, [x.into(), y.into(), z - height_mm]);
                    prop_assert_eq!(height_mm.abs(), 0.5);
                }
                Outcome::Rejected(Rejection::NotFinite) => prop_assert!(z.is_nan()),
                Outcome::Rejected(Rejection::OutOfRange) => prop_assert_eq!(z, 1e13),
                outcome @ (Outcome::Pending | Outcome::Withdrawn(_)) => {
                    prop_assert!(false, "{} is {:?}", index, outcome);
                }
            }
        }
        prop_assert_eq!(u64::from(vertices), mesh.counts().vertices);
    }
}

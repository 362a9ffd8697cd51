use asphera_geometry::VertexId;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use super::*;
use crate::assess;

fn unit(random: &mut Pcg64) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A serpentine over a dome with a hole, and a coarse stripe.
fn scan(lines: usize, seed: u64) -> Vec<PointMm> {
    let mut random = Pcg64::seed_from_u64(seed);
    let mut points = Vec::new();
    for line in 0..lines {
        for step in 0..lines {
            let step = if line % 2 == 0 { step } else { lines - 1 - step };
            let [x, y] = [step, line].map(|index| index as f64 + 0.1 * unit(&mut random));
            let hole = (x - 30.0).hypot(y - 40.0) < 6.0;
            let thinned = (50.0..60.0).contains(&y) && line % 3 != 0;
            if !hole && !thinned {
                points.push([x, y, -(x * x + y * y) / 400.0]);
            }
        }
    }
    points
}

const CRITERIA: Criteria =
    Criteria { gap_limit_mm: Some(2.5), epsilon_limit: Some(0.011), aperture_area_mm2: None };

fn inside(x: f64, y: f64) -> bool {
    (x - 40.0).hypot(y - 40.0) < 33.0
}

/// With a gradient, as a real one has.
fn lfs_mm(x: f64, y: f64) -> f64 {
    120.0 + 0.4 * x - 0.3 * y
}

fn assessed(mesh: &Mesh) -> Sampling {
    let points = mesh.points();
    let triangles = mesh.triangles().into_iter().filter(|corners| {
        let [x, y] = [0, 1].map(|axis| {
            let [p, q, r] = corners.map(|corner| points[corner as usize][axis]);
            (p + q + r) / 3.0
        });
        inside(x, y)
    });
    *assess(points, triangles, &CRITERIA, lfs_mm).sampling()
}

fn near(left: f64, right: f64, share: f64) -> bool {
    (left - right).abs() <= share * right.abs()
}

/// Against the assessment of the whole: all is the same but for what is simplified to the safe side.
/// `far` is how much larger ε p99 may be.
fn assert_as_assessed(found: &Sampling, mesh: &Mesh, far: f64) {
    let expected = assessed(mesh);
    assert_eq!(found.gap_max_mm.is_some(), expected.gap_max_mm.is_some());
    assert!(near(found.area_mm2, expected.area_mm2, 1e-12), "{found:?} {expected:?}");
    assert!(near(found.projected_area_mm2, expected.projected_area_mm2, 1e-12));
    let Some(expected_gap_mm) = expected.gap_max_mm else { return };
    assert!(found.gap_max_mm.is_some_and(|gap_mm| gap_mm >= expected_gap_mm * (1.0 - 1e-14)));
    // ε is never smaller, and larger only by what the local feature size may be smaller at a corner.
    let (epsilon, expected_epsilon) = (found.epsilon_max.unwrap(), expected.epsilon_max.unwrap());
    assert!(epsilon >= expected_epsilon * (1.0 - 1e-12), "{epsilon} below {expected_epsilon}");
    assert!(
        epsilon <= expected_epsilon / (1.0 - 4.0 * expected_epsilon),
        "{epsilon} far above {expected_epsilon}"
    );
    let (p99, expected_p99) = (found.epsilon_p99.unwrap(), expected.epsilon_p99.unwrap());
    assert!((1.0 - 1e-12..far).contains(&(p99 / expected_p99)), "{p99}, {expected_p99}");
    let counts = found.triangles;
    assert_eq!(
        counts.good + counts.over_gap + counts.over_epsilon,
        expected.triangles.good + expected.triangles.over_gap + expected.triangles.over_epsilon
    );
    assert!(counts.good <= expected.triangles.good, "{found:?} {expected:?}");
    assert!(found.undersampled_area_mm2 >= expected.undersampled_area_mm2 * (1.0 - 1e-12));
    assert!(found.coverage.unwrap() <= expected.coverage.unwrap() + 1e-12);
    assert!(found.coverage.unwrap() >= expected.coverage.unwrap() - 0.02, "{found:?} {expected:?}");
}

#[test]
fn looked_at_in_between_or_not_the_figures_are_the_same_and_as_assessed() {
    for (seed, batch) in [(1, 100), (2, 37), (3, 1000), (4, 5000)] {
        let points = scan(80, seed);
        let mut mesh = Mesh::new();
        let mut often = RunningSampling::new();
        for (index, batch) in points.chunks(batch).enumerate() {
            mesh.insert(batch);
            if index % 3 == 0 {
                let found = often.update(&mesh, &CRITERIA, inside, lfs_mm);
                let once = RunningSampling::new().update(&mesh, &CRITERIA, inside, lfs_mm);
                assert_eq!(found, once, "batch {index} of {batch:?}", batch = batch.len());
            }
        }
        let found = often.update(&mesh, &CRITERIA, inside, lfs_mm);
        assert_eq!(found, RunningSampling::new().update(&mesh, &CRITERIA, inside, lfs_mm));
        assert_as_assessed(&found, &mesh, 1.3);
    }
}

#[test]
fn points_in_no_order_withdrawals_and_heights_are_taken_in() {
    let mut random = Pcg64::seed_from_u64(5);
    let mut points = scan(70, 6);
    for index in (1..points.len()).rev() {
        points.swap(index, (random.next_u64() % (index as u64 + 1)) as usize);
    }
    let mut mesh = Mesh::new();
    let mut running = RunningSampling::new();
    for batch in points.chunks(300) {
        mesh.insert(batch);
        let count = mesh.points().len() as u64;
        for _ in 0..20 {
            let vertex = (random.next_u64() % count) as VertexId;
            // It may have been withdrawn before.
            let _ = mesh.remove(vertex);
        }
        running.update(&mesh, &CRITERIA, inside, lfs_mm);
        let vertex = (0..count as VertexId).find(|&vertex| mesh.is_vertex(vertex)).unwrap();
        mesh.set_height(vertex, -30.0 * unit(&mut random)).unwrap();
        let found = running.update(&mesh, &CRITERIA, inside, lfs_mm);
        let once = RunningSampling::new().update(&mesh, &CRITERIA, inside, lfs_mm);
        assert_eq!(found, once);
    }
    assert_as_assessed(&running.update(&mesh, &CRITERIA, inside, lfs_mm), &mesh, 1.3);
}

#[test]
fn of_nothing_and_next_to_nothing() {
    let mut mesh = Mesh::new();
    let mut running = RunningSampling::new();
    assert_eq!(running.update(&mesh, &CRITERIA, inside, lfs_mm), Sampling::default());
    mesh.insert(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
    assert_eq!(running.update(&mesh, &CRITERIA, inside, lfs_mm), Sampling::default());
    mesh.insert(&[[1.0, 1.0, 0.0], [1.0, 1.0, 0.0]]);
    let found = running.update(&mesh, &CRITERIA, |_, _| true, lfs_mm);
    assert_eq!((found.projected_area_mm2, found.triangles.good), (1.0, 2));
    // Unknown is not good.
    running.restart();
    let found = running.update(&mesh, &CRITERIA, |_, _| true, |_, _| f64::NAN);
    assert_eq!((found.epsilon_max, found.triangles.good), (Some(f64::INFINITY), 0));
}

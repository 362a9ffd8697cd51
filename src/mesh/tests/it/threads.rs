//! One thread, two, or more: the same mesh. The threads of a pool of eight meet on two processors more
//! often than they would alone.

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, check};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::patterns::{jittered_raster, raster, scattered};
use crate::random::Random;

fn pool(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool can be made")
}

fn meshed(points: &[PointMm], batch: usize) -> Mesh {
    let mut mesh = Mesh::new();
    for points in points.chunks(batch) {
        mesh.insert(points);
    }
    mesh
}

/// In an order that means nothing.
fn shuffled(mut points: Vec<PointMm>, seed: u64) -> Vec<PointMm> {
    let mut random = Random::new(seed);
    for index in (1..points.len()).rev() {
        points.swap(index, (random.unit() * (index + 1) as f64) as usize);
    }
    points
}

/// A few dense heaps far apart.
fn heaps(count: usize, seed: u64) -> Vec<PointMm> {
    let mut random = Random::new(seed);
    let heap = |index: usize| [(index % 7) as f64 * 100.0, (index % 3) as f64 * 1e4];
    (0..count)
        .map(|index| {
            let [x, y] = heap(index);
            [x + random.normal(), y + random.normal(), 0.0]
        })
        .collect()
}

/// Each place is measured about three times.
fn repeated(count: usize, seed: u64) -> Vec<PointMm> {
    let mut random = Random::new(seed);
    let places = scattered(count / 3, 10.0, seed);
    (0..count)
        .map(|index| {
            let [x, y, _] = places[(random.unit() * places.len() as f64) as usize];
            [x, y, index as f64]
        })
        .collect()
}

#[test]
fn scattered_points_of_every_kind_give_the_same_mesh_with_any_number_of_threads() {
    let pools = [2, 8].map(pool);
    let one = pool(1);
    for seed in 0..6 {
        for (name, points) in [
            ("scattered", scattered(6_000, 10.0, seed)),
            ("raster", shuffled(raster(77), seed)),
            ("jittered", shuffled(jittered_raster(77, 0.05, seed), seed)),
            ("heaps", heaps(6_000, seed)),
            ("repeated", repeated(6_000, seed)),
        ] {
            for batch in [300, 1_000, 6_000] {
                let alone = one.install(|| meshed(&points, batch));
                assert_eq!(check::delaunay(alone.points(), alone.triangles()), Ok(()), "{name}");
                for pool in &pools {
                    let mesh = pool.install(|| meshed(&points, batch));
                    let threads = pool.current_num_threads();
                    let case = format!("{name} {seed} by {batch} with {threads} threads");
                    assert!(mesh.points() == alone.points(), "{case}: the vertices differ");
                    assert!(mesh.triangles() == alone.triangles(), "{case}: the triangles differ");
                    assert_eq!(mesh.counts(), alone.counts(), "{case}");
                }
            }
        }
    }
}

/// A large batch is shared as two blocks; one of them goes over to rounds, which two threads share as a rule.
#[test]
fn a_block_that_ends_in_no_order_gives_the_same_mesh_with_any_number_of_threads() {
    for seed in 0..4 {
        let mut points: Vec<PointMm> = (0..6_000)
            .map(|index| {
                let (row, step) = (index / 50, index % 50);
                let column = if row % 2 == 0 { step } else { 49 - step };
                [f64::from(column), f64::from(row), 0.0]
            })
            .collect();
        points.extend(scattered(3_600, 50.0, seed).into_iter().map(|[x, y, z]| [x, y + 130.0, z]));
        let alone = pool(1).install(|| meshed(&points, points.len()));
        assert_eq!(check::delaunay(alone.points(), alone.triangles()), Ok(()));
        for threads in [2, 8] {
            let mesh = pool(threads).install(|| meshed(&points, points.len()));
            assert!(mesh.triangles() == alone.triangles(), "seed {seed}, {threads} threads");
        }
    }
}

/// Traced curves, by batches of which most go over to rounds.
#[test]
fn traced_curves_give_the_same_mesh_with_any_number_of_threads() {
    let turns = |count: usize| {
        (0..count)
            .map(move |index| (index as f64, std::f64::consts::TAU * index as f64 / count as f64))
    };
    let inwards = |(_, t): (f64, f64)| {
        let left = (1.0 - t / std::f64::consts::TAU).sqrt();
        let angle = 6.0 * std::f64::consts::TAU * left;
        [left * angle.cos(), left * angle.sin(), 0.0]
    };
    let star = |(_, t): (f64, f64)| {
        let spike = (3.0 * t / std::f64::consts::PI).rem_euclid(2.0) - 1.0;
        let radius = 1.0 + spike.abs();
        [radius * t.cos(), radius * t.sin(), 0.0]
    };
    let far = |(index, t): (f64, f64)| [t.cos() + 100.0 * (index % 2.0), t.sin(), 0.0];
    let parabola = |(_, t): (f64, f64)| [t - 3.0, 5.0 * (t - 3.0) * (t - 3.0), 0.0];
    for (name, points) in [
        ("spiral inwards", turns(9_000).map(inwards).collect::<Vec<PointMm>>()),
        ("star", turns(9_000).map(star).collect()),
        ("far circles by turns", turns(9_000).map(far).collect()),
        ("parabola", turns(9_000).map(parabola).collect()),
    ] {
        let once = pool(1).install(|| meshed(&points, points.len()));
        assert_eq!(check::delaunay(once.points(), once.triangles()), Ok(()), "{name}");
        for threads in [1, 2, 8] {
            for batch in [500, 3_000, 9_000] {
                let mesh = pool(threads).install(|| meshed(&points, batch));
                let case = format!("{name} by {batch} with {threads} threads");
                assert!(mesh.triangles() == once.triangles(), "{case}");
            }
        }
    }
}

/// Points one after the other along an Archimedean spiral, from the inside.
fn spiral(count: usize) -> Vec<PointMm> {
    let at = |index: usize| {
        let angle = (2.0 * std::f64::consts::TAU * index as f64).sqrt();
        let radius = 0.003 * angle / std::f64::consts::TAU;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    };
    (0..count).map(at).collect()
}

/// Rings of 400 points from the inside, every other one the other way round if they turn.
fn rings(count: usize, turning: bool) -> Vec<PointMm> {
    let at = |index: usize| {
        let (ring, step) = (index / 400, index % 400);
        let step = if turning && ring % 2 == 1 { 399 - step } else { step };
        let angle = step as f64 / 400.0 * std::f64::consts::TAU;
        let radius = 0.003 * (ring + 1) as f64;
        [radius * angle.cos(), radius * angle.sin(), 0.0]
    };
    (0..count).map(at).collect()
}

/// Lines of 250 points, all in the same direction, turned by an angle and far from the origin.
fn lines(count: usize, angle: f64, origin: f64) -> Vec<PointMm> {
    let mut random = Random::new(7);
    let (sin, cos) = angle.sin_cos();
    let mut at = |index: usize| {
        let along = (index % 250) as f64 + 0.1 * random.unit();
        let off = 1.5 * (index / 250) as f64;
        [origin + 0.003 * (along * cos - off * sin), 0.003 * (along * sin + off * cos), 0.0]
    };
    (0..count).map(&mut at).collect()
}

/// The same without some points, with some twice, and with lines that are broken off.
fn damaged(points: &[PointMm]) -> Vec<PointMm> {
    let mut random = Random::new(3);
    let mut kept = Vec::new();
    let mut gap = 0_usize;
    for &point in points {
        let chance = random.unit();
        if chance < 0.002 {
            gap = (random.unit() * 60.0) as usize;
        }
        gap = gap.saturating_sub(1);
        if gap == 0 {
            kept.push(point);
        }
        if chance > 0.999 {
            kept.push([point[0], point[1], 1.0]);
        }
    }
    kept
}

#[test]
fn scans_by_large_batches_give_the_same_mesh_with_any_number_of_threads() {
    let pools = [2, 8].map(pool);
    let one = pool(1);
    let reversed = |mut points: Vec<PointMm>| {
        points.reverse();
        points
    };
    let twice = |points: Vec<PointMm>| [&points[..], &points[..20_000]].concat();
    for (name, points) in [
        ("raster", raster(180)),
        ("jittered", jittered_raster(180, 0.05, 1)),
        ("spiral", spiral(30_000)),
        ("spiral inwards", reversed(spiral(30_000))),
        ("rings", rings(30_000, false)),
        ("rings that turn", rings(30_000, true)),
        ("rings inwards", reversed(rings(30_000, false))),
        ("lines", lines(30_000, 0.0, 0.0)),
        ("lines at a slant", lines(30_000, 0.7, 0.0)),
        ("lines far away", lines(30_000, 0.2, 1e7)),
        ("lines, damaged", damaged(&lines(30_000, 0.1, 0.0))),
        ("raster, damaged", damaged(&raster(180))),
        ("spiral, damaged", damaged(&spiral(30_000))),
        ("the same lines twice", twice(lines(25_000, 0.0, 0.0))),
        ("lines across lines", [lines(15_000, 0.0, 0.0), lines(15_000, 1.4, 0.0)].concat()),
        ("all on one line", (0..30_000).map(|i| [f64::from(i), 0.0, 0.0]).collect()),
    ] {
        let alone = one.install(|| meshed(&points, 1_000));
        assert_eq!(check::delaunay(alone.points(), alone.triangles()), Ok(()), "{name}");
        for batch in [9_000, 30_000] {
            for pool in &pools {
                let mesh = pool.install(|| meshed(&points, batch));
                let case = format!("{name} by {batch} with {} threads", pool.current_num_threads());
                assert!(mesh.points() == alone.points(), "{case}: the vertices differ");
                assert!(mesh.triangles() == alone.triangles(), "{case}: the triangles differ");
                assert_eq!(mesh.counts(), alone.counts(), "{case}");
            }
        }
    }
}

#[test]
fn points_that_are_no_vertices_are_told_from_the_others_in_a_large_batch() {
    let mut points = lines(30_000, 0.0, 0.0);
    points[12_345] = [f64::NAN, 0.0, 0.0];
    points[25_000] = [0.0, 2e12, 0.0];
    points[20_000] = points[19_000];
    let [alone, mesh] = [1, 2].map(|threads| pool(threads).install(|| meshed(&points, 30_000)));
    assert_eq!((mesh.counts().rejected, mesh.counts().duplicates), (2, 1));
    assert!(mesh.points() == alone.points() && mesh.triangles() == alone.triangles());
    assert!((0..30_000).all(|index| mesh.outcome(index) == alone.outcome(index)));
}

/// The table by which triangles are found names some that were changed since, and some that are none.
#[test]
fn vertices_may_be_withdrawn_between_the_batches() {
    let [one, two] = [1, 2].map(pool);
    let points = shuffled(raster(60), 1);
    let edited = || {
        let mut mesh = Mesh::new();
        for batch in points.chunks(400) {
            mesh.insert(batch);
            let some: Vec<VertexId> = mesh.vertices().step_by(3).collect();
            for vertex in some {
                mesh.remove(vertex).expect("it is a vertex");
            }
        }
        mesh.insert(&points);
        mesh
    };
    let (alone, mesh) = (one.install(edited), two.install(edited));
    assert!(mesh.triangles() == alone.triangles());
    assert_eq!(mesh.counts(), alone.counts());
}

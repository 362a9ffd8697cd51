//! One thread, two, or more: the same mesh. The threads of a pool of eight meet on two processors more
//! often than they would alone.

use asphera_surface::{Mesh, PointMm, VertexId, check};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::patterns::{jittered_raster, raster, scattered};
use crate::shapes::Random;

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

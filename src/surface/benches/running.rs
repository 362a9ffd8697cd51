//! What it costs to keep the sampling of a growing mesh current, against the mesh itself.
//!
//! `cargo bench -p asphera-surface --bench running` meshes 1,044,336 points of a raster and of a spiral, 0.01 mm
//! apart, in batches of 1,000, and brings the sampling up to date after every batch, after every 20 (five times a
//! second at 100,000 points a second), and at the end. One thread unless `RAYON_NUM_THREADS` says otherwise;
//! medians of 5 runs. `ASPHERA_BENCH_POINTS` sets another number of points.

use std::f64::consts::TAU;
use std::time::Instant;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::{Criteria, RunningSampling};

const PITCH_MM: f64 = 0.01;
const RADIUS_MM: f64 = 20.0;
const BATCH: usize = 1_000;
const RUNS: usize = 5;

#[expect(clippy::print_stdout, reason = "a benchmark prints what it measures")]
fn main() {
    let count = std::env::var("ASPHERA_BENCH_POINTS").map_or(1_044_336, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    });
    println!("{count} points, batches of {BATCH}, {} threads", rayon::current_num_threads());
    for (name, points) in [("raster", raster(count)), ("spiral", spiral(count))] {
        for every in [1, 20, count.div_ceil(BATCH)] {
            let mut runs: Vec<[f64; 2]> = (0..RUNS).map(|_| run(&points, every)).collect();
            runs.sort_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])));
            let [mesh_s, sampling_s] = runs[RUNS / 2];
            println!(
                "{name}: mesh {:.1} ms, sampling every {} points {:.1} ms, ratio {:.2}",
                1e3 * mesh_s,
                every * BATCH,
                1e3 * sampling_s,
                sampling_s / mesh_s
            );
        }
    }
}

/// Seconds of the mesh and of the sampling, which is looked at after every so many batches and at the end.
#[expect(clippy::disallowed_methods, reason = "a benchmark looks at the clock")]
fn run(points: &[PointMm], every: usize) -> [f64; 2] {
    let criteria = Criteria {
        gap_limit_mm: Some(4.0 * PITCH_MM),
        epsilon_limit: Some(0.05),
        aperture_area_mm2: None,
    };
    let (mut mesh, mut sampling) = (Mesh::new(), RunningSampling::new());
    let (mut mesh_s, mut sampling_s) = (0.0, 0.0);
    let last = points.len().div_ceil(BATCH);
    for (number, batch) in (1..).zip(points.chunks(BATCH)) {
        let begun = Instant::now();
        mesh.insert(batch);
        mesh_s += begun.elapsed().as_secs_f64();
        if number % every == 0 || number == last {
            let begun = Instant::now();
            let found =
                sampling.update(&mesh, &criteria, |x, y| x.hypot(y) < 1e3, |_, _| RADIUS_MM);
            sampling_s += begun.elapsed().as_secs_f64();
            assert!(found.triangles.good > 0);
        }
    }
    [mesh_s, sampling_s]
}

/// Lines to and fro, every place moved by up to 5 % of the pitch.
fn raster(count: usize) -> Vec<PointMm> {
    let side = (count as f64).sqrt() as usize;
    let mut state = 7_u64;
    let mut moved = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (0.1 * ((state >> 11) as f64 / (1_u64 << 53) as f64) - 0.05) * PITCH_MM
    };
    (0..side * side)
        .map(|index| {
            let (row, along) = (index / side, index % side);
            let column = if row % 2 == 0 { along } else { side - 1 - along };
            let middle = 0.5 * side as f64;
            lifted(
                (column as f64 - middle) * PITCH_MM + moved(),
                (row as f64 - middle) * PITCH_MM + moved(),
            )
        })
        .collect()
}

/// An Archimedean spiral from the centre.
fn spiral(count: usize) -> Vec<PointMm> {
    (0..count)
        .map(|index| {
            let turn = (2.0 * TAU * index as f64).sqrt();
            let r_mm = PITCH_MM * turn / TAU;
            lifted(r_mm * turn.cos(), r_mm * turn.sin())
        })
        .collect()
}

/// On a sphere.
fn lifted(x_mm: f64, y_mm: f64) -> PointMm {
    let square = x_mm * x_mm + y_mm * y_mm;
    [x_mm, y_mm, square / (RADIUS_MM + (RADIUS_MM * RADIUS_MM - square).sqrt())]
}

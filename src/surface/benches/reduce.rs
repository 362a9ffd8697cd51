//! What is left of the two measured lenses, and what reducing costs.
//!
//! `cargo bench -p asphera-surface --bench reduce` runs them at full size.

use asphera_surface::reduce::{
    Reducer, Target, average, crumpled_fraction, noise_limit_mm, noise_of, reduce, spread,
};
use asphera_surface::{Criteria, Mesh, PointMm, assess};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

#[path = "../tests/it/lenses.rs"]
mod lenses;

/// Points of the first lens along each axis.
const GRID_SIDE: usize = 1668;
/// Points of the second.
const SPIRAL_POINTS: usize = 1_044_336;
const LENSES: [&str; 2] = ["grid", "spiral"];
/// Standard deviation of the simulated noise.
const SIGMA_MM: f64 = 20e-6;
const EPSILON: f64 = 0.05;

fn main() {
    table();
    divan::main();
}

#[expect(clippy::print_stdout, reason = "figures are what this program is for")]
fn table() {
    for (lens, epsilon, sigma_mm) in [
        ("grid", 0.05, 20e-6),
        ("grid", 0.005, 20e-6),
        ("grid", 0.0007, 0.62e-6),
        ("spiral", 0.05, 20e-6),
        ("spiral", 0.005, 20e-6),
        ("spiral", 0.004, 20e-6),
    ] {
        let mesh = meshed(&points(lens, sigma_mm));
        let target = target(epsilon, sigma_mm);
        let noise = noise_of(&mesh).map_or(0.0, |noise| noise.sigma_mm);
        let crumpled = |mesh: &Mesh| {
            let found = crumpled_fraction(
                mesh.points(),
                mesh.triangles(),
                &target,
                sigma_mm,
                lenses::lfs_mm,
            );
            100.0 * found.unwrap_or(0.0)
        };
        let before = crumpled(&mesh);
        let reduction = reduce(mesh.points(), mesh.triangles(), &target, lenses::lfs_mm);
        let kept: Vec<PointMm> =
            reduction.kept.iter().map(|&index| mesh.points()[index as usize]).collect();
        let reduced = meshed(&kept);
        let lfs_mm = |x: f64, y: f64| lenses::lfs_mm([x, y, 0.0]).unwrap_or(0.0);
        let survey = assess(reduced.points(), reduced.triangles(), &Criteria::default(), lfs_mm);
        println!(
            "{lens}: ε {epsilon}, σ {:.2} nm (found {:.2}), noise limit {:.1} µm at the vertex: {} of {} points, \
             crumpled {before:.1} % before, {:.1} % after, largest ε after {:.5}, area {:.4} of {:.4} mm², {:?}, {:?}",
            1e6 * sigma_mm,
            1e6 * noise,
            1e3 * noise_limit_mm(sigma_mm, 11.65),
            kept.len(),
            mesh.points().len(),
            crumpled(&reduced),
            survey.sampling().epsilon_max.unwrap_or(0.0),
            reduced.area().projected_mm2,
            mesh.area().projected_mm2,
            spread(&kept),
            reduction.tally,
        );
    }
}

fn target(epsilon: f64, sigma_mm: f64) -> Target {
    Target::new(epsilon, 20.0)
        .and_then(|target| target.with_noise(sigma_mm))
        .expect("the figures above make a target")
}

fn points(lens: &str, sigma_mm: f64) -> Vec<PointMm> {
    match lens {
        "grid" => lenses::grid_lens(GRID_SIDE, sigma_mm, 1),
        _ => lenses::spiral_lens(SPIRAL_POINTS, sigma_mm, 2),
    }
}

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    mesh
}

/// Items are points, as they arrive; the gap is that of the scan.
#[divan::bench(args = LENSES, consts = [5, 50, 1000], sample_count = 3, sample_size = 1)]
fn reducer<const PER_10000: u32>(bencher: Bencher, lens: &str) {
    let points = points(lens, SIGMA_MM);
    let epsilon = f64::from(PER_10000) * 1e-4;
    let target = target(epsilon, 0.0);
    let gap_mm = if lens == "grid" { 0.0022 } else { 0.012 };
    bencher.counter(ItemsCount::new(points.len())).bench(|| {
        let mut reducer = Reducer::new();
        for &point in black_box(&points) {
            reducer.take(point, target.spacing(lenses::lfs_mm(point), gap_mm));
        }
        reducer.arrivals().len()
    });
}

/// Items are points of a finished mesh.
#[divan::bench(args = LENSES, sample_count = 3, sample_size = 1)]
fn whole(bencher: Bencher, lens: &str) {
    let mesh = meshed(&points(lens, SIGMA_MM));
    let triangles = mesh.triangles();
    let target = target(EPSILON, SIGMA_MM);
    bencher
        .counter(ItemsCount::new(mesh.points().len()))
        .bench(|| reduce(mesh.points(), triangles.iter().copied(), &target, lenses::lfs_mm));
}

/// Items are points averaged into those kept.
#[divan::bench(args = LENSES, sample_count = 3, sample_size = 1)]
fn averaged(bencher: Bencher, lens: &str) {
    let mesh = meshed(&points(lens, SIGMA_MM));
    let target = target(0.005, SIGMA_MM);
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, lenses::lfs_mm);
    let kept: Vec<PointMm> =
        reduction.kept.iter().map(|&index| mesh.points()[index as usize]).collect();
    bencher
        .counter(ItemsCount::new(mesh.points().len()))
        .bench(|| average(mesh.points(), &kept, SIGMA_MM, lenses::lfs_mm));
}

//! What is left of the two measured lenses, and what reducing costs.
//!
//! `cargo bench -p asphera-surface --bench reduce` runs them at full size.

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::noise::{Along, Noise, assess_spacing};
use asphera_surface::reduce::{About, Keep, Reducer, Target, average, reduce, spread};
use asphera_surface::{Criteria, assess};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

#[path = "../tests/it/lenses.rs"]
#[expect(dead_code, reason = "the tests measure more of the lenses")]
mod lenses;

/// Points of the first lens along each axis.
const GRID_SIDE: usize = 1668;
/// Points of the second.
const SPIRAL_POINTS: usize = 1_044_336;
const LENSES: [&str; 2] = ["grid", "spiral"];
/// Standard deviation of the simulated noise: see `README.md`.
const SIGMAS_MM: [f64; 2] = [100e-6, 650e-6];
const EPSILON: f64 = 0.05;

fn main() {
    table();
    divan::main();
}

/// What `README.md` shows.
#[expect(clippy::print_stdout, reason = "figures are what this program is for")]
fn table() {
    println!(
        "| lens | σ in nm | keep | points | too dense before | kept | median spacing in µm | too dense after | largest ε after |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for (lens, sigma_mm) in LENSES.into_iter().zip(SIGMAS_MM) {
        let mesh = meshed(&points(lens, sigma_mm));
        for keep in [Keep::Fewest, Keep::Truest, Keep::Most] {
            let target = target(sigma_mm).keeping(keep);
            let (before, _) = condition(&mesh, &target);
            let reduction = reduce(mesh.points(), mesh.triangles(), &target, lenses::lfs_mm);
            let kept: Vec<PointMm> =
                reduction.retained.iter().map(|&index| mesh.points()[index as usize]).collect();
            let (after, epsilon) = condition(&meshed(&kept), &target);
            println!(
                "| {lens} | {:.0} | {keep:?} | {} | {:.1} % | {} | {:.2} | {:.1} % | {epsilon:.5} |",
                1e6 * sigma_mm,
                mesh.points().len(),
                100.0 * before,
                kept.len(),
                1e3 * spread(&kept).map_or(0.0, |spread| spread.median_mm),
                100.0 * after,
            );
        }
    }
}

/// The share that is too dense for the noise, and the largest ε.
fn condition(mesh: &Mesh, target: &Target) -> (f64, f64) {
    let lfs_mm = |x: f64, y: f64| lenses::lfs_mm([x, y, 0.0]).unwrap_or(0.0);
    let (points, noise) = (mesh.points(), target.noise());
    let spacing = assess_spacing(points, mesh.triangles(), target.criteria(), |_, _| noise, lfs_mm);
    let survey = assess(points, mesh.triangles(), &Criteria::default(), lfs_mm);
    (
        spacing.overdense_fraction.unwrap_or(f64::NAN),
        survey.sampling().epsilon_max.unwrap_or(f64::NAN),
    )
}

fn target(sigma_mm: f64) -> Target {
    let noise = Noise::new(sigma_mm, Along::Z).expect("a length");
    Target::new(EPSILON, 20.0)
        .and_then(|target| target.with_noise(noise))
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

fn noisy(lens: &str) -> (Vec<PointMm>, Target) {
    let sigma_mm = if lens == LENSES[0] { SIGMAS_MM[0] } else { SIGMAS_MM[1] };
    (points(lens, sigma_mm), target(sigma_mm))
}

/// Items are points, as they arrive; the gap is that of the scan.
#[divan::bench(args = LENSES, consts = [false, true], sample_count = 3, sample_size = 1)]
fn reducer<const MOST: bool>(bencher: Bencher, lens: &str) {
    let (points, target) = noisy(lens);
    let target = target.keeping(if MOST { Keep::Most } else { Keep::Fewest });
    let gap_mm = if lens == LENSES[0] { 0.0022 } else { 0.012 };
    let about = About { gap_mm, gap_nearby_mm: gap_mm, cosine: 0.9 };
    bencher.counter(ItemsCount::new(points.len())).bench(|| {
        let mut reducer = Reducer::new();
        for &point in black_box(&points) {
            reducer.take(point, target.spacing(lenses::lfs_mm(point), about));
        }
        reducer.arrivals().len()
    });
}

/// Items are points of a finished mesh.
#[divan::bench(args = LENSES, consts = [false, true], sample_count = 3, sample_size = 1)]
fn whole<const MOST: bool>(bencher: Bencher, lens: &str) {
    let (points, target) = noisy(lens);
    let target = target.keeping(if MOST { Keep::Most } else { Keep::Fewest });
    let mesh = meshed(&points);
    let triangles = mesh.triangles();
    bencher
        .counter(ItemsCount::new(mesh.points().len()))
        .bench(|| reduce(mesh.points(), triangles.iter().copied(), &target, lenses::lfs_mm));
}

/// The check alone; items are points of a finished mesh.
#[divan::bench(args = LENSES, sample_count = 3, sample_size = 1)]
fn check(bencher: Bencher, lens: &str) {
    let (points, target) = noisy(lens);
    let mesh = meshed(&points);
    let triangles = mesh.triangles();
    bencher.counter(ItemsCount::new(mesh.points().len())).bench(|| {
        let triangles = triangles.iter().copied();
        let noise = target.noise();
        assess_spacing(mesh.points(), triangles, target.criteria(), |_, _| noise, |_, _| 11.65)
    });
}

/// Items are points averaged into those kept.
#[divan::bench(args = LENSES, sample_count = 3, sample_size = 1)]
fn averaged(bencher: Bencher, lens: &str) {
    let (points, target) = noisy(lens);
    let mesh = meshed(&points);
    let target = target.keeping(Keep::Truest);
    let sigma_mm = target.noise().map_or(0.0, |noise| noise.sigma_mm());
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, lenses::lfs_mm);
    let kept: Vec<PointMm> =
        reduction.retained.iter().map(|&index| mesh.points()[index as usize]).collect();
    bencher
        .counter(ItemsCount::new(mesh.points().len()))
        .bench(|| average(mesh.points(), &kept, sigma_mm, lenses::lfs_mm));
}

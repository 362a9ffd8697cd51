//! Rates of insertion, assessment, rasterization, and of the search for folds and islands.
//!
//! `cargo bench -p asphera-surface` runs 100,000 points; `ASPHERA_BENCH_POINTS=1000000` another
//! number. Scattered points, which are no scan, are inserted at the cost of long walks: there are
//! at most 20,000 of them.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::Mesh;
use asphera_surface::coverage::{Aperture, Target, cover};
use asphera_surface::sections::{CuttingPlane, Profile, SectionPath, cut, section};
use asphera_surface::{
    Criteria, Grid, Relief, assess, islands, projectable_along, rasterize, topography,
};
use divan::counter::ItemsCount;
use divan::{Bencher, black_box};

#[path = "../../mesh/tests/it/patterns.rs"]
mod patterns;

#[expect(clippy::print_stdout, reason = "a figure without its size and seed says nothing")]
fn main() {
    println!("{} points a pattern ({} scattered), seed {SEED}", count(), scattered_count());
    divan::main();
}

const SEED: u64 = 42;

const PATTERNS: [&str; 4] = ["exact raster", "jittered raster", "spiral", "scattered"];

fn count() -> usize {
    std::env::var("ASPHERA_BENCH_POINTS").map_or(100_000, |count| {
        count.parse().expect("ASPHERA_BENCH_POINTS must be a number of points")
    })
}

fn scattered_count() -> usize {
    count().min(20_000)
}

/// Rasters have the largest square number of points up to the count.
fn points(pattern: &str) -> Vec<PointMm> {
    let side = count().isqrt();
    match pattern {
        "exact raster" => patterns::raster(side),
        "jittered raster" => patterns::jittered_raster(side, 0.05, SEED),
        "spiral" => patterns::spiral(count()),
        _ => {
            let side_mm = (scattered_count() as f64).sqrt() * patterns::PITCH_MM;
            patterns::scattered(scattered_count(), side_mm, SEED)
        }
    }
}

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.extend(points.iter().copied());
    mesh.flush();
    mesh
}

/// Items are points.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn insert(bencher: Bencher, pattern: &str) {
    let points = points(pattern);
    bencher.counter(ItemsCount::new(points.len())).bench(|| meshed(black_box(&points)));
}

/// Coverage of a circle that the scan reaches beyond. Items are triangles.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn cover_all(bencher: Bencher, pattern: &str) {
    cover_circle(bencher, pattern, 2.0);
}

/// The same where nothing is covered.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn cover_nothing(bencher: Bencher, pattern: &str) {
    cover_circle(bencher, pattern, 0.5);
}

/// The target is a spacing of so many pitches.
fn cover_circle(bencher: Bencher, pattern: &str, pitches: f64) {
    let mesh = meshed(&points(pattern));
    let triangles = mesh.triangles();
    let (low, high) =
        mesh.points().iter().fold(([f64::MAX; 2], [f64::MIN; 2]), |(low, high), p| {
            ([low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])])
        });
    let centre_mm = [0, 1].map(|axis| (low[axis] + high[axis]) / 2.0);
    let aperture = Aperture::circle(centre_mm, 0.48 * (high[0] - low[0])).expect("it is sound");
    let target = Target { spacing_mm: Some(pitches * patterns::PITCH_MM), ..Target::default() };
    let lfs_mm = |x: f64, y: f64| Some(50.0 + x * y);
    bencher
        .counter(ItemsCount::new(triangles.len()))
        .bench(|| cover(mesh.points(), &triangles, &[], Some(&aperture), &target, lfs_mm));
}

/// Items are triangles.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn assess_all(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let criteria = Criteria {
        gap_limit_mm: Some(2.0 * FRAC_1_SQRT_2 * patterns::PITCH_MM),
        epsilon_limit: Some(0.05),
        aperture_area_mm2: None,
    };
    bencher
        .counter(ItemsCount::new(mesh.counts().triangles))
        .bench(|| assess(mesh.points(), mesh.triangles(), &criteria, |x, y| 50.0 + x * y));
}

/// Items are triangles; the grid has as many nodes as the mesh has vertices.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn rasterize_all(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let values: Vec<f64> = mesh.points().iter().map(|point| point[2]).collect();
    let low = |axis: usize| mesh.points().iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
    let side = count().isqrt();
    let grid = Grid {
        x0_mm: low(0),
        y0_mm: low(1),
        dx_mm: patterns::PITCH_MM,
        dy_mm: patterns::PITCH_MM,
        nx: side,
        ny: side,
    };
    bencher
        .counter(ItemsCount::new(mesh.counts().triangles))
        .bench(|| rasterize(mesh.points(), mesh.triangles(), &values, &grid));
}

/// Items are triangles; nothing is steep.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn topography_gentle(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let triangles: Vec<[VertexId; 3]> = mesh.triangles();
    bencher
        .counter(ItemsCount::new(triangles.len()))
        .bench(|| topography(mesh.points(), &triangles, &Relief::default()));
}

/// Items are triangles; nearly all are steep.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn topography_folded(bencher: Bencher) {
    let mesh = meshed(&lying_cylinder());
    let triangles: Vec<[VertexId; 3]> = mesh.triangles();
    bencher
        .counter(ItemsCount::new(triangles.len()))
        .bench(|| topography(mesh.points(), &triangles, &Relief::default()));
}

/// Items are triangles; every fifth is left out.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn islands_all(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let triangles: Vec<[VertexId; 3]> = mesh.triangles();
    let keep: Vec<bool> = (0..triangles.len()).map(|index| index % 5 != 0).collect();
    bencher
        .counter(ItemsCount::new(triangles.len()))
        .bench(|| islands(mesh.points(), &triangles, &keep));
}

/// Items are planes tried.
/// Across the pattern, askew; items are points of the section.
#[divan::bench(args = PATTERNS, sample_count = 20, sample_size = 1)]
fn section_line(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let [from_mm, to_mm] = across(&mesh);
    measure_section(bencher, &mesh, &SectionPath::Segment { from_mm, to_mm });
}

/// About the middle of the pattern, with half its size for a diameter.
#[divan::bench(args = PATTERNS, sample_count = 20, sample_size = 1)]
fn section_circle(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let [from_mm, to_mm] = across(&mesh);
    let centre_mm = [0, 1].map(|axis| (from_mm[axis] + to_mm[axis]) / 2.0);
    let radius_mm = (to_mm[0] - from_mm[0]) / 4.0;
    let path = SectionPath::Circle { centre_mm, radius_mm, start_rad: 0.3 };
    measure_section(bencher, &mesh, &path);
}

fn measure_section(bencher: Bencher, mesh: &Mesh, path: &SectionPath) {
    let found = || section(mesh, path, Some(4.0 * patterns::PITCH_MM)).expect("it has a length");
    let count = found().points().count();
    bencher.counter(ItemsCount::new(count)).bench_local(|| black_box(found()));
}

/// Items are samples: heights, figures, a line and a circle fitted.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn profile_fits(bencher: Bencher) {
    let mesh = meshed(&points("jittered raster"));
    let [from_mm, to_mm] = across(&mesh);
    let path = SectionPath::Segment { from_mm, to_mm };
    let found = section(&mesh, &path, None).expect("it has a length");
    bencher.counter(ItemsCount::new(found.points().count())).bench_local(|| {
        let profile = Profile::heights(black_box(&found));
        black_box((profile.figures(), profile.line(), profile.circle()))
    });
}

/// Items are points of the mesh.
#[divan::bench(args = PATTERNS, sample_count = 5, sample_size = 1)]
fn cut_level(bencher: Bencher, pattern: &str) {
    let mesh = meshed(&points(pattern));
    let heights_mm = mesh.points().iter().map(|point| point[2]);
    let plane = CuttingPlane::new([0.0, 0.0, 1.0], heights_mm.fold(0.0, f64::max) / 3.0)
        .expect("its normal has a direction");
    bencher
        .counter(ItemsCount::new(mesh.points().len()))
        .bench_local(|| black_box(cut(&mesh, &plane, None)));
}

/// From near the lower left corner of the box around a mesh to near the upper right one.
fn across(mesh: &Mesh) -> [[f64; 2]; 2] {
    let low = [0, 1].map(|axis| extreme(mesh, axis, f64::min));
    let high = [0, 1].map(|axis| extreme(mesh, axis, f64::max));
    [0.013, 0.987].map(|share| {
        [low[0] + share * (high[0] - low[0]), low[1] + (0.8 * share + 0.1) * (high[1] - low[1])]
    })
}

fn extreme(mesh: &Mesh, axis: usize, better: fn(f64, f64) -> f64) -> f64 {
    let coordinates = mesh.points().iter().map(|point| point[axis]);
    coordinates.reduce(better).expect("there are points")
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn projectable_along_all(bencher: Bencher) {
    let points = lying_cylinder();
    bencher
        .counter(ItemsCount::new(84_usize))
        .bench(|| projectable_along(&points, &Relief::default()));
}

/// A cylinder measured all round, along its length: two sheets one above the other.
fn lying_cylinder() -> Vec<PointMm> {
    let side_mm = count().isqrt() as f64 * patterns::PITCH_MM;
    let bent = |[x, y, _]: PointMm| {
        let (sine, cosine) = (TAU * y / side_mm).sin_cos();
        [side_mm / TAU * sine, x, side_mm / TAU * cosine]
    };
    points("jittered raster").into_iter().map(bent).collect()
}

//! Texture of a surface. Sizes are the arguments, the seed is fixed.

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Mesh, Order, Robust, Threshold, core_parameters, height_parameters,
    hybrid_parameters, spatial_parameters,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SEED: u64 = 25_178;
const SPACING_MM: f64 = 0.01;
/// A tenth of the nodes is a gap; cut-offs span 20 nodes.
const CUTOFF_MM: f64 = 0.2;
const SIDES: [usize; 2] = [256, 1024];

#[expect(clippy::print_stderr, reason = "whoever reads the rates must see what they are for")]
fn main() {
    eprintln!(
        "square grids with a tenth of gaps, cut-off {CUTOFF_MM} mm of {SPACING_MM} mm, seed {SEED}"
    );
    divan::main();
}

fn height_nm(random: &mut Pcg64Mcg, x: f64, y: f64) -> f64 {
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let height = 40.0 * (7.0 * x - 3.0 * y).sin() + 20.0 * (11.0 * y).cos() + uniform();
    if uniform() < 0.1 { f64::NAN } else { height }
}

fn grid(side: usize) -> Grid {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let at = |i: usize| i as f64 * SPACING_MM;
    let heights: Vec<f64> =
        (0..side * side).map(|i| height_nm(&mut random, at(i % side), at(i / side))).collect();
    Grid::new(&heights, side, side, [SPACING_MM; 2]).expect("a square grid")
}

fn filter(order: Order) -> Gaussian {
    Gaussian::new(CUTOFF_MM, order).expect("a positive cut-off")
}

#[divan::bench(args = SIDES)]
fn order_zero(bencher: Bencher, side: usize) {
    let grid = grid(side);
    let bench = bencher.counter(ItemsCount::new(side * side));
    bench.bench_local(|| filter(Order::Zero).of_grid(&grid));
}

#[divan::bench(args = SIDES)]
fn order_two(bencher: Bencher, side: usize) {
    let grid = grid(side);
    let bench = bencher.counter(ItemsCount::new(side * side));
    bench.bench_local(|| filter(Order::Two).of_grid(&grid));
}

#[divan::bench(args = SIDES)]
fn order_two_robust(bencher: Bencher, side: usize) {
    let grid = grid(side);
    let bench = bencher.counter(ItemsCount::new(side * side));
    bench.bench_local(|| filter(Order::Two).robust(Robust::default()).of_grid(&grid));
}

/// The same nodes as a mesh, with a cut-off of six of them: a hundred or two neighbours each.
#[divan::bench(args = [256])]
fn mesh_order_two(bencher: Bencher, side: u32) {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let at = |i: u32| f64::from(i) * SPACING_MM;
    let points: Vec<[f64; 3]> = (0..side * side)
        .map(|i| (at(i % side), at(i / side)))
        .map(|(x, y)| [x, y, height_nm(&mut random, x, y) * 1e-6])
        .collect();
    let corners = (0..side * (side - 1)).filter(|i| i % side + 1 < side);
    let triangles: Vec<[u32; 3]> =
        corners.flat_map(|i| [[i, i + 1, i + side], [i + 1, i + side + 1, i + side]]).collect();
    let mesh = Mesh::new(&points, &triangles).expect("corners are points");
    let filter = Gaussian::new(6.0 * SPACING_MM, Order::Two).expect("a positive cut-off");
    bencher.counter(ItemsCount::new(points.len())).bench_local(|| filter.of_mesh(&mesh));
}

#[divan::bench(args = SIDES)]
fn heights_slopes_and_core(bencher: Bencher, side: usize) {
    let grid = grid(side).levelled(Datum::MeanPlane);
    let bench = bencher.counter(ItemsCount::new(side * side));
    bench.bench_local(|| {
        let surface = (&grid).into();
        (height_parameters(surface), hybrid_parameters(surface), core_parameters(surface))
    });
}

#[divan::bench(args = SIDES)]
fn autocorrelation_lengths(bencher: Bencher, side: usize) {
    let grid = grid(side).levelled(Datum::MeanPlane);
    let bench = bencher.counter(ItemsCount::new(side * side));
    bench.bench_local(|| spatial_parameters((&grid).into(), Threshold::DEFAULT));
}

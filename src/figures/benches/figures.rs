//! Figures of a deviation. Sizes are the arguments, the seed is fixed.

use std::f64::consts::TAU;

use asphera_figures::{
    Approximation, FringeCount, HeightGrid, Sample, Share, SlopeSettings, Window, decompose,
    fringe_fit, map_psd, robust_peak_to_valley, slopes,
};
use asphera_form::Aperture;
use divan::Bencher;
use divan::counter::ItemsCount;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SEED: u64 = 10_110;
const RADIUS_MM: f64 = 5.0;
const COUNTS: [usize; 2] = [100_000, 1_000_000];

#[expect(clippy::print_stderr, reason = "whoever reads the rates must see what they are for")]
fn main() {
    eprintln!("disc of {RADIUS_MM} mm, uniform places, waves and noise, seed {SEED}");
    divan::main();
}

fn height_nm(x: f64, y: f64) -> f64 {
    40.0 * (x - 0.4 * y).sin() + 3.0 * x * y + 5.0 * (7.0 * y).sin()
}

fn sample(count: usize) -> Sample {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (mut places, mut deviations) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let (r, phi) = (RADIUS_MM * uniform().sqrt(), TAU * uniform());
        let (x, y) = (r * phi.cos(), r * phi.sin());
        places.push([x, y]);
        deviations.push((height_nm(x, y) + uniform()) * 1e-6);
    }
    let disc = Aperture::Circle { radius_mm: RADIUS_MM };
    Sample::new(&places, &deviations, None, &disc).expect("places in the aperture")
}

#[divan::bench(args = COUNTS)]
fn fringe_37(bencher: Bencher, count: usize) {
    let sample = sample(count);
    let bench = bencher.counter(ItemsCount::new(count));
    bench.bench_local(|| fringe_fit(&sample, FringeCount::ThirtySeven));
}

#[divan::bench(args = COUNTS)]
fn decomposition(bencher: Bencher, count: usize) {
    let sample = sample(count);
    let bench = bencher.counter(ItemsCount::new(count));
    bench.bench_local(|| decompose(&sample, Approximation::Quadratic, None));
}

#[divan::bench(args = COUNTS)]
fn robust_range(bencher: Bencher, count: usize) {
    let sample = sample(count);
    let bench = bencher.counter(ItemsCount::new(count));
    bench.bench_local(|| robust_peak_to_valley(&sample, Share::NINETY_NINE));
}

/// Half a millimetre of integration length at every tenth of one: each point is in some twenty discs.
#[divan::bench(args = COUNTS)]
fn slope_map(bencher: Bencher, count: usize) {
    let sample = sample(count);
    let settings = SlopeSettings::new(0.5, 0.1).expect("positive lengths");
    let bench = bencher.counter(ItemsCount::new(count));
    bench.bench_local(|| slopes(&sample, settings));
}

/// Square maps of a power of two and of another length.
#[divan::bench(args = [1000, 1024])]
fn density_of_map(bencher: Bencher, side: usize) {
    let step_mm = 2.0 * RADIUS_MM / side as f64;
    let at = |i: usize| (i as f64 + 0.5) * step_mm - RADIUS_MM;
    let height = |i: usize| {
        let (x, y) = (at(i % side), at(i / side));
        if x.hypot(y) > RADIUS_MM { f64::NAN } else { height_nm(x, y) }
    };
    let heights: Vec<f64> = (0..side * side).map(height).collect();
    let grid = HeightGrid::new(&heights, side, side, [step_mm; 2]).expect("a square grid");
    let bench = bencher.counter(ItemsCount::new(side * side));
    bench.bench_local(|| map_psd(&grid, Window::None));
}

//! Fits, deviations and running figures of an asphere. Sizes are the arguments, the seed is fixed.

use asphera_form::{
    FitSettings, Grid, Live, LiveReference, LiveSettings, Parameter, Pose, ReferenceSettings,
    deviations, fit,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use part::{RADIUS_MM, SEED, nominal};

mod part;

#[expect(clippy::print_stderr, reason = "whoever reads the rates must see what they are for")]
fn main() {
    eprintln!(
        "asphere R 11.65 mm with seven coefficients, semi-diameter {RADIUS_MM} mm, seed {SEED}"
    );
    divan::main();
}

const GRID: Grid = Grid {
    x_min_mm: -RADIUS_MM,
    x_max_mm: RADIUS_MM,
    y_min_mm: -RADIUS_MM,
    y_max_mm: RADIUS_MM,
    nx: 96,
    ny: 96,
};

fn live(count: usize) -> Live {
    let settings = LiveSettings::new(FitSettings::default(), GRID);
    let mut live = Live::new(nominal(), settings).expect("a valid grid");
    part::points(count, |_, _| 0.0).into_iter().for_each(|point| live.push(point));
    live
}

#[divan::bench(args = [1_000, 10_000, 100_000], threads = 1)]
fn fit_pose(bencher: Bencher, count: usize) {
    let points = part::points(count, |_, _| 0.0);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| fit(&points, &nominal(), &FitSettings::default()));
}

#[divan::bench(args = [100_000], sample_count = 10)]
fn fit_pose_and_shape(bencher: Bencher, count: usize) {
    let points = part::points(count, |_, _| 0.0);
    let shape = [Parameter::Radius, Parameter::Conic, Parameter::A(4), Parameter::A(6)];
    let free = Parameter::RIGID.into_iter().chain(shape).collect();
    let settings = FitSettings { free, ..FitSettings::default() };
    bencher.counter(ItemsCount::new(count)).bench(|| fit(&points, &nominal(), &settings));
}

#[divan::bench(args = [1_000, 100_000])]
fn deviations_of_asphere(bencher: Bencher, count: usize) {
    let points = part::points(count, |_, _| 0.0);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| deviations(&points, &nominal(), &Pose::default()));
}

#[divan::bench(args = [1_000, 100_000], sample_count = 10)]
fn live_push(bencher: Bencher, count: usize) {
    let points = part::points(count, |_, _| 0.0);
    bencher.counter(ItemsCount::new(count)).with_inputs(|| live(0)).bench_local_values(
        |mut live| {
            points.iter().for_each(|&point| live.push(point));
            live
        },
    );
}

#[divan::bench(args = [1_000, 10_000, 100_000, 2_782_224], sample_count = 20)]
fn live_estimate(bencher: Bencher, count: usize) {
    let live = live(count);
    bencher.bench(|| live.estimate());
}

fn unknown(count: usize) -> LiveReference {
    let settings = ReferenceSettings { centre_mm: Some([0.0; 2]), ..ReferenceSettings::default() };
    let mut live = LiveReference::new(settings, GRID).expect("a valid grid");
    part::points(count, |_, _| 0.0).into_iter().for_each(|point| live.push(point));
    live
}

#[divan::bench(args = [100_000], sample_count = 5)]
fn unknown_push(bencher: Bencher, count: usize) {
    bencher.counter(ItemsCount::new(count)).bench(|| unknown(count));
}

#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 20)]
fn unknown_estimate(bencher: Bencher, count: usize) {
    let live = unknown(count);
    bencher.bench(|| live.estimate());
}

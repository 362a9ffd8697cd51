//! Fits, deviations and running figures of an asphere. Sizes are the arguments, the seed is fixed.

use asphera_form::{
    Asphere, FitSettings, Grid, Live, LiveSettings, Nominal, Parameter, PointMm, Pose, deviations,
    fit,
};
use divan::Bencher;
use divan::counter::ItemsCount;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SEED: u64 = 2012;
const RADIUS_MM: f64 = 9.0;

#[expect(clippy::print_stderr, reason = "whoever reads the rates must see what they are for")]
fn main() {
    eprintln!(
        "asphere R 11.65 mm with seven coefficients, semi-diameter {RADIUS_MM} mm, seed {SEED}"
    );
    divan::main();
}

fn nominal() -> Nominal {
    let coefficients = [
        (4, 3.69067205091e-5),
        (6, -1.285461192617e-8),
        (8, -1.400167659754e-10),
        (10, -2.51311664812e-13),
        (12, 5.01789877647e-16),
        (14, 5.855871513042e-18),
        (16, -1.127794407419e-20),
    ];
    Nominal::Asphere(Asphere::new(11.65, -1.1, &coefficients).expect("a valid prescription"))
}

/// Uniform over the disc, 20 nm of noise, half a milliradian and 30 µm out of place.
fn points(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let pose =
        Pose { tx_mm: 0.03, ty_mm: -0.02, tz_mm: 0.4, rx_rad: 5e-4, ry_rad: -3e-4, rz_rad: 0.0 };
    let nominal = nominal();
    (0..count)
        .map(|_| {
            let r = RADIUS_MM * uniform().sqrt();
            let phi = std::f64::consts::TAU * uniform();
            let z = nominal.sag_mm(r) + 2e-5 * (uniform() - 0.5);
            pose.to_measured([r * phi.cos(), r * phi.sin(), z])
        })
        .collect()
}

fn live(count: usize) -> Live {
    let grid = Grid {
        x_min_mm: -RADIUS_MM,
        x_max_mm: RADIUS_MM,
        y_min_mm: -RADIUS_MM,
        y_max_mm: RADIUS_MM,
        nx: 96,
        ny: 96,
    };
    let settings = LiveSettings::new(FitSettings::default(), grid);
    let mut live = Live::new(nominal(), settings).expect("a valid grid");
    points(count).into_iter().for_each(|point| live.push(point));
    live
}

#[divan::bench(args = [1_000, 10_000, 100_000], threads = 1)]
fn fit_pose(bencher: Bencher, count: usize) {
    let points = points(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| fit(&points, &nominal(), &FitSettings::default()));
}

#[divan::bench(args = [100_000], sample_count = 10)]
fn fit_pose_and_shape(bencher: Bencher, count: usize) {
    let points = points(count);
    let shape = [Parameter::Radius, Parameter::Conic, Parameter::A(4), Parameter::A(6)];
    let free = Parameter::RIGID.into_iter().chain(shape).collect();
    let settings = FitSettings { free, ..FitSettings::default() };
    bencher.counter(ItemsCount::new(count)).bench(|| fit(&points, &nominal(), &settings));
}

#[divan::bench(args = [1_000, 100_000])]
fn deviations_of_asphere(bencher: Bencher, count: usize) {
    let points = points(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| deviations(&points, &nominal(), &Pose::default()));
}

#[divan::bench(args = [1_000, 100_000], sample_count = 10)]
fn live_push(bencher: Bencher, count: usize) {
    let points = points(count);
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

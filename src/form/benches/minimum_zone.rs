//! The minimum zone of an asphere against its least-squares fit. Sizes are the arguments, the seed is fixed.

use std::f64::consts::TAU;

use asphera_form::form_error::FormError;
use asphera_form::{
    Asphere, Criterion, FitSettings, Nominal, Parameter, PointMm, Pose, ZoneSettings, fit,
    minimum_zone,
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
        "asphere R 11.65 mm with seven coefficients, semi-diameter {RADIUS_MM} mm, smooth form error and \
         20 nm of noise, seed {SEED}"
    );
    for count in [10_000, 1_000_000] {
        let found = minimum_zone(&points(count), &nominal(), &ZoneSettings::default())
            .expect("points over the nominal");
        eprintln!(
            "{count} points: zone {:.3} nm in {} passes, {} points took part, {:?}",
            found.zone_mm * 1e6,
            found.certificate.scans,
            found.certificate.working,
            found.termination,
        );
    }
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

/// Uniform over the disc, half a milliradian and 30 µm out of place.
fn points(count: usize) -> Vec<PointMm> {
    let mut random = Pcg64Mcg::seed_from_u64(SEED);
    let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let pose =
        Pose { tx_mm: 0.03, ty_mm: -0.02, tz_mm: 0.4, rx_rad: 5e-4, ry_rad: -3e-4, rz_rad: 0.0 };
    let (nominal, form) = (nominal(), FormError::typical(RADIUS_MM));
    (0..count)
        .map(|_| {
            let (r, phi) = (RADIUS_MM * uniform().sqrt(), TAU * uniform());
            let (x, y) = (r * phi.cos(), r * phi.sin());
            let error_mm = form.height_nm(x, y) * 1e-6 + 2e-5 * (uniform() - 0.5);
            pose.to_measured([x, y, nominal.sag_mm(r) + error_mm])
        })
        .collect()
}

#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 5)]
fn least_squares(bencher: Bencher, count: usize) {
    let points = points(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| fit(&points, &nominal(), &FitSettings::default()));
}

/// With the least-squares fit it begins with.
#[divan::bench(args = [10_000, 100_000, 1_000_000], sample_count = 5)]
fn zone(bencher: Bencher, count: usize) {
    let points = points(count);
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| minimum_zone(&points, &nominal(), &ZoneSettings::default()));
}

/// The same with a zone symmetric about the nominal.
#[divan::bench(args = [1_000_000], sample_count = 5)]
fn centred_zone(bencher: Bencher, count: usize) {
    let points = points(count);
    let settings = ZoneSettings { criterion: Criterion::Centred, ..ZoneSettings::default() };
    bencher.counter(ItemsCount::new(count)).bench(|| minimum_zone(&points, &nominal(), &settings));
}

/// Pose, radius and conic constant.
fn with_shape() -> FitSettings {
    let shape = [Parameter::Radius, Parameter::Conic];
    let free = Parameter::RIGID.into_iter().chain(shape).collect();
    FitSettings { free, ..FitSettings::default() }
}

#[divan::bench(args = [1_000_000], sample_count = 5)]
fn least_squares_with_shape(bencher: Bencher, count: usize) {
    let points = points(count);
    bencher.counter(ItemsCount::new(count)).bench(|| fit(&points, &nominal(), &with_shape()));
}

#[divan::bench(args = [1_000_000], sample_count = 5)]
fn zone_with_shape(bencher: Bencher, count: usize) {
    let points = points(count);
    let settings = ZoneSettings {
        fit: with_shape(),
        criterion: Criterion::Centred,
        ..ZoneSettings::default()
    };
    bencher.counter(ItemsCount::new(count)).bench(|| minimum_zone(&points, &nominal(), &settings));
}

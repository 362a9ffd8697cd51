//! The minimum zone of an asphere against its least-squares fit. Sizes are the arguments, the seed is fixed.

use asphera_form::form_error::FormError;
use asphera_form::{Criterion, FitSettings, Parameter, PointMm, ZoneSettings, fit, minimum_zone};
use divan::Bencher;
use divan::counter::ItemsCount;
use part::{RADIUS_MM, SEED, nominal};

mod part;

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

/// Zone symmetric about the nominal.
#[divan::bench(args = [1_000_000], sample_count = 5)]
fn centred_zone(bencher: Bencher, count: usize) {
    let points = points(count);
    let settings = ZoneSettings { criterion: Criterion::Centred, ..ZoneSettings::default() };
    bencher.counter(ItemsCount::new(count)).bench(|| minimum_zone(&points, &nominal(), &settings));
}

/// Points with a smooth form error.
fn points(count: usize) -> Vec<PointMm> {
    let form = FormError::typical(RADIUS_MM);
    part::points(count, |x_mm, y_mm| form.height_nm(x_mm, y_mm) * 1e-6)
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

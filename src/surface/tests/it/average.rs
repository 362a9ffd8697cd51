//! Averaged heights against surfaces that are known: what they are off by, and what they state.

use asphera_geometry::PointMm;
use asphera_surface::reduce::{Averaged, Reducer, Spacing, average};

use crate::patterns::scattered;
use crate::random::Random;
use crate::reduce::thinned;
use crate::shapes::{Sampled, over_square};

/// A height in mm over x and y in mm, about the middle of a square.
type Surface = fn(f64, f64) -> f64;

/// Radii of curvature of 50 and 15 mm, an asphere that bends from 20 mm at its vertex to 8 mm at its rim, a wave with
/// inflections, and an ellipsoid where it is cut a tenth before its end.
const SURFACES: [(&str, Surface, f64); 5] = [
    ("sphere", |x, y| 50.0 - (2500.0 - x * x - y * y).sqrt(), 50.0),
    ("cylinder", |x, _| 15.0 - (225.0 - x * x).sqrt(), 15.0),
    (
        "asphere",
        |x, y| {
            let squared = x * x + y * y;
            squared / 40.0 + 2e-4 * squared * squared
        },
        8.0,
    ),
    ("cosine", |x, _| 0.5 * x.cos(), 2.0),
    (
        "ellipsoid",
        |x, y| {
            let [u, v] = [(x + 4.0) / 12.0, (y + 2.0) / 9.0];
            6.0 * (1.0 - u * u - v * v).max(0.0).sqrt()
        },
        3.0,
    ),
];

/// How far averaged heights are off, in standard uncertainties.
#[derive(Clone, Copy, Default)]
struct Errors {
    count: f64,
    squares: f64,
    within_two: f64,
}

impl Errors {
    fn add(&mut self, found: &Averaged, truth_mm: impl Fn(f64, f64) -> f64) {
        for point in found.points.iter().filter(|point| point.measurements > 1) {
            let [x, y, z] = point.point_mm;
            let error = (z - truth_mm(x, y)) / point.u_mm;
            self.count += 1.0;
            self.squares += error * error;
            self.within_two += f64::from(error.abs() <= 2.0);
        }
    }

    fn rms(&self) -> f64 {
        (self.squares / self.count).sqrt()
    }
}

fn median_u_mm(found: &Averaged) -> f64 {
    let mut u_mm: Vec<f64> = found.points.iter().map(|point| point.u_mm).collect();
    u_mm.sort_by(f64::total_cmp);
    u_mm[u_mm.len() / 2]
}

/// A square about the middle with noise, and the points kept of it.
fn measured(
    surface: impl Fn(f64, f64) -> f64,
    side_mm: f64,
    sigma_mm: f64,
    seed: u64,
    count: usize,
) -> Vec<PointMm> {
    // Not the numbers the places are made of.
    let mut random = Random::new(1000 + seed);
    let along = (count as f64).sqrt() as usize;
    let sampled = if seed.is_multiple_of(2) {
        Sampled::Raster { along, across: along }
    } else {
        Sampled::Scattered { count, seed }
    };
    over_square(sampled, side_mm, |_, _| 0.0)
        .into_iter()
        .map(|[x, y, _]| {
            let [x, y] = [x - 0.5 * side_mm, y - 0.5 * side_mm];
            [x, y, surface(x, y) + sigma_mm * random.normal()]
        })
        .collect()
}

/// Issue 14, line 1: the quadric over a whole cell of the sphere was off by 6 nm where 0.1 nm were stated.
#[test]
fn heights_are_off_by_what_they_state_on_any_surface() {
    let mut seed = 1;
    for (name, surface, lfs_mm) in SURFACES {
        let mut errors = Errors::default();
        for sigma_mm in [1e-8, 2e-6, 1e-4] {
            for epsilon in [0.02, 0.05, 0.1, 0.3] {
                seed += 1;
                let points = measured(surface, 8.0, sigma_mm, seed, 40_000);
                let kept = thinned(&points, epsilon * lfs_mm);
                let found = average(&points, &kept, sigma_mm, |_| None);
                errors.add(&found, surface);
                for point in &found.points {
                    assert!(point.u_mm <= 1.01 * sigma_mm, "{name} {epsilon}: {point:?}");
                    assert!(4.0 * point.bias_mm <= point.u_mm, "{name} {epsilon}: {point:?}");
                }
            }
        }
        let (rms, within) = (errors.rms(), errors.within_two / errors.count);
        eprintln!("{name}: {} averaged, rms {rms:.3} u, {within:.3} within 2 u", errors.count);
        assert!(rms <= 1.1 && within >= 0.94 - 2.0 / errors.count.sqrt(), "{name}: {rms} {within}");
    }
}

/// A short wave is followed as soon as it stands out of the noise of the windows that show it.
#[test]
fn what_is_finer_than_a_cell_is_not_averaged_away() {
    let sigma_mm = 2e-6;
    for (wave_mm, times) in
        [(0.2, 3.0), (0.2, 100.0), (0.5, 10.0), (0.5, 100.0), (1.0, 10.0), (1.0, 100.0), (3.0, 1.0)]
    {
        let wave_per_mm = std::f64::consts::TAU / wave_mm;
        let surface =
            |x: f64, y: f64| SURFACES[0].1(x, y) + times * sigma_mm * (x * wave_per_mm).cos();
        let points = measured(surface, 10.0, sigma_mm, 3, 60_000);
        let kept = thinned(&points, 1.0);
        let found = average(&points, &kept, sigma_mm, |_| None);
        let mut errors = Errors::default();
        errors.add(&found, surface);
        eprintln!("{times} σ of {wave_mm} mm: {} averaged, rms {} u", errors.count, errors.rms());
        assert!(errors.count < 1.0 || errors.rms() < 1.3, "{wave_mm} {times}: {}", errors.rms());
    }
}

/// The surface that is known need not be the one measured: what it does not hold is estimated as without it.
#[test]
fn deviations_from_a_known_surface_are_averaged_more_widely() {
    let sigma_mm = 2e-6;
    let surface = |x: f64, y: f64| SURFACES[1].1(x, y) + 1e-4 * (0.4 * y).sin();
    let points = measured(surface, 8.0, sigma_mm, 4, 40_000);
    let kept = thinned(&points, 0.1 * 15.0);
    let without = average(&points, &kept, sigma_mm, |_| None);
    let with = average(&points, &kept, sigma_mm, |[x, y, _]| Some(SURFACES[1].1(x, y)));
    let partly =
        average(&points, &kept, sigma_mm, |[x, y, _]| (x > 0.0).then(|| 7.0 + SURFACES[1].1(x, y)));
    for found in [&without, &with, &partly] {
        let mut errors = Errors::default();
        errors.add(found, surface);
        let allowed = 1.0 + 3.0 / (2.0 * errors.count).sqrt();
        assert!(errors.rms() < allowed && errors.count > 20.0, "{} {}", errors.rms(), errors.count);
    }
    let gain = median_u_mm(&with) / median_u_mm(&without);
    assert!(gain < 0.7, "{gain}");
}

#[test]
fn a_spike_that_was_kept_is_not_averaged_away() {
    let sigma_mm = 2e-6;
    let mut points = measured(SURFACES[0].1, 8.0, sigma_mm, 4, 40_000);
    let spike = 20_100;
    points[spike][2] += 1e-3;
    let kept = [points[0], points[spike], points[39_000]];
    let found = average(&points, &kept, sigma_mm, |_| None);
    assert_eq!((found.points[1].point_mm, found.points[1].measurements), (points[spike], 1));
    assert_eq!(found.points[1].u_mm, sigma_mm);
}

#[test]
fn averages_have_the_uncertainty_they_state() {
    let sigma_mm = 50e-6;
    let truth = scattered(200_000, 2.0, 13);
    let mut random = Random::new(14);
    let noisy: Vec<PointMm> =
        truth.iter().map(|&[x, y, z]| [x, y, z + sigma_mm * random.normal()]).collect();
    for (spacing_mm, largest_u_mm) in [(0.02, 0.45 * sigma_mm), (0.2, 0.1 * sigma_mm)] {
        let mut reducer = Reducer::new();
        for &point in &noisy {
            reducer.take(point, Spacing::given(spacing_mm).unwrap());
        }
        let kept = reducer.points();
        let found = average(&noisy, kept, sigma_mm, |_| None);
        // Nearly all: a window that the sphere bends away from is smaller than its cell.
        let used = found.points.iter().map(|point| point.measurements).sum::<u64>();
        assert!((190_000..=200_000).contains(&used), "{spacing_mm}: {used}");
        let mut squares = Vec::new();
        for ((point, &before), &arrival) in found.points.iter().zip(kept).zip(reducer.arrivals()) {
            assert_eq!(point.point_mm[..2], before[..2]);
            let error_mm = point.point_mm[2] - truth[arrival as usize][2];
            squares.push((error_mm / point.u_mm).powi(2));
        }
        let reduced = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        let allowed = 0.02 + 3.0 / (2.0 * squares.len() as f64).sqrt();
        assert!((reduced - 1.0).abs() < allowed, "{spacing_mm}: {reduced}, {} kept", squares.len());
        let mut u_mm: Vec<f64> = found.points.iter().map(|point| point.u_mm).collect();
        u_mm.sort_by(f64::total_cmp);
        assert!(u_mm[u_mm.len() / 2] < largest_u_mm, "{spacing_mm}: {}", u_mm[u_mm.len() / 2]);
    }
}

#[test]
fn a_point_without_surroundings_stays_as_it_was() {
    let kept = [[0.0, 0.0, 1.0], [10.0, 0.0, 2.0]];
    let points = [kept[0], kept[1], [0.1, 0.0, 5.0], [0.2, 0.0, 9.0]];
    let found = average(&points, &kept, 1e-3, |_| None);
    assert_eq!(found.averaged, 0);
    assert_eq!(found.points.iter().map(|p| p.point_mm).collect::<Vec<_>>(), kept);
    assert!(found.points.iter().all(|p| p.u_mm == 1e-3 && p.measurements == 1));
}

//! Ranges of what is left: whether their intervals hold those of the form, and what becomes of waves that are taken off.

use super::*;
use crate::{Budget, Kernel, LongWave, Noise, Uncertainty, uncertainty};
use asphera_figures::{Approximation, Term, irregular, remove};
use asphera_form::{Aperture, FitSettings, Nominal, Parameter, PointMm, fit};
use asphera_geometry::Numbers;

/// Remainder of the deviations: B, the PV over a ring, that without terms, and that of all.
#[derive(Clone, Copy, Debug)]
enum Of {
    Irregularity,
    Ring,
    Less,
    All,
}

impl Of {
    fn zone(self) -> Aperture {
        match self {
            Of::Ring => Aperture::Annulus { inner_mm: 3.0, outer_mm: 7.0 },
            _ => Aperture::None,
        }
    }

    fn left(self, places_mm: &[[f64; 2]], mm: &[f64], areas: &[f64]) -> Option<Sample> {
        let sample = Sample::new(places_mm, mm, Some(areas), &self.zone()).ok()?;
        match self {
            Of::Irregularity => irregular(&sample, Approximation::Quadratic).ok(),
            Of::Ring | Of::All => Some(sample),
            Of::Less => Some(remove(&sample, &[Term::Power, Term::Coma]).ok()?.sample),
        }
    }
}

/// Deviations of a disc of 10 mm in nm: form with a peak on a few points.
fn form_nm(scale_nm: f64, [x, y]: [f64; 2]) -> f64 {
    let peak = (-(x - 4.0).powi(2) - (y + 2.0).powi(2)).exp();
    scale_nm * ((0.7 * x).sin() * (0.5 * y).cos() + 0.02 * x * y + 0.3 * peak)
}

/// Such points with noise.
fn measured(
    scale_nm: f64,
    noise_nm: f64,
    budget: &Budget,
    free: &[Parameter],
    seed: u64,
) -> Uncertainty {
    let numbers = Numbers::new(seed, 0, 0);
    let point = |i: u32| -> PointMm {
        let radius = 10.0 * ((f64::from(i) + 0.5) / f64::from(POINTS)).sqrt();
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        let nm = form_nm(scale_nm, [x, y]) + noise_nm * numbers.normal(i as usize);
        [x, y, 1e-6 * nm]
    };
    let points: Vec<PointMm> = (0..POINTS).map(point).collect();
    let settings = FitSettings { free: free.to_vec(), ..FitSettings::default() };
    let found = fit(&points, &Nominal::Plane, &settings).unwrap();
    uncertainty(&points, &found, &Aperture::None, None, budget).unwrap()
}

fn simulated(of: Of, uncertainty: &Uncertainty, draws: &Draws) -> Simulated {
    let (places_mm, mm) = (uncertainty.places_mm(), uncertainty.deviations_mm());
    let whole = of.left(places_mm, mm, &vec![1.0; mm.len()]).unwrap();
    let left = |places: &[[f64; 2]], mm: &[f64], areas: &[f64]| of.left(places, mm, areas);
    uncertainty.simulate_range(draws, &whole, left).unwrap().unwrap()
}

fn budget(noise_nm: f64, wave: Option<(f64, f64)>) -> Budget {
    let noise = Noise::Uniform { sigma_mm: 1e-6 * noise_nm, dof: f64::INFINITY };
    let long_waves = wave.map(|(nm, length_mm)| LongWave {
        sigma_mm: 1e-6 * nm,
        length_mm,
        kernel: Kernel::Gaussian,
        dof: f64::INFINITY,
    });
    Budget { noise, long_waves: long_waves.into_iter().collect(), ..Budget::default() }
}

#[test]
fn where_nothing_is_taken_off_it_is_that_of_all_points() {
    let draws = Draws { count: 100, seed: 5 };
    for wave in [None, Some((4.0, 6.0))] {
        let uncertainty = measured(20.0, 2.0, &budget(2.0, wave), &UPRIGHT, 3);
        let [found, whole] = [
            simulated(Of::All, &uncertainty, &draws),
            uncertainty.peak_to_valley_nm(&draws).unwrap(),
        ];
        let [few, many] = [&found, &whole].map(|one| {
            let [low, high] = one.interval(0.95);
            [one.measured, one.u, one.bias, low, high]
        });
        for (a, b) in few.into_iter().zip(many) {
            assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{few:?} {many:?}");
        }
    }
}

/// A wave three times as long as the part is hardly more than tilt, which the pose leaves here and B takes off.
#[test]
fn what_is_taken_off_takes_its_errors_along() {
    let draws = Draws { count: 100, seed: 5 };
    let more = |of: Of| {
        let u = |wave: Option<(f64, f64)>| {
            let uncertainty = measured(100.0, 1.0, &budget(1.0, wave), &[Parameter::Tz], 4);
            simulated(of, &uncertainty, &draws).u
        };
        u(Some((20.0, 60.0))) / u(None)
    };
    let (b, all) = (more(Of::Irregularity), more(Of::All));
    assert!(b < 1.5 && all > 3.0, "{b} {all}");
}

/// Of noise alone, of form as high as it, and of form that rules: of 100 at 95 % no more than 12 with a probability of 99.8 %.
#[test]
fn intervals_hold_the_range_of_the_form() {
    for of in [Of::Irregularity, Of::Ring, Of::Less] {
        for scale_nm in [0.0, 5.0, 200.0] {
            let outside = (0..100).filter(|&seed| {
                let draws = Draws { count: 100, seed };
                let uncertainty =
                    measured(scale_nm, 5.0, &budget(5.0, None), &[Parameter::Tz], 100 + seed);
                let places_mm = uncertainty.places_mm();
                let mm: Vec<f64> =
                    places_mm.iter().map(|&place| 1e-6 * form_nm(scale_nm, place)).collect();
                let form = of.left(places_mm, &mm, &vec![1.0; mm.len()]).unwrap();
                let [low, high] = Sample::range(form.values_nm()).unwrap();
                let [least, most] = simulated(of, &uncertainty, &draws).interval(0.95);
                !(least..=most).contains(&(high - low))
            });
            let outside = outside.count();
            eprintln!("{of:?}, form of {scale_nm} nm: {outside} of 100 outside");
            assert!(outside <= 12, "{of:?} {scale_nm}: {outside}");
        }
    }
}

#[test]
fn without_errors_it_is_what_was_measured() {
    let uncertainty = measured(50.0, 0.0, &budget(0.0, None), &UPRIGHT, 1);
    let found = simulated(Of::Ring, &uncertainty, &Draws { count: 20, seed: 1 });
    assert!(found.u < 1e-9 && found.bias.abs() < 1e-9, "{found:?}");
}

const POINTS: u32 = 2_000;
const UPRIGHT: [Parameter; 3] = [Parameter::Tz, Parameter::Rx, Parameter::Ry];

//! Ranges drawn by patches against the same ranges of all points drawn one by one.

use super::*;
use crate::figures::{Approximation, Term, irregular, peak_to_valley, remove};
use crate::uncertainty::{Budget, Kernel, LongWave, Noise, Uncertainty, uncertainty};
use crate::{Aperture, FitSettings, Nominal, PointMm, fit};

/// What is left of the deviations: B, the PV over a ring, and the PV without terms.
#[derive(Clone, Copy, Debug)]
enum Of {
    Irregularity,
    Ring,
    Less,
}

impl Of {
    fn zone(self) -> Aperture {
        match self {
            Of::Ring => Aperture::Annulus { inner_mm: 3.0, outer_mm: 7.0 },
            _ => Aperture::None,
        }
    }

    fn left(self, places_mm: &[[f64; 2]], mm: &[f64], areas: Option<&[f64]>) -> Option<Sample> {
        let sample = Sample::new(places_mm, mm, areas, &self.zone()).ok()?;
        match self {
            Of::Irregularity => irregular(&sample, Approximation::Quadratic).ok(),
            Of::Ring => Some(sample),
            Of::Less => Some(remove(&sample, &[Term::Power, Term::Coma]).ok()?.sample),
        }
    }

    fn figure_nm(self, places_mm: &[[f64; 2]], mm: &[f64]) -> Option<f64> {
        let sample = Sample::new(places_mm, mm, None, &self.zone()).ok()?;
        Some(match self {
            Of::Irregularity => {
                peak_to_valley(&irregular(&sample, Approximation::Quadratic).ok()?).ok()?.value
            }
            Of::Ring => peak_to_valley(&sample).ok()?.value,
            Of::Less => {
                let left = remove(&sample, &[Term::Power, Term::Coma]).ok()?.sample;
                peak_to_valley(&left).ok()?.value
            }
        })
    }
}

/// Points of a disc of 10 mm with form of this height, and a peak on a few of them.
fn measured(form_nm: f64, noise_nm: f64, budget: &Budget) -> Uncertainty {
    let count = POINTS;
    let numbers = Numbers::new(11, 0, 0);
    let point = |i: u32| -> PointMm {
        let radius = 10.0 * ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
        let (sin, cos) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
        let (x, y) = (radius * cos, radius * sin);
        let peak = (-(x - 4.0).powi(2) - (y + 2.0).powi(2)).exp();
        let form = (0.7 * x).sin() * (0.5 * y).cos() + 0.02 * x * y + 0.3 * peak;
        let nm = form_nm * form + noise_nm * numbers.normal(i as usize);
        [x, y, 1e-6 * nm + 1e-4 * x]
    };
    let points: Vec<PointMm> = (0..count).map(point).collect();
    let found = fit(&points, &Nominal::Plane, &FitSettings::default()).unwrap();
    uncertainty(&points, &found, &Aperture::None, None, budget).unwrap()
}

/// u, bias and tails are those of full draws, to what so many draws tell.
fn agrees(name: &str, form_nm: f64, noise_nm: f64, budget: &Budget) {
    let uncertainty = measured(form_nm, noise_nm, budget);
    let draws = Draws { count: 400, seed: 5 };
    let (places_mm, mm) = (uncertainty.places_mm(), uncertainty.deviations_mm());
    for of in [Of::Irregularity, Of::Ring, Of::Less] {
        let whole = of.left(places_mm, mm, None).unwrap();
        let left =
            |places: &[[f64; 2]], mm: &[f64], areas: Option<&[f64]>| of.left(places, mm, areas);
        let found = uncertainty.simulate_range(&draws, &whole, left).unwrap().unwrap();
        // Other numbers, so that both err by themselves.
        let full = uncertainty
            .simulate(&Draws { seed: 77, ..draws }, |mm| of.figure_nm(places_mm, mm))
            .unwrap()
            .unwrap();
        let [few, many] = [&found, &full]
            .map(|one| [one.measured, one.u, one.bias, one.quantile(0.05), one.quantile(0.95)]);
        eprintln!("{name}, {of:?}: {few:.4?} {many:.4?}, {} points", found.candidates);
        assert_eq!((few[0], found.capped, found.draws), (many[0], false, 400));
        // Four standard errors of the difference: of u 3.5 % by each, of the mean u/√400.
        let error = full.u * (2.0_f64 / 400.0).sqrt();
        assert!((few[1] / many[1] - 1.0).abs() < 4.0 / 400.0_f64.sqrt(), "{name} {of:?} u");
        assert!((few[2] - many[2]).abs() < 4.0 * error, "{name} {of:?} bias");
        // A quantile of 5 % is known to 2.1 times that of the mean, of skew draws to somewhat more.
        for tail in [3, 4] {
            assert!((few[tail] - many[tail]).abs() < 11.0 * error, "{name} {of:?} tail {tail}");
        }
    }
}

fn budget(noise_nm: f64) -> Budget {
    let noise = Noise::Uniform { sigma_mm: 1e-6 * noise_nm, dof: f64::INFINITY };
    Budget { noise, long_waves: Vec::new(), effects: Vec::new() }
}

#[test]
fn noise_on_form_and_noise_alone() {
    agrees("form", 100.0, 2.0, &budget(2.0));
    agrees("noise", 1.0, 5.0, &budget(5.0));
}

#[test]
fn waves_and_points_that_are_known_unequally_well() {
    let wave =
        LongWave { sigma_mm: 5e-6, length_mm: 6.0, kernel: Kernel::Gaussian, dof: f64::INFINITY };
    agrees("waves", 60.0, 2.0, &Budget { long_waves: vec![wave], ..budget(2.0) });
    let own = (0..POINTS).map(|i| if i % 7 == 0 { 6e-6 } else { 1e-6 }).collect();
    agrees("unequal", 40.0, 1.0, &Budget { noise: Noise::EachPoint(own), ..budget(0.0) });
}

#[test]
fn without_errors_it_is_what_was_measured() {
    let uncertainty = measured(50.0, 0.0, &budget(0.0));
    let whole = Of::Ring.left(uncertainty.places_mm(), uncertainty.deviations_mm(), None).unwrap();
    let left =
        |places: &[[f64; 2]], mm: &[f64], areas: Option<&[f64]>| Of::Ring.left(places, mm, areas);
    let draws = Draws { count: 20, seed: 1 };
    let found = uncertainty.simulate_range(&draws, &whole, left).unwrap().unwrap();
    assert!(found.u < 1e-9 && found.bias.abs() < 1e-9, "{found:?}");
}

/// Normal numbers of n points: the median of their highest is Φ⁻¹(2^(−1/n)).
#[test]
fn the_highest_of_many_alike() {
    let table = Unlikely::new();
    for count in [1_u32, 30, 5000] {
        let highest = Highest::new(|| (0..count).map(|_| (7.0, 2.0)), 7.0, &table);
        let p = 0.5_f64.powf(1.0 / f64::from(count));
        let truth_nm = 7.0 + 2.0 * student_quantile(p, f64::INFINITY);
        let found_nm = highest.drawn_nm(0.5, f64::NEG_INFINITY);
        assert!((found_nm - truth_nm).abs() < 0.01, "{found_nm} {truth_nm}");
        assert_eq!(highest.drawn_nm(0.5, truth_nm + 1.0), f64::NEG_INFINITY);
    }
    // One that stands alone and is certain.
    let certain = Highest::new(|| [(9.0, 0.0), (1.0, 2.0)].into_iter(), 9.0, &table);
    assert!((certain.drawn_nm(0.5, f64::NEG_INFINITY) - 9.0).abs() < 0.51);
}

/// More than are drawn one by one.
const POINTS: u32 = 17_000;

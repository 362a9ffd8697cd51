//! Uncertainties of robust fits.

use asphera_form::{Aperture, FitSettings, Loss, Nominal, Parameter, PointMm, fit};
use asphera_uncertainty::{Budget, Noise as NoiseOf, coverage_factor, type_a, uncertainty};
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::common::{al1815, misaligned, spiral};
use crate::spoilt::{measured, spoilt, with};

/// The scatter of 240 fits, each with its own noise and a tenth of outliers, against what the uncertainties of a
/// single one say.
#[test]
fn uncertainties_of_robust_fits_are_their_scatter() {
    let budget = Budget {
        noise: NoiseOf::Uniform { sigma_mm: 1e-5, dof: f64::INFINITY },
        ..Budget::default()
    };
    for loss in [Loss::HUBER, Loss::TUKEY] {
        let nominal = al1815();
        let one = |seed: u64| {
            let (points, _) = spoilt(&nominal, 0.1, seed);
            let points: Vec<PointMm> = points.into_iter().step_by(5).collect();
            let fitted = fit(&points, &nominal, &with(loss)).unwrap();
            let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
            let values: Vec<f64> = fitted.estimates.iter().map(|estimate| estimate.value).collect();
            let of_fit = fitted.estimates.iter().map(|estimate| estimate.u.unwrap());
            let of_budget = found.parameters.iter().map(|parameter| parameter.u);
            (values, of_fit.zip(of_budget).collect::<Vec<_>>())
        };
        let fits: Vec<_> = (0..FITS).into_par_iter().map(one).collect();
        let n = FITS as f64;
        for index in 0..5 {
            let mean = |of: &dyn Fn(usize) -> f64| (0..fits.len()).map(of).sum::<f64>() / n;
            let centre = mean(&|i| fits[i].0[index]);
            let scatter = mean(&|i| (fits[i].0[index] - centre).powi(2)).sqrt();
            let of_fit = mean(&|i| fits[i].1[index].0) / scatter;
            let of_budget = mean(&|i| fits[i].1[index].1) / scatter;
            eprintln!(
                "{loss:?} {index}: u of the fit {of_fit:.3}, of the budget {of_budget:.3} of the scatter"
            );
            // A standard deviation from 240 fits is known to 4.6 %.
            assert!((0.87..1.15).contains(&of_budget), "{loss:?} {index}: {of_budget}");
            assert!((0.85..1.2).contains(&of_fit), "{loss:?} {index}: {of_fit}");
        }
    }
}

/// One and five in a hundred points are up to a millimetre off on either side: the intervals of both losses hold the
/// sphere in 95 %. Found: 93.9 to 95.9 %; without the pull of the outliers 92.2 to 93.4 % for Huber's and 5 %.
#[test]
fn intervals_of_robust_fits_hold_the_truth_beside_outliers() {
    let (nominal, places) = (Nominal::Sphere { radius_mm: 20.0 }, spiral(300, 8.0));
    let budget = Budget {
        noise: NoiseOf::Uniform { sigma_mm: 1e-5, dof: f64::INFINITY },
        ..Budget::default()
    };
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
    for (share, loss) in
        [0.01, 0.05].into_iter().flat_map(|share| [(share, Loss::HUBER), (share, Loss::TUKEY)])
    {
        let settings =
            FitSettings { start: misaligned(), search: false, free: free.clone(), ..with(loss) };
        let one = |seed: u64| {
            let mut generator = Pcg64Mcg::seed_from_u64(seed);
            let mut uniform = || ((generator.next_u64() >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
            let mut off_mm = || {
                let (radius, angle) = (uniform(), uniform());
                let d = 1e-5 * (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos();
                if uniform() < share { d + 2.0 * uniform() - 1.0 } else { d }
            };
            let points: Vec<PointMm> =
                places.iter().map(|&place| measured(&nominal, place, off_mm())).collect();
            let fitted = fit(&points, &nominal, &settings).unwrap();
            let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
            let inside = found.parameters.iter().map(|of| {
                let truth = of.parameter.value(&misaligned(), &nominal).unwrap();
                let by_noise = coverage_factor(0.95, f64::INFINITY) * of.sources[0].1;
                let off = (of.value - truth).abs();
                [off <= of.expanded(0.95).expanded, off <= by_noise]
            });
            inside.collect::<Vec<[bool; 2]>>()
        };
        let fits: Vec<Vec<[bool; 2]>> = (0..INTERVALS).into_par_iter().map(one).collect();
        let share_of = |index: usize, which: usize| {
            let inside = fits.iter().filter(|inside| inside[index][which]).count();
            inside as f64 / INTERVALS as f64
        };
        let shares: Vec<f64> = (0..4).map(|index| share_of(index, 0)).collect();
        let by_noise: Vec<f64> = (0..4).map(|index| share_of(index, 1)).collect();
        eprintln!(
            "{loss:?}, {:.0} % outliers: inside {shares:.4?}, without their pull {by_noise:.4?}",
            100.0 * share
        );
        // Of 2,000 a share of 95 % is known to 0.5 %.
        assert!(shares.iter().all(|share| (share - 0.95).abs() < 0.015), "{loss:?}: {shares:?}");
    }
}

/// Outliers have no part in what the deviations tell of a fit that leaves them out: as if they were not there.
#[test]
fn type_a_of_a_robust_fit_does_not_see_what_it_leaves_out() {
    let (points, outliers) = spoilt(&al1815(), 0.1, 17);
    let fitted = fit(&points, &al1815(), &with(Loss::TUKEY)).unwrap();
    assert_eq!(fitted.robust.unwrap().zero, outliers);
    let found = type_a(&points, &fitted, &Aperture::None, None).unwrap();
    for (known, estimate) in found.parameters.iter().zip(&fitted.estimates) {
        let ratio = known.u / estimate.u.unwrap();
        eprintln!("{}: {ratio:.2} times the uncertainty of the fit", known.parameter);
        // A weak wave over the whole part cannot be ruled out, and would be height.
        assert!(ratio > 0.7 && ratio < 10.0, "{known:?} {estimate:?}");
    }
}

const FITS: u64 = 240;
const INTERVALS: u64 = 2_000;

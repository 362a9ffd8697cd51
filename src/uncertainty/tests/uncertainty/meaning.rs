//! What the uncertainty of a fitted parameter is that of: the fit's own, of the best fit to this very part.

use crate::common::{Noise, normals};
use asphera_form::form_error::FormError;
use asphera_form::{Aperture, FitSettings, Nominal, Parameter, PointMm, deviations, fit};
use asphera_uncertainty::glance;
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

const RADIUS_MM: f64 = 100.0;
const APERTURE_MM: f64 = 10.0;
const POINTS: usize = 1_500;
const FREE: [Parameter; 4] = [Parameter::Tz, Parameter::Rx, Parameter::Ry, Parameter::Radius];

/// One part with a form of long waves and 5 nm of noise, measured 500 times at other random places: the values scatter by
/// about what the fit says of itself, though the form is correlated. What the deviations as they are tell is another thing, and
/// far more.
#[test]
fn other_points_of_the_same_part_scatter_by_u_of_the_fit() {
    let error = FormError::typical(APERTURE_MM);
    let measured = |seed: u64| {
        let mut places = Noise::new(seed);
        let noise = normals(&mut Pcg64Mcg::seed_from_u64(1_000 + seed), POINTS);
        let points: Vec<PointMm> = noise
            .into_iter()
            .map(|noise| {
                let (radius, angle) = (
                    APERTURE_MM * (0.5 + 0.5 * places.next()).sqrt(),
                    std::f64::consts::PI * places.next(),
                );
                let (x, y) = (radius * angle.cos(), radius * angle.sin());
                let sag = RADIUS_MM - (RADIUS_MM * RADIUS_MM - radius * radius).sqrt();
                [x, y, sag + 1e-6 * (error.height_nm(x, y) + 5.0 * noise)]
            })
            .collect();
        let settings = FitSettings { free: FREE.to_vec(), search: false, ..FitSettings::default() };
        let nominal = Nominal::Sphere { radius_mm: RADIUS_MM };
        let fitted = fit(&points, &nominal, &settings).unwrap();
        (points, fitted)
    };
    let runs: Vec<Vec<(f64, f64)>> = (0..500_u64)
        .into_par_iter()
        .map(|seed| {
            let (_, fitted) = measured(seed);
            fitted.estimates.iter().map(|one| (one.value, one.u.unwrap())).collect()
        })
        .collect();
    let count = runs.len() as f64;
    let (points, fitted) = measured(0);
    let deviations_mm = deviations(&points, &fitted.nominal, &fitted.pose);
    let seen = glance(&points, &deviations_mm, &fitted, &Aperture::None, None).unwrap().unwrap();
    for (index, of_form) in seen.parameters.iter().enumerate() {
        let mean = runs.iter().map(|run| run[index].0).sum::<f64>() / count;
        let scatter =
            (runs.iter().map(|run| (run[index].0 - mean).powi(2)).sum::<f64>() / count).sqrt();
        let u = (runs.iter().map(|run| run[index].1.powi(2)).sum::<f64>() / count).sqrt();
        eprintln!(
            "{}: scatter {scatter:.3e}, u of the fit {u:.3e}, by the deviations {:.3e}",
            of_form.parameter, of_form.u
        );
        // Form is larger near the rim, which counts more for some parameters than for others.
        assert!((0.7..1.45).contains(&(u / scatter)), "{}: {u} {scatter}", of_form.parameter);
        assert!(of_form.u > 2.0 * scatter);
    }
}

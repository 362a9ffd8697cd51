//! Noise that neighbouring points share: drawn many times, against the u and the interval of the RMS.

use asphera_form::{Aperture, FitSettings, Nominal, Parameter, PointMm, fit};
use asphera_uncertainty::{Budget, Noise, uncertainty};
use rand_core::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

/// Points a side, 0.02 mm apart.
const SIDE: usize = 61;
const SPACING_MM: f64 = 0.02;
/// Standard deviation of the Gaussian that smooths white noise, in points: its correlation is exp(−h²/(4·s²)).
const SMOOTHING: f64 = 1.4;
const NOISE_NM: f64 = 200.0;

/// A wave of 900 nm, 20 points long, over a plane.
fn form_nm(i: usize, j: usize) -> f64 {
    900.0 * (std::f64::consts::TAU * (0.8 * i as f64 + 0.6 * j as f64) / 20.0).sin()
}

/// White noise smoothed by rows and columns, of the standard deviation [`NOISE_NM`].
fn noise_nm(seed: u64) -> Vec<f64> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let reach = 6;
    let wide = SIDE + 2 * reach;
    let weights: Vec<f64> = (0..=2 * reach)
        .map(|at| (-0.5 * ((at as f64 - reach as f64) / SMOOTHING).powi(2)).exp())
        .collect();
    let power: f64 = weights.iter().map(|weight| weight * weight).sum();
    let mut normal = || {
        let uniform = |word: u64| ((word >> 11) as f64 + 0.5) / (1_u64 << 53) as f64;
        let (a, b) = (uniform(random.next_u64()), uniform(random.next_u64()));
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    };
    let white: Vec<f64> = (0..wide * wide).map(|_| normal()).collect();
    let smooth = |at: &dyn Fn(usize) -> f64| -> f64 {
        weights.iter().enumerate().map(|(step, weight)| weight * at(step)).sum()
    };
    let rows: Vec<f64> = (0..wide * SIDE)
        .map(|index| smooth(&|step| white[index / SIDE * wide + index % SIDE + step]))
        .collect();
    (0..SIDE * SIDE)
        .map(|index| smooth(&|step| rows[index + step * SIDE]) / power * NOISE_NM)
        .collect()
}

/// The noise of 300 scans scatters the RMS as much as u says, which is five times what it would be for independent noise. The 95 %
/// interval holds the truth in 91 to 99 % (one in 10,000 beyond).
#[test]
fn shared_noise_scatters_the_rms_as_told() {
    let places = || (0..SIDE * SIDE).map(|index| (index % SIDE, index / SIDE));
    let settings = FitSettings {
        free: vec![Parameter::Tz, Parameter::Rx, Parameter::Ry],
        ..FitSettings::default()
    };
    let found = |noise_nm: &[f64], shared: f64| {
        let points: Vec<PointMm> = places()
            .zip(noise_nm)
            .map(|((i, j), noise)| {
                let z_nm = form_nm(i, j) + noise;
                [SPACING_MM * i as f64, SPACING_MM * j as f64, 1e-6 * z_nm]
            })
            .collect();
        let fitted = fit(&points, &Nominal::Plane, &settings).unwrap();
        let noise = Noise::Uniform { sigma_mm: 1e-6 * NOISE_NM, dof: f64::INFINITY };
        let budget = Budget { noise, noise_shared_by: shared, ..Budget::default() };
        uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap().rms
    };
    // ℓ² = 2·s², and a point on a unit of area.
    let shared = std::f64::consts::TAU * 2.0 * SMOOTHING * SMOOTHING;
    let truth_nm = found(&vec![0.0; SIDE * SIDE], 1.0).measured_nm;
    let scans = 300;
    let rms: Vec<(f64, f64, bool)> = (0..scans)
        .into_par_iter()
        .map(|seed| {
            let rms = found(&noise_nm(seed), shared);
            let [low, high] = rms.interval_nm(0.95);
            (rms.form_nm, rms.u_nm, low <= truth_nm && truth_nm <= high)
        })
        .collect();
    let mean =
        |of: &dyn Fn(&(f64, f64, bool)) -> f64| rms.iter().map(of).sum::<f64>() / scans as f64;
    let middle = mean(&|(form, ..)| *form);
    let scatter = mean(&|(form, ..)| (form - middle).powi(2)).sqrt();
    let told = mean(&|(_, u, _)| *u);
    assert!((scatter / told - 1.0).abs() < 0.17, "{scatter} {told}");
    assert!((middle - truth_nm).abs() < 0.3 * told, "{middle} {truth_nm} {told}");
    let held = mean(&|(.., holds)| f64::from(*holds));
    assert!((0.91..=0.99).contains(&held), "{held}");
    let alone = found(&noise_nm(0), 1.0).u_nm;
    assert!(told > 4.0 * alone, "{told} {alone}");
}

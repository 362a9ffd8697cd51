//! What noise does to spectra of coefficients and to slopes: told, and taken off.

use std::f64::consts::TAU;
use std::num::NonZeroU8;

use asphera_figures::{Sample, SlopeSettings, q_spectrum, slopes};
use asphera_form::Aperture;

use super::DISC;
use crate::common::{Noise, spiral};

/// Σ a_m·u²(1 − u²)·Q_m(u²) with the first six polynomials in powers of u², as prysm 0.21.1 has them
/// (`prysm.polynomials.Qbfs`), by their recurrence: Forbes, Opt. Express 18 (2010) 19700, appendix A.
fn series_nm(coefficients: &[f64; 6], u: f64) -> f64 {
    let x = u * u;
    let (mut f, mut g, mut h) = (vec![2.0, 19.0_f64.sqrt() / 2.0], vec![-0.5], vec![]);
    let (mut p, mut q) = (vec![2.0, 6.0 - 8.0 * x], vec![1.0, (13.0 - 16.0 * x) / 19.0_f64.sqrt()]);
    for m in 2..6 {
        h.push(-((m * (m - 1)) as f64) / (2.0 * f[m - 2]));
        g.push(-(1.0 + g[m - 2] * h[m - 2]) / f[m - 1]);
        f.push(((m * (m + 1)) as f64 + 3.0 - g[m - 1] * g[m - 1] - h[m - 2] * h[m - 2]).sqrt());
        p.push((2.0 - 4.0 * x) * p[m - 1] - p[m - 2]);
        q.push((p[m] - g[m - 1] * q[m - 1] - h[m - 2] * q[m - 2]) / f[m]);
    }
    coefficients.iter().zip(&q).map(|(a, q)| a * x * (1.0 - x) * q).sum()
}

/// Of mean square 1; uniform, as nothing here hangs on the kind.
fn next(noise: &mut Noise) -> f64 {
    3.0_f64.sqrt() * noise.next()
}

/// Points of a disc that ends short of the aperture, as of a part that is masked at the rim.
fn part(places: &[[f64; 2]], truth: &[f64; 6], sigma_nm: f64, noise: &mut Noise) -> Sample {
    let deviations: Vec<f64> = places
        .iter()
        .map(|[x, y]| series_nm(truth, x.hypot(*y) / 5.0) + sigma_nm * next(noise))
        .map(|nm| nm * 1e-6)
        .collect();
    Sample::new(places, &deviations, None, &DISC).unwrap()
}

const TRUTH: [f64; 6] = [-413.0, 0.0, 50.0, 0.0, 0.0, -60.0];

#[test]
fn coefficients_lie_within_their_uncertainties_of_the_truth() {
    let places = spiral(1500, 4.9);
    let slope_urad = TRUTH.iter().map(|a| a * a).sum::<f64>().sqrt() / 5.0;
    let (mut held, mut all, mut slopes_held, mut cut) = (0_usize, 0_usize, 0_usize, 0_usize);
    let mut errors = [0.0; 6];
    let mut us = [0.0; 6];
    const PARTS: usize = 100;
    for seed in 0..PARTS as u64 {
        let sample = part(&places, &TRUTH, 5.0, &mut Noise::new(seed + 1));
        let found = q_spectrum(&sample, NonZeroU8::new(16).unwrap(), Some(5.0)).unwrap();
        let given = found.coefficients_nm.len();
        cut += usize::from(given == 6);
        assert!(given >= 6 && found.ends(), "{given} terms");
        for m in 0..6 {
            let (error, u) = (found.coefficients_nm[m] - TRUTH[m], found.u_nm[m]);
            held += usize::from(error.abs() <= 1.96 * u);
            all += 1;
            errors[m] += error / PARTS as f64;
            us[m] += u / PARTS as f64;
            assert!(!found.is_determined(m) || error.abs() < 6.0 * u);
        }
        let [low, high] = found.slope.interval_urad(1.96);
        slopes_held += usize::from(low <= slope_urad && slope_urad <= high);
    }
    assert!(cut >= PARTS - 3, "the series ended at the last term there is in {cut} of {PARTS}");
    let share = held as f64 / all as f64;
    assert!((0.91..0.985).contains(&share), "{share} of the coefficients");
    let share = slopes_held as f64 / PARTS as f64;
    assert!(share >= 0.86, "{share} of the slopes");
    for m in 0..6 {
        let standard = us[m] / (PARTS as f64).sqrt();
        assert!(errors[m].abs() < 3.5 * standard, "a{m}: {} of {standard}", errors[m]);
    }
}

/// The figures of issue 14: all 24 terms of a masked disc are off by thousands of nm, and none of that is told.
/// Astigmatism, coma and trefoil of 200 nm counted as noise of so much: the first terms then were not determined.
#[test]
fn form_that_is_not_rotational_is_no_noise() {
    let places = spiral(1500, 4.9);
    let terms = NonZeroU8::new(16).unwrap();
    let found = |size_nm: f64| {
        let mut noise = Noise::new(7);
        let nm = |[x, y]: [f64; 2]| {
            let [u, v] = [x / 5.0, y / 5.0];
            let (square, cosine) = (u * u + v * v, u * u - v * v);
            let form =
                1.5 * cosine + 0.8 * square * u * v + square * v - 0.5 * (3.0 * u * u - v * v) * v;
            series_nm(&TRUTH, square.sqrt()) + size_nm * form
        };
        let deviations: Vec<f64> =
            places.iter().map(|&place| 1e-6 * (nm(place) + 5.0 * next(&mut noise))).collect();
        let sample = Sample::new(&places, &deviations, None, &DISC).unwrap();
        q_spectrum(&sample, terms, Some(5.0)).unwrap()
    };
    let (plain, with) = (found(0.0), found(200.0));
    assert!(!with.noise_of_residuals && with.noise_nm == 5.0, "{}", with.noise_nm);
    assert_eq!(with.coefficients_nm.len(), plain.coefficients_nm.len());
    for (m, truth) in TRUTH.into_iter().enumerate() {
        let error = with.coefficients_nm[m] - truth;
        assert!(error.abs() < 4.0 * with.u_nm[m], "a{m}: {error}, u {}", with.u_nm[m]);
        assert!((with.u_nm[m] / plain.u_nm[m] - 1.0).abs() < 0.01);
        assert!(m > 0 || with.is_determined(m));
    }
}

#[test]
fn terms_that_noise_drowns_are_not_given() {
    let places = spiral(4000, 4.9);
    let sample = part(&places, &TRUTH, 5.0, &mut Noise::new(3));
    let all = NonZeroU8::new(24).unwrap();
    let found = q_spectrum(&sample, all, Some(5.0)).unwrap();
    assert_eq!((found.asked, found.coefficients_nm.len()), (24, 6));
    assert!((0..6).all(|m| found.is_determined(m)));
    assert!((found.coefficients_nm[0] + 413.0).abs() < 4.0 * found.u_nm[0], "{found:?}");
    assert!(found.u_nm[0] < 30.0, "{found:?}");
    // Without a noise all terms stay that the places tell apart, and their u says what they are worth.
    let unknown = q_spectrum(&sample, NonZeroU8::new(12).unwrap(), None).unwrap();
    assert!(unknown.noise_of_residuals && (unknown.noise_nm - 5.0).abs() < 0.3, "{unknown:?}");
    assert_eq!(unknown.coefficients_nm.len(), 12);
    assert!(unknown.u_nm[0] > 10.0 * found.u_nm[0]);
    assert!((unknown.coefficients_nm[0] + 413.0).abs() < 4.0 * unknown.u_nm[0]);
    // A wave along the radius that needs more terms than noise lets be told: none of them is given.
    let waves: Vec<f64> = places
        .iter()
        .map(|[x, y]| 40.0 * (TAU * 4.0 * (x.hypot(*y) / 5.0).powi(2)).cos())
        .collect();
    let mut noise = Noise::new(9);
    let near = places.iter().map(|place| place.map(|part| 0.8 * part)).collect::<Vec<_>>();
    let deviations: Vec<f64> =
        waves.iter().map(|nm| (nm + 5.0 * next(&mut noise)) * 1e-6).collect();
    let sample = Sample::new(&near, &deviations, None, &DISC).unwrap();
    let found = q_spectrum(&sample, NonZeroU8::new(12).unwrap(), Some(5.0)).unwrap();
    assert!((0..found.coefficients_nm.len()).any(|m| !found.is_determined(m)), "{found:?}");
}

#[test]
fn noise_is_taken_off_slopes() {
    let (sigma_nm, places) = (5.0, spiral(20_000, 5.0));
    let form = |[x, y]: [f64; 2]| 6.0 * x + 0.5 * x * y;
    let settings = SlopeSettings::new(0.5, 0.25).unwrap();
    let sample = |sigma_nm: f64, seed: u64| {
        let mut noise = Noise::new(seed);
        let of = |place: &[f64; 2]| (form(*place) + sigma_nm * next(&mut noise)) * 1e-6;
        let deviations: Vec<f64> = places.iter().map(of).collect();
        Sample::new(&places, &deviations, None, &DISC).unwrap()
    };
    let truth = slopes(&sample(0.0, 1), settings).unwrap();
    let kinds = [truth.meridional, truth.gradient];
    let (mut squares, mut missed) = ([0.0; 2], 0);
    const PARTS: u64 = 10;
    for seed in 1..=PARTS {
        let found = slopes(&sample(sigma_nm, seed), settings).unwrap();
        for (kind, (found_of, truth)) in
            [found.meridional, found.gradient].iter().zip(kinds).enumerate()
        {
            squares[kind] += (found_of.rms_urad.powi(2) - truth.rms_urad.powi(2)) / PARTS as f64;
            let without = found_of.rms_without_noise_urad(sigma_nm);
            // With the noise it is half as much again and more.
            assert!(found_of.rms_urad > 1.4 * truth.rms_urad, "{found_of:?}");
            assert!((without / truth.rms_urad - 1.0).abs() < 0.25, "{without} {truth:?}");
            let raised = found_of.max_urad - truth.max_urad;
            missed += usize::from(raised > found_of.noise_on_max_urad(sigma_nm, found.stations));
        }
    }
    for (square, truth) in squares.iter().zip(kinds) {
        let share = square.sqrt() / (sigma_nm * truth.noise_rms_urad);
        assert!((share - 1.0).abs() < 0.06, "{share}");
    }
    assert!(missed <= 2, "{missed}");
    // Areas weigh the noise as they weigh the heights.
    let areas: Vec<f64> = (0..places.len()).map(|i| if i % 2 == 0 { 1.0 } else { 0.2 }).collect();
    let mut squares = 0.0;
    let mut told = 0.0;
    for seed in 1..=6 {
        let mut noise = Noise::new(seed);
        let deviations: Vec<f64> = places.iter().map(|_| next(&mut noise) * 1e-6).collect();
        let sample = Sample::new(&places, &deviations, Some(&areas), &Aperture::None).unwrap();
        let found = slopes(&sample, settings).unwrap().gradient;
        squares += found.rms_urad.powi(2) / 6.0;
        told = found.noise_rms_urad;
    }
    assert!((squares.sqrt() / told - 1.0).abs() < 0.05, "{squares} {told}");
}

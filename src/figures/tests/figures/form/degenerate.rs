//! Data that tell little or nothing: never a number that is not known, never NaN, never a panic.

use std::num::{NonZeroU8, NonZeroU16};

use asphera_figures::{
    Approximation, FringeCount, Reference, Sample, SettingError, Share, SlopeSettings, Term,
    Unknown, azimuthal_profile, decompose, fringe_fit, peak_to_valley, pvr, q_spectrum,
    radial_profile, remove, rms, robust_peak_to_valley, slopes,
};
use asphera_form::Aperture;
use proptest::prelude::*;

use super::{disc, part};
use crate::common::spiral;

const Q_TERMS: NonZeroU8 = NonZeroU8::new(5).unwrap();

fn sample(places: &[[f64; 2]], heights_nm: &[f64], aperture: &Aperture) -> Sample {
    let deviations: Vec<f64> = heights_nm.iter().map(|nm| nm * 1e-6).collect();
    Sample::new(places, &deviations, None, aperture).unwrap()
}

/// Every number the sample has; panics on one that is not finite.
fn numbers(sample: &Sample) -> usize {
    let mut found: Vec<f64> = Vec::new();
    let figures = [
        peak_to_valley(sample),
        rms(sample, Reference::Zero),
        rms(sample, Reference::Mean),
        robust_peak_to_valley(sample, Share::NINETY_NINE),
        pvr(sample, FringeCount::ThirtySix),
        pvr(sample, FringeCount::ThirtySeven),
    ];
    found.extend(figures.iter().flatten().map(|figure| figure.value));
    if let Ok(fit) = fringe_fit(sample, FringeCount::ThirtySix) {
        found.extend(fit.coefficients_nm.iter().flatten());
        found.extend([fit.residual_rms_nm, fit.condition]);
        found.extend(fit.spectrum().iter().map(|line| line.rms_nm));
    }
    for approximation in [Approximation::Quadratic, Approximation::sphere(1e3).unwrap()] {
        for rings in [None, NonZeroU16::new(40)] {
            if let Ok(parts) = decompose(sample, approximation, rings) {
                found.extend(parts.figures().map(|figure| figure.value));
                found.extend(&parts.variant_nm);
            }
        }
    }
    if let Ok(removed) = remove(sample, &[Term::Piston, Term::Tilt, Term::Spherical]) {
        found.extend(removed.sample.values_nm());
    }
    if let Ok(q) = q_spectrum(sample, Q_TERMS, None) {
        found.extend(&q.coefficients_nm);
        found.push(q.slope.fitted_urad);
    }
    if let Ok(slopes) = slopes(sample, SlopeSettings::new(0.5, 0.3).unwrap()) {
        found.extend(slopes.figures().map(|figure| figure.value));
    }
    let rings = radial_profile(sample, None).unwrap_or_default();
    let sectors = azimuthal_profile(sample, NonZeroU16::new(9).unwrap(), None).unwrap_or_default();
    let heights = rings.iter().map(|ring| ring.heights);
    let heights = heights.chain(sectors.iter().map(|sector| sector.heights)).flatten();
    found.extend(heights.flat_map(|heights| [heights.mean_nm, heights.spread_nm]));
    assert!(found.iter().all(|number| number.is_finite()), "{found:?}");
    found.len()
}

#[test]
fn no_points_have_no_figures() {
    let empty = sample(&[], &[], &Aperture::None);
    assert_eq!(numbers(&empty), 0);
    assert_eq!(peak_to_valley(&empty), Err(Unknown::NoPoints));
    assert_eq!(pvr(&empty, FringeCount::ThirtySix), Err(Unknown::NoPoints));
    let outside = sample(&[[9.0, 0.0]], &[1.0], &Aperture::Circle { radius_mm: 1.0 });
    assert_eq!(numbers(&outside), 0);
    let nothing = sample(&[[0.0; 2]; 3], &[f64::NAN; 3], &Aperture::None);
    assert_eq!((numbers(&nothing), nothing.left_out().not_finite), (0, 3));
}

#[test]
fn one_and_two_points_have_a_range_and_no_fit() {
    for count in [1, 2] {
        let places = [[1.0, 2.0], [3.0, -1.0]];
        let few = sample(&places[..count], &[5.0, 9.0][..count], &Aperture::None);
        assert!(numbers(&few) > 0);
        assert_eq!(peak_to_valley(&few).unwrap().value, 4.0 * (count - 1) as f64);
        let needed = Err(Unknown::TooFewPoints { used: count, needed: 37 });
        assert_eq!(pvr(&few, FringeCount::ThirtySix), needed);
        let parts = decompose(&few, Approximation::Quadratic, None);
        assert_eq!(parts.unwrap_err(), Unknown::TooFewPoints { used: count, needed: 5 });
        assert!(remove(&few, &[Term::Tilt]).is_err());
    }
}

#[test]
fn a_line_determines_neither_all_terms_nor_a_figure_of_them() {
    let places: Vec<[f64; 2]> = (0..500).map(|i| [f64::from(i) * 0.01 - 2.5, 0.0]).collect();
    let heights: Vec<f64> = places.iter().map(|p| 3.0 + 10.0 * p[0]).collect();
    let line = sample(&places, &heights, &Aperture::None);
    assert!(numbers(&line) > 0);
    let fit = fringe_fit(&line, FringeCount::ThirtySix).unwrap();
    assert!(fit.indeterminate().contains(&3) && fit.indeterminate().contains(&5));
    assert!((fit.coefficient_nm(2).unwrap() - 25.0).abs() < 1e-9);
    assert_eq!(fit.aberrations(), None);
    let Err(Unknown::Indeterminate { terms }) = pvr(&line, FringeCount::ThirtySix) else {
        panic!("a line has no PVr");
    };
    assert_eq!(terms, fit.indeterminate());
    // The tilt across the line goes without saying; that along it is removed.
    let removed = remove(&line, &[Term::Piston, Term::Tilt]).unwrap();
    assert_eq!(removed.coefficients_nm[2], (3, None));
    assert!(removed.sample.values_nm().iter().all(|nm| nm.abs() < 1e-9));
}

#[test]
fn one_radius_determines_no_sphere() {
    let ring = |r: f64| {
        (0..100).map(move |i| [r * (0.1 * f64::from(i)).cos(), r * (0.1 * f64::from(i)).sin()])
    };
    let places: Vec<[f64; 2]> = ring(2.0).collect();
    let one = part(&places, |x, _| x * x);
    assert!(numbers(&one) > 0);
    let unknown = decompose(&one, Approximation::Quadratic, None).unwrap_err();
    assert_eq!(unknown, Unknown::IndeterminateSphere);
    assert!(matches!(
        q_spectrum(&one, Q_TERMS, None),
        Err(Unknown::IndeterminateSeries { wanted: 9, .. })
    ));
    let free = sample(&places, &[1.0; 100], &Aperture::None);
    assert_eq!(radial_profile(&free, NonZeroU16::new(7)).unwrap().len(), 1);
}

#[test]
fn points_on_the_axis_alone_have_no_radius() {
    let axis = sample(&[[0.0; 2]; 50], &[2.0; 50], &Aperture::None);
    assert!(numbers(&axis) > 0);
    for unknown in [
        decompose(&axis, Approximation::Quadratic, None).unwrap_err(),
        radial_profile(&axis, None).unwrap_err(),
        remove(&axis, &[Term::Power]).unwrap_err(),
        q_spectrum(&axis, Q_TERMS, None).unwrap_err(),
    ] {
        assert_eq!(unknown, Unknown::OnePlace);
    }
    let removed = remove(&axis, &[Term::Piston]).unwrap();
    assert!(removed.sample.values_nm().iter().all(|nm| nm.abs() < 1e-12));
}

#[test]
fn equal_heights_have_figures_of_zero_and_no_directions() {
    let flat = disc(2000, |_, _| 0.0);
    assert!(numbers(&flat) > 0);
    let found = decompose(&flat, Approximation::Quadratic, None).unwrap();
    assert!(found.figures().iter().all(|figure| figure.value == 0.0));
    let fit = fringe_fit(&flat, FringeCount::ThirtySix).unwrap();
    assert_eq!(fit.aberrations().unwrap().astigmatism.direction_rad, None);
    assert_eq!(rms(&flat, Reference::Mean).unwrap().value, 0.0);
}

#[test]
fn large_offsets_and_extreme_sizes_keep_figures_finite() {
    let lattice: Vec<[f64; 2]> =
        (0..400).map(|i| [f64::from(i % 20) - 9.5, f64::from(i / 20) - 9.5]).collect();
    for scale in [1e-50, 1e-9, 1.0, 1e9, 1e50] {
        let places: Vec<[f64; 2]> = lattice.iter().map(|p| p.map(|c| c * scale)).collect();
        for height in [1e-40, 1.0, 1e40] {
            let heights: Vec<f64> = lattice.iter().map(|p| height * (p[0] * p[1]).sin()).collect();
            assert!(numbers(&sample(&places, &heights, &Aperture::None)) > 0);
        }
    }
    // A part far from the axis of its frame: 1 mm of it, 1 m away.
    let far: Vec<[f64; 2]> = spiral(500, 0.5).iter().map(|p| [p[0] + 1000.0, p[1]]).collect();
    let heights: Vec<f64> = far.iter().map(|p| (p[0] - 1000.0) * 5.0 + 1e6).collect();
    let far = sample(&far, &heights, &Aperture::None);
    assert!(numbers(&far) > 0);
    let removed = remove(&far, &[Term::Piston, Term::Tilt]).unwrap();
    assert!(peak_to_valley(&removed.sample).unwrap().value < 1e-6);
    let beyond = sample(&[[1e200, 0.0], [1.0, 0.0]], &[1.0, 1.0], &Aperture::None);
    assert_eq!((beyond.len(), beyond.left_out().not_finite), (1, 1));
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(SlopeSettings::new(bad, 1.0), Err(SettingError::Length { .. })));
        assert!(matches!(SlopeSettings::new(1.0, bad), Err(SettingError::Length { .. })));
    }
    for bad in [0.0, 1.1, f64::NAN] {
        assert!(matches!(Share::new(bad), Err(SettingError::Share { .. })));
    }
    assert!(Approximation::sphere(0.0).is_err() && Approximation::sphere(f64::INFINITY).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn areas_of_any_size_give_finite_numbers(
        areas in prop::collection::vec(
            prop::sample::select(vec![0.0, 5e-324, 1e-300, 1e-18, 1e-3, 1.0, 7.0, 1e59]),
            60..90,
        ),
    ) {
        let places = &spiral(90, 5.0)[..areas.len()];
        let deviations: Vec<f64> = places.iter().map(|p| (p[0] * p[1]).sin() * 1e-5).collect();
        let made = Sample::new(places, &deviations, Some(&areas), &Aperture::None);
        prop_assert_eq!(made.is_err(), areas.iter().all(|&area| area == 0.0));
        if let Ok(sample) = made {
            numbers(&sample);
        }
    }

    #[test]
    fn coarse_lattices_with_holes_give_finite_numbers(
        points in prop::collection::vec((-3..=3i32, -3..=3i32, prop::option::of(-2..=2i32)), 0..90),
        scale in prop::sample::select(vec![1e-3, 1.0, 1.6]),
    ) {
        let places: Vec<[f64; 2]> =
            points.iter().map(|&(x, y, _)| [f64::from(x) * scale, f64::from(y) * scale]).collect();
        let heights: Vec<f64> =
            points.iter().map(|&(_, _, z)| z.map_or(f64::NAN, f64::from)).collect();
        let ring = Aperture::Annulus { inner_mm: scale, outer_mm: 3.0 * scale };
        let rectangle = Aperture::Rectangle { width_mm: 4.0 * scale, height_mm: 2.0 * scale };
        for aperture in [Aperture::None, ring, rectangle] {
            numbers(&sample(&places, &heights, &aperture));
        }
    }
}

//! Deviations whose figures are known.

use std::f64::consts::PI;
use std::num::{NonZeroU8, NonZeroU16};

use asphera_figures::Definition;
use asphera_figures::{
    Approximation, Comparison, FringeCount, Indication, Reference, Sample, Share, SlopeSettings,
    Term, Unknown, azimuthal_profile, decompose, fringe_fit, peak_to_valley, pvr, q_spectrum,
    radial_profile, remove, rms, robust_peak_to_valley, slopes,
};
use asphera_form::Aperture;
use asphera_form::basis::{Normalisation, Zernike, zernike_value};

use super::{DISC, disc, part};
use crate::common::{Noise, spiral};

fn term(index: u8, x: f64, y: f64) -> f64 {
    let set = Zernike::fringe_37(Normalisation::UnitHeight);
    let (n, m) = set.orders()[usize::from(index) - 1];
    zernike_value(n, m, Normalisation::UnitHeight, x / 5.0, y / 5.0).unwrap()
}

fn rings(count: u16) -> Option<NonZeroU16> {
    NonZeroU16::new(count)
}

#[test]
fn every_fringe_term_is_found_again_at_random_places_with_a_gap() {
    let mut noise = Noise::new(7);
    let places: Vec<[f64; 2]> = (0..6000)
        .map(|_| [5.0 * noise.next(), 5.0 * noise.next()])
        .filter(|p| p[0].hypot(p[1]) <= 5.0 && (p[0] < 2.0 || p[1] < 1.0))
        .collect();
    let coefficient = |index: u8| f64::from(index % 7) * 10.0 - 25.0;
    let sample = part(&places, |x, y| (1..=37).map(|j| coefficient(j) * term(j, x, y)).sum());
    let fit = fringe_fit(&sample, FringeCount::ThirtySeven).unwrap();
    for index in 1..=37 {
        let found = fit.coefficient_nm(index).unwrap();
        assert!((found - coefficient(index)).abs() < 1e-8, "{index}: {found}");
    }
    assert!(fit.residual_rms_nm < 1e-8 && fit.indeterminate().is_empty());
    assert_eq!((fit.coefficient_nm(0), fit.coefficient_nm(38)), (None, None));
    // What the fit takes up whole has PVr = PV; without term 37 three times its remainder is added.
    let (pv, whole) = (peak_to_valley(&sample).unwrap(), pvr(&sample, FringeCount::ThirtySeven));
    assert!((whole.unwrap().value - pv.value).abs() < 1e-6);
    assert!(pvr(&sample, FringeCount::ThirtySix).unwrap().value > pv.value + 0.1);
}

#[test]
fn amplitudes_of_power() {
    // 2ρ² − 1 has the range 2 and, with ρ² evenly spread, the RMS 1/√3 and the middle 99 % 1.98.
    let sample = disc(10_000, |x, y| 30.0 + 50.0 * term(4, x, y));
    assert!((peak_to_valley(&sample).unwrap().value - 100.0).abs() < 0.02);
    let about_mean = rms(&sample, Reference::Mean).unwrap();
    assert!((about_mean.value - 50.0 / 3.0_f64.sqrt()).abs() < 1e-6);
    assert_eq!(about_mean.definition, Definition::RmsAboutMean);
    let about_zero = rms(&sample, Reference::Zero).unwrap().value;
    assert!((about_zero - (900.0 + 2500.0 / 3.0_f64).sqrt()).abs() < 1e-6);
    let robust = |share| robust_peak_to_valley(&sample, Share::new(share).unwrap()).unwrap().value;
    assert!((robust(0.99) - 99.0).abs() < 0.021, "{}", robust(0.99));
    assert_eq!(robust(1.0), peak_to_valley(&sample).unwrap().value);
    assert!(robust(1e-9) < 0.011);
}

#[test]
fn robust_range_leaves_out_whole_points_of_the_stated_area() {
    let deviations: Vec<f64> = (0..1000).map(|i| f64::from(i * 619 % 1000) * 1e-6).collect();
    let range = |share| {
        let sample = Sample::new(&[[0.0; 2]; 1000], &deviations, None, &Aperture::None).unwrap();
        robust_peak_to_valley(&sample, Share::new(share).unwrap()).unwrap().value.round()
    };
    // The fifth lowest is 4, the fifth highest 995.
    assert_eq!((range(0.99), range(0.998), range(0.9989)), (991.0, 999.0, 999.0));
    // A spike of a thousandth of the area does not count, one of a hundredth does.
    let spike = |area| {
        let mut areas = vec![1.0; 1000];
        areas[0] = area;
        let mut deviations = deviations.clone();
        deviations[0] = 1.0;
        let sample =
            Sample::new(&[[0.0; 2]; 1000], &deviations, Some(&areas), &Aperture::None).unwrap();
        robust_peak_to_valley(&sample, Share::NINETY_NINE).unwrap().value
    };
    assert!(spike(1.0) < 1000.0 && spike(10.0) > 9e5);
}

#[test]
fn removal_takes_the_terms_named_and_no_others() {
    let sample = disc(20_000, |x, y| (1..=11).map(|j| f64::from(j) * term(j, x, y)).sum());
    let removed = remove(&sample, &[Term::Coma, Term::Tilt, Term::Piston, Term::Tilt]).unwrap();
    assert_eq!(removed.terms, [Term::Piston, Term::Tilt, Term::Coma]);
    let numbers: Vec<u8> = removed.coefficients_nm.iter().map(|(index, _)| *index).collect();
    assert_eq!(numbers, [1, 2, 3, 7, 8]);
    let fit = fringe_fit(&removed.sample, FringeCount::ThirtySix).unwrap();
    for index in 1..=36 {
        let gone = [1, 2, 3, 7, 8].contains(&index) || index > 11;
        let expected = if gone { 0.0 } else { f64::from(index) };
        let found = fit.coefficient_nm(index).unwrap();
        assert!((found - expected).abs() < 2e-3, "{index}: {found}");
    }
    assert_eq!(remove(&sample, &[]).unwrap().sample, sample);
}

#[test]
fn aberrations_have_their_size_and_direction() {
    let sample = disc(4000, |x, y| {
        let (r, phi) = (x.hypot(y) / 5.0, y.atan2(x));
        let astigmatism = 40.0 * r * r * (2.0 * (phi - 0.6)).cos();
        let coma = 20.0 * (3.0 * r.powi(3) - 2.0 * r) * (phi - 5.0).cos();
        let trefoil = 7.0 * r.powi(3) * (3.0 * (phi - 2.0)).cos();
        astigmatism + coma + trefoil + 11.0 * term(4, x, y) - 6.0 * term(9, x, y)
    });
    let fit = fringe_fit(&sample, FringeCount::ThirtySix).unwrap();
    let found = fit.aberrations().unwrap();
    let pairs =
        [(found.astigmatism, 40.0, 0.6), (found.coma, 20.0, 5.0), (found.trefoil, 7.0, 2.0)];
    for (pair, magnitude, direction) in pairs {
        assert!((pair.magnitude_nm - magnitude).abs() < 1e-9, "{pair:?}");
        assert!((pair.direction_rad.unwrap() - direction).abs() < 1e-9, "{pair:?}");
    }
    assert!((found.power_nm - 11.0).abs() < 1e-9 && (found.spherical_nm + 6.0).abs() < 1e-9);
    // By orthogonality over the disc the squares of the spectrum add up to that of the RMS.
    let spectrum = fit.spectrum();
    let square: f64 = spectrum.iter().map(|line| line.rms_nm * line.rms_nm).sum();
    let whole = rms(&sample, Reference::Zero).unwrap().value;
    assert!((square.sqrt() / whole - 1.0).abs() < 2e-3);
    let line = spectrum.iter().find(|line| (line.n, line.m) == (2, 2)).unwrap();
    assert!((line.rms_nm - 40.0 / 6.0_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn decomposition_of_known_parts() {
    // Piston, tilt, power and astigmatism, and spherical as the rotationally invariant irregularity.
    let height = |x: f64, y: f64| {
        9.0 + 3.0 * x - y + 50.0 * term(4, x, y) + 20.0 * term(5, x, y) + 8.0 * term(9, x, y)
    };
    let sample = disc(40_000, height);
    let found = decompose(&sample, Approximation::Quadratic, rings(100)).unwrap();
    let near = |value: f64, expected: f64| (value - expected).abs() < 0.02;
    assert!(near(found.a_nm, 100.0) && near(found.sagitta_nm, 100.0), "{}", found.a_nm);
    assert!(near(found.c_nm, 12.0), "{}", found.c_nm);
    assert!(near(found.rms_variant_nm, 20.0 / 6.0_f64.sqrt()), "{}", found.rms_variant_nm);
    let irregularity = (400.0 / 6.0 + 64.0 / 5.0_f64).sqrt();
    assert!(near(found.rms_irregularity_nm, irregularity));
    let total = (2500.0 / 3.0 + irregularity * irregularity).sqrt();
    assert!(near(found.rms_total_nm, total));
    // Total = sphere + irregularity, irregularity = invariant + variant, and the parts are orthogonal.
    let parts = found.invariant_nm.iter().zip(&found.variant_nm).zip(&found.irregularity_nm);
    let (mut product, mut mean) = (0.0, 0.0);
    for ((invariant, variant), irregularity) in parts {
        assert!((invariant + variant - irregularity).abs() < 1e-12);
        product += invariant * variant;
        mean += irregularity;
    }
    assert!(product.abs() / 4e4 < 1e-9 && mean.abs() / 4e4 < 1e-9, "{product} {mean}");
    let limits: Indication = "3/0.2(0.2/0.05) RMSi<0.03; λ=1000".parse().unwrap();
    let holds: Vec<bool> = limits.compare(&found).iter().map(Comparison::holds).collect();
    assert_eq!(holds, [true, true, true, true]);
    let limits: Indication = "3/99.9(–/11.9); RMSa<8.1".parse().unwrap();
    let compared = limits.compare(&found);
    assert_eq!(compared[1].definition, Definition::InvariantIrregularity);
    let holds: Vec<bool> = compared.iter().map(Comparison::holds).collect();
    assert_eq!(holds, [false, false, false]);
}

#[test]
fn a_sphere_seen_through_gaps_is_no_irregularity() {
    // The whole right third is missing; a change of radius and a decentre of a sphere of 8 mm.
    let places: Vec<[f64; 2]> = spiral(5000, 5.0).into_iter().filter(|p| p[0] < 1.5).collect();
    let sample = part(&places, |x, y| {
        let cos = (1.0 - (x * x + y * y) / 64.0).sqrt();
        300.0 * (1.0 - cos) + 12.0 * x / 8.0 - 5.0 * cos
    });
    let sphere = Approximation::sphere(-8.0).unwrap();
    let found = decompose(&sample, sphere, None).unwrap();
    assert!(found.b_nm < 1e-9 && found.rms_variant_nm < 1e-9, "{}", found.b_nm);
    let expected = 305.0 * (1.0 - (1.0 - 25.0 / 64.0_f64).sqrt());
    assert!((found.sagitta_nm - expected).abs() < 1e-9);
    // The quadratic part alone leaves the difference of the two shapes.
    let quadratic = decompose(&sample, Approximation::Quadratic, None).unwrap();
    assert!(quadratic.b_nm > 1.0);
    let small = Approximation::sphere(4.9).unwrap();
    let beyond = decompose(&sample, small, None).unwrap_err();
    assert_eq!(beyond, Unknown::BeyondSphere { reach_mm: 5.0, radius_mm: 4.9 });
}

#[test]
fn the_sagitta_is_over_the_aperture_not_over_the_points() {
    let height = |p: &[f64; 2]| 4e-6 * (p[0] * p[0] + p[1] * p[1]);
    // The rim is not measured, nor is the middle.
    let places: Vec<[f64; 2]> =
        spiral(3000, 4.0).into_iter().filter(|p| p[0].hypot(p[1]) > 2.0).collect();
    let deviations: Vec<f64> = places.iter().map(height).collect();
    let sagitta = |aperture| {
        let sample = Sample::new(&places, &deviations, None, &aperture).unwrap();
        decompose(&sample, Approximation::Quadratic, None).unwrap().sagitta_nm
    };
    let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;
    assert!(near(sagitta(Aperture::Circle { radius_mm: 5.0 }), 100.0));
    assert!(near(sagitta(Aperture::Annulus { inner_mm: 1.0, outer_mm: 5.0 }), 96.0));
    assert!(near(sagitta(Aperture::Rectangle { width_mm: 6.0, height_mm: 8.0 }), 100.0));
    // Without an aperture only the points say where the part ends.
    let free = sagitta(Aperture::None);
    assert!((47.9..48.1).contains(&free), "{free}");
}

#[test]
fn azimuthal_mean_over_an_exact_polar_scan() {
    // Radii 0, 1, …, 5 in more intervals than there are radii: knots join, the mean is exact.
    let places: Vec<[f64; 2]> = (0..6)
        .flat_map(|r| (0..64).map(move |k| (f64::from(r), f64::from(k) * PI / 32.0)))
        .map(|(r, phi)| [r * phi.cos(), r * phi.sin()])
        .filter(|place| place[0].hypot(place[1]) <= 5.0)
        .collect();
    let sample = part(&places, |x, y| 10.0 * term(9, x, y) + 4.0 * term(5, x, y));
    for count in [1, 2, 5, 17, 1000] {
        let found = decompose(&sample, Approximation::Quadratic, rings(count)).unwrap();
        assert!(found.variant_nm.iter().all(|nm| nm.is_finite()), "{count} rings");
        assert!(found.rms_variant_nm <= found.rms_irregularity_nm * (1.0 + 1e-12));
    }
}

#[test]
fn q_spectrum_finds_its_coefficients() {
    // Q0 = 1 and Q1 = (13 − 16u²)/√19 beside a power and a tilt.
    let sample = disc(3000, |x, y| {
        let u = (x * x + y * y) / 25.0;
        let series = 30.0 - 12.0 * (13.0 - 16.0 * u) / 19.0_f64.sqrt();
        5.0 + 2.0 * x + 70.0 * u + u * (1.0 - u) * series
    });
    let found = q_spectrum(&sample, NonZeroU8::new(6).unwrap(), None).unwrap();
    assert!((found.power_nm - 70.0).abs() < 1e-9);
    let expected = [30.0, -12.0, 0.0, 0.0, 0.0, 0.0];
    for (found, expected) in found.coefficients_nm.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9, "{found}");
    }
    assert!((found.slope.fitted_urad - 30.0_f64.hypot(12.0) / 5.0).abs() < 1e-9);
}

/// Bessel function J₂ by its integral, (1/π)·∫ cos(2τ − x·sin τ) dτ over half a turn.
fn bessel_2(x: f64) -> f64 {
    let nodes = 200;
    let node = |k: i32| {
        let tau = (f64::from(k) + 0.5) * PI / f64::from(nodes);
        (2.0 * tau - x * tau.sin()).cos()
    };
    (0..nodes).map(node).sum::<f64>() / f64::from(nodes)
}

#[test]
fn slopes_of_a_plane_and_of_waves() {
    let settings = SlopeSettings::new(0.5, 0.25).unwrap();
    let plane = slopes(&disc(20_000, |x, y| 1e6 + 30.0 * x - 40.0 * y), settings).unwrap();
    for slope in [plane.gradient.max_urad, plane.gradient.rms_urad, plane.meridional.max_urad] {
        assert!((slope - 50.0).abs() < 1e-6, "{slope}");
    }
    // Along a meridian at φ the plane rises by 50·cos(φ − φ₀): an RMS of 50/√2.
    assert!((plane.meridional.rms_urad - 50.0 / 2.0_f64.sqrt()).abs() < 0.4);
    assert!(plane.stations > 1100 && plane.unmeasured < 110, "{plane:?}");

    for wave_mm in [0.6, 1.0, 4.0] {
        let k = 2.0 * PI / wave_mm;
        let found = slopes(&disc(200_000, |x, _| 10.0 * (k * x).sin()), settings).unwrap();
        let a = 0.25;
        let expected = 10.0 * k * 8.0 * bessel_2(k * a) / (k * a).powi(2);
        // Stations see every phase of the wave, and discs cut by the border are few.
        let share = found.gradient.rms_urad * 2.0_f64.sqrt() / expected;
        assert!((share - 1.0).abs() < 0.03, "{wave_mm} mm: {share}");
    }
    // A gap and the border are counted, not bridged.
    let places: Vec<[f64; 2]> =
        spiral(20_000, 5.0).into_iter().filter(|p| (p[0] - 2.0).hypot(p[1]) > 1.0).collect();
    let holed = slopes(&part(&places, |x, _| 3.0 * x), settings).unwrap();
    assert_eq!(holed.stations + holed.unmeasured, plane.stations + plane.unmeasured);
    assert!(holed.unmeasured >= plane.unmeasured + 35, "{holed:?}");
    assert!((holed.gradient.max_urad - 3.0).abs() < 1e-9);
    let sparse = slopes(&disc(50, |x, _| x), SlopeSettings::new(0.1, 1.0).unwrap());
    assert!(matches!(sparse, Err(Unknown::Unsupported { stations: 81, .. })), "{sparse:?}");
    let fine = slopes(&disc(50, |x, _| x), SlopeSettings::new(0.1, 1e-4).unwrap());
    assert!(matches!(fine, Err(Unknown::TooManyStations { .. })));
}

#[test]
fn profiles_of_rings_and_sectors() {
    let places: Vec<[f64; 2]> = spiral(50_000, 5.0)
        .into_iter()
        .filter(|p| {
            !(2.0..3.0).contains(&p[0].hypot(p[1])) && (p[0].hypot(p[1]) < 3.0 || p[0] > 0.0)
        })
        .collect();
    let sample = part(&places, |x, y| x.hypot(y) * 10.0 + 4.0 * (2.0 * y.atan2(x)).cos());
    let profile = radial_profile(&sample, rings(5)).unwrap();
    assert_eq!(profile[2].heights, None);
    assert_eq!((profile[2].count, profile[2].covered), (0, 0.0));
    assert_eq!((profile[0].covered, profile[4].covered), (1.0, 0.5));
    // Mean radius of a ring from a to b is 2/3·(b³ − a³)/(b² − a²); the astigmatism averages out.
    let heights = profile[1].heights.unwrap();
    assert!((heights.mean_nm - 10.0 * 14.0 / 9.0).abs() < 0.02, "{heights:?}");
    // Mean square of the radius is (a² + b²)/2 = 2.5.
    let spread = (100.0 * (2.5 - (14.0 / 9.0_f64).powi(2)) + 8.0).sqrt();
    assert!((heights.spread_nm - spread).abs() < 0.02, "{heights:?} {spread}");
    assert!(heights.low_nm > 5.9 && heights.high_nm < 24.1);

    let sectors =
        azimuthal_profile(&sample, NonZeroU16::new(8).unwrap(), Some([1.0, 2.0])).unwrap();
    for (k, sector) in sectors.iter().enumerate() {
        // The mean of cos 2φ from kπ/4 to (k+1)π/4 is ±2/π, with the sign + − − +.
        let sign = if matches!(k % 4, 0 | 3) { 1.0 } else { -1.0 };
        let expected = 10.0 * 14.0 / 9.0 + sign * 8.0 / PI;
        let found = sector.heights.unwrap().mean_nm;
        assert!((found - expected).abs() < 0.1, "{k}: {found} {expected}");
    }
    let half = azimuthal_profile(&sample, NonZeroU16::new(4).unwrap(), Some([3.0, 5.0])).unwrap();
    assert!(half[0].count > 0 && half[1].heights.is_none() && half[2].heights.is_none());
    let none = azimuthal_profile(&sample, NonZeroU16::MIN, Some([6.0, 7.0]));
    assert_eq!(none, Err(Unknown::NoPoints));
    assert!(DISC.contains(3.0, 4.0));
}

//! References made from the points themselves: what they find, what they hide, what they refuse.

use std::f64::consts::{PI, TAU};

use asphera_form::{
    Aperture, Base, Knots, PointMm, Pose, ReferenceError, ReferenceSettings, Smoothing, reference,
};
use proptest::prelude::*;

use crate::common::{Noise, spiral};

const COUNT: usize = 12_000;

/// Points on a graph over a disc of 8 mm, with normal noise of z.
fn points(count: usize, sigma_mm: f64, sag: impl Fn(f64, f64) -> f64) -> Vec<PointMm> {
    let mut noise = Noise::new(5);
    spiral(count, 8.0)
        .into_iter()
        .map(|[x, y]| {
            // A sum of twelve uniform numbers of variance 1/3 is all but normal.
            let normal = (0..12).map(|_| noise.next()).sum::<f64>() / 2.0;
            [x, y, sag(x, y) + sigma_mm * normal]
        })
        .collect()
}

fn sphere(radius_mm: f64, x: f64, y: f64) -> f64 {
    (x * x + y * y) / (radius_mm + (radius_mm * radius_mm - x * x - y * y).sqrt())
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, square) = values.fold((0.0, 0.0), |(n, sum), value| (n + 1.0, sum + value * value));
    (square / count).sqrt()
}

#[test]
fn the_base_and_the_noise_are_found() {
    let sigma_mm = 2e-5;
    let tilted = |x: f64, y: f64| 0.3 + 0.01 * x - 0.02 * y;
    let saddle = |x: f64, y: f64| 0.4 + 2e-3 * x * x - 1e-3 * y * y + 5e-4 * x * y;
    type Sag<'a> = &'a dyn Fn(f64, f64) -> f64;
    let cases: [(Sag, Base); 4] = [
        (&tilted, Base::Plane),
        (&|x, y| sphere(30.0, x, y), Base::Sphere),
        (&|x, y| -sphere(11.0, x, y), Base::Sphere),
        (&saddle, Base::Quadric),
    ];
    for (sag, base) in cases {
        let points = points(COUNT, sigma_mm, sag);
        let found = reference(&points, &ReferenceSettings::default()).unwrap();
        assert_eq!(found.base, base);
        let noise_mm = found.spline.noise_mm.unwrap();
        eprintln!(
            "{}: noise {:.2} nm of {:.0}, {:.0} effective parameters",
            base.name(),
            1e6 * noise_mm,
            1e6 * sigma_mm,
            found.spline.effective_parameters
        );
        assert!((noise_mm / sigma_mm - 1.0).abs() < 0.03, "{noise_mm:e}");
        assert_eq!(found.fit.used, COUNT);
        assert!(found.fit.residuals.rms_mm < 1.01 * sigma_mm);
        assert!(found.fit.dof < COUNT && found.fit.dof > COUNT / 2);
    }
    let steep = points(COUNT, sigma_mm, |x, y| -sphere(11.0, x, y));
    let found = reference(&steep, &ReferenceSettings::default()).unwrap();
    let radius_mm = found.base_fit.nominal.radius_mm().unwrap();
    assert!((radius_mm + 11.0).abs() < 1e-5, "{radius_mm}");
}

/// Half the height of a wave of the length told is followed, nearly all of a long one, hardly any of a short one.
#[test]
fn waves_are_followed_as_told() {
    let smoothing = Smoothing::Relative { lambda: 1e3 };
    let settings = ReferenceSettings {
        base: Some(Base::Plane),
        knots: Knots::Spacing(0.3),
        smoothing,
        ..ReferenceSettings::default()
    };
    let amplitude = |wave_mm: f64| {
        let wave = |x: f64| (TAU * x / wave_mm).cos();
        let points = points(COUNT, 0.0, |x, _| 1e-4 * wave(x));
        let found = reference(&points, &settings).unwrap();
        let cutoff_mm = found.spline.cutoff_mm[0];
        // Projected onto the wave, away from the rim where splines have less to hold on to.
        let near = || points.iter().filter(|[x, y, _]| x.hypot(*y) < 5.0);
        let part = |point: &PointMm| found.fit.pose.to_part(*point);
        let sag = |point: &PointMm| {
            let [x, y, _] = part(point);
            found.fit.nominal.height_mm(x, y).unwrap() + found.fit.pose.tz_mm
        };
        let mean = near().map(|point| wave(point[0])).sum::<f64>() / near().count() as f64;
        let along: f64 = near().map(|point| sag(point) * (wave(point[0]) - mean)).sum();
        let square: f64 = near().map(|point| wave(point[0]) * (wave(point[0]) - mean)).sum();
        (along / square / 1e-4, cutoff_mm)
    };
    let (_, cutoff_mm) = amplitude(3.0);
    let [long, half, short] = [2.0, 1.0, 0.5].map(|share| amplitude(share * cutoff_mm).0);
    eprintln!("cutoff {cutoff_mm:.3} mm: {long:.3}, {half:.3}, {short:.3} of the height");
    // 1/(1 + 2^-4), 1/2, 1/(1 + 2^4).
    assert!((long - 16.0 / 17.0).abs() < 0.02);
    assert!((half - 0.5).abs() < 0.03);
    assert!((short - 1.0 / 17.0).abs() < 0.02);
}

#[test]
fn a_defect_narrower_than_the_knots_stays_in_the_deviation() {
    let bump = |x: f64, y: f64| 3e-4 * (-((x - 2.0).powi(2) + (y - 1.0).powi(2)) / 0.02).exp();
    let points = points(COUNT, 1e-5, |x, y| sphere(40.0, x, y) + bump(x, y));
    let settings = ReferenceSettings { knots: Knots::Spacing(2.0), ..ReferenceSettings::default() };
    let found = reference(&points, &settings).unwrap();
    assert!(found.fit.residuals.high_mm > 2e-4, "{:e}", found.fit.residuals.high_mm);
    assert!(found.fit.residuals.low_mm > -1e-4);
}

#[test]
fn what_makes_no_surface_is_refused_with_the_cure() {
    let defaults = ReferenceSettings::default();
    let points = points(400, 0.0, |x, y| 1e-3 * (x * x + y * y));
    let error = |points: &[PointMm], settings: ReferenceSettings| {
        let error = reference(points, &settings).unwrap_err();
        eprintln!("{error}");
        error
    };
    assert_eq!(error(&[], defaults.clone()), ReferenceError::TooFew { used: 0, outside: 0 });
    assert_eq!(
        error(&points[..15], defaults.clone()),
        ReferenceError::TooFew { used: 15, outside: 0 }
    );
    let away = ReferenceSettings {
        aperture: Aperture::Circle { radius_mm: 1.0 },
        centre_mm: Some([100.0, 0.0]),
        ..defaults.clone()
    };
    assert_eq!(error(&points, away), ReferenceError::TooFew { used: 0, outside: 400 });
    let line: Vec<PointMm> = (0..500)
        .map(|i| [0.01 * f64::from(i), 0.02 * f64::from(i), (0.1 * f64::from(i)).sin()])
        .collect();
    assert!(matches!(error(&line, defaults.clone()), ReferenceError::Line { used: 500, .. }));
    assert!(matches!(error(&[[1.0, 2.0, 3.0]; 40], defaults.clone()), ReferenceError::Line { .. }));
    let knots = |knots| ReferenceSettings { knots, ..defaults.clone() };
    let finer = error(&points, knots(Knots::Spacing(0.5)));
    let ReferenceError::FinerThanPoints { least_mm, .. } = finer else { panic!("{finer}") };
    assert!(reference(&points, &knots(Knots::Spacing(least_mm * 1.001))).is_ok());
    assert!(matches!(
        error(&points, knots(Knots::Across(40))),
        ReferenceError::FinerThanPoints { .. }
    ));
    for spacing in [0.0, -1.0, f64::NAN] {
        assert!(matches!(
            error(&points, knots(Knots::Spacing(spacing))),
            ReferenceError::Spacing(_)
        ));
    }
    assert!(matches!(error(&points, knots(Knots::Across(0))), ReferenceError::Spacing(_)));
    let dense = self::points(160_000, 0.0, |x, _| 1e-3 * x);
    let many = knots(Knots::Spacing(0.1));
    assert!(matches!(error(&dense, many), ReferenceError::Cells { nx: 160, .. }));
    let bad = Smoothing::Relative { lambda: -1.0 };
    let bad = ReferenceSettings { smoothing: bad, ..defaults.clone() };
    assert!(matches!(error(&points, bad), ReferenceError::Spline(_)));
    let bad = ReferenceSettings { centre_mm: Some([f64::NAN, 0.0]), ..defaults.clone() };
    assert!(matches!(error(&points, bad), ReferenceError::Centre(_)));
}

#[test]
fn points_that_are_not_finite_are_left_out() {
    let mut points = points(2000, 1e-5, |x, y| sphere(30.0, x, y));
    let whole = reference(&points, &ReferenceSettings::default()).unwrap();
    points.push([f64::NAN, 0.0, 0.0]);
    points.push([0.0, 0.0, f64::INFINITY]);
    let found = reference(&points, &ReferenceSettings::default()).unwrap();
    assert_eq!((found.fit.used, found.fit.excluded.not_finite), (2000, 2));
    assert_eq!(found.fit.residuals, whole.fit.residuals);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Shifts, turns about z and small tilts of the points change the deviation by rounding and by the way tilts
    /// change what is along z.
    #[test]
    fn the_deviation_moves_with_the_points(
        shift in prop::array::uniform3(-1e3..1e3f64),
        tilt in prop::array::uniform2(-0.02..0.02f64),
    ) {
        let surface = |x: f64, y: f64| sphere(25.0, x, y) + 1e-4 * (PI * x / 2.0).sin() * (PI * y / 3.0).cos();
        let flat = points(3000, 1e-5, surface);
        let pose = Pose {
            tx_mm: shift[0], ty_mm: shift[1], tz_mm: shift[2], rx_rad: tilt[0], ry_rad: tilt[1], rz_rad: 0.0,
        };
        let moved: Vec<PointMm> = flat.iter().map(|point| pose.to_measured(*point)).collect();
        let settings = ReferenceSettings { base: Some(Base::Sphere), ..ReferenceSettings::default() };
        let first = reference(&flat, &settings).unwrap();
        let second = reference(&moved, &settings).unwrap();
        let deviations = |found: &asphera_form::Reference, points: &[PointMm]| {
            asphera_form::deviations(points, &found.fit.nominal, &found.fit.pose)
        };
        let (a, b) = (deviations(&first, &flat), deviations(&second, &moved));
        let off = rms(a.iter().zip(&b).map(|(a, b)| a - b));
        prop_assert!(off < 0.05 * rms(a.iter().copied()), "{off:e}");
    }
}

//! Forecasts of forms whose whole is known.

use super::*;
use asphera_figures::{Reference, Sample, Term, peak_to_valley, rms};
use asphera_form::{FitSettings, PointMm, deviations, fit};

const RADIUS_MM: f64 = 10.0;

/// A disc with points 0.25 mm apart, line by line.
fn disc(nm: impl Fn(f64, f64) -> f64) -> Vec<PointMm> {
    let mut points = Vec::new();
    for line in 0..81 {
        for column in 0..81 {
            let (x, y) = (0.25 * f64::from(column) - 10.0, 0.25 * f64::from(line) - 10.0);
            if x.hypot(y) <= RADIUS_MM {
                points.push([x, y, 1e-6 * nm(x, y)]);
            }
        }
    }
    points
}

/// Forecast of PV and RMS after `less` by these points of a plane, and what they are of these points.
fn foreseen(points: &[PointMm], less: &Terms, missing: Option<f64>) -> ([Predicted; 2], [f64; 2]) {
    let found = fit(points, &Nominal::Plane, &FitSettings::default()).unwrap();
    let deviations_mm = deviations(points, &found.nominal, &found.pose);
    let places: Vec<[f64; 2]> =
        points.iter().map(|&point| found.pose.to_part(point)).map(|[x, y, _]| [x, y]).collect();
    let sample = Sample::new(&places, &deviations_mm, None, &Aperture::None).unwrap();
    let sample = asphera_figures::remove(&sample, &less.list()).unwrap().sample;
    let now =
        [peak_to_valley(&sample).unwrap().value, rms(&sample, Reference::Zero).unwrap().value];
    let free: Vec<Parameter> = found.estimates.iter().map(|one| one.parameter).collect();
    let aperture = Aperture::Circle { radius_mm: RADIUS_MM };
    let measured = Deviations { places_mm: &places, deviations_mm: &deviations_mm };
    let whole = forecast(measured, &aperture, &found.nominal, &found.pose, &free, missing).unwrap();
    let of = [Definition::PeakToValley, Definition::RmsOverPoints];
    let predicted = [0, 1].map(|figure| {
        let laid = (&places[..], &deviations_mm[..]);
        whole.predict(of[figure], &Aperture::None, less, now[figure], laid).unwrap()
    });
    (predicted, now)
}

#[test]
fn what_is_measured_never_becomes_less_and_its_rms_hardly_more() {
    let points = disc(|x, y| 20.0 * (0.9 * x).sin() * (0.7 * y).cos() + 0.3 * x * y);
    for less in [Terms::NONE, Terms::new(&[Term::Astigmatism])] {
        let (predicted, now) = foreseen(&points, &less, None);
        // Blocks at the rim may seem not quite whole and have an extreme to come, the more where terms reach highest there.
        for ((predicted, now), most) in predicted.iter().zip(now).zip([1.6, 1.05]) {
            let [low, high] = [0.01, 0.99].map(|p| predicted.quantile_nm(p) / now);
            assert!(low > 0.99 && high < most, "{low} {high}");
        }
        // Unless it is known that nothing is missing.
        let (predicted, now) = foreseen(&points, &less, Some(0.0));
        for (predicted, now) in predicted.iter().zip(now) {
            let [low, high] = [0.0, 1.0].map(|p| predicted.quantile_nm(p) / now);
            assert!((low - 1.0).abs() < 0.01 && (high - 1.0).abs() < 0.01, "{low} {high}");
        }
    }
}

/// A saddle of which the fit of one part swallows most.
#[test]
fn long_waves_that_the_fit_swallowed_are_expected_in_the_rest() {
    let points = disc(|x, y| 2.0 * (x * x - y * y) + 3.0 * (1.3 * x).sin() * (1.1 * y).sin());
    let (_, [pv_nm, rms_nm]) = foreseen(&points, &Terms::NONE, None);
    let part = &points[..6 * points.len() / 10];
    let ([pv, rms], [pv_now_nm, rms_now_nm]) = foreseen(part, &Terms::NONE, None);
    assert!(pv_now_nm < 0.9 * pv_nm && rms_now_nm < 0.9 * rms_nm, "{pv_now_nm} {pv_nm}");
    assert!(pv.quantile_nm(0.95) > pv_nm && rms.quantile_nm(0.95) > rms_nm, "{pv_nm} {rms_nm}");
    assert!(rms.beyond(rms_nm) > 0.05 && rms.beyond(10.0 * rms_nm) < 0.01);
}

#[test]
fn too_little_tells_nothing_and_the_same_gives_the_same_bits() {
    let plane = (Nominal::Plane, Pose::default(), Aperture::Circle { radius_mm: RADIUS_MM });
    let of = |places: &[[f64; 2]], free: &[Parameter]| {
        let deviations_mm: Vec<f64> = places.iter().map(|[x, y]| 1e-6 * (x * y).sin()).collect();
        let measured = Deviations { places_mm: places, deviations_mm: &deviations_mm };
        forecast(measured, &plane.2, &plane.0, &plane.1, free, None)
    };
    assert!(of(&[], &[Parameter::Tz]).is_none() && of(&[[1.0, 2.0]; 50], &[]).is_none());
    let places: Vec<[f64; 2]> = disc(|_, _| 0.0).iter().map(|[x, y, _]| [*x, *y]).collect();
    assert!(of(&places[..400], &[Parameter::Tz]).is_none());
    let half = &places[..places.len() / 2];
    let means = |found: Option<Forecast>| found.unwrap().draws[7].mean_nm.clone();
    assert_eq!(means(of(half, &[])), means(of(half, &[])));
    let even = Deviations { places_mm: half, deviations_mm: &vec![0.0; half.len()] };
    let no_aperture = forecast(even, &Aperture::None, &plane.0, &plane.1, &[], None);
    assert!(no_aperture.is_none());
}

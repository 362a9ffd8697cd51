//! Fits with a known answer: numerical artefacts, closed forms, far offsets.

use crate::common::{Noise, al1815, misaligned, pose_difference, spiral};
use asphera_form::artefact::Artefact;
use asphera_form::zernike::FormError;
use asphera_form::{
    Aperture, Figures, FitSettings, Nominal, Parameter, PointMm, Pose, deviations, fit,
};

fn shape_free(extra: &[Parameter]) -> Vec<Parameter> {
    Parameter::RIGID.iter().chain(extra).copied().collect()
}

fn artefact_points(
    nominal: Nominal,
    pose: Pose,
    free: &[Parameter],
    sample: &[[f64; 2]],
    radius_mm: f64,
) -> (Vec<PointMm>, Vec<f64>) {
    let error = FormError::typical(radius_mm);
    let error_mm = move |x: f64, y: f64| error.height_nm(x, y) * 1e-6;
    let artefact = Artefact::new(nominal, pose, free, sample, error_mm).unwrap();
    let points = sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
    let deviations = sample.iter().map(|&[x, y]| artefact.deviation_mm(x, y).unwrap()).collect();
    (points, deviations)
}

#[test]
fn artefact_on_an_asphere_gives_back_pose_and_deviations() {
    let sample = spiral(20_000, 9.0);
    let (points, truth) = artefact_points(al1815(), misaligned(), &Parameter::RIGID, &sample, 9.0);
    let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert!(fitted.indeterminate.is_empty());
    let difference = pose_difference(&fitted.pose, &misaligned());
    eprintln!(
        "pose off by {difference:e}, {} iterations, condition {}",
        fitted.iterations, fitted.condition
    );
    assert!(difference < 1e-12, "{difference:e}");
    let found = deviations(&points, &fitted.nominal, &fitted.pose);
    for (found, truth) in found.iter().zip(&truth) {
        assert!((found - truth).abs() < 2e-14, "{found:e} {truth:e}");
    }
    let figures = Figures::new(&points, &found, &fitted.pose, &Aperture::None).unwrap();
    let rms = (truth.iter().map(|d| d * d).sum::<f64>() / truth.len() as f64).sqrt();
    assert!((figures.rms_nm - rms * 1e6).abs() < 1e-8);
}

#[test]
fn artefact_with_free_shape_gives_back_the_shape() {
    let free = shape_free(&[Parameter::Radius, Parameter::Conic, Parameter::A(4), Parameter::A(6)]);
    let sample = spiral(20_000, 9.0);
    let (points, _) = artefact_points(al1815(), misaligned(), &free, &sample, 9.0);
    let Nominal::Asphere(mut begin) = al1815() else { unreachable!() };
    begin.radius_mm += 0.02;
    begin.conic += 0.03;
    begin.coefficients[0] *= 1.2;
    let settings = FitSettings { free, ..FitSettings::default() };
    let fitted = fit(&points, &Nominal::Asphere(begin), &settings).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    let (found, truth) = (*fitted.nominal.asphere().unwrap(), *al1815().asphere().unwrap());
    eprintln!(
        "radius off by {:e}, conic by {:e}, A4 by {:e}, pose by {:e}, condition {:e}",
        found.radius_mm - truth.radius_mm,
        found.conic - truth.conic,
        found.coefficients[0] - truth.coefficients[0],
        pose_difference(&fitted.pose, &misaligned()),
        fitted.condition,
    );
    // A8 and above of the start are the truth and stayed; the free ones came back.
    assert!((found.radius_mm - truth.radius_mm).abs() < 1e-10);
    assert!((found.conic - truth.conic).abs() < 1e-9);
    assert!((found.coefficients[0] - truth.coefficients[0]).abs() < 1e-13);
    assert!((found.coefficients[1] - truth.coefficients[1]).abs() < 1e-15);
    assert!(pose_difference(&fitted.pose, &misaligned()) < 1e-10);
}

#[test]
fn artefacts_on_spheres_and_planes() {
    let far = Pose { tx_mm: 310.0, ty_mm: -220.0, tz_mm: 95.0, ..Pose::default() };
    for radius_mm in [25.0, -25.0, 400.0] {
        let free = [Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
        let nominal = Nominal::Sphere { radius_mm };
        let (points, _) = artefact_points(nominal, far, &free, &spiral(3_000, 12.0), 12.0);
        let begin = Nominal::Sphere { radius_mm: radius_mm * 1.01 };
        let settings = FitSettings { free: free.to_vec(), ..FitSettings::default() };
        let fitted = fit(&points, &begin, &settings).unwrap();
        assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
        let off = fitted.nominal.radius_mm().unwrap() - radius_mm;
        assert!(off.abs() < 1e-9, "R {radius_mm}: off by {off:e}");
        let off = pose_difference(&fitted.pose, &far);
        assert!(off < 1e-9, "R {radius_mm}: pose off by {off:e}");
    }
    let tilted = Pose { tz_mm: 7.0, rx_rad: 0.3, ry_rad: -0.2, ..Pose::default() };
    let (points, _) =
        artefact_points(Nominal::Plane, tilted, &Parameter::RIGID, &spiral(3_000, 12.0), 12.0);
    let fitted = fit(&points, &Nominal::Plane, &FitSettings::default()).unwrap();
    assert_eq!(fitted.indeterminate, [Parameter::Tx, Parameter::Ty]);
    assert!(pose_difference(&fitted.pose, &tilted) < 1e-13);
}

/// Plane by the formula for three points, and by the sums of a regression where the normal is known.
#[test]
fn plane_closed_forms() {
    let exact = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.5], [0.0, 2.0, 0.6]];
    let fitted = fit(&exact, &Nominal::Plane, &FitSettings::default()).unwrap();
    assert_eq!((fitted.used, fitted.dof, fitted.sigma_mm), (3, 0, 0.0));
    assert!(fitted.estimates.iter().all(|estimate| estimate.u.is_none()));
    // z = 1 + 0.5·x − 0.2·y: normal (−0.5, 0.2, 1), so tan ry = −0.5.
    assert!((fitted.pose.tz_mm - 1.0).abs() < 1e-15);
    assert!((fitted.pose.ry_rad - (-0.5_f64).atan()).abs() < 1e-15);
    assert!((fitted.pose.rx_rad - (-0.2_f64).atan2(1.25_f64.sqrt())).abs() < 1e-15);

    // Symmetric heights over a square: the plane is z = mean, σ² the sum over n − 3.
    let square = [[1., 1., 3.], [-1., 1., 1.], [-1., -1., 3.], [1., -1., 1.]];
    let fitted = fit(&square, &Nominal::Plane, &FitSettings::default()).unwrap();
    assert!(pose_difference(&fitted.pose, &Pose { tz_mm: 2.0, ..Pose::default() }) < 1e-15);
    assert_eq!(fitted.dof, 1);
    assert!((fitted.sigma_mm - 2.0).abs() < 1e-14);
    let u: Vec<f64> = fitted.estimates.iter().map(|estimate| estimate.u.unwrap()).collect();
    assert!(u.iter().all(|u| (u - 1.0).abs() < 1e-14), "{u:?}");
}

/// A map of 640 × 480 heights of a few nm over 0.7 mm whose coordinates begin at 0.
#[test]
fn height_map_that_begins_at_the_corner() {
    let pitch = 0.7 / 640.0;
    let mut noise = Noise::new(7);
    let (slope_x, slope_y, level) = (2.0e-4, -1.1e-4, 3.4e-3);
    let points: Vec<PointMm> = (0..480)
        .flat_map(|row| (0..640).map(move |column| (column, row)))
        .map(|(column, row)| {
            let (x, y) = (f64::from(column) * pitch, f64::from(row) * pitch);
            [x, y, level + slope_x * x + slope_y * y + 5e-6 * noise.next()]
        })
        .collect();
    let fitted = fit(&points, &Nominal::Plane, &FitSettings::default()).unwrap();
    assert!(fitted.termination.is_converged());
    // The vertical regression plane, by its normal equations in centred coordinates on the full grid,
    // where the mixed sums vanish.
    let n = points.len() as f64;
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / n;
    let (mx, my, mz) = (mean(0), mean(1), mean(2));
    let sum = |f: &dyn Fn(&PointMm) -> f64| points.iter().map(f).sum::<f64>();
    let a = sum(&|p| (p[0] - mx) * (p[2] - mz)) / sum(&|p| (p[0] - mx).powi(2));
    let b = sum(&|p| (p[1] - my) * (p[2] - mz)) / sum(&|p| (p[1] - my).powi(2));
    let square = sum(&|p| (p[2] - mz - a * (p[0] - mx) - b * (p[1] - my)).powi(2));
    // Orthogonal and vertical distance differ by the cosine of the tilt, 3e-8.
    let rms = (square / n).sqrt() * (1.0 + a * a + b * b).sqrt().recip();
    let found = deviations(&points, &Nominal::Plane, &fitted.pose);
    let figures = Figures::new(&points, &found, &fitted.pose, &Aperture::None).unwrap();
    assert!((figures.rms_nm / (rms * 1e6) - 1.0).abs() < 1e-9, "{} {}", figures.rms_nm, rms * 1e6);
    assert!((fitted.pose.tz_mm - (mz - a * mx - b * my)).abs() < 1e-12);
}

#[test]
fn far_offsets_are_found_without_a_start() {
    let far =
        Pose { tx_mm: 412.0, ty_mm: -97.0, tz_mm: -33.0, rx_rad: 2e-3, ry_rad: 1e-3, rz_rad: 0.0 };
    let (points, _) = artefact_points(al1815(), far, &Parameter::RIGID, &spiral(5_000, 9.0), 9.0);
    let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert!(pose_difference(&fitted.pose, &far) < 1e-11, "{:?}", fitted.pose);
    // A part of the lens that does not hold the vertex.
    let off_axis: Vec<[f64; 2]> =
        spiral(5_000, 3.0).into_iter().map(|[x, y]| [x + 5.0, y + 1.0]).collect();
    let (points, _) = artefact_points(al1815(), far, &Parameter::RIGID, &off_axis, 9.0);
    let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert!(pose_difference(&fitted.pose, &far) < 1e-9, "{:?}", fitted.pose);
}

#[test]
fn only_points_in_the_aperture_count_and_the_rest_is_counted() {
    let sample = spiral(8_000, 7.0);
    let (mut points, _) = artefact_points(al1815(), misaligned(), &Parameter::RIGID, &sample, 9.0);
    // Rubbish on the rim and beyond, as a scan that leaves the part brings it.
    for [x, y] in spiral(500, 1.0) {
        let r = x.hypot(y);
        let (x, y) = ((7.5 + r) * x / r, (7.5 + r) * y / r);
        points.push(misaligned().to_measured([x, y, 3.0]));
    }
    points.push([f64::NAN, 0.0, 0.0]);
    let settings =
        FitSettings { aperture: Aperture::Circle { radius_mm: 7.2 }, ..FitSettings::default() };
    let fitted = fit(&points, &al1815(), &settings).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert_eq!(fitted.used, 8_000);
    assert_eq!((fitted.excluded.not_finite, fitted.excluded.outside_aperture), (1, 500));
    assert!(pose_difference(&fitted.pose, &misaligned()) < 1e-12);
}

//! Fits against SciPy: `tests/reference.py` makes the points and `tests/reference.txt`.

use asphera_form::{
    Aperture, Asphere, Figures, FitSettings, Nominal, Parameter, PointMm, Pose, deviations, fit,
};

use crate::common::al1815;

/// The numbers of the line that begins with `name`.
pub(crate) fn reference(name: &str) -> Vec<f64> {
    let mut lines = include_str!("../reference.txt").lines();
    let line = lines.find(|line| line.split(' ').next() == Some(name)).unwrap();
    line.split(' ').skip(1).map(|number| number.parse().unwrap()).collect()
}

/// `made` of reference.py.
pub(crate) fn made(
    count: u32,
    radius_mm: f64,
    nominal: &Nominal,
    roughness: f64,
    pose: &Pose,
) -> Vec<PointMm> {
    let weyl = |i: u32, f: f64| (f64::from(i) * f).fract();
    (1..=count)
        .map(|i| {
            let r = radius_mm * weyl(i, 0.8191725133961645).sqrt();
            let phi = 2.0 * std::f64::consts::PI * weyl(i, 0.6710436067037893);
            let w = 2.0 * weyl(i, 0.5497004779019703) - 1.0;
            let (x, y) = (r * phi.cos(), r * phi.sin());
            pose.to_measured([x, y, nominal.sag_mm(x.hypot(y)) + roughness * w])
        })
        .collect()
}

/// Values within `share` of their uncertainty, uncertainties within 1e-4, RMS within 1e-9 of SciPy's.
fn compare(name: &str, points: &[PointMm], begin: &Nominal, start: Pose, free: &[Parameter]) {
    let settings = FitSettings { free: free.to_vec(), start, ..FitSettings::default() };
    let fitted = fit(points, begin, &settings).unwrap();
    assert!(fitted.termination.is_converged(), "{name}: {:?}", fitted.termination);
    let expected = reference(name);
    assert_eq!(expected.len(), 2 * free.len() + 1);
    for (i, estimate) in fitted.estimates.iter().enumerate() {
        let (value, u) = (expected[i], expected[free.len() + i]);
        let off = (estimate.value - value) / u;
        eprintln!("{name} {}: off by {off:e} of its uncertainty", estimate.parameter);
        assert!(off.abs() < 1e-5, "{name} {}: {off:e}", estimate.parameter);
        assert!((estimate.u.unwrap() / u - 1.0).abs() < 1e-4, "{name} {estimate:?} {u}");
    }
    let found = deviations(points, &fitted.nominal, &fitted.pose);
    let figures = Figures::new(points, &found, &fitted.pose, &Aperture::None).unwrap();
    let rms_nm = expected[2 * free.len()] * 1e6;
    assert!((figures.rms_nm / rms_nm - 1.0).abs() < 1e-9, "{name}: {} {rms_nm}", figures.rms_nm);
}

pub(crate) fn lens_pose() -> Pose {
    Pose { tx_mm: 0.03, ty_mm: -0.02, tz_mm: 0.4, rx_rad: 5e-4, ry_rad: -3e-4, rz_rad: 0.0 }
}

#[test]
fn asphere_by_shifts_and_tilts() {
    let points = made(400, 9.0, &al1815(), 1e-3, &lens_pose());
    compare("asphere_rigid", &points, &al1815(), Pose::default(), &Parameter::RIGID);
}

#[test]
fn asphere_by_shifts_tilts_radius_and_conic() {
    let points = made(400, 9.0, &al1815(), 1e-3, &lens_pose());
    let Nominal::Asphere(asphere) = al1815() else { unreachable!() };
    let begin = Nominal::Asphere(Asphere { radius_mm: 11.9, conic: -0.9, ..asphere });
    let free: Vec<Parameter> =
        Parameter::RIGID.into_iter().chain([Parameter::Radius, Parameter::Conic]).collect();
    compare("asphere_shape", &points, &begin, Pose::default(), &free);
}

#[test]
fn sphere_far_away() {
    let pose = Pose { tx_mm: 120.0, ty_mm: -80.0, tz_mm: 15.0, ..Pose::default() };
    let points = made(300, 12.0, &Nominal::Sphere { radius_mm: -40.0 }, 1e-2, &pose);
    let free = [Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
    compare("sphere_free", &points, &Nominal::Sphere { radius_mm: -41.0 }, Pose::default(), &free);
}

//! A measured X-ray mirror: 64 × 1657 heights whose coordinates begin at a corner.

use asphera_form::{
    Aperture, Figures, Fit, FitSettings, Nominal, Parameter, PointMm, deviations, fit,
};

use crate::mirror::{SHAPE, hyperbolic, mirror};
use crate::reference::reference;

fn figures(points: &[PointMm], fitted: &Fit) -> Figures {
    let found = deviations(points, &fitted.nominal, &fitted.pose);
    Figures::new(points, &found, &fitted.pose, &Aperture::None).unwrap()
}

#[test]
fn plane_through_the_mirror() {
    let Some(points) = mirror() else { return };
    let fitted = fit(&points, &Nominal::Plane, &FitSettings::default()).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    assert_eq!((fitted.used, fitted.excluded.total()), (106_048, 0));
    let [tz, rx, ry, rms] = reference("xmf_plane")[..] else { unreachable!() };
    let found = figures(&points, &fitted);
    assert!((found.rms_nm / (rms * 1e6) - 1.0).abs() < 1e-9, "{} {}", found.rms_nm, rms * 1e6);
    assert!((fitted.pose.tz_mm - tz).abs() < 1e-9);
    assert!((fitted.pose.rx_rad - rx).abs() < 1e-10 && (fitted.pose.ry_rad - ry).abs() < 1e-10);
}

#[test]
fn sphere_through_the_mirror() {
    let Some(points) = mirror() else { return };
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
    let settings = FitSettings { free, ..FitSettings::default() };
    for begin_mm in [5e4, 7.8e4, 2e5] {
        let fitted = fit(&points, &Nominal::Sphere { radius_mm: begin_mm }, &settings).unwrap();
        assert!(fitted.termination.is_converged(), "{begin_mm}: {:?}", fitted.termination);
        let [radius, rms] = reference("xmf_sphere")[..] else { unreachable!() };
        let found = figures(&points, &fitted);
        assert!((found.rms_nm / (rms * 1e6) - 1.0).abs() < 1e-7, "{} {rms}", found.rms_nm);
        assert!((fitted.nominal.radius_mm().unwrap() / radius - 1.0).abs() < 1e-6);
    }
}

/// Along a hyperbola p, q and θ change with the place, so beside a free shift along x only two of them have a
/// value; and a millimetre in the place of the centre changes them by a percent, not by the tenth they are off.
#[test]
fn a_shift_along_the_mirror_is_no_parameter_beside_p_q_and_theta() {
    let Some(points) = mirror() else { return };
    let all = [&[Parameter::Tx], &SHAPE[..]].concat();
    let fitted = hyperbolic(&points, 0.0, &all);
    eprintln!("{:?}", fitted.undetermined);
    assert_eq!(fitted.indeterminate.len(), 1);
    let (here, there) = (hyperbolic(&points, 0.0, &SHAPE), hyperbolic(&points, 1.0, &SHAPE));
    assert!((here.sigma_mm / there.sigma_mm - 1.0).abs() < 1e-6);
    for (here, there) in here.estimates.iter().zip(&there.estimates).skip(4) {
        let change = there.value / here.value - 1.0;
        eprintln!("{}: {:.3} % a mm", here.parameter, 100.0 * change);
        assert!(change.abs() < 0.012);
    }
}

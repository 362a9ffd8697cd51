//! A measured X-ray mirror: 64 × 1657 heights whose coordinates begin at a corner.

use std::path::PathBuf;

use asphera_form::{
    Aperture, Figures, Fit, FitSettings, Nominal, Parameter, PointMm, deviations, fit,
};

use crate::reference::reference;

/// The points of the file, or `None` where the shared data are absent.
fn mirror() -> Option<Vec<PointMm>> {
    let data = std::env::var_os("ASPHERA_DATA").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/data")),
        PathBuf::from,
    );
    let path = data.join("mirrors/xmf_02_hyperbolic_cylinder.xyz");
    let Ok(text) = std::fs::read_to_string(&path) else {
        eprintln!("skipped: {} not found", path.display());
        return None;
    };
    let point = |line: &str| {
        let mut numbers = line.split_whitespace().map(|number| number.parse().unwrap());
        std::array::from_fn(|_| numbers.next().unwrap())
    };
    Some(text.lines().map(point).collect())
}

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

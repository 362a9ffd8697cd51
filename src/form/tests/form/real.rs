//! A measured X-ray mirror: 64 × 1657 heights whose coordinates begin at a corner.

use std::path::PathBuf;

use std::sync::Arc;

use asphera_form::shape::Mirror;
use asphera_form::uncertainty::type_a;
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

/// p, q and θ of the design: the source is virtual, for the mirror is a hyperbolic cylinder.
const DESIGN: [f64; 3] = [-306.0, 115.0, 4.6e-3];
const SHAPE: [Parameter; 3] = [Parameter::Shape(0), Parameter::Shape(1), Parameter::Shape(2)];

/// The map about the centre its authors give, laid on the design with more parameters free.
fn hyperbolic(points: &[PointMm], shift_mm: f64, free: &[Parameter]) -> Fit {
    let centred: Vec<PointMm> =
        points.iter().map(|&[x, y, z]| [x - 28.512 - shift_mm, y - 3.312, z]).collect();
    let [p, q, theta] = DESIGN;
    let design = Nominal::Freeform(Arc::new(Mirror::cylindrical(p, q, theta).unwrap()));
    let pose = [Parameter::Tz, Parameter::Rx, Parameter::Ry, Parameter::Rz];
    let settings = FitSettings { free: [&pose, free].concat(), ..FitSettings::default() };
    let fitted = fit(&centred, &design, &settings).unwrap();
    assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
    fitted
}

fn centred(points: &[PointMm]) -> Vec<PointMm> {
    points.iter().map(|&[x, y, z]| [x - 28.512, y - 3.312, z]).collect()
}

/// With p, q and θ free at once each lies within its expanded uncertainty of the design. That is the type A
/// one: by the covariance of the fit, which takes 0.69 nm of form for noise, they lie a hundred standard
/// uncertainties off.
#[test]
fn p_q_and_theta_of_the_hyperbolic_mirror_agree_with_its_design() {
    let Some(points) = mirror() else { return };
    let fitted = hyperbolic(&points, 0.0, &SHAPE);
    let found = type_a(&centred(&points), &fitted, &Aperture::None, None).unwrap();
    eprintln!(
        "rms {:.3} nm, {:?}, kernels {:.2?}, {} patches",
        fitted.residuals.rms_mm * 1e6,
        found.correlation,
        found.kernels,
        found.patches
    );
    assert!((fitted.residuals.rms_mm * 1e6 - 0.690_411).abs() < 1e-5);
    // As found here first; `asphera measure` gives the same.
    let found_first = [28.690_754, 5.972_1, 1.044_5e-3];
    for ((parameter, design), u) in SHAPE.iter().zip(DESIGN).zip(found_first) {
        let own = |p: &&asphera_form::uncertainty::TypeAParameter| p.parameter == *parameter;
        let known = found.parameters.iter().find(own).unwrap();
        let white = fitted.estimates.iter().find(|e| e.parameter == *parameter).unwrap().u.unwrap();
        let expanded = known.expanded(0.95);
        let off = known.value - design;
        eprintln!(
            "{parameter}: {:.6} is {off:.6} off, U95 {:.6} (k {:.2}), u {:.6}, as if of noise {white:.6}",
            known.value, expanded.expanded, expanded.k, known.u
        );
        assert!((known.u / u - 1.0).abs() < 1e-3, "{parameter}: {} {u}", known.u);
        assert!(off.abs() < expanded.expanded, "{parameter}: {off} {expanded:?}");
        assert!(off.abs() < 2.0 * known.u && off.abs() > 20.0 * white, "{parameter}");
    }
}

/// With one of p, q and θ free it stands for the curvature at the centre, which the map has half a percent below
/// that of the design. Neither noise nor form explains that: it is how the mirror was made or measured.
#[test]
fn the_hyperbolic_mirror_is_flatter_than_designed() {
    let Some(points) = mirror() else { return };
    for (index, design) in DESIGN.into_iter().enumerate() {
        let fitted = hyperbolic(&points, 0.0, &SHAPE[index..=index]);
        let found = type_a(&centred(&points), &fitted, &Aperture::None, None).unwrap();
        let known = found.parameters.last().unwrap();
        let (off, expanded) = (known.value - design, known.expanded(0.95).expanded);
        let bend_per_mm = fitted.nominal.jet(0.0, 0.0).unwrap().hessian_per_mm[0];
        eprintln!(
            "{} alone: {:.3} % off, U95 {:.3} %, radius {:.1} m, rms {:.3} nm",
            known.parameter,
            100.0 * off / design,
            100.0 * expanded / design.abs(),
            1e-3 / bend_per_mm,
            fitted.residuals.rms_mm * 1e6
        );
        assert!((off / design).abs() < 0.011);
        assert!(off.abs() > expanded, "{off} {expanded}");
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

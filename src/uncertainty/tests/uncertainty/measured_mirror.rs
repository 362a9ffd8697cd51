//! The type A uncertainty of a measured X-ray mirror holds its design where it should.

use asphera_form::{Aperture, PointMm};
use asphera_uncertainty::type_a;

use crate::mirror::{DESIGN, SHAPE, hyperbolic, mirror};

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
        let own = |p: &&asphera_uncertainty::TypeAParameter| p.parameter == *parameter;
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

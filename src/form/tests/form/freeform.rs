//! Freeforms: feet, fits, symmetries, names.

use std::sync::Arc;

use asphera_form::artefact::Artefact;
use asphera_form::{
    FitError, FitSettings, Nominal, Parameter, ParameterError, PointMm, Pose, deviations, fit,
};
use proptest::prelude::*;

use crate::common::{al1815, misaligned, pose_difference, spiral};
use crate::shapes::{Revolved, biconic, cylinder, saddle, toroid};

fn all_six() -> FitSettings {
    FitSettings { free: Parameter::POSE.to_vec(), ..FitSettings::default() }
}

/// Every motion and every parameter of the shape.
fn everything(nominal: &Nominal) -> Vec<Parameter> {
    nominal.parameters().into_iter().map(|(parameter, _)| parameter).collect()
}

#[test]
fn the_shapes_of_the_tests_are_what_their_derivatives_say() {
    for nominal in [biconic(), saddle(), toroid(), cylinder(), al1815()] {
        for [x, y] in spiral(40, 8.0) {
            let h = 1e-3;
            let richardson = |f: &dyn Fn(f64) -> f64| {
                let central = |h: f64| (f(h) - f(-h)) / (2.0 * h);
                (4.0 * central(0.5 * h) - central(h)) / 3.0
            };
            let jet = nominal.jet(x, y).unwrap();
            let z = |x: f64, y: f64| nominal.jet(x, y).unwrap();
            let pairs = [
                (jet.gradient[0], richardson(&|h| z(x + h, y).z_mm)),
                (jet.gradient[1], richardson(&|h| z(x, y + h).z_mm)),
                (jet.hessian_per_mm[0], richardson(&|h| z(x + h, y).gradient[0])),
                (jet.hessian_per_mm[1], richardson(&|h| z(x + h, y).gradient[1])),
                (jet.hessian_per_mm[1], richardson(&|h| z(x, y + h).gradient[0])),
                (jet.hessian_per_mm[2], richardson(&|h| z(x, y + h).gradient[1])),
            ];
            for (analytic, numerical) in pairs {
                let off = (analytic - numerical).abs();
                assert!(off < 2e-10, "{nominal} at {x}, {y}: {analytic} {numerical}");
            }
        }
    }
}

proptest! {
    #[test]
    fn point_made_along_a_normal_has_that_foot(
        place in prop::array::uniform2(-8.0..8.0f64), d in -3.0..3.0f64,
    ) {
        for nominal in [biconic(), saddle(), toroid(), cylinder()] {
            let jet = nominal.jet(place[0], place[1]).unwrap();
            let [p, q] = jet.gradient;
            let n_z = (1.0 + p * p + q * q).sqrt().recip();
            let normal = [-p * n_z, -q * n_z, n_z];
            let on = [place[0], place[1], jet.z_mm];
            let point: PointMm = std::array::from_fn(|i| on[i] + d * normal[i]);
            let foot = nominal.foot(point).unwrap();
            prop_assert!((foot.distance_mm - d).abs() < 3e-14, "{nominal}: {:e}", foot.distance_mm - d);
            for i in 0..3 {
                prop_assert!((foot.foot_mm[i] - on[i]).abs() < 4e-14, "{nominal} {foot:?} {on:?}");
                prop_assert!((foot.normal[i] - normal[i]).abs() < 1e-14);
            }
        }
    }

    /// The foot over the plane against that in the meridian, far off the surface as well.
    #[test]
    fn distance_is_that_of_the_meridian(
        place in prop::array::uniform2(-8.0..8.0f64), d in -4.0..2.0f64,
    ) {
        let general = Nominal::Freeform(Arc::new(Revolved(al1815())));
        let point = [place[0], place[1], al1815().sag_mm(place[0].hypot(place[1])) + d];
        let (found, known) = (general.foot(point), al1815().foot(point));
        let (found, known) = (found.unwrap(), known.unwrap());
        prop_assert!((found.distance_mm - known.distance_mm).abs() < 2e-14);
    }
}

/// Next to the equator, where the slope goes to infinity, against the closed form.
#[test]
fn feet_near_the_border_of_a_steep_domain() {
    let sphere = Nominal::Sphere { radius_mm: 10.0 };
    let general = Nominal::Freeform(Arc::new(Revolved(sphere.clone())));
    for beside in [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6] {
        let mut worst_mm = 0.0_f64;
        for step in 0..400 {
            let r: f64 = 10.0 * (1.0 - beside);
            let (phi, d) = (0.1 * f64::from(step), 1e-2 * (f64::from(step) - 200.0));
            let [n_r, n_z] = [-r / 10.0, (1.0 - (r / 10.0).powi(2)).sqrt()];
            let rho = r + d * n_r;
            let point = [rho * phi.cos(), rho * phi.sin(), sphere.sag_mm(r) + d * n_z];
            let found = general.foot(point).map(|foot| foot.distance_mm);
            let known = sphere.foot(point).map(|foot| foot.distance_mm);
            let off_mm = found.zip(known).map_or(f64::INFINITY, |(a, b)| (a - b).abs());
            worst_mm = worst_mm.max(off_mm);
        }
        eprintln!("{beside:e} of the radius within the border: off by {worst_mm:e} mm");
        assert!(worst_mm < 1e-13, "{beside}: {worst_mm:e}");
    }
}

#[test]
fn points_without_a_foot() {
    let bowl = Nominal::Freeform(Arc::new(Revolved(Nominal::Sphere { radius_mm: 10.0 })));
    assert!(bowl.foot([3.0, 0.0, 11.0]).is_none(), "beyond the equator");
    assert!(bowl.foot([f64::NAN, 0.0, 0.0]).is_none());
    assert!(bowl.foot([0.0, f64::INFINITY, 0.0]).is_none());
    // Beside the domain, but over a place within it: 1 mm below the sphere along its normal.
    let outside = bowl.foot([10.5, 0.0, 9.0]).unwrap();
    let known = Nominal::Sphere { radius_mm: 10.0 }.foot([10.5, 0.0, 9.0]).unwrap();
    assert!((outside.distance_mm - known.distance_mm).abs() < 1e-13);
}

#[test]
fn a_part_of_revolution_fits_the_same_as_a_freeform() {
    let sample = spiral(3_000, 9.0);
    let error_mm = |x: f64, y: f64| 2e-4 * (0.7 * x).sin() * (0.4 * y).cos();
    let artefact = Artefact::new(al1815(), misaligned(), &[], &sample, error_mm).unwrap();
    let points: Vec<PointMm> =
        sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
    let general = Nominal::Freeform(Arc::new(Revolved(al1815())));
    let (a, b) = (
        fit(&points, &al1815(), &FitSettings::default()).unwrap(),
        fit(&points, &general, &all_six()).unwrap(),
    );
    assert!(b.termination.is_converged(), "{:?}", b.termination);
    assert_eq!(b.indeterminate, [Parameter::Rz]);
    assert!(b.undetermined[0].by_shape);
    assert!(pose_difference(&a.pose, &b.pose) < 1e-12, "{:?} {:?}", a.pose, b.pose);
    assert!((a.sigma_mm / b.sigma_mm - 1.0).abs() < 1e-9);
    for (a, b) in a.estimates.iter().zip(&b.estimates) {
        assert!((a.u.unwrap() / b.u.unwrap() - 1.0).abs() < 1e-6, "{a:?} {b:?}");
    }
}

/// Form errors from 10 nm to 10 µm, poses to 1 mm and 1°.
#[test]
fn artefacts_give_back_pose_shape_and_deviations() {
    let pose =
        Pose { tx_mm: 0.9, ty_mm: -0.7, tz_mm: 1.0, rx_rad: 0.015, ry_rad: -0.0174, rz_rad: 0.01 };
    let sample = spiral(4_000, 9.0);
    for nominal in [biconic(), saddle()] {
        for amplitude_mm in [1e-5, 1e-3, 1e-2] {
            for free in [Parameter::POSE.to_vec(), everything(&nominal)] {
                let error_mm =
                    move |x: f64, y: f64| amplitude_mm * (1.1 * x + 0.3).sin() * (0.8 * y).cos();
                let artefact =
                    Artefact::new(nominal.clone(), pose, &free, &sample, error_mm).unwrap();
                let points: Vec<PointMm> =
                    sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
                let settings = FitSettings { free: free.clone(), ..FitSettings::default() };
                let fitted = fit(&points, &nominal, &settings).unwrap();
                let name = format!("{} {amplitude_mm:e} {}", nominal.kind(), free.len());
                assert!(fitted.termination.is_converged(), "{name}: {:?}", fitted.termination);
                assert!(fitted.indeterminate.is_empty(), "{name}: {:?}", fitted.undetermined);
                let off = pose_difference(&fitted.pose, &pose);
                let turns = |pose: &Pose| Pose { tx_mm: 0.0, ty_mm: 0.0, tz_mm: 0.0, ..*pose };
                let off_rad = pose_difference(&turns(&fitted.pose), &turns(&pose));
                let found = deviations(&points, &fitted.nominal, &fitted.pose);
                let worst = sample.iter().zip(&found).fold(0.0, |worst: f64, (&[x, y], found)| {
                    worst.max((found - artefact.deviation_mm(x, y).unwrap()).abs())
                });
                eprintln!(
                    "{name}: pose off by {off:e}, turns by {off_rad:e} rad, residuals by {worst:e} mm, condition {:e}",
                    fitted.condition
                );
                assert!(off < 1e-9 && off_rad < 1e-12, "{name}: {off:e} mm, {off_rad:e} rad");
                assert!(worst < 1e-9, "{name}: {worst:e}");
            }
        }
    }
}

#[test]
fn symmetries_are_found_and_named() {
    let laid =
        Pose { tx_mm: 0.2, ty_mm: 0.1, tz_mm: -0.3, rx_rad: 0.01, ry_rad: 0.02, rz_rad: 0.03 };
    let names = |nominal: &Nominal, pose: &Pose| {
        let points: Vec<PointMm> = spiral(2_000, 8.0)
            .into_iter()
            .map(|[x, y]| pose.to_measured([x, y, nominal.height_mm(x, y).unwrap()]))
            .collect();
        let fitted = fit(&points, nominal, &all_six()).unwrap();
        assert!(fitted.termination.is_converged(), "{nominal}: {:?}", fitted.termination);
        assert!(fitted.sigma_mm < 1e-13, "{nominal}: {:e}", fitted.sigma_mm);
        for left in &fitted.undetermined {
            assert!(left.by_shape, "{nominal}: {left:?}");
        }
        let told = fitted.undetermined.iter().map(|left| left.combination.to_string());
        (fitted.indeterminate, told.collect::<Vec<_>>())
    };
    let bowl = Nominal::Freeform(Arc::new(Revolved(Nominal::Sphere { radius_mm: 40.0 })));
    for pose in [Pose::default(), laid] {
        use Parameter::{Rx, Ry, Rz, Ty};
        assert_eq!(names(&cylinder(), &pose).0, [Ty, Ry]);
        assert_eq!(names(&toroid(), &pose).0, [Ry]);
        assert_eq!(names(&bowl, &pose).0, [Rx, Ry, Rz]);
        assert_eq!(names(&saddle(), &pose).0, []);
        assert_eq!(names(&biconic(), &pose).0, []);
    }
    let (_, told) = names(&cylinder(), &Pose::default());
    assert_eq!(told[0], "1.00·ty");
    // A turn about the axis of a cylinder goes with a shift across it.
    assert!(told[1] == "0.71·tx - 0.71·ry" || told[1] == "0.71·ry - 0.71·tx", "{told:?}");
}

#[test]
fn a_cylinder_needs_no_more_points_than_it_has_freedoms() {
    let settings = all_six();
    let points = |count: usize| -> Vec<PointMm> {
        spiral(count, 8.0)
            .iter()
            .map(|&[x, y]| [x, y, cylinder().height_mm(x, y).unwrap()])
            .collect()
    };
    let found = fit(&points(3), &cylinder(), &settings);
    assert!(matches!(found, Err(FitError::TooFewPoints { used: 3, needed: 4, .. })), "{found:?}");
    let fitted = fit(&points(5), &cylinder(), &settings).unwrap();
    assert_eq!((fitted.estimates.len(), fitted.dof), (4, 1));
}

#[test]
fn parameters_have_the_names_and_units_of_the_shape() {
    let nominal = biconic();
    assert_eq!(nominal.parameter("conic_y"), Ok(Parameter::Shape(3)));
    assert_eq!(nominal.parameter("tx"), Ok(Parameter::Tx));
    assert_eq!(Parameter::Shape(0).name(&nominal), "radius_x");
    assert_eq!(Parameter::Shape(0).unit(&nominal).as_deref(), Some("mm"));
    assert_eq!(Parameter::Shape(1).value(&Pose::default(), &nominal), Some(-45.0));
    assert_eq!(Parameter::Shape(4).value(&Pose::default(), &nominal), None);
    assert!(!nominal.has(Parameter::Radius) && !nominal.has(Parameter::Shape(4)));
    assert_eq!(
        nominal.parameter("radius"),
        Err(ParameterError::NotOfNominal {
            name: "radius".to_owned(),
            kind: "biconic",
            expected: "tx, ty, tz, rx, ry, rz, radius_x, radius_y, conic_x, conic_y".to_owned(),
        })
    );
    let settings = FitSettings { free: vec![Parameter::Shape(4)], ..FitSettings::default() };
    let error = fit(&[[0.0; 3]; 9], &nominal, &settings).unwrap_err();
    assert_eq!(error.to_string(), "a biconic has no parameter shape[4]");
    assert_eq!(
        nominal.to_string(),
        "biconic, radius_x 30 mm, radius_y -45 mm, conic_x -0.7, conic_y 0.4"
    );
    assert_eq!(nominal, biconic());
    assert_ne!(nominal, saddle());
    assert!(
        nominal.sag_mm(1.0).is_nan() && nominal.slope(1.0).is_nan() && !nominal.is_rotational()
    );
}

#[test]
fn curvature_bound_at_a_place_is_that_of_the_meridian() {
    for [x, y] in spiral(50, 8.5) {
        let (found, known) =
            (al1815().lfs_bound_at_mm(x, y).unwrap(), al1815().lfs_bound_mm(x.hypot(y)));
        assert!((found / known - 1.0).abs() < 1e-9, "{found} {known}");
    }
    assert_eq!(Nominal::Plane.lfs_bound_at_mm(1.0, 2.0), Some(f64::INFINITY));
    assert!((cylinder().lfs_bound_at_mm(3.0, 9.0).unwrap() - 40.0).abs() < 1e-12);
}

//! Numbers that make no shape, and places that have no height.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use asphera_form::shape::{
    Biconic, Conic, ConicSection, Cylinder, EvenAsphere, Mirror, OddAsphere, OffAxis, Projection,
    QAsphere, Shape, ShapeError, Sum, Toroid,
};

fn section(radius: f64, conic: f64) -> ConicSection {
    ConicSection::new(radius, conic).unwrap()
}

fn message<T>(result: Result<T, ShapeError>) -> String {
    result.err().unwrap().to_string()
}

#[test]
fn refusals_of_sections_and_powers_say_what_is_wrong() {
    let base = section(30.0, 0.0);
    let flat = "expected a number other than 0, at most 1e307 in size (what is flat has no radius)";
    let rows = [
        (message(ConicSection::new(0.0, 0.0)), format!("radius of the conic section is 0, {flat}")),
        (
            message(ConicSection::new(f64::INFINITY, 0.0)),
            format!("radius of the conic section is inf, {flat}"),
        ),
        (message(Conic::sphere(f64::NAN)), format!("radius of the sphere is NaN, {flat}")),
        (message(Cylinder::new(1e-310)), format!("radius of the cylinder is 1e-310, {flat}")),
        (message(Cylinder::new(1e308)), format!("radius of the cylinder is 1e308, {flat}")),
        (
            message(Toroid::new(0.0, base, &[])),
            format!("rotation_radius of the toroid is 0, {flat}"),
        ),
        (
            message(ConicSection::new(5.0, f64::NAN)),
            "conic of the conic section is NaN, expected a finite number".to_owned(),
        ),
        (
            message(EvenAsphere::new(base, &[(4, f64::INFINITY)])),
            "A4 of the even asphere is inf, expected a finite number".to_owned(),
        ),
        (
            message(EvenAsphere::new(base, &[(3, 1.0)])),
            "order of a power of the even asphere is 3, expected an even order from 2 on, once"
                .to_owned(),
        ),
        (
            message(Cylinder::acylinder(base, &[(4, 1.0), (4, 1.0)])),
            "order of a power of the acylinder is 4, expected an even order from 2 on, once"
                .to_owned(),
        ),
        (
            message(OddAsphere::new(base, &[(0, 1.0)])),
            "order of a power of the odd asphere is 0, expected an order from 1 on, once"
                .to_owned(),
        ),
    ];
    for (ours, expected) in rows {
        assert_eq!(ours, expected);
    }
}

#[test]
fn refusals_of_series_mirrors_and_sums_say_what_is_wrong() {
    let base = section(30.0, 0.0);
    let rows = [
        (
            message(QAsphere::con(base, 0.0, &[1.0])),
            "normalisation radius of the Q-con asphere is 0, expected a finite number above 0"
                .to_owned(),
        ),
        (
            message(QAsphere::bfs(base, -3.0, Projection::Axis, &[1.0])),
            "normalisation radius of the Q-bfs asphere is -3, expected a finite number above 0"
                .to_owned(),
        ),
        (
            message(QAsphere::bfs(base, 3.0, Projection::Axis, &[1.0, f64::NAN])),
            "Q1 of the Q-bfs asphere is NaN, expected a finite number".to_owned(),
        ),
        (
            message(Mirror::cylindrical(0.0, 5.0, 0.1)),
            "p of the hyperbolic cylinder is 0, expected a distance other than 0".to_owned(),
        ),
        (
            message(Mirror::revolved(5.0, 5.0, 0.0)),
            "theta of the ellipsoid is 0, expected a grazing angle above 0, at most pi/2"
                .to_owned(),
        ),
        (
            message(Mirror::revolved(5.0, -5.0, 0.1)),
            "q of the hyperboloid is -5, expected other than -p (that mirror is plane)".to_owned(),
        ),
        (
            message(Mirror::revolved(f64::INFINITY, f64::INFINITY, 0.1)),
            "q of the paraboloid is inf, expected other than -p (that mirror is plane)".to_owned(),
        ),
        (
            message(Sum::new(Vec::new())),
            "number of parts of the sum is 0, expected at least 1".to_owned(),
        ),
        (
            message(OffAxis::tilted(Arc::new(Conic::new(base)), 24.0, 18.0)),
            "decentre of the off-axis section is 30, expected a place at which the parent has a \
             tangent plane"
                .to_owned(),
        ),
    ];
    for (ours, expected) in rows {
        assert_eq!(ours, expected);
    }
    assert!(Mirror::revolved(5.0, 5.0, FRAC_PI_2).is_ok());
    assert!(Mirror::revolved(5.0, 5.0, FRAC_PI_2 + 1e-9).is_err());
    assert!(Mirror::revolved(5.0, f64::NAN, 0.1).is_err());
}

/// One of every kind.
fn all() -> Vec<Arc<dyn Shape>> {
    let base = section(-30.0, -0.5);
    let even = Arc::new(EvenAsphere::new(base, &[(4, 1e-5), (6, 1e-7)]).unwrap());
    vec![
        Arc::new(Conic::plane()),
        Arc::new(Conic::sphere(30.0).unwrap()),
        Arc::new(Conic::new(base)),
        Arc::new(Cylinder::new(30.0).unwrap()),
        Arc::new(Cylinder::acylinder(base, &[(4, 1e-5)]).unwrap()),
        even.clone(),
        Arc::new(OddAsphere::new(base, &[(1, 1e-3), (3, 1e-4)]).unwrap()),
        Arc::new(Biconic::new(base, section(50.0, 0.0))),
        Arc::new(Toroid::new(40.0, base, &[(4, 1e-5)]).unwrap()),
        Arc::new(Toroid::unrotated(base, &[]).unwrap()),
        Arc::new(QAsphere::bfs(base, 20.0, Projection::ConicNormal, &[0.1, 0.2]).unwrap()),
        Arc::new(QAsphere::bfs(base, 20.0, Projection::Axis, &[]).unwrap()),
        Arc::new(QAsphere::con(base, 20.0, &[0.1]).unwrap()),
        Arc::new(QAsphere::con(base, 20.0, &[]).unwrap()),
        Arc::new(Mirror::cylindrical(300.0, 100.0, 0.01).unwrap()),
        Arc::new(Mirror::revolved(f64::INFINITY, -100.0, 0.01).unwrap()),
        Arc::new(Sum::new(vec![even.clone(), Arc::new(Cylinder::new(50.0).unwrap())]).unwrap()),
        Arc::new(OffAxis::tilted(even.clone(), 3.0, 4.0).unwrap()),
        Arc::new(OffAxis::parallel(even, 3.0, 4.0).unwrap()),
    ]
}

#[test]
fn places_that_are_none() {
    for shape in all() {
        let mut derivatives = vec![0.0; shape.parameters().len()];
        for none in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for (x, y) in [(none, 0.0), (0.0, none), (none, none)] {
                assert_eq!(shape.jet(x, y), None, "{shape:?} at ({x}, {y})");
                assert_eq!(shape.sag_mm(x, y), None, "{shape:?} at ({x}, {y})");
                let by = shape.by_parameters(x, y, &mut derivatives);
                assert_eq!(by, None, "{shape:?} at ({x}, {y})");
            }
        }
        for (x, y) in [(1e200, 0.0), (0.0, 1e200), (-1e300, 1e300)] {
            if let Some(jet) = shape.jet(x, y) {
                assert!(jet.z_mm.is_finite(), "{shape:?} at ({x}, {y})");
            }
        }
    }
}

#[test]
fn parameters_must_be_as_many_and_numbers() {
    for shape in all() {
        let values: Vec<f64> = shape.parameters().iter().map(|own| own.value).collect();
        let same = shape.with_parameters(&values).unwrap();
        assert_eq!(same.parameters(), shape.parameters());
        assert_eq!(same.kind(), shape.kind());
        assert_eq!(same.jet(1.0, 2.0), shape.jet(1.0, 2.0), "{shape:?}");
        let mut more = values.clone();
        more.push(1.0);
        assert!(matches!(
            shape.with_parameters(&more),
            Err(ShapeError::Count { found, expected, .. }) if found == expected + 1
        ));
        for index in 0..values.len() {
            assert!(shape.with_parameters(&values[1..]).is_err());
            for wrong in [f64::NAN, f64::INFINITY] {
                let mut values = values.clone();
                values[index] = wrong;
                let refused = shape.with_parameters(&values);
                assert!(matches!(refused, Err(ShapeError::Value { .. })), "{shape:?} {index}");
            }
        }
    }
}

#[test]
fn names_are_unique_and_have_units() {
    for shape in all() {
        let parameters = shape.parameters();
        for (index, own) in parameters.iter().enumerate() {
            assert!(!own.unit.is_empty());
            assert!(parameters[..index].iter().all(|other| other.name != own.name));
        }
    }
    let odd = OddAsphere::new(section(9.0, 0.0), &[(4, 0.0), (1, 0.0), (2, 0.0)]).unwrap();
    let units: Vec<_> =
        odd.parameters().into_iter().map(|own| format!("{} {}", own.name, own.unit)).collect();
    assert_eq!(units, ["radius mm", "conic 1", "A1 1", "A2 mm^-1", "A4 mm^-3"]);
}

/// The tip of a cone has a height but no tangent plane.
#[test]
fn tip_of_an_odd_asphere() {
    let tip = OddAsphere::new(section(30.0, 0.0), &[(1, 0.02), (2, 0.1)]).unwrap();
    assert_eq!(tip.sag_mm(0.0, 0.0), Some(0.0));
    assert_eq!(tip.jet(0.0, 0.0), None);
    assert_eq!(tip.by_parameters(0.0, 0.0, &mut [0.0; 4]), None);
    let beside = tip.jet(3e-9, -4e-9).unwrap();
    assert!((beside.gradient[0] - 0.012).abs() < 1e-8);
    assert!((beside.gradient[1] + 0.016).abs() < 1e-8);
    let blunt = tip.with_parameters(&[30.0, 0.0, 0.0, 0.1]).unwrap();
    assert!(blunt.jet(0.0, 0.0).is_some());
}

#[test]
fn q_aspheres_end_at_their_normalisation_radius() {
    let bfs = QAsphere::bfs(ConicSection::FLAT, 5.0, Projection::Axis, &[1.0]).unwrap();
    assert_eq!(bfs.sag_mm(3.0, 4.0), Some(0.0));
    assert_eq!(bfs.sag_mm(3.0, 4.0 + 1e-12), None);
    assert_eq!(bfs.jet(0.0, -5.000001), None);
    // The rim itself belongs to it, however its places are rounded.
    for i in 0..1000 {
        let (sin, cos) = f64::from(i).sin_cos();
        assert!(bfs.jet(5.0 * cos, 5.0 * sin).is_some());
    }
}

//! The form of an artefact is told from errors of the machine by turning it.

use std::f64::consts::FRAC_PI_2;

use asphera_calibrate::{Artefact, CalibrateError, Machine, Parameter, Settings, calibrate};

use crate::simulated::{Errors, Part, raster, spiral};

/// Radius of the disc over which the form is given.
const REACH: f64 = 6.0;

/// Z(2,2) of 20 nm and Z(3,-3) of 10 nm, unit RMS over the disc.
fn astigmatic([x, y]: [f64; 2]) -> f64 {
    let [u, v] = [x / REACH, y / REACH];
    20e-6 * 6f64.sqrt() * (u * u - v * v) + 10e-6 * 8f64.sqrt() * (3.0 * u * u * v - v * v * v)
}

/// The term of Zernike order (n, m) over a disc of another radius, of the form above.
fn expected(n: u32, m: i32, radius: f64) -> f64 {
    match (n, m) {
        (2, 2) => 20e-6 * (radius / REACH).powi(2),
        (3, -3) => 10e-6 * (radius / REACH).powi(3),
        _ => 0.0,
    }
}

#[test]
fn form_turns_with_the_artefact_and_squareness_does_not() {
    let errors = Errors(vec![(Parameter::Squareness, 6e-6), (Parameter::ScaleX, 5e-6)]);
    let part = Part { form: astigmatic, ..Part::ball([0.5, 0.0, -10.0], 10.0) };
    let poses: Vec<_> = (0..4_u32)
        .map(|quarter| {
            let turned = Part { turn: FRAC_PI_2 * f64::from(quarter) * 0.8, ..part };
            raster(&errors, turned, REACH, 18, (5e-6, u64::from(quarter)))
        })
        .collect();
    let artefact = Artefact::Sphere { radius_mm: 10.0, u_radius_mm: 0.0 };
    let parameters = vec![Parameter::Squareness, Parameter::ScaleX, Parameter::ScaleY];
    let settings = Settings { parameters, map_order: 0, form_order: 4 };
    let found = calibrate(Machine::Cartesian, artefact, &poses, &settings).unwrap();
    // Both scales together bend as forms of revolution do: of these the machine's are asked for first.
    assert!(found.form_undetermined.contains(&(2, 0)), "{:?}", found.form_undetermined);
    let truth = [5e-6, 0.0, 6e-6];
    for (estimate, truth) in found.parameters.iter().zip(truth) {
        assert!((estimate.value - truth).abs() < 4.0 * estimate.u, "{estimate:?}, truth {truth}");
        assert!(estimate.u < 1e-7, "{estimate:?}");
    }
    for term in &found.form {
        let truth = expected(term.n, term.m, found.form_radius_mm);
        assert!((term.value_mm - truth).abs() < 4.0 * term.u_mm, "{term:?}, truth {truth}");
        assert!(term.u_mm < 1e-6, "{term:?}");
    }
    // Without the form as an unknown it would be taken for errors of the machine.
    let blind = Settings { form_order: 0, ..settings };
    let wrong = calibrate(Machine::Cartesian, artefact, &poses[..1], &blind).unwrap();
    let scale = wrong.parameters.iter().find(|one| one.parameter == Parameter::ScaleX).unwrap();
    assert!((scale.value - 5e-6).abs() > 10.0 * found.parameters[0].u, "{scale:?}");
}

/// Of a flat turned about the axis nothing tells terms of revolution of the artefact from those of the machine: they
/// are given to the machine, and named.
#[test]
fn turns_alone_leave_what_is_of_revolution() {
    fn saddle([x, y]: [f64; 2]) -> f64 {
        40e-6 * 6f64.sqrt() * 2.0 * x * y / (REACH * REACH)
    }
    let errors = Errors::default();
    // A flat, as a sphere without curvature would be: one of 1e9 mm.
    let flat = Part { form: saddle, ..Part::ball([0.0, 0.0, -1e7], 1e7) };
    let turns = [0.0, 1.0, 2.1];
    let poses = turns
        .map(|turn| spiral(&errors, Part { turn, ..flat }, REACH, 2000, (2e-6, turn.to_bits())));
    let settings = Settings { parameters: Vec::new(), map_order: 4, form_order: 4 };
    let found = calibrate(Machine::Polar, Artefact::Flat, &poses, &settings).unwrap();
    assert_eq!(found.form_undetermined, [(2, 0), (4, 0)]);
    assert!(found.map_undetermined.is_empty(), "{:?}", found.map_undetermined);
    let scale = (found.form_radius_mm / REACH).powi(2);
    for term in &found.form {
        let truth = if (term.n, term.m) == (2, -2) { 40e-6 * scale } else { 0.0 };
        assert!((term.value_mm - truth).abs() < 4.0 * term.u_mm, "{term:?}, truth {truth}");
    }
    for term in found.map.iter().filter(|term| term.m != 0) {
        assert!(term.value_mm.abs() < 4.0 * term.u_mm, "{term:?}");
    }
}

#[test]
fn one_place_cannot_tell_the_two_apart() {
    let part = Part::ball([0.0, 0.0, -10.0], 10.0);
    let pose = raster(&Errors::default(), part, REACH, 12, (0.0, 0));
    let artefact = Artefact::Sphere { radius_mm: 10.0, u_radius_mm: 0.0 };
    let settings = Settings { parameters: Vec::new(), map_order: 0, form_order: 3 };
    let found = calibrate(Machine::Cartesian, artefact, &[pose.clone(), pose], &settings);
    assert_eq!(found, Err(CalibrateError::NoReversal));
}

//! Laws: what is found takes the errors out; order, threads and batches change nothing that matters.

use asphera_calibrate::{Artefact, Axes, Machine, Parameter, Settings, calibrate};
use proptest::prelude::*;

use crate::simulated::{Errors, Part, raster, spiral};

const BALL: Artefact = Artefact::Sphere { radius_mm: 10.0, u_radius_mm: 0.0 };

fn all(machine: Machine) -> Settings {
    Settings { parameters: machine.parameters().to_vec(), map_order: 0, form_order: 0 }
}

/// Of a ball on the axis the tangential offset moves points along the surface: it is not felt.
#[test]
fn a_centred_ball_does_not_feel_the_tangential_errors() {
    let errors = Errors(vec![(Parameter::OffsetRadial, 3e-3)]);
    let part = Part::ball([0.0, 0.0, -10.0], 10.0);
    let pose = spiral(&errors, part, 7.0, 4000, (5e-6, 3));
    let found = calibrate(Machine::Polar, BALL, &[pose], &all(Machine::Polar)).unwrap();
    let missing = [Parameter::OffsetTangential, Parameter::TiltTangential];
    assert!(missing.iter().all(|one| found.undetermined.contains(one)), "{found:?}");
    let radial = found.parameters[0];
    assert_eq!(radial.parameter, Parameter::OffsetRadial);
    assert!((radial.value - 3e-3).abs() < 4.0 * radial.u && radial.u < 1e-4, "{radial:?}");
}

/// The same machine measures a part it was not calibrated with.
#[test]
fn the_correction_mends_other_parts() {
    let errors = Errors(vec![
        (Parameter::Squareness, 40e-6),
        (Parameter::TiltX, -30e-6),
        (Parameter::TiltY, 50e-6),
    ]);
    let part = Part::ball([3.0, -2.0, -10.0], 10.0);
    let pose = raster(&errors, part, 7.0, 25, (5e-6, 4));
    let parameters = errors.0.iter().map(|(parameter, _)| *parameter).collect();
    let settings = Settings { parameters, map_order: 0, form_order: 0 };
    let found = calibrate(Machine::Cartesian, BALL, &[pose], &settings).unwrap();
    let worst = [[7.0, -5.0, 1.0], [-6.0, 6.0, -3.0], [0.0, 0.0, 0.0]].map(|place| {
        let axes = Axes::Cartesian(place);
        let corrected = found.correction.apply(axes).unwrap();
        let truth = errors.true_place(axes);
        (0..3).map(|axis| (corrected[axis] - truth[axis]).abs()).fold(0.0, f64::max)
    });
    assert!(worst.iter().all(|off| *off < 50e-6), "{worst:?}");
}

#[test]
fn threads_change_no_bit() {
    let errors = Errors(vec![(Parameter::Squareness, 40e-6)]);
    let pose = raster(&errors, Part::ball([0.0, 0.0, -10.0], 10.0), 7.0, 60, (5e-6, 5));
    let settings = all(Machine::Cartesian);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let poses = [pose.clone()];
        pool.install(|| calibrate(Machine::Cartesian, BALL, &poses, &settings)).unwrap()
    };
    assert_eq!(with(1), with(3));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Without noise every error comes back, inside and outside of balls, wherever they lie.
    #[test]
    fn errors_come_back_exactly(
        values in prop::array::uniform3(-100e-6..100e-6_f64),
        centre in prop::array::uniform2(-4.0..4.0_f64),
        is_inside in prop::bool::ANY,
    ) {
        let names = [Parameter::Squareness, Parameter::TiltX, Parameter::TiltY];
        let errors = Errors(names.into_iter().zip(values).collect());
        let radius = if is_inside { -10.0 } else { 10.0 };
        let part = Part::ball([centre[0], centre[1], -radius], radius);
        let pose = raster(&errors, part, 6.0, 10, (0.0, 0));
        let settings = Settings { parameters: names.to_vec(), map_order: 0, form_order: 0 };
        let found = calibrate(Machine::Cartesian, BALL, &[pose], &settings).unwrap();
        for (estimate, value) in found.parameters.iter().zip(values) {
            prop_assert!((estimate.value - value).abs() < 1e-11, "{:?} of {}", estimate, value);
        }
        prop_assert!(found.after_mm < 1e-12, "{}", found.after_mm);
    }
}

//! Errors come back within their stated uncertainty, as often as it says.

use asphera_calibrate::{Artefact, Machine, Parameter, Settings, calibrate};
use asphera_geometry::Numbers;

use crate::simulated::{Errors, Part, raster, spiral};

/// Half width of a 95 % interval in standard uncertainties, of a normal distribution.
const K95: f64 = 1.959_963_984_540_054;

/// Runs of the study.
const RUNS: u64 = 200;

/// A share of runs in percent, and the band in which it must lie: 95 ± 3.
fn assert_covered(name: &str, held: u64) {
    let percent = 100.0 * held as f64 / RUNS as f64;
    assert!((92.0..=98.0).contains(&percent), "{name}: {percent} %");
}

/// A ball of 10 mm beside the axis by 2 mm, 60° to each side, probe noise 5 nm; its radius is known to 30 nm.
#[test]
fn offsets_and_tilts_of_a_spiral_machine() {
    let truth = [
        (Parameter::OffsetRadial, 4.2e-3),
        (Parameter::OffsetTangential, -2.5e-3),
        (Parameter::TiltRadial, 80e-6),
        (Parameter::TiltTangential, -120e-6),
    ];
    let errors = Errors(truth.to_vec());
    let mut held = [0; 4];
    for run in 0..RUNS {
        let radius = 10.0 + 30e-6 * Numbers::new(run, 7, 0).normal(0);
        let part = Part::ball([2.0, -0.5, -10.0], radius);
        let pose = spiral(&errors, part, 6.5, 1500, (5e-6, run));
        let artefact = Artefact::Sphere { radius_mm: 10.0, u_radius_mm: 30e-6 };
        let parameters = truth.map(|(parameter, _)| parameter).to_vec();
        let settings = Settings { parameters, map_order: 0, form_order: 0 };
        let found = calibrate(Machine::Polar, artefact, &[pose], &settings).unwrap();
        assert!(found.undetermined.is_empty(), "{found:?}");
        assert!(found.before_mm > 20.0 * found.after_mm, "{found:?}");
        for ((held, (parameter, value)), estimate) in
            held.iter_mut().zip(truth).zip(&found.parameters)
        {
            assert_eq!(estimate.parameter, parameter);
            *held += u64::from((estimate.value - value).abs() <= K95 * estimate.u);
        }
    }
    for ((parameter, _), held) in truth.iter().zip(held) {
        assert_covered(parameter.word(), held);
    }
}

/// A ball of 12.5 mm, 45° to each side, probe noise 5 nm: squareness, both tilts and the scales of x and y.
#[test]
fn squareness_and_tilts_of_a_machine_with_linear_axes() {
    let truth = [
        (Parameter::ScaleX, 12e-6),
        (Parameter::ScaleY, -8e-6),
        (Parameter::Squareness, 25e-6),
        (Parameter::TiltX, -60e-6),
        (Parameter::TiltY, 90e-6),
    ];
    let errors = Errors(truth.to_vec());
    let mut held = [0; 5];
    for run in 0..RUNS {
        let radius = 12.5 + 50e-6 * Numbers::new(run, 8, 0).normal(0);
        let part = Part::ball([1.0, 2.0, -12.5], radius);
        let pose = raster(&errors, part, 8.8, 20, (5e-6, run));
        let artefact = Artefact::Sphere { radius_mm: 12.5, u_radius_mm: 50e-6 };
        let parameters = truth.map(|(parameter, _)| parameter).to_vec();
        let settings = Settings { parameters, map_order: 0, form_order: 0 };
        let found = calibrate(Machine::Cartesian, artefact, &[pose], &settings).unwrap();
        for ((held, (parameter, value)), estimate) in
            held.iter_mut().zip(truth).zip(&found.parameters)
        {
            assert_eq!(estimate.parameter, parameter);
            *held += u64::from((estimate.value - value).abs() <= K95 * estimate.u);
        }
    }
    for ((parameter, _), held) in truth.iter().zip(held) {
        assert_covered(parameter.word(), held);
    }
}

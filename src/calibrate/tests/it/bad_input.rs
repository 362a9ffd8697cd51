//! Input of which nothing can be made.

use asphera_calibrate::{
    Artefact, Axes, CalibrateError, Calibration, Machine, Parameter, Pose, Settings, calibrate,
};

use crate::simulated::{Errors, Part, raster};

const BALL: Artefact = Artefact::Sphere { radius_mm: 10.0, u_radius_mm: 0.0 };

fn settings() -> Settings {
    Settings { parameters: vec![Parameter::Squareness], map_order: 0, form_order: 0 }
}

fn pose() -> Pose {
    raster(&Errors::default(), Part::ball([0.0, 0.0, -10.0], 10.0), 6.0, 6, (0.0, 0))
}

fn of(artefact: Artefact, poses: &[Pose]) -> Result<Calibration, CalibrateError> {
    calibrate(Machine::Cartesian, artefact, poses, &settings())
}

fn message(found: Result<Calibration, CalibrateError>) -> String {
    found.map(|found| format!("{found:?}")).unwrap_err().to_string()
}

#[test]
fn each_mistake_is_named() {
    assert_eq!(of(BALL, &[]), Err(CalibrateError::NoPose));
    let few = Pose { axes: pose().axes[..5].to_vec(), ..pose() };
    let unknowns = 1 + 3 + 1;
    assert_eq!(
        of(BALL, &[few]),
        Err(CalibrateError::TooFewPoints { pose: 1, points: 5, unknowns })
    );
    let mut broken = pose();
    broken.axes[7] = Axes::Cartesian([0.0, f64::NAN, 0.0]);
    let found = of(BALL, &[pose(), broken]);
    assert_eq!(message(found), "point 8 of measurement 2 is not finite");
    let mut foreign = pose();
    foreign.axes[2] = Axes::Polar { angle_rad: 0.0, radius_mm: 0.0, z_mm: 0.0 };
    let found = of(BALL, &[foreign]);
    assert_eq!(
        message(found),
        "point 3 of measurement 1 is of another machine, expected cartesian"
    );
    let turned = Pose { turn_rad: f64::INFINITY, ..pose() };
    assert_eq!(of(BALL, &[turned]), Err(CalibrateError::BadPose { pose: 1 }));
    for (radius_mm, u_radius_mm) in
        [(0.0, 0.0), (-1.0, 0.0), (f64::NAN, 0.0), (1.0, 0.2), (1.0, -1.0)]
    {
        let found = of(Artefact::Sphere { radius_mm, u_radius_mm }, &[pose()]);
        assert!(matches!(found, Err(CalibrateError::BadRadius { .. })), "{found:?}");
    }
    let foreign = Settings { parameters: vec![Parameter::OffsetRadial], ..settings() };
    let found = calibrate(Machine::Cartesian, BALL, &[pose()], &foreign);
    assert!(message(found).starts_with("parameter offset_radial is not among those"));
    let high = Settings { map_order: 11, ..settings() };
    let found = calibrate(Machine::Cartesian, BALL, &[pose()], &high);
    assert_eq!(found, Err(CalibrateError::BadOrder { order: 11 }));
}

#[test]
fn points_on_a_line_or_in_one_place_are_refused() {
    let line = |step: f64| Pose {
        axes: (0..50)
            .map(|i| Axes::Cartesian([step * f64::from(i), 2.0 * step * f64::from(i), 0.0]))
            .collect(),
        turn_rad: 0.0,
        shift_mm: [0.0; 2],
    };
    for step in [0.0, 0.1] {
        assert_eq!(of(BALL, &[line(step)]), Err(CalibrateError::NoArea { pose: 1 }));
        assert_eq!(of(Artefact::Flat, &[line(step)]), Err(CalibrateError::NoArea { pose: 1 }));
    }
}

#[test]
fn another_artefact_is_told() {
    let small = Artefact::Sphere { radius_mm: 3.0, u_radius_mm: 0.0 };
    assert!(message(of(small, &[pose()])).contains("is it the right artefact"));
    let large = Artefact::Sphere { radius_mm: 1000.0, u_radius_mm: 0.0 };
    assert!(message(of(large, &[pose()])).contains("is it the right artefact"));
    assert!(message(of(Artefact::Flat, &[pose()])).contains("is it the right artefact"));
    let inside = raster(&Errors::default(), Part::ball([0.0, 0.0, 10.0], -10.0), 6.0, 6, (0.0, 0));
    assert!(message(of(BALL, &[pose(), inside])).contains("of others concave"));
}

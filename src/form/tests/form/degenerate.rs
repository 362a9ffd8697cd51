//! Inputs that determine little or nothing.

use crate::common::{al1815, misaligned, spiral};
use asphera_form::{
    Aperture, ApertureError, Excluded, FitError, FitSettings, Nominal, NominalError, Parameter,
    PointMm, Pose, Termination, fit,
};

fn plane(points: &[PointMm]) -> Result<asphera_form::Fit, FitError> {
    fit(points, &Nominal::Plane, &FitSettings::default())
}

#[test]
fn none_one_and_two_points() {
    assert_eq!(plane(&[]), Err(FitError::NoPoints { given: 0 }));
    let too_few = |used| FitError::TooFewPoints { used, needed: 3, excluded: Excluded::default() };
    assert_eq!(plane(&[[1.0, 2.0, 3.0]]), Err(too_few(1)));
    assert_eq!(plane(&[[1.0, 2.0, 3.0], [2.0, 0.0, 1.0]]), Err(too_few(2)));
    let free = vec![Parameter::Tz];
    let only_height = FitSettings { free, ..FitSettings::default() };
    let fitted = fit(&[[1.0, 2.0, 3.0]], &Nominal::Plane, &only_height).unwrap();
    assert_eq!((fitted.pose.tz_mm, fitted.dof, fitted.used), (3.0, 0, 1));
    let needed = fit(&spiral(4, 1.0).map_points(), &al1815(), &FitSettings::default());
    assert!(matches!(needed, Err(FitError::TooFewPoints { used: 4, needed: 5, .. })));
}

#[test]
fn points_that_are_not_finite_are_counted() {
    let bad = [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [0.0, 0.0, f64::NEG_INFINITY]];
    assert_eq!(plane(&bad), Err(FitError::NoPoints { given: 3 }));
    let mut points = bad.to_vec();
    points.extend([[0., 0., 1.], [1., 0., 1.], [0., 1., 1.], [1., 1., 1.]]);
    let fitted = plane(&points).unwrap();
    assert_eq!((fitted.used, fitted.excluded.not_finite, fitted.excluded.total()), (4, 3, 3));
    assert_eq!(fitted.pose.tz_mm, 1.0);
}

#[test]
fn collinear_points_leave_a_tilt_indeterminate() {
    let line = |dx: f64, dy: f64| -> Vec<PointMm> {
        (0..50)
            .map(|i| f64::from(i) * 0.1 - 2.0)
            .map(|s| [s * dx, s * dy, 0.5 + 0.01 * s])
            .collect()
    };
    let along_x = plane(&line(1.0, 0.0)).unwrap();
    assert!(along_x.termination.is_converged());
    assert_eq!(along_x.indeterminate, [Parameter::Tx, Parameter::Ty, Parameter::Rx]);
    assert_eq!(along_x.pose.rx_rad, 0.0);
    assert!((along_x.pose.ry_rad + 0.01_f64.atan()).abs() < 1e-14);
    let oblique = plane(&line(0.6, 0.8)).unwrap();
    assert_eq!(oblique.indeterminate, [Parameter::Tx, Parameter::Ty, Parameter::Ry]);
    assert!(oblique.sigma_mm < 1e-14);
}

#[test]
fn one_point_many_times() {
    let fitted = plane(&[[1.0, 2.0, 3.0]; 40]).unwrap();
    assert!(fitted.termination.is_converged());
    assert_eq!(fitted.estimates.len(), 1);
    assert_eq!(fitted.indeterminate.len(), 4);
    assert!((fitted.pose.tz_mm - 3.0).abs() < 1e-14 && fitted.sigma_mm < 1e-14);
    let fitted = fit(&[[0.1, 0.2, 3.0]; 40], &al1815(), &FitSettings::default()).unwrap();
    assert!(fitted.sigma_mm < 1e-12 && fitted.pose.is_finite());
}

#[test]
fn exact_lattice_is_an_exact_plane() {
    let lattice: Vec<PointMm> =
        (0..400).map(|i| [f64::from(i % 20), f64::from(i / 20), 2.0]).collect();
    let fitted = plane(&lattice).unwrap();
    assert!((fitted.pose.tz_mm - 2.0).abs() < 1e-13);
    assert!(fitted.pose.rx_rad.abs() < 1e-15 && fitted.pose.ry_rad.abs() < 1e-15);
    assert!(fitted.sigma_mm < 1e-13);
}

#[test]
fn huge_offsets_cost_only_their_rounding() {
    for offset in [1e4, 1e6, 1e8] {
        let points: Vec<PointMm> = spiral(500, 10.0)
            .into_iter()
            .map(|[x, y]| [x + offset, y - offset, 0.1 * x + 1e-6 * y + offset])
            .collect();
        let fitted = plane(&points).unwrap();
        assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
        assert!((fitted.pose.ry_rad + 0.1_f64.atan()).abs() < 1e-16 * offset + 1e-13);
        assert!(fitted.sigma_mm < 4e-16 * offset, "{offset:e}: {:e}", fitted.sigma_mm);
    }
    assert!(matches!(
        plane(&[[1e200, 0., 0.], [0., 1e200, 0.], [0., 0., 1e200], [1., 1., 1.]]),
        Err(FitError::TooFewPoints { used: 2, needed: 3, .. })
    ));
    let apart = [[0., 0., 1e200], [1., 0., -1e200], [0., 1., 3e200], [1., 1., 0.]];
    assert_eq!(plane(&apart), Err(FitError::Overflow { used: 4 }));
}

#[test]
fn turn_about_the_axis_is_indeterminate() {
    let points: Vec<PointMm> = spiral(2_000, 9.0)
        .into_iter()
        .map(|[x, y]| misaligned().to_measured([x, y, al1815().sag_mm(x.hypot(y))]))
        .collect();
    let free: Vec<Parameter> = Parameter::RIGID.into_iter().chain([Parameter::Rz]).collect();
    let start = Pose { rz_rad: 0.1, ..Pose::default() };
    let settings = FitSettings { free, start, ..FitSettings::default() };
    let fitted = fit(&points, &al1815(), &settings).unwrap();
    assert_eq!(fitted.indeterminate, [Parameter::Rz]);
    assert_eq!(fitted.pose.rz_rad, 0.1);
    assert!(fitted.sigma_mm < 1e-14, "{:e}", fitted.sigma_mm);
}

#[test]
fn tilts_of_a_sphere_are_indeterminate() {
    let sphere = Nominal::Sphere { radius_mm: 40.0 };
    let points: Vec<PointMm> = spiral(2_000, 9.0)
        .into_iter()
        .map(|[x, y]| [x + 0.3, y - 0.2, sphere.sag_mm(x.hypot(y)) + 1.0])
        .collect();
    let fitted = fit(&points, &sphere, &FitSettings::default()).unwrap();
    assert_eq!(fitted.indeterminate, [Parameter::Rx, Parameter::Ry]);
    assert!((fitted.pose.tx_mm - 0.3).abs() < 1e-13 && (fitted.pose.tz_mm - 1.0).abs() < 1e-13);
}

/// The flatter nominal fits best beside the steep part.
#[test]
fn points_of_another_radius_say_that_the_fit_strayed() {
    let [steep, flat] = [11.65, 50.0].map(|radius_mm| Nominal::Sphere { radius_mm });
    let points: Vec<PointMm> =
        spiral(5_000, 9.0).into_iter().map(|[x, y]| [x, y, steep.sag_mm(x.hypot(y))]).collect();
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz];
    let aperture = Aperture::Circle { radius_mm: 5.0 };
    let error =
        fit(&points, &flat, &FitSettings { free, aperture, ..FitSettings::default() }).unwrap_err();
    let words = error.to_string();
    assert!(matches!(error, FitError::Strayed { .. }), "{words}");
    assert!(words.contains("do not have the shape of the nominal"), "{words}");
}

#[test]
fn settings_that_make_no_sense() {
    let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
    let with = |settings: FitSettings| fit(&points, &Nominal::Plane, &settings).unwrap_err();
    let free = |free: &[Parameter]| FitSettings { free: free.to_vec(), ..FitSettings::default() };
    assert_eq!(
        with(free(&[Parameter::Radius])),
        FitError::NoSuchParameter { parameter: Parameter::Radius, kind: "plane" }
    );
    assert_eq!(with(free(&[Parameter::Tz, Parameter::Tz])), FitError::Repeated(Parameter::Tz));
    let aperture = Aperture::Circle { radius_mm: -1.0 };
    assert_eq!(
        with(FitSettings { aperture, ..FitSettings::default() }),
        FitError::Aperture(ApertureError::Size { name: "radius", value_mm: -1.0 })
    );
    let start = Pose { tx_mm: f64::NAN, ..Pose::default() };
    assert_eq!(with(FitSettings { start, ..FitSettings::default() }), FitError::Start);
    let aperture = Aperture::Annulus { inner_mm: 20.0, outer_mm: 21.0 };
    let (low, high) = ([0.0; 3], [1.0, 1.0, 0.0]);
    assert_eq!(
        with(FitSettings { aperture, ..FitSettings::default() }),
        FitError::OutsideAperture { finite: 3, low_mm: low, high_mm: high }
    );
    let nothing = Nominal::Sphere { radius_mm: 0.0 };
    assert_eq!(
        fit(&points, &nothing, &FitSettings::default()),
        Err(FitError::Nominal(NominalError::Radius(0.0)))
    );
    let small = Nominal::Sphere { radius_mm: 1e-3 };
    let fixed = FitSettings { free: vec![], ..FitSettings::default() };
    let beside = [[1.0, 0.0, 2.0], [0.0, 1.0, 2.0]];
    let beyond = FitError::OutsideDomain { inside: 2, domain_mm: 1e-3, nearest_mm: 1.0 };
    assert_eq!(fit(&beside, &small, &fixed), Err(beyond));
}

#[test]
fn nothing_free_only_evaluates_the_start() {
    let points = [[0., 0., 1e-3], [1., 0., -1e-3], [0., 1., 1e-3]];
    let settings = FitSettings { free: vec![], ..FitSettings::default() };
    let fitted = fit(&points, &Nominal::Plane, &settings).unwrap();
    assert_eq!((fitted.pose, fitted.dof, fitted.iterations), (Pose::default(), 3, 0));
    assert!((fitted.sigma_mm - 1e-3).abs() < 1e-18);
    assert!(fitted.estimates.is_empty() && fitted.indeterminate.is_empty());
}

#[test]
fn too_few_iterations_are_told() {
    let points: Vec<PointMm> = spiral(2_000, 9.0)
        .into_iter()
        .map(|[x, y]| misaligned().to_measured([x, y, al1815().sag_mm(x.hypot(y))]))
        .collect();
    let settings = FitSettings { max_iterations: 0, ..FitSettings::default() };
    let fitted = fit(&points, &al1815(), &settings).unwrap();
    assert!(
        matches!(fitted.termination, Termination::MaxIterations { limit: 0, motion_mm } if motion_mm > 1e-6)
    );
    assert_eq!((fitted.iterations, fitted.pose), (0, fitted.start));
}

/// A high point on the border of the aperture: with it the plane tilts so that it lies outside, without it
/// the plane is level and it lies inside.
#[test]
fn an_aperture_that_never_settles_is_told() {
    let mut points: Vec<PointMm> =
        (0..40).map(|i| [0.05 * f64::from(i) - 1.0, 0.4 * f64::from(i % 3 - 1), 0.0]).collect();
    points.push([1.0, 0.0, 0.5]);
    let aperture = Aperture::Rectangle { width_mm: 2.0, height_mm: 2.0 };
    let settings = FitSettings { aperture, ..FitSettings::default() };
    let fitted = fit(&points, &Nominal::Plane, &settings).unwrap();
    assert!(matches!(fitted.termination, Termination::UnstableAperture { changed } if changed > 0));
    assert!(!fitted.termination.is_converged());
}

trait MapPoints {
    fn map_points(self) -> Vec<PointMm>;
}

impl MapPoints for Vec<[f64; 2]> {
    fn map_points(self) -> Vec<PointMm> {
        self.into_iter().map(|[x, y]| [x, y, al1815().sag_mm(x.hypot(y))]).collect()
    }
}

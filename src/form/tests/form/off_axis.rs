//! A piece away from the axis of its parent, which does not feel the turn about it: all six motions free.

use std::sync::Arc;

use asphera_form::shape::{Conic, ConicSection, Cylinder, OffAxis};
use asphera_form::{
    Fit, FitSettings, Grid, Live, LiveSettings, Loss, Nominal, Parameter, PointMm, Pose,
    ZoneSettings, fit, minimum_zone,
};
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;

use crate::common::{normals, pose_difference, spiral};

/// Distance of the piece from the axis, mm.
const BESIDE_MM: f64 = 50.0;

/// Thorlabs MPD249 is one like it: 203.2 mm of radius, here 50 mm off its axis.
fn piece() -> OffAxis {
    let parent = Conic::new(ConicSection::new(203.2, -1.0).unwrap());
    OffAxis::tilted(Arc::new(parent), 0.0, BESIDE_MM).unwrap()
}

/// The parent's vertex and the direction of its axis, in the frame of the piece.
fn parent() -> [[f64; 3]; 2] {
    let piece = piece();
    let along = |of: [f64; 3]| -> [f64; 3] {
        piece.axes().map(|axis| axis.iter().zip(of).map(|(a, b)| a * b).sum())
    };
    [along(piece.origin_mm().map(|entry| -entry)), along([0.0, 0.0, 1.0])]
}

fn measured(pose: &Pose, count: usize, noise_mm: f64, seed: u64) -> Vec<PointMm> {
    let nominal = Nominal::Freeform(Arc::new(piece()));
    let noise = normals(&mut Pcg64Mcg::seed_from_u64(seed), count);
    let places = spiral(count, 12.7).into_iter().zip(noise);
    let point = |([x, y], e): ([f64; 2], f64)| {
        pose.to_measured([x, y, nominal.height_mm(x, y).unwrap() + noise_mm * e])
    };
    places.map(point).collect()
}

fn settings() -> FitSettings {
    FitSettings { free: Parameter::POSE.to_vec(), ..FitSettings::default() }
}

fn fitted(points: &[PointMm], settings: &FitSettings) -> Fit {
    fit(points, &Nominal::Freeform(Arc::new(piece())), settings).unwrap()
}

fn apart(a: PointMm, b: PointMm) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Shifts in mm and turns in mrad, and by how many mrad each turns about the parent's axis.
fn truths() -> Vec<(Pose, f64)> {
    let [_, axis] = parent();
    let of = |t: [f64; 3], r: [f64; 3]| {
        let [rx_rad, ry_rad, rz_rad] = r.map(|mrad| 1e-3 * mrad);
        let about = (0..3).map(|i| axis[i] * r[i]).sum();
        (Pose { tx_mm: t[0], ty_mm: t[1], tz_mm: t[2], rx_rad, ry_rad, rz_rad }, about)
    };
    vec![
        of([0.012, 0.450, -0.356], [4.486, -1.882, -0.767]),
        of([-0.398, 0.354, 0.293], [4.974, -4.265, 3.857]),
        // Across the parent's axis alone: the aperture comes to lie where it is.
        of([0.7, -0.2, 0.1], [6.0, -20.0, 20.0 * axis[1] / axis[2]]),
        of([-1.5, 0.8, -0.4], [0.0, 0.0, 0.0]),
    ]
}

/// Before, `ry` was held: the aperture slid by 0.40, 0.91, 4.28 and 0 mm.
#[test]
fn the_turn_about_the_parents_axis_stays_at_its_start_and_the_aperture_on_the_part() {
    let [vertex, axis] = parent();
    let end = [0, 1, 2].map(|i| vertex[i] + 100.0 * axis[i]);
    for (truth, about_mrad) in truths() {
        let found = fitted(&measured(&truth, 2_000, 0.0, 1), &settings());
        assert!(found.termination.is_converged(), "{:?}", found.termination);
        assert!(found.sigma_mm < 1e-12, "{:e}", found.sigma_mm);
        // What the points do tell is exact: where the parent's axis lies, and its vertex on it.
        for place in [vertex, end] {
            let off_mm = apart(found.pose.to_measured(place), truth.to_measured(place));
            assert!(off_mm < 1e-9, "the parent is off by {off_mm:e} mm");
        }
        let off_mm = apart(found.pose.to_measured([0.0; 3]), truth.to_measured([0.0; 3]));
        let expected_mm = 1e-3 * about_mrad.abs() * BESIDE_MM;
        eprintln!("turned by {about_mrad:.3} mrad: aperture off by {off_mm:.4} mm");
        // Turns do not quite add up: 20 mrad by 20 mrad.
        assert!((off_mm - expected_mm).abs() < 0.03, "{off_mm}, expected {expected_mm} mm");
        let [held] = &found.undetermined[..] else { panic!("{:?}", found.undetermined) };
        assert!(held.by_shape && held.is_combined);
        assert_eq!(held.what, "turn about the parent's axis");
        let said = "the turn about the parent's axis cannot be found from these points: held at its start; \
                    every mrad it is off moves the aperture by 0.050 mm over the part";
        assert_eq!(held.text, said);
        assert_eq!((found.indeterminate.len(), found.freedoms.count()), (1, 5));
        assert_eq!((found.estimates.len(), found.dof), (6, 1_995));
    }
}

/// Over 80 draws of noise each parameter scatters by its u, to three standard deviations of such a scatter.
#[test]
fn uncertainties_are_those_with_the_turn_held() {
    let truth = truths()[1].0;
    let fits: Vec<Fit> = (0..80)
        .map(|seed| {
            fitted(&measured(&truth, 300, 1e-5, seed), &FitSettings { start: truth, ..settings() })
        })
        .collect();
    for index in 0..6 {
        let values: Vec<f64> = fits.iter().map(|fit| fit.estimates[index].value).collect();
        let mean = values.iter().sum::<f64>() / 80.0;
        let scatter = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 79.0).sqrt();
        let u = fits.iter().map(|fit| fit.estimates[index].u.unwrap()).sum::<f64>() / 80.0;
        let name = fits[0].estimates[index].parameter;
        eprintln!("{name}: scatter {scatter:e}, u {u:e}");
        assert!((scatter / u - 1.0).abs() < 0.24, "{name}: scatter {scatter:e}, u {u:e}");
    }
}

#[test]
fn running_fits_hold_the_same() {
    let grid =
        Grid { x_min_mm: -13.0, x_max_mm: 13.0, y_min_mm: -13.0, y_max_mm: 13.0, nx: 32, ny: 32 };
    let points = measured(&truths()[0].0, 3_000, 2e-6, 5);
    for loss in [Loss::Squares, Loss::HUBER] {
        let settings = FitSettings { loss, ..settings() };
        let full = fitted(&points, &settings);
        let nominal = Nominal::Freeform(Arc::new(piece()));
        let mut live = Live::new(nominal, LiveSettings::new(settings, grid)).unwrap();
        points.iter().for_each(|&point| live.push(point));
        let found = live.estimate().unwrap();
        assert_eq!(found.indeterminate, full.indeterminate);
        assert_eq!(found.undetermined[0].what, full.undetermined[0].what);
        let off = pose_difference(&found.pose, &full.pose);
        let u = full.estimates.iter().filter_map(|estimate| estimate.u).fold(0.0, f64::max);
        eprintln!("{loss:?}: running pose off by {off:e}, the largest u is {u:e}");
        assert!(off < 0.5 * u, "{loss:?}: {off:e}, u {u:e}");
        assert_eq!(found.estimates.len(), full.estimates.len());
        for (running, last) in found.estimates.iter().zip(&full.estimates) {
            assert!(
                (running.u.unwrap() / last.u.unwrap() - 1.0).abs() < 0.05,
                "{running:?} {last:?}"
            );
        }
    }
}

#[test]
fn the_minimum_zone_holds_no_more() {
    let nominal = Nominal::Freeform(Arc::new(piece()));
    let points = measured(&truths()[1].0, 500, 1e-5, 3);
    let zone_settings = ZoneSettings { fit: settings(), ..ZoneSettings::default() };
    let zone = minimum_zone(&points, &nominal, &zone_settings).unwrap();
    assert!(zone.termination.is_settled(), "{:?}", zone.termination);
    assert_eq!(zone.indeterminate, zone.least_squares.indeterminate);
    assert!(pose_difference(&zone.pose, &zone.least_squares.pose) < 1e-2);
}

/// A cylinder that lies at 0.3 rad: of the shifts the one along it is held, not that along y.
#[test]
fn a_cylinder_that_lies_askew_stays_where_it_is_along_its_axis() {
    let nominal = Nominal::Freeform(Arc::new(Cylinder::new(40.0).unwrap()));
    let truth = Pose { tx_mm: 0.4, ty_mm: 0.7, rz_rad: 0.3, ..Pose::default() };
    let points: Vec<PointMm> = spiral(1_000, 8.0)
        .into_iter()
        .map(|[x, y]| truth.to_measured([x, y, nominal.height_mm(x, y).unwrap()]))
        .collect();
    let start = Pose { rz_rad: 0.28, ..Pose::default() };
    let found = fit(&points, &nominal, &FitSettings { start, ..settings() }).unwrap();
    assert!(found.sigma_mm < 1e-12, "{:e}", found.sigma_mm);
    assert_eq!(found.indeterminate, [Parameter::Ty, Parameter::Ry]);
    // Along the axis (−sin, cos) nothing; across it all there is.
    let (sin, cos) = 0.3_f64.sin_cos();
    let along_mm = -sin * found.pose.tx_mm + cos * found.pose.ty_mm;
    let across_mm = cos * found.pose.tx_mm + sin * found.pose.ty_mm;
    assert!(along_mm.abs() < 0.02, "{along_mm}");
    assert!((across_mm - (0.4 * cos + 0.7 * sin)).abs() < 1e-9, "{across_mm}");
    let text = &found.undetermined[0].text;
    assert!(text.starts_with("the shift along y of the part cannot be found"), "{text}");
}

/// A shift along an axis of the part has its name, in the words of one who moves the part.
#[test]
fn a_shift_along_an_axis_has_its_name() {
    let nominal = Nominal::Freeform(Arc::new(Cylinder::new(40.0).unwrap()));
    let points: Vec<PointMm> = spiral(1_000, 8.0)
        .into_iter()
        .map(|[x, y]| [x, y, nominal.height_mm(x, y).unwrap()])
        .collect();
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz];
    let found = fit(&points, &nominal, &FitSettings { free, ..settings() }).unwrap();
    let [held] = &found.undetermined[..] else { panic!("{:?}", found.undetermined) };
    let said = "ty cannot be found from these points: moving the part along y changes nothing. It is held at its start";
    assert_eq!(held.text, said);
}

//! The computed scan against the fit, against sums of its own, and against itself.

#![expect(clippy::unwrap_used, reason = "a failed test may panic, in its helpers too")]

use std::f64::consts::TAU;

use asphera_form::{
    Aperture, Asphere, FitSettings, Nominal, Parameter, Pose, Termination, deviations, fit,
};
use asphera_rig::{Plan, Scene};

/// The asphere of the built-in scene, written down here once more.
fn nominal() -> Nominal {
    let terms = [(4, 3.69067205091e-5), (6, -1.285461192617e-8), (8, -1.400167659754e-10)];
    Nominal::Asphere(Asphere::new(11.65, -1.1, &terms).unwrap())
}

fn pose() -> Pose {
    Pose {
        tx_mm: 0.024,
        ty_mm: -0.018,
        tz_mm: 0.0035,
        rx_rad: 0.0003,
        ry_rad: -0.0004,
        rz_rad: 0.0,
    }
}

fn asphere(points: u64) -> (Scene, Plan) {
    let scene = Scene::built_in("asphere").unwrap().with_points(points);
    let plan = Plan::new(&scene).unwrap();
    (scene, plan)
}

fn differences(a: &Pose, b: &Pose) -> [f64; 6] {
    [
        a.tx_mm - b.tx_mm,
        a.ty_mm - b.ty_mm,
        a.tz_mm - b.tz_mm,
        a.rx_rad - b.rx_rad,
        a.ry_rad - b.ry_rad,
        a.rz_rad - b.rz_rad,
    ]
}

#[test]
fn the_fit_finds_the_stated_pose_in_the_ideal_points() {
    let (_, plan) = asphere(5_000);
    let settings =
        FitSettings { aperture: Aperture::Circle { radius_mm: 9.0 }, ..FitSettings::default() };
    let found = fit(plan.ideal_mm(), &nominal(), &settings).unwrap();
    assert!(matches!(found.termination, Termination::Converged { .. }));
    assert_eq!(found.used, 5_000);
    for difference in differences(&found.pose, &pose()) {
        assert!(difference.abs() < 1e-9, "{:?}", found.pose);
    }
    let rms_nm = 1e6 * found.sigma_mm * (found.dof as f64 / found.used as f64).sqrt();
    assert!((rms_nm - plan.truth().part.deviation.rms_nm).abs() < 1e-3);
}

#[test]
fn a_fit_of_the_noisy_points_agrees_within_the_noise() {
    let (_, plan) = asphere(20_000);
    let found = fit(plan.measured_mm(), &nominal(), &FitSettings::default()).unwrap();
    for (difference, estimate) in
        differences(&found.pose, &pose()).iter().zip(found.estimates.iter().take(5))
    {
        // The uncertainty of the fit counts the form error as noise: far more than there is.
        assert!(difference.abs() < estimate.u.unwrap(), "{difference} {estimate:?}");
    }
}

/// Deviations along z of the part frame, taken with the normal's slope: exact to second order,
/// (200 nm)² · curvature, far below the bound.
fn deviations_nm(points: &[[f64; 3]]) -> Vec<f64> {
    points
        .iter()
        .map(|&point| {
            let [x, y, z] = pose().to_part(point);
            let rho = x.hypot(y);
            let slope = nominal().slope(rho);
            (z - nominal().sag_mm(rho)) / (1.0 + slope * slope).sqrt() * 1e6
        })
        .collect()
}

#[test]
fn the_figures_are_those_of_the_points() {
    let (_, plan) = asphere(5_000);
    for (points, truth) in [
        (plan.measured_mm(), plan.truth().form.deviation),
        (plan.ideal_mm(), plan.truth().part.deviation),
    ] {
        let found = deviations_nm(points);
        let max = found.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let min = found.iter().copied().fold(f64::INFINITY, f64::min);
        let rms = (found.iter().map(|v| v * v).sum::<f64>() / found.len() as f64).sqrt();
        assert!((max - truth.max_nm).abs() < 0.01, "{max} {truth:?}");
        assert!((min - truth.min_nm).abs() < 0.01, "{min} {truth:?}");
        assert!((rms - truth.rms_nm).abs() < 0.01, "{rms} {truth:?}");
        assert!((truth.max_nm - truth.min_nm - truth.pv_nm).abs() < 1e-9);
        let highest = found.iter().position(|v| *v == max).unwrap();
        let at = pose().to_part(points[highest]);
        assert!((0..3).all(|i| (at[i] - truth.at_max_mm[i]).abs() < 1e-12));
    }
}

#[test]
fn the_part_has_the_form_error_asked_for_and_the_probe_its_noise() {
    let (_, plan) = asphere(20_000);
    let part = plan.truth().part.deviation;
    assert!((150.0..250.0).contains(&part.pv_nm), "{part:?}");
    // Noise along z of 5 nm; what the telegram rounds adds at most a quarter of a nanometre.
    let errors: Vec<f64> = plan
        .measured_mm()
        .iter()
        .zip(plan.ideal_mm())
        .map(|(measured, ideal)| (measured[2] - ideal[2]) * 1e6)
        .collect();
    let n = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / n;
    let sigma = (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt();
    assert!(mean.abs() < 5.0 * 5.0 / n.sqrt(), "{mean}");
    assert!((sigma - 5.0).abs() < 5.0 * 5.0 / (2.0 * n).sqrt(), "{sigma}");
}

/// The points as the station makes them of what the instruments say, to the last bit but the
/// order of its operations.
#[test]
fn the_points_are_what_a_station_makes_of_the_readings() {
    let (_, plan) = asphere(3_000);
    for (trigger, measured) in plan.triggers().iter().zip(plan.measured_mm()) {
        let rho_mm = f64::from(trigger.stop.stage_steps[0]) * 1e-6;
        let theta_rad = f64::from(trigger.stop.rotary_counts) * (TAU / 3_600_000.0);
        let z_mm = f64::from(trigger.distance_um) * 1e-3 - 1.0;
        let point = [rho_mm * theta_rad.cos(), rho_mm * theta_rad.sin(), z_mm];
        assert!((0..3).all(|i| (point[i] - measured[i]).abs() < 1e-14 * 64.0));
    }
    // The part is met where the encoders say, not where the path was meant to be.
    for (measured, ideal) in plan.measured_mm().iter().zip(plan.ideal_mm()) {
        assert!((measured[0] - ideal[0]).hypot(measured[1] - ideal[1]) < 1e-12);
    }
}

#[test]
fn a_seed_gives_the_same_bits_and_another_seed_other_noise() {
    let (scene, plan) = asphere(2_000);
    let again = Plan::new(&scene).unwrap();
    assert_eq!(plan.triggers(), again.triggers());
    assert_eq!(plan.truth(), again.truth());
    let other = Plan::new(&scene.with_seed(2)).unwrap();
    assert_eq!(plan.ideal_mm(), other.ideal_mm());
    assert_ne!(plan.truth().form, other.truth().form);
    assert_eq!(plan.truth().part, other.truth().part);
}

#[test]
fn without_noise_and_error_nothing_is_left_but_the_telegram() {
    let text = Scene::built_in_toml("asphere").unwrap();
    let start = text.find("[part.form_error]").unwrap();
    let end = text.find("# What the station fits").unwrap();
    let text = format!("{}{}", &text[..start], &text[end..]);
    let text = text.replace("noise_nm = 5.0", "noise_nm = 0.0");
    let scene = Scene::parse("perfect", &text).unwrap().with_points(2_000);
    let plan = Plan::new(&scene).unwrap();
    assert!(plan.truth().part.deviation.pv_nm < 1e-6);
    // Distances up to 4.7 mm in single precision: half a unit in the last place is 0.244 nm.
    let deviation = plan.truth().form.deviation;
    assert!(deviation.max_nm < 0.2442 && deviation.min_nm > -0.2442, "{deviation:?}");
}

#[test]
fn the_sphere_is_found_with_its_radius() {
    let scene = Scene::built_in("sphere").unwrap().with_points(2_500);
    let plan = Plan::new(&scene).unwrap();
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz, Parameter::Radius];
    let settings = FitSettings { free, ..FitSettings::default() };
    let nominal = Nominal::Sphere { radius_mm: 20.0 };
    let found = fit(plan.ideal_mm(), &nominal, &settings).unwrap();
    for (estimate, truth) in found.estimates.iter().zip([0.021, 0.012, -0.0042, 20.0]) {
        assert!((estimate.value - truth).abs() < 1e-9, "{estimate:?}");
    }
    let truth = plan.truth();
    assert_eq!(truth.form.fit.parameters["radius"].value, 20.0);
    let left = deviations(plan.ideal_mm(), &found.nominal, &found.pose);
    let rms = (left.iter().map(|v| v * v).sum::<f64>() / left.len() as f64).sqrt() * 1e6;
    assert!((rms - truth.part.deviation.rms_nm).abs() < 1e-3);
}

/// The names are those of the daemon's report, so that a script can compare key by key.
#[test]
fn the_truth_has_the_names_of_the_report() {
    let (_, plan) = asphere(100);
    let json = serde_json::to_value(plan.truth()).unwrap();
    for pointer in [
        "/form/deviation/pv_nm",
        "/form/deviation/rms_nm",
        "/form/deviation/at_max_mm/2",
        "/form/fit/pose/tx_mm",
        "/form/fit/pose/rz_rad",
        "/form/fit/parameters/ry/value",
        "/part/deviation/min_nm",
        "/noise_nm",
        "/points",
        "/seed",
    ] {
        assert!(json.pointer(pointer).is_some_and(serde_json::Value::is_number), "{pointer}");
    }
    assert_eq!(json.pointer("/form/fit/parameters/rx/unit").unwrap(), "rad");
    assert_eq!(json.pointer("/scene").unwrap(), "asphere");
}

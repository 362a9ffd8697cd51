//! Starts that need no human: far, tilted, upside down, turned.

use std::f64::consts::PI;

use asphera_form::{
    Aperture, Asphere, Caution, FitSettings, MeasuredFrom, Nominal, Parameter, PointMm, Pose, fit,
};
use rayon::prelude::*;

use crate::common::{Noise, al1815, misaligned, pose_difference, spiral};
use crate::shapes::{biconic, cylinder, saddle, toroid};

const RADIUS_MM: f64 = 8.0;
/// Random poses of each part. With 500 none is missed either.
const RUNS: u64 = 120;
/// Half the range of the noise.
const NOISE_MM: f64 = 2e-5;

/// A pose with a decentre of up to a third of the aperture, up to 10° of tilt, any turn about the axis, and
/// upside down every other time.
fn anywhere(noise: &mut Noise) -> (Pose, bool) {
    let decentre_mm = 2.0 * RADIUS_MM / 3.0;
    let tilt_rad = 10.0_f64.to_radians();
    let (toward, leaning) = (PI * noise.next(), PI * noise.next());
    let (far, steep) = (decentre_mm * noise.next().abs(), tilt_rad * noise.next().abs());
    let upside_down = noise.next() > 0.0;
    let pose = Pose {
        tx_mm: far * toward.cos(),
        ty_mm: far * toward.sin(),
        tz_mm: 5.0 * noise.next(),
        rx_rad: steep * leaning.cos() + if upside_down { PI } else { 0.0 },
        ry_rad: steep * leaning.sin(),
        rz_rad: PI * noise.next(),
    };
    (pose, upside_down)
}

fn measured(nominal: &Nominal, pose: &Pose, noise: &mut Noise, count: usize) -> Vec<PointMm> {
    spiral(count, RADIUS_MM)
        .into_iter()
        .map(|[x, y]| {
            let z = nominal.height_mm(x, y).unwrap() + NOISE_MM * noise.next();
            pose.to_measured([x, y, z])
        })
        .collect()
}

/// How many of `runs` random poses are not found, and what the first such fit says.
fn failures(nominal: &Nominal, free: &[Parameter], aperture: Aperture, runs: u64) -> Vec<String> {
    let run = |seed: u64| {
        let mut noise = Noise::new(seed);
        let (pose, upside_down) = anywhere(&mut noise);
        let points = measured(nominal, &pose, &mut noise, 400);
        let settings = FitSettings {
            free: free.to_vec(),
            aperture: aperture.clone(),
            ..FitSettings::default()
        };
        let fitted = match fit(&points, nominal, &settings) {
            Ok(fitted) => fitted,
            Err(error) => return Some(format!("seed {seed}, {pose:?}: {error}")),
        };
        let told = fitted.cautions.contains(&Caution::UpsideDown { allowed: false });
        // Uniform noise of this range has a standard deviation of its half over √3.
        let is_found = fitted.sigma_mm < NOISE_MM && 10 * fitted.used > 9 * points.len();
        (!is_found || told != upside_down).then(|| {
            format!(
                "seed {seed}, {pose:?}: sigma {:e} mm of {} points, told {told}, {:?}",
                fitted.sigma_mm, fitted.used, fitted.termination
            )
        })
    };
    (0..runs).into_par_iter().filter_map(run).collect()
}

fn every_start_is_found(nominal: &Nominal, free: &[Parameter], aperture: Aperture) {
    let found = failures(nominal, free, aperture, RUNS);
    eprintln!("{}: {} of {RUNS} not found", nominal.kind(), found.len());
    assert!(found.is_empty(), "{nominal}: {} of {RUNS}: {:?}", found.len(), found.first());
}

#[test]
fn spheres_from_anywhere() {
    for radius_mm in [40.0, -15.0] {
        every_start_is_found(&Nominal::Sphere { radius_mm }, &Parameter::RIGID, Aperture::None);
    }
}

#[test]
fn a_strong_asphere_from_anywhere() {
    every_start_is_found(&al1815(), &Parameter::RIGID, Aperture::None);
}

#[test]
fn a_strong_asphere_in_its_aperture_from_anywhere() {
    let aperture = Aperture::Circle { radius_mm: RADIUS_MM + 0.1 };
    every_start_is_found(&al1815(), &Parameter::RIGID, aperture);
}

#[test]
fn a_paraboloid_and_a_gull_wing_from_anywhere() {
    let paraboloid = Nominal::Asphere(Asphere::new(-25.0, -1.0, &[]).unwrap());
    every_start_is_found(&paraboloid, &Parameter::RIGID, Aperture::None);
    // Concave in the middle, convex at the rim.
    let gull = Nominal::Asphere(Asphere::new(30.0, 0.0, &[(4, -4e-4), (6, 1e-6)]).unwrap());
    every_start_is_found(&gull, &Parameter::RIGID, Aperture::None);
}

#[test]
fn freeforms_from_anywhere() {
    for nominal in [biconic(), saddle(), toroid(), cylinder()] {
        every_start_is_found(&nominal, &Parameter::POSE, Aperture::None);
    }
}

#[test]
fn a_start_that_is_good_enough_stays() {
    let points = measured(&al1815(), &misaligned(), &mut Noise::new(5), 800);
    let with = |search: bool| {
        fit(&points, &al1815(), &FitSettings { search, ..FitSettings::default() }).unwrap()
    };
    assert_eq!(with(true), with(false));
}

#[test]
fn what_is_not_free_is_not_searched() {
    // Upside down, but the tilts are fixed: the fit stays as it can and the misfit shows.
    let over = Pose { rx_rad: PI, ..Pose::default() };
    let points = measured(&al1815(), &over, &mut Noise::new(6), 800);
    let free = vec![Parameter::Tx, Parameter::Ty, Parameter::Tz];
    let fitted = fit(&points, &al1815(), &FitSettings { free, ..FitSettings::default() }).unwrap();
    assert!(matches!(fitted.cautions[..], [Caution::Mirrored { .. }]), "{:?}", fitted.cautions);
    let words = fitted.cautions[0].to_string();
    assert!(words.contains("`--along 0,0,-1`") && words.contains("--flip"), "{words}");
    assert!(fitted.sigma_mm > 0.5);
    assert_eq!((fitted.pose.rx_rad, fitted.pose.ry_rad), (0.0, 0.0));
}

#[test]
fn upside_down_is_told_and_found_exactly() {
    let over = Pose { tx_mm: 0.2, rx_rad: PI - 0.01, ry_rad: 0.02, ..Pose::default() };
    let points: Vec<PointMm> = spiral(2_000, RADIUS_MM)
        .into_iter()
        .map(|[x, y]| over.to_measured([x, y, al1815().sag_mm(x.hypot(y))]))
        .collect();
    let fitted = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    assert_eq!(fitted.cautions, [Caution::UpsideDown { allowed: false }]);
    assert!(fitted.sigma_mm < 1e-13 && pose_difference(&fitted.pose, &over) < 1e-11);
    assert!(fitted.cautions[0].to_string().contains("upside down"));
    let either = FitSettings { side: MeasuredFrom::Either, ..FitSettings::default() };
    let allowed = fit(&points, &al1815(), &either).unwrap();
    assert_eq!(allowed.cautions, [Caution::UpsideDown { allowed: true }]);
    assert_eq!((allowed.pose, allowed.sigma_mm), (fitted.pose, fitted.sigma_mm));
}

/// Heights with the wrong sign, where the pose may not turn over: a profile, a bowl held upright.
#[test]
fn wrong_signs_that_no_free_motion_mends_are_told() {
    let mirrored = |points: &[PointMm], nominal: &Nominal, free: &[Parameter]| {
        let settings = FitSettings { free: free.to_vec(), search: false, ..FitSettings::default() };
        let cautions = fit(points, nominal, &settings).unwrap().cautions;
        cautions.into_iter().find_map(|caution| match caution {
            Caution::Mirrored { rms_mm, mirrored_rms_mm } => Some((rms_mm, mirrored_rms_mm)),
            _ => None,
        })
    };
    for nominal in [al1815(), Nominal::Sphere { radius_mm: -40.0 }, biconic(), saddle()] {
        let mut noise = Noise::new(3);
        let upright = Pose { tz_mm: 2.0, rx_rad: 1e-3, ry_rad: -2e-3, ..Pose::default() };
        let points = measured(&nominal, &upright, &mut noise, 400);
        let reflected: Vec<PointMm> = points.iter().map(|&[x, y, z]| [x, y, -z]).collect();
        let free = [Parameter::Tz, Parameter::Rx, Parameter::Ry];
        assert_eq!(mirrored(&points, &nominal, &free), None, "{nominal}");
        let (rms_mm, mirrored_rms_mm) = mirrored(&reflected, &nominal, &free).unwrap();
        let expected_mm = NOISE_MM / 3.0_f64.sqrt();
        assert!(rms_mm > 0.1 && mirrored_rms_mm < 1.1 * expected_mm, "{nominal}: {rms_mm}");
        // Turned over instead, where that is allowed: then it is not mirrored.
        if nominal.is_rotational() {
            let fitted = fit(&reflected, &nominal, &FitSettings::default()).unwrap();
            assert_eq!(fitted.cautions, [Caution::UpsideDown { allowed: false }], "{nominal}");
        }
    }
    let neither: Vec<PointMm> =
        spiral(300, 8.0).iter().map(|&[x, y]| [x, y, (9.0 * x).sin()]).collect();
    assert_eq!(mirrored(&neither, &al1815(), &[Parameter::Tz]), None);
}

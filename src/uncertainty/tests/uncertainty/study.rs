//! Two thousand simulated measurements a case: how often the 95 % intervals hold the truth.

use crate::common::{al1815, misaligned, normals, spiral};
use asphera_form::artefact::Artefact;
use asphera_form::form_error::FormError;
use asphera_form::{Aperture, FitSettings, Nominal, Parameter, PointMm, Pose, fit};
use asphera_uncertainty::{Budget, Kernel, LongWave, Noise, uncertainty};
use nalgebra::{Cholesky, DMatrix, DVector};
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

struct Case {
    name: &'static str,
    nominal: Nominal,
    pose: Pose,
    free: Vec<Parameter>,
    radius_mm: f64,
    points: usize,
    /// Of the form, as a multiple of a typical one.
    form: f64,
    noise_mm: f64,
    wave: Option<LongWave>,
    stated: bool,
}

/// A measurement without errors, and what is needed to lay errors over it.
struct Bench {
    points: Vec<PointMm>,
    normals: Vec<[f64; 3]>,
    rms_nm: f64,
    root: Option<DMatrix<f64>>,
}

fn bench(case: &Case) -> Bench {
    let sample = spiral(case.points, case.radius_mm);
    // Without its ring, which so few points do not resolve: it would count as noise.
    let error = FormError { ring: None, ..FormError::typical(case.radius_mm) };
    let form = case.form;
    let error_mm = move |x: f64, y: f64| form * error.height_nm(x, y) * 1e-6;
    let artefact =
        Artefact::new(case.nominal.clone(), case.pose, &case.free, &sample, error_mm).unwrap();
    let points: Vec<PointMm> =
        sample.iter().map(|&[x, y]| artefact.point_mm(x, y).unwrap()).collect();
    let square: f64 =
        sample.iter().map(|&[x, y]| artefact.deviation_mm(x, y).unwrap().powi(2)).sum();
    let origin = case.pose.to_measured([0.0; 3]);
    let normal = |point: &PointMm| {
        let foot = case.nominal.foot(case.pose.to_part(*point)).unwrap();
        let end = case.pose.to_measured(foot.normal);
        std::array::from_fn(|axis| end[axis] - origin[axis])
    };
    let root = case.wave.map(|wave| {
        let h = |i: usize, j: usize| {
            let (a, b) = (sample[i], sample[j]);
            (a[0] - b[0]).hypot(a[1] - b[1]) / wave.length_mm
        };
        let n = sample.len();
        // The kernel anew, from its definition.
        let kernel = DMatrix::from_fn(n, n, |i, j| {
            let correlation = match wave.kernel {
                Kernel::Gaussian => (-0.5 * h(i, j) * h(i, j)).exp(),
                Kernel::Matern => (1.0 + h(i, j)) * (-h(i, j)).exp(),
                Kernel::Exponential => (-h(i, j)).exp(),
            };
            wave.sigma_mm * wave.sigma_mm * (correlation + if i == j { 1e-9 } else { 0.0 })
        });
        Cholesky::new(kernel).unwrap().l()
    });
    Bench {
        normals: points.iter().map(normal).collect(),
        rms_nm: (square / case.points as f64).sqrt() * 1e6,
        points,
        root,
    }
}

/// For each quantity whether its interval holds the truth, the last being the RMS; and the RMS with its uncertainty.
fn measure(case: &Case, bench: &Bench, seed: u64) -> (Vec<bool>, [f64; 2]) {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let mut errors_mm: Vec<f64> =
        normals(&mut generator, case.points).iter().map(|value| case.noise_mm * value).collect();
    if let Some(root) = &bench.root {
        let wave = root * DVector::from_vec(normals(&mut generator, case.points));
        errors_mm.iter_mut().zip(wave.iter()).for_each(|(error, wave)| *error += wave);
    }
    let laid = bench.points.iter().zip(&bench.normals).zip(&errors_mm);
    let points: Vec<PointMm> = laid
        .map(|((point, normal), error)| std::array::from_fn(|i| point[i] + error * normal[i]))
        .collect();
    let settings = FitSettings {
        free: case.free.clone(),
        start: case.pose,
        search: false,
        ..FitSettings::default()
    };
    let fitted = fit(&points, &case.nominal, &settings).unwrap();
    let noise = if case.stated {
        Noise::Uniform { sigma_mm: case.noise_mm, dof: f64::INFINITY }
    } else {
        Noise::Measured
    };
    let budget = Budget { noise, long_waves: case.wave.into_iter().collect(), ..Budget::default() };
    let found = uncertainty(&points, &fitted, &Aperture::None, None, &budget).unwrap();
    let mut inside: Vec<bool> = found
        .parameters
        .iter()
        .map(|of| {
            let truth = of.parameter.value(&case.pose, &case.nominal).unwrap();
            (of.value - truth).abs() <= of.expanded(0.95).expanded
        })
        .collect();
    let [low, high] = found.rms.interval_nm(0.95);
    inside.push((low..=high).contains(&bench.rms_nm));
    (inside, [found.rms.form_nm, found.rms.u_nm])
}

fn study(case: &Case) {
    let bench = bench(case);
    let (all, rms): (Vec<Vec<bool>>, Vec<[f64; 2]>) =
        (0..MEASUREMENTS).into_par_iter().map(|seed| measure(case, &bench, seed)).unzip();
    let names: Vec<String> =
        case.free.iter().map(ToString::to_string).chain(["RMS".to_owned()]).collect();
    let mut line = format!("{:34} form {:5.1} nm:", case.name, bench.rms_nm);
    let mut out = Vec::new();
    for (index, name) in names.iter().enumerate() {
        let share = all.iter().filter(|inside| inside[index]).count() as f64 / all.len() as f64;
        line += &format!("  {name} {:.2} %", 100.0 * share);
        if (share - 0.95).abs() > 0.015 {
            out.push(name.clone());
        }
    }
    let count = rms.len() as f64;
    let mean = rms.iter().map(|[form_nm, _]| form_nm).sum::<f64>() / count;
    let square: f64 = rms.iter().map(|[form_nm, _]| (form_nm - mean).powi(2)).sum();
    let scatter = (square / (count - 1.0)).sqrt();
    let stated = rms.iter().map(|[_, u_nm]| u_nm).sum::<f64>() / count;
    line += &format!("  RMS {mean:.2} nm, scatter {scatter:.2} nm, u {stated:.2} nm");
    eprintln!("{line}");
    assert!((mean / bench.rms_nm - 1.0).abs() < 0.05, "{line}: biased");
    assert!((stated / scatter - 1.0).abs() < 0.12, "{line}: u is not the scatter");
    assert!(out.is_empty(), "{line}: {out:?} not within 95 ± 1.5 %");
}

fn on_sphere() -> Case {
    use Parameter::{Radius, Tx, Ty, Tz};
    Case {
        name: "sphere",
        nominal: Nominal::Sphere { radius_mm: 20.0 },
        pose: Pose { tx_mm: 0.01, ty_mm: -0.02, tz_mm: 0.3, ..Pose::default() },
        free: vec![Tx, Ty, Tz, Radius],
        radius_mm: 9.0,
        points: 400,
        form: 1.0,
        noise_mm: 20e-6,
        wave: None,
        stated: false,
    }
}

fn on_asphere() -> Case {
    Case {
        name: "asphere",
        nominal: al1815(),
        pose: misaligned(),
        free: Parameter::RIGID.iter().copied().chain([Parameter::Radius]).collect(),
        ..on_sphere()
    }
}

fn wave(sigma_mm: f64, kernel: Kernel) -> Option<LongWave> {
    Some(LongWave { sigma_mm, length_mm: 5.0, kernel, dof: f64::INFINITY })
}

#[test]
fn sphere_with_independent_noise() {
    study(&Case { name: "sphere, noise measured", ..on_sphere() });
}

#[test]
fn sphere_with_correlated_noise() {
    study(&Case {
        name: "sphere, noise and smooth wave",
        wave: wave(30e-6, Kernel::Gaussian),
        ..on_sphere()
    });
}

#[test]
fn asphere_with_independent_noise() {
    study(&Case { name: "asphere, noise measured", ..on_asphere() });
}

#[test]
fn asphere_with_correlated_noise() {
    study(&Case {
        name: "asphere, noise and smooth wave",
        wave: wave(30e-6, Kernel::Gaussian),
        ..on_asphere()
    });
}

const MEASUREMENTS: u64 = 2000;

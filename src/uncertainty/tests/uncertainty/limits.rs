//! Simulated measurements of a flat: how often the 95 % intervals of minimum zone and texture hold the truth.
//!
//! Truth of all of them is the figure of the same places without errors: the zone of the points without errors, and
//! the parameters of the surface that the same filters leave of the deviation without errors.

use asphera_figures::texture::{Datum, Gaussian, Mesh, Order, Scale, height_parameters};
use asphera_form::{
    Aperture, FitSettings, Nominal, Parameter, PointMm, Pose, ZoneSettings, deviations, fit,
    minimum_zone,
};
use asphera_uncertainty::{
    Budget, Draws, Kernel, LongWave, Noise, Simulated, Uncertainty, uncertainty,
};
use nalgebra::{Cholesky, DMatrix};
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::common::normals;

/// A lattice of `SIDE` by `SIDE` places on a flat of 10 mm.
struct Case {
    name: &'static str,
    noise_nm: f64,
    wave: Option<LongWave>,
    /// Of the short waves, 1.5 mm long; the long ones have 40 nm.
    ripple_nm: f64,
    scale: Scale,
}

struct Found {
    name: String,
    value: f64,
    simulated: Simulated,
}

fn place(index: usize) -> [f64; 2] {
    [index % SIDE, index / SIDE].map(|at| WIDTH_MM * at as f64 / (SIDE - 1) as f64)
}

fn form_nm(case: &Case, [x, y]: [f64; 2]) -> f64 {
    let [u, v] = [x / WIDTH_MM, y / WIDTH_MM];
    let long = 40.0 * (3.1 * u + 0.4).sin() * (2.3 * v - 0.2).cos() + 12.0 * (7.0 * u * v).sin();
    let turns = std::f64::consts::TAU;
    long + case.ripple_nm * (turns * (0.6 * x + 0.21 * y) + 0.3 * x).sin() * (1.0 + 0.4 * u * v)
}

/// The Gaussian kernel is a product along x and y, and so is its root.
fn root_of(wave: &LongWave) -> DMatrix<f64> {
    assert_eq!(wave.kernel, Kernel::Gaussian);
    let at = |i: usize| WIDTH_MM * i as f64 / (SIDE - 1) as f64;
    let kernel = DMatrix::from_fn(SIDE, SIDE, |i, j| {
        let h = (at(i) - at(j)) / wave.length_mm;
        (-0.5 * h * h).exp() + if i == j { 1e-9 } else { 0.0 }
    });
    Cholesky::new(kernel).unwrap().l()
}

fn errors_nm(case: &Case, root: Option<&DMatrix<f64>>, seed: u64) -> Vec<f64> {
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let mut errors: Vec<f64> =
        normals(&mut generator, SIDE * SIDE).iter().map(|z| case.noise_nm * z).collect();
    if let (Some(root), Some(wave)) = (root, &case.wave) {
        let white = DMatrix::from_vec(SIDE, SIDE, normals(&mut generator, SIDE * SIDE));
        let waves = root * white * root.transpose() * (wave.sigma_mm * 1e6);
        // Columns of the matrix are rows of the lattice.
        errors.iter_mut().zip(waves.iter()).for_each(|(error, wave)| *error += wave);
    }
    errors
}

fn triangles() -> Vec<[u32; 3]> {
    let cells = (0..SIDE * (SIDE - 1)).filter(|i| i % SIDE + 1 < SIDE);
    cells
        .flat_map(|i| [[i, i + 1, i + SIDE], [i + 1, i + SIDE + 1, i + SIDE]])
        .map(|corners| corners.map(|corner| corner as u32))
        .collect()
}

/// The minimum zone and the limited surface of a measurement with these errors.
fn measure(
    case: &Case,
    triangles: &[[u32; 3]],
    errors_nm: &[f64],
) -> (asphera_form::ZoneFit, Mesh, Vec<PointMm>) {
    let free = vec![Parameter::Tz, Parameter::Rx, Parameter::Ry];
    let points: Vec<PointMm> = (0..SIDE * SIDE)
        .map(|i| {
            let [x, y] = place(i);
            [x, y, 1e-6 * (form_nm(case, [x, y]) + errors_nm[i])]
        })
        .collect();
    let settings = FitSettings { free, start: Pose::default(), ..FitSettings::default() };
    let fitted = fit(&points, &Nominal::Plane, &settings).unwrap();
    let zone_settings = ZoneSettings { fit: settings, ..ZoneSettings::default() };
    let zone = minimum_zone(&points, &Nominal::Plane, &zone_settings).unwrap();
    let deviations_mm = deviations(&points, &fitted.nominal, &fitted.pose);
    let heights: Vec<PointMm> = points
        .iter()
        .zip(&deviations_mm)
        .map(|(&point, &deviation)| {
            let [x, y, _] = fitted.pose.to_part(point);
            [x, y, deviation]
        })
        .collect();
    let mesh = Mesh::new(&heights, triangles).unwrap();
    let limited = case.scale.of_mesh(&mesh, Datum::MeanPlane).surface.levelled(Datum::Mean);
    (zone, limited, points)
}

fn values_nm(zone: &asphera_form::ZoneFit, surface: &Mesh) -> Vec<(String, f64)> {
    let heights = height_parameters(surface.into()).unwrap();
    let mut values = vec![("zone".to_owned(), zone.zone_mm * 1e6)];
    values.extend(
        heights.figures().iter().map(|figure| (figure.definition.to_string(), figure.value)),
    );
    values
}

fn found(case: &Case, triangles: &[[u32; 3]], errors_nm: &[f64], seed: u64) -> Vec<Found> {
    let (zone, surface, points) = measure(case, triangles, errors_nm);
    let noise = Noise::Uniform { sigma_mm: case.noise_nm * 1e-6, dof: f64::INFINITY };
    let budget = Budget { noise, long_waves: case.wave.into_iter().collect(), ..Budget::default() };
    let known: Uncertainty =
        uncertainty(&points, &zone.least_squares, &Aperture::None, None, &budget).unwrap();
    let draws = Draws { count: DRAWS, seed };
    let of_zone = known.minimum_zone_nm(&zone, &draws).unwrap().unwrap();
    assert!((of_zone.measured / (zone.zone_mm * 1e6) - 1.0).abs() < 1e-12);
    let of_texture = known.texture(&surface, &case.scale, Datum::MeanPlane, &draws).unwrap();
    let values = values_nm(&zone, &surface);
    let value = |name: &str| values.iter().find(|(other, _)| other == name).unwrap().1;
    let mut all = vec![Found { name: "zone".to_owned(), value: value("zone"), simulated: of_zone }];
    for (definition, simulated) in of_texture {
        let name = definition.to_string();
        let value = value(&name);
        assert!((simulated.measured / value - 1.0).abs() < 1e-9, "{name}");
        all.push(Found { name, value, simulated });
    }
    all
}

/// Of each figure by name: share of the intervals that hold the truth, mean of u over the scatter of the figure, and the
/// bias told and had.
fn study(case: &Case) -> Vec<(String, f64, f64)> {
    let triangles = triangles();
    let root = case.wave.as_ref().map(root_of);
    let (zone, surface, _) = measure(case, &triangles, &vec![0.0; SIDE * SIDE]);
    let truth = values_nm(&zone, &surface);
    let all: Vec<Vec<Found>> = (0..MEASUREMENTS)
        .into_par_iter()
        .map(|seed| found(case, &triangles, &errors_nm(case, root.as_ref(), seed), seed))
        .collect();
    let count = all.len() as f64;
    let mut line = format!("{:38}", case.name);
    let mut told = Vec::new();
    for (index, first) in all[0].iter().enumerate() {
        let truth = truth.iter().find(|(name, _)| *name == first.name).unwrap().1;
        let of = || all.iter().map(|found| &found[index]);
        let inside = of().filter(|found| {
            let [low, high] = found.simulated.interval(0.95);
            (low..=high).contains(&truth)
        });
        let share = inside.count() as f64 / count;
        let mean = of().map(|found| found.value).sum::<f64>() / count;
        // Of Sa and Sq u is that of the figure without noise.
        let of_squares = ["Sa", "Sq"].contains(&&first.name[..]);
        let meant =
            |found: &Found| found.value - if of_squares { found.simulated.bias } else { 0.0 };
        let middle = of().map(meant).sum::<f64>() / count;
        let square = of().map(|found| (meant(found) - middle).powi(2)).sum::<f64>();
        let scatter = (square / (count - 1.0)).sqrt();
        let u = of().map(|found| found.simulated.u).sum::<f64>() / count;
        let bias = of().map(|found| found.simulated.bias).sum::<f64>() / count;
        let median = |end: usize| {
            let mut ends: Vec<f64> =
                of().map(|found| found.simulated.interval(0.95)[end]).collect();
            ends.sort_by(f64::total_cmp);
            ends[ends.len() / 2]
        };
        let [low, high] = [0, 1].map(median);
        line += &format!(
            "\n  {:5} truth {truth:7.2} nm: {:5.1} %, u {u:.3} scatter {scatter:.3}, bias {:.2} told {bias:.2}, 95 % {low:.2} to {high:.2}",
            first.name,
            100.0 * share,
            mean - truth
        );
        told.push((first.name.clone(), share, u / scatter));
    }
    eprintln!("{line}");
    told
}

fn filter(cutoff_mm: f64) -> Gaussian {
    Gaussian::new(cutoff_mm, Order::Two).unwrap()
}

fn independent() -> Case {
    Case {
        name: "noise alone, L-filter",
        noise_nm: 2.0,
        wave: None,
        ripple_nm: 20.0,
        scale: Scale::new(None, Some(filter(2.4))).unwrap(),
    }
}

fn smooth() -> Option<LongWave> {
    let dof = f64::INFINITY;
    Some(LongWave { sigma_mm: 5e-6, length_mm: 1.5, kernel: Kernel::Gaussian, dof })
}

/// Averages hold the truth as often as they say, or more where their u is too large: it takes ripples for whole of which
/// the S-filter passes a part. u of what is made of extremes is that of single places, however many may be the extreme.
fn assert_covered(told: &[(String, f64, f64)]) {
    for (name, share, ratio) in told {
        let is_average = ["Sa", "Sq"].contains(&&name[..]);
        let largest = if is_average { 1.8 } else { 2.2 };
        assert!(*share >= 0.92 && (0.75..largest).contains(ratio), "{name}: {share} {ratio}");
    }
}

#[test]
fn with_independent_noise() {
    let told = study(&independent());
    assert_covered(&told);
}

#[test]
fn with_independent_noise_and_both_filters() {
    let scale = Scale::new(Some(filter(1.1)), Some(filter(2.4))).unwrap();
    let told = study(&Case { name: "noise alone, both filters", scale, ..independent() });
    assert_covered(&told);
}

#[test]
fn with_correlated_noise() {
    let told = study(&Case { name: "noise and wave, L-filter", wave: smooth(), ..independent() });
    assert_covered(&told);
}

#[test]
fn with_correlated_noise_and_both_filters() {
    let scale = Scale::new(Some(filter(1.1)), Some(filter(2.4))).unwrap();
    let told = study(&Case {
        name: "noise and wave, both filters",
        wave: smooth(),
        scale,
        ..independent()
    });
    assert_covered(&told);
}

/// Noise of twice the ripples.
#[test]
fn where_noise_makes_the_figure() {
    let told = study(&Case {
        name: "noise over ripples",
        noise_nm: 10.0,
        ripple_nm: 5.0,
        ..independent()
    });
    for (name, share, ratio) in &told {
        // Draws of averages hold the noise twice, and so scatter more than measurements. What is left of them without noise is
        // at least 0, which narrows its scatter.
        let largest = if ["Sa", "Sq"].contains(&&name[..]) { 1.4 } else { 3.2 };
        assert!(*share >= 0.92 && (1.0..largest).contains(ratio), "{name}: {share} {ratio}");
    }
}

const SIDE: usize = 30;
const WIDTH_MM: f64 = 10.0;
const MEASUREMENTS: u64 = 500;
const DRAWS: u32 = 100;

//! Surfaces whose texture is known exactly.

use std::f64::consts::{LN_2, PI, TAU};

use asphera_figures::texture::{
    Datum, Gaussian, Grid, Order, Parameter, Robust, Scale, ScaleKind, Threshold, Unknown,
    core_parameters, height_parameters, hybrid_parameters, spatial_parameters,
};
use asphera_figures::{Definition, Unit};

use super::{grid, mesh};
use crate::common::Noise;

fn near(found: f64, expected: f64, off: f64) {
    assert!((found - expected).abs() <= off, "{found}, expected {expected} ± {off}");
}

/// Ten whole waves along x, sampled evenly.
fn waves(amplitude_nm: f64, offset_nm: f64) -> Grid {
    grid(40, 400, [0.01, 0.01], |x, _| offset_nm + amplitude_nm * (TAU * x / 0.4).sin())
}

#[test]
fn a_sinusoid_has_the_heights_of_one() {
    for offset_nm in [0.0, 1e6] {
        let found = height_parameters((&waves(80.0, offset_nm).levelled(Datum::Mean)).into());
        let found = found.unwrap();
        near(found.sq_nm, 80.0 / 2f64.sqrt(), 1e-8);
        // The mean of |sin| over 40 places a wave.
        near(found.sa_nm, 80.0 / (20.0 * (PI / 40.0).tan()), 1e-8);
        near(found.ssk.unwrap(), 0.0, 1e-9);
        near(found.sku.unwrap(), 1.5, 1e-9);
        near(found.sp_nm, 80.0, 1e-8);
        near(found.sz_nm, 160.0, 1e-8);
        assert_eq!((found.support.points, found.support.measured), (16_000, 1.0));
        assert_eq!(found.support.datum, Datum::Mean);
        assert_eq!(found.figures().len(), 7);
    }
}

#[test]
fn a_tilted_plane_has_its_slope_and_after_removal_nothing() {
    let (a, b) = (3000.0, -4000.0);
    let plane = |x: f64, y: f64| 1e5 + a * x + b * y;
    let tilted = grid(30, 50, [0.02, 0.03], plane);
    let moved =
        |i: u32, j: u32| [f64::from(j) * 0.02 + f64::from(i % 3) * 0.005, f64::from(i) * 0.03];
    let meshed = mesh(30, 50, moved, plane);
    let slope: f64 = 5000e-6;
    let excess = 100.0 * ((1.0 + slope * slope).sqrt() - 1.0);
    for surface in [(&tilted).into(), (&meshed).into()] {
        let found = hybrid_parameters(surface).unwrap();
        near(found.sdq_urad, 5000.0, 1e-5);
        near(found.sdr_percent, excess, 1e-10);
    }
    let (flat, flat_mesh) = (tilted.levelled(Datum::MeanPlane), meshed.levelled(Datum::MeanPlane));
    for surface in [(&flat).into(), (&flat_mesh).into()] {
        near(hybrid_parameters(surface).unwrap().sdq_urad, 0.0, 1e-6);
        near(hybrid_parameters(surface).unwrap().sdr_percent, 0.0, 1e-15);
        near(height_parameters(surface).unwrap().sz_nm, 0.0, 1e-9);
    }
}

/// A pyramid: four faces of slope 2/5 and an area that is known.
#[test]
fn developed_area_of_a_mesh_is_exact() {
    let points =
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.4]];
    let faces = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [0, 4, 3]];
    let pyramid = asphera_figures::texture::Mesh::new(&points, &faces).unwrap();
    let found = hybrid_parameters((&pyramid).into()).unwrap();
    near(found.sdr_percent, 100.0 * (1.16_f64.sqrt() - 1.0), 1e-12);
    near(found.sdq_urad, 0.4e6, 1e-6);
    // The volume over the area: a third of the height.
    let mean = pyramid.levelled(Datum::Mean);
    near(mean.heights_nm().last().unwrap().unwrap(), 0.4e6 * 2.0 / 3.0, 1e-6);
}

/// Share of a wave along x, in the middle of a long surface, that a filter lets pass.
fn transmitted(filter: &Gaussian, period_mm: f64) -> f64 {
    let wave = grid(3, 1201, [0.01, 0.01], |x, _| 100.0 * (TAU * (x - 6.0) / period_mm).cos());
    filter.of_grid(&wave).surface.height_nm(1, 600).unwrap() / 100.0
}

#[test]
fn waves_pass_by_the_share_of_the_standard() {
    for ratio in [0.25, 0.5, 1.0, 1.6] {
        let y = LN_2 * ratio * ratio;
        let zero = Gaussian::new(0.5, Order::Zero).unwrap();
        near(transmitted(&zero, 0.5 / ratio), 2f64.powf(-ratio * ratio), 1e-6);
        near(transmitted(&zero, 0.5 / ratio), (-y).exp(), 1e-6);
        let y = 1.678_346_990_016_66 * ratio * ratio;
        let two = Gaussian::new(0.5, Order::Two).unwrap();
        near(transmitted(&two, 0.5 / ratio), (1.0 + y) * (-y).exp(), 3e-5);
    }
}

/// sin t becomes sin t·exp(−s²/2) under a Gaussian of standard deviation s.
#[test]
fn a_profile_is_filtered_by_the_law_of_the_sine() {
    let (spacing, cutoff) = (0.002, 0.8);
    let s = cutoff * (0.5 * LN_2).sqrt() / PI;
    let heights: Vec<f64> = (0..4000).map(|i| 50.0 * (f64::from(i) * spacing).sin()).collect();
    let profile = Grid::profile(&heights, spacing).unwrap();
    let filtered = Gaussian::new(cutoff, Order::Zero).unwrap().of_grid(&profile);
    for column in (400..3600).step_by(100) {
        let expected = heights[column] * (-0.5 * s * s).exp();
        near(filtered.surface.height_nm(0, column).unwrap(), expected, 1e-5);
    }
}

#[test]
fn order_two_passes_a_quadric_whole_and_order_zero_a_constant() {
    let quadric =
        |x: f64, y: f64| 5e4 + 300.0 * x - 200.0 * y + 90.0 * x * x - 70.0 * x * y + 8.0 * y * y;
    let gap = |x: f64, y: f64| if (3.0 * x + 7.0 * y).sin() > 0.6 { f64::NAN } else { 0.0 };
    let holed = grid(60, 80, [0.05, 0.04], |x, y| quadric(x, y) + gap(x, y));
    let moved =
        |i: u32, j: u32| [f64::from(j) * 0.05, f64::from(i) * 0.04 + f64::from(j % 4) * 0.008];
    let meshed = mesh(60, 80, moved, |x, y| quadric(x, y) + gap(x, y));
    let filter = Gaussian::new(0.5, Order::Two).unwrap();
    for filter in [filter, filter.robust(Robust::default())] {
        let left = Scale::new(None, Some(filter)).unwrap();
        let grid_left = left.of_grid(&holed, Datum::AsGiven);
        let mesh_left = left.of_mesh(&meshed, Datum::AsGiven);
        assert_eq!((grid_left.kind, mesh_left.kind), (ScaleKind::SL, ScaleKind::SL));
        assert!(grid_left.surface.heights_nm().flatten().all(|z| z.abs() < 1e-6));
        assert!(mesh_left.surface.heights_nm().flatten().all(|z| z.abs() < 1e-6));
    }
    let constant = grid(20, 20, [0.05, 0.04], |x, y| 1e8 + gap(x, y));
    let filtered = Gaussian::new(0.3, Order::Zero).unwrap().of_grid(&constant);
    assert!(filtered.surface.heights_nm().flatten().all(|z| z == 1e8));
}

#[test]
fn a_robust_filter_leaves_outliers_where_they_are() {
    let mut noise = Noise::new(5);
    let form = |x: f64| 40.0 * (TAU * x / 3.0).sin();
    let mut heights = Vec::new();
    for i in 0..80 * 80 {
        let peak = if i % 80 % 9 == 4 && i / 80 % 9 < 2 { 500.0 } else { 0.0 };
        heights.push(form(f64::from(i % 80) * 0.02) + noise.next() + peak);
    }
    let peaks = Grid::new(&heights, 80, 80, [0.02, 0.02]).unwrap();
    let linear = Gaussian::new(0.3, Order::Two).unwrap();
    let off = |filter: Gaussian| {
        let filtered = filter.of_grid(&peaks);
        let off = filtered.surface.heights_nm().enumerate();
        let off = off.map(|(i, z)| (z.unwrap() - form((i % 80) as f64 * 0.02)).abs());
        (off.fold(0.0, f64::max), filtered.robust)
    };
    let (pulled, none) = off(linear);
    let (kept, report) = off(linear.robust(Robust::default()));
    let report = report.unwrap();
    assert!(none.is_none() && pulled > 30.0 && kept < 2.0, "{pulled} {kept}");
    assert!(report.converged && report.iterations < 20);
    assert!(report.limit_nm > 1.5 && report.limit_nm < 3.0, "{}", report.limit_nm);
    assert!(report.outliers >= 8 * 2 * 9, "{}", report.outliers);
}

#[test]
fn short_middle_and_long_waves_are_separated() {
    let at = |x: f64, period: f64| (TAU * x / period).sin();
    let sum = |x: f64| 50.0 * at(x, 0.02) + 20.0 * at(x, 0.2) + 300.0 * at(x, 4.0);
    let rough = grid(8, 3200, [0.0025, 0.0025], |x, _| sum(x));
    let filter = |cutoff| Some(Gaussian::new(cutoff, Order::Zero).unwrap());
    let limited = Scale::new(filter(0.06), filter(0.8)).unwrap().of_grid(&rough, Datum::Mean);
    let passed = 2f64.powf(-0.3_f64.powi(2));
    let share = passed * (1.0 - 2f64.powi(-16));
    let long = 300.0 * (1.0 - 2f64.powf(-0.04));
    for column in (600..2600).step_by(8) {
        let x = column as f64 * 0.0025;
        let expected = 20.0 * share * at(x, 0.2) + long * at(x, 4.0);
        near(limited.surface.height_nm(4, column).unwrap(), expected, 0.4);
    }
    let smooth = Scale::new(filter(0.06), None).unwrap().of_grid(&rough, Datum::Mean);
    assert_eq!((limited.kind, smooth.kind), (ScaleKind::SL, ScaleKind::SF));
    assert!(smooth.l.is_none() && smooth.s.as_ref().unwrap().surface == smooth.surface);
}

#[test]
fn grooves_have_the_length_of_their_cosine_and_no_aspect_ratio() {
    // Whole waves: the unbiased function is the cosine but for the ends.
    let period = 0.16;
    let grooves = grid(100, 1600, [0.01, 0.02], |x, _| 7.0 * (TAU * x / period).sin());
    let found = spatial_parameters((&grooves).into(), Threshold::DEFAULT).unwrap();
    let expected_um = 1e3 * period * 0.2_f64.acos() / TAU;
    near(found.sal_um(), expected_um, 3e-3 * expected_um);
    let direction = found.fastest.direction_rad;
    assert!(direction.min(PI - direction) < 1e-3, "{direction}");
    let Err(Unknown::StaysInOneDirection { direction_rad, reach_mm, at_most, .. }) = found.slowest
    else {
        panic!("{:?}", found.slowest)
    };
    near(direction_rad, 0.5 * PI, 0.04);
    assert!(reach_mm >= 0.98 && at_most < 0.04);
    assert_eq!(found.figures().len(), 1);
}

/// Noise under a Gaussian of standard deviation s has the autocorrelation exp(−τ²/4s²).
#[test]
fn smoothed_noise_has_the_length_of_its_gaussian() {
    let mut noise = Noise::new(11);
    let heights: Vec<f64> = (0..600 * 600).map(|_| noise.next()).collect();
    let rough = Grid::new(&heights, 600, 600, [0.01, 0.005]).unwrap();
    // The same distance in mm is twice as many rows as columns.
    let cutoff = 0.1;
    let smooth = Gaussian::new(cutoff, Order::Zero).unwrap().of_grid(&rough).surface;
    let found =
        spatial_parameters((&smooth.levelled(Datum::Mean)).into(), Threshold::DEFAULT).unwrap();
    let s = cutoff * (0.5 * LN_2).sqrt() / PI;
    let expected_um = 1e3 * 2.0 * s * 5f64.ln().sqrt();
    near(found.sal_um(), expected_um, 0.05 * expected_um);
    assert!(found.str_ratio().unwrap() > 0.85, "{found:?}");
}

/// Heights at equal steps of a distribution, in any order.
fn distributed(quantile: impl Fn(f64) -> f64) -> Grid {
    let count = 40_000;
    let heights: Vec<f64> =
        (0..count).map(|i| quantile(((i * 7919 % count) as f64 + 0.5) / count as f64)).collect();
    Grid::new(&heights, 200, 200, [0.01, 0.01]).unwrap()
}

#[test]
fn evenly_spread_heights_are_all_core() {
    let core = core_parameters((&distributed(|p| 90.0 * p)).into()).unwrap();
    near(core.sk_nm, 90.0, 1e-9);
    near(core.spk_nm, 0.0, 1e-9);
    near(core.svk_nm, 0.0, 1e-9);
    assert_eq!((core.smrk1_percent, core.smrk2_percent), (0.0, 100.0));
}

/// A sine has two flattest secants; the last bits of its heights do not choose between them.
#[test]
fn a_symmetric_surface_has_one_core_in_every_unit() {
    let core = |scale: f64, turn: f64| {
        let heights = grid(40, 400, [0.01, 0.01], |x, _| {
            let mm = 1e-3 * (TAU * x / 0.4 + turn).sin();
            // As a file in another unit has them.
            ((mm / scale) * scale) * 1e6
        });
        core_parameters((&heights.levelled(Datum::Mean)).into()).unwrap()
    };
    let of_mm = core(1.0, 0.3);
    for scale in [25.4, 1e-3, 0.7] {
        let found = core(scale, 0.3);
        near(found.spk_nm, of_mm.spk_nm, 1e-3);
        near(found.svk_nm, of_mm.svk_nm, 1e-3);
        near(found.line_from_percent, of_mm.line_from_percent, 1e-9);
    }
}

/// A plateau from 20 to 80 % with a slope of 10 nm, peaks up to 50 nm and dales down to 200 nm, both linear.
#[test]
fn a_stratified_surface_has_the_core_it_is_made_of() {
    let height = |p: f64| match p {
        p if p < 0.2 => 200.0 * (p / 0.2) - 205.0,
        p if p < 0.8 => 10.0 * (p - 0.5) / 0.6,
        p => 5.0 + 45.0 * (p - 0.8) / 0.2,
    };
    let core = core_parameters((&distributed(height)).into()).unwrap();
    let line = |ratio: f64| 10.0 * (0.5 - ratio) / 0.6;
    near(core.sk_nm, 10.0 / 0.6, 1e-3);
    // Where the linear peaks and dales leave the ends of the line.
    let (over, under) = (line(0.0) - 5.0, -5.0 - line(1.0));
    let (first, last) = (0.2 * (1.0 - over / 45.0), 0.2 * (1.0 - under / 200.0));
    near(core.smrk1_percent, 100.0 * first, 0.01);
    near(core.smrk2_percent, 100.0 * (1.0 - last), 0.01);
    near(core.spk_nm, 45.0 - over, 0.02);
    near(core.svk_nm, 200.0 - under, 0.05);
    assert!(core.line_from_percent >= 20.0 - 0.01 && core.line_from_percent < 40.01);
}

/// Of a normal distribution the 40 % lie in the middle; the slope there is ∫(p−½)·q dp/∫(p−½)² dp.
#[test]
fn normal_heights_have_the_core_of_a_normal_distribution() {
    // Acklam's approximation is not needed: the quantile is found by bisection of a series of the error
    // function, exact to 1e-12 within 6 standard deviations.
    let below = |t: f64| {
        let (mut term, mut sum, mut n) = (t, t, 1.0);
        while term.abs() > 1e-17 {
            term *= t * t / (2.0 * n + 1.0);
            sum += term;
            n += 1.0;
        }
        0.5 + sum * (-0.5 * t * t).exp() / TAU.sqrt()
    };
    let quantile = |p: f64| {
        let (mut low, mut high) = (-6.0, 6.0);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if below(middle) < p {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let core = core_parameters((&distributed(|p| 10.0 * quantile(p))).into()).unwrap();
    // 12/0.4³·2·∫ (p − ½)·q(p) dp from ½ to 0.7, by Simpson's rule over 200 intervals.
    let integrand = |p: f64| (p - 0.5) * quantile(p);
    let h = 0.2 / 200.0;
    let weight = |i: i32| if i == 0 || i == 200 { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    let integral: f64 =
        (0..=200).map(|i| weight(i) * integrand(0.5 + f64::from(i) * h)).sum::<f64>() * h / 3.0;
    let sk = 10.0 * 24.0 / 0.064 * integral;
    near(core.sk_nm, sk, 1e-3 * sk);
    near(core.line_from_percent, 30.0, 0.5);
    near(core.smrk1_percent, 100.0 * (1.0 - below(0.05 * sk)), 0.1);
    near(core.smrk1_percent, 100.0 - core.smrk2_percent, 0.1);
}

#[test]
fn every_definition_has_a_text_a_unit_and_a_source() {
    let surface = waves(10.0, 0.0);
    let figures = [
        height_parameters((&surface).into()).unwrap().figures(),
        hybrid_parameters((&surface).into()).unwrap().figures(),
        core_parameters((&surface).into()).unwrap().figures(),
        spatial_parameters((&surface).into(), Threshold::DEFAULT).unwrap().figures(),
    ]
    .concat();
    for figure in &figures {
        assert!(figure.definition.text().len() > 20);
        assert!(figure.definition.source().starts_with("ISO 25178-2"));
    }
    let unit = |wanted: Parameter| {
        let wanted = Definition::Texture(wanted);
        figures.iter().find(|figure| figure.definition == wanted).unwrap().definition.unit()
    };
    assert_eq!(unit(Parameter::Sdq), Unit::Microradians);
    assert_eq!(unit(Parameter::Sal), Unit::Micrometres);
    assert_eq!(unit(Parameter::Smrk1), Unit::Percent);
}

//! The running estimator of points with uncertainties against the weighted fit of the same points.

use crate::common::{Noise, al1815, misaligned, pose_difference, spiral};
use asphera_form::artefact::Artefact;
use asphera_form::{
    Accumulator, Aperture, Figures, Fit, FitError, FitSettings, Grid, Live, LiveError,
    LiveEstimate, LiveSettings, LiveWeights, Nominal, Parameter, PointMm, Pose, along_normal_mm,
    deviations, fit, fit_weighted,
};
use proptest::prelude::*;

const GRID: Grid =
    Grid { x_min_mm: -9.0, x_max_mm: 9.0, y_min_mm: -9.0, y_max_mm: 9.0, nx: 96, ny: 96 };
const UP: [f64; 3] = [0.0, 0.0, 1.0];

fn settings(fit: FitSettings) -> LiveSettings {
    LiveSettings::new(fit, GRID)
}

/// A lens with 200 nm of coma in places where it is known badly, and noise as large as the uncertainties say: from
/// 2 nm in the middle to 200 nm at the rim, times 0.5 to 2 from point to point.
fn lens(count: usize, seed: u64) -> (Vec<PointMm>, Vec<f64>) {
    let sample = spiral(count, 9.0);
    let error_mm = |x: f64, y: f64| 2e-4 * (x / 9.0) * (x * x + y * y) / 81.0;
    let artefact = Artefact::new(al1815(), misaligned(), &[], &sample, error_mm).unwrap();
    let mut noise = Noise::new(seed);
    let point = |&[x, y]: &[f64; 2]| {
        let u_mm = 2e-6 * 10_f64.powf(2.0 * x.hypot(y) / 9.0) * 2_f64.powf(noise.next());
        let [x, y, z] = artefact.point_mm(x, y).unwrap();
        ([x, y, z + 3_f64.sqrt() * u_mm * noise.next()], u_mm)
    };
    sample.iter().map(point).unzip()
}

/// All of an estimate that can be compared: maps have gaps.
fn told(found: Option<LiveEstimate>) -> Option<(Pose, Figures, usize, Option<LiveWeights>)> {
    found.map(|found| (found.pose, found.figures, found.count, found.weights))
}

fn over(points: &[PointMm], u_mm: &[f64], settings: LiveSettings) -> Live {
    let mut live = Live::new(al1815(), settings).unwrap();
    for (&point, &u_mm) in points.iter().zip(u_mm) {
        live.push_weighted(point, u_mm).unwrap();
    }
    live
}

/// How far an estimate lies from a fit of the same points: pose in shares of its uncertainty, RMS and PV in nm.
fn off(found: &LiveEstimate, full: &Fit, points: &[PointMm]) -> [f64; 3] {
    let all = deviations(points, &full.nominal, &full.pose);
    let figures = Figures::new(points, &all, &full.pose, &Aperture::None).unwrap();
    assert_eq!((found.count, found.method()), (full.used, full.method));
    let mut worst = 0.0_f64;
    for (found, full) in found.estimates.iter().zip(&full.estimates) {
        assert_eq!(found.parameter, full.parameter);
        let (u, of_full) = (found.u.unwrap(), full.u.unwrap());
        assert!((u / of_full - 1.0).abs() < 1e-2, "{u} {of_full}");
        worst = worst.max((found.value - full.value).abs() / of_full);
    }
    let weights = found.weights.unwrap();
    let chi_square = weights.reduced_chi_square.unwrap() / full.reduced_chi_square.unwrap();
    assert!((chi_square - 1.0).abs() < 1e-6, "{chi_square}");
    assert!((found.effective_points / full.effective_points - 1.0).abs() < 1e-9);
    let rms_nm = (found.figures.rms_nm - figures.rms_nm).abs();
    [worst, rms_nm, (found.figures.pv_nm - figures.pv_nm).abs()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// The scan at random moments: pose to a thousandth of its uncertainty, RMS to 0.001 nm, PV to 0.1 nm of some 1000.
    #[test]
    fn at_any_moment_it_is_the_weighted_fit_of_the_same_points(
        moment in 1_200..6_000_usize,
        seed in 0..1_000_u64,
        steps in 1..2_000_usize,
    ) {
        // From the middle outwards, or in no order.
        let (mut points, mut u_mm) = lens(6_000, seed);
        for index in (0..points.len()).filter(|_| seed % 3 > 0) {
            let other = (index * steps) % points.len();
            points.swap(index, other);
            u_mm.swap(index, other);
        }
        let (points, u_mm) = (&points[..moment], &u_mm[..moment]);
        let mut live = over(points, u_mm, settings(FitSettings::default()));
        let full = fit_weighted(points, Some(u_mm), &al1815(), &FitSettings::default()).unwrap();
        let found = live.estimate().unwrap();
        let [pose, rms_nm, pv_nm] = off(&found, &full, points);
        eprintln!("{moment} by {steps} ({}): pose {pose:.1e} of u, rms {rms_nm:.1e} nm, pv {pv_nm:.1e} nm", seed % 3);
        prop_assert!(pose < 1e-3 && rms_nm < 1e-3 && pv_nm < 0.1, "{pose} {rms_nm} {pv_nm}");
        // What the points would leave if they counted alike is the least any pose leaves.
        let alike = fit(points, &al1815(), &FitSettings::default()).unwrap();
        let least_nm = 1e6 * alike.residuals.rms_mm;
        prop_assert!((found.least_rms_nm() - least_nm).abs() < 0.01);
        prop_assert!(found.least_rms_nm() <= found.figures.rms_nm);
        live.settle();
        let [pose, rms_nm, pv_nm] = off(&live.estimate().unwrap(), &full, points);
        prop_assert!(pose < 1e-6 && rms_nm < 1e-6 && pv_nm < 1e-5, "{pose} {rms_nm} {pv_nm}");
    }
}

/// Without this the comparison with the weighted fit would prove little.
#[test]
fn the_weights_move_the_pose_by_more_than_its_uncertainty() {
    let (points, u_mm) = lens(5_000, 3);
    let found = over(&points, &u_mm, settings(FitSettings::default())).estimate().unwrap();
    let mut alike = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    points.iter().for_each(|&point| alike.push(point));
    let alike = alike.estimate().unwrap();
    let shift = |a: &LiveEstimate, b: &LiveEstimate, i: usize| {
        (a.estimates[i].value - b.estimates[i].value).abs() / a.estimates[i].u.unwrap()
    };
    let most = (0..5).map(|i| shift(&found, &alike, i)).fold(0.0, f64::max);
    assert!(most > 2.0, "{most}");
    assert!(alike.weights.is_none() && alike.least_rms_nm() == alike.figures.rms_nm);
    // The map and its counts know no weights: the mean of the cells by points is that of all.
    assert_eq!(found.map.counts.iter().sum::<usize>(), 5_000);
    let cells = found.mean_squares_nm2.iter().zip(&found.map.counts).filter(|(_, n)| **n > 0);
    let square: f64 = cells.map(|(square, count)| square * *count as f64).sum();
    assert!(((square / 5e3).sqrt() / found.figures.rms_nm - 1.0).abs() < 1e-2);
}

#[test]
fn uncertainties_all_alike_change_no_bit_of_the_pose() {
    let (points, _) = lens(3_000, 4);
    let mut alike = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    points.iter().for_each(|&point| alike.push(point));
    let alike = alike.estimate().unwrap();
    // A power of two scales without rounding.
    let u_mm = vec![2_f64.powi(-17); points.len()];
    let found = over(&points, &u_mm, settings(FitSettings::default())).estimate().unwrap();
    assert_eq!(found.pose, alike.pose);
    assert_eq!(found.figures, alike.figures);
    assert_eq!(found.least_rms_nm(), alike.figures.rms_nm);
    for (found, alike) in found.estimates.iter().zip(&alike.estimates) {
        assert!((found.u.unwrap() / alike.u.unwrap() - 1.0).abs() < 1e-12);
    }
}

/// A scale of all uncertainties moves nothing; that of the deviations over them goes with its square.
#[test]
fn the_scale_of_the_uncertainties_does_not_matter() {
    let (points, u_mm) = lens(3_000, 5);
    let found = over(&points, &u_mm, settings(FitSettings::default())).estimate().unwrap();
    for scale in [1e-3, 1e-80, 3.0, 1e100] {
        let scaled: Vec<f64> = u_mm.iter().map(|u_mm| scale * u_mm).collect();
        let again = over(&points, &scaled, settings(FitSettings::default())).estimate().unwrap();
        assert!(pose_difference(&again.pose, &found.pose) < 1e-13, "{scale}");
        let [a, b] = [&again, &found].map(|one| one.weights.unwrap().reduced_chi_square.unwrap());
        assert!((a * scale * scale / b - 1.0).abs() < 1e-9, "{scale}");
    }
}

/// A part measured elsewhere: the same deviations, the pose moved as the points.
#[test]
fn a_rigid_motion_moves_the_pose_alone() {
    let (points, u_mm) = lens(3_000, 6);
    let away =
        Pose { tx_mm: 800.0, ty_mm: -350.0, tz_mm: 90.0, rx_rad: 0.3, ry_rad: -0.2, rz_rad: 0.7 };
    let moved: Vec<PointMm> = points.iter().map(|&point| away.to_measured(point)).collect();
    let from = |start: Pose| settings(FitSettings { start, ..FitSettings::default() });
    let here = over(&points, &u_mm, from(Pose::default())).estimate().unwrap();
    let there = over(&moved, &u_mm, from(away)).estimate().unwrap();
    for place in [[0.0; 3], [5.0, 0.0, 1.0], [0.0, -5.0, 2.0]] {
        // A part of revolution does not feel a turn about its axis: heights alone are compared.
        let here = away.to_measured(here.pose.to_measured(place));
        let back = there.pose.to_part(here);
        assert!(
            (back[2] - place[2]).abs() < 1e-7
                && (back[0].hypot(back[1]) - place[0].hypot(place[1])).abs() < 1e-7
        );
    }
    assert!((here.figures.rms_nm - there.figures.rms_nm).abs() < 1e-3);
    assert!((here.figures.pv_nm - there.figures.pv_nm).abs() < 1e-1);
    let [a, b] = [&here, &there].map(|one| one.weights.unwrap().reduced_chi_square.unwrap());
    assert!((a / b - 1.0).abs() < 1e-4, "{a} {b}");
}

#[test]
fn parts_merge_in_any_order() {
    let (points, u_mm) = lens(6_000, 7);
    let settings = settings(FitSettings::default());
    let start = 1_500;
    let reference =
        fit_weighted(&points[..start], Some(&u_mm[..start]), &al1815(), &settings.fit).unwrap();
    let empty = Accumulator::new(reference, settings).unwrap();
    let over = |range: std::ops::Range<usize>| {
        let mut accumulator = empty.clone();
        for (&point, &u_mm) in points[range.clone()].iter().zip(&u_mm[range]) {
            accumulator.push_weighted(point, u_mm).unwrap();
        }
        accumulator
    };
    let whole = over(0..6_000).estimate().unwrap();
    let parts = [0..7, 7..900, 900..3_333, 3_333..3_334, 3_334..6_000];
    for order in [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2, 0, 4, 1, 3]] {
        let mut merged = empty.clone();
        order.iter().for_each(|&part| merged.merge(over(parts[part].clone())).unwrap());
        let merged = merged.estimate().unwrap();
        assert_eq!((merged.count, merged.excluded), (whole.count, whole.excluded));
        let pose = pose_difference(&merged.pose, &whole.pose);
        let rms_nm = (merged.figures.rms_nm - whole.figures.rms_nm).abs();
        eprintln!("{order:?}: pose off by {pose:.1e}, rms by {rms_nm:.1e} nm");
        assert!(pose < 1e-12 && rms_nm < 1e-8);
        let [a, b] = [&merged, &whole].map(|one| one.weights.unwrap());
        let ratio = |a: f64, b: f64| (a / b - 1.0).abs();
        assert!(ratio(a.reduced_chi_square.unwrap(), b.reduced_chi_square.unwrap()) < 1e-9);
        assert!(ratio(merged.effective_points, whole.effective_points) < 1e-12);
        assert_eq!((a.u_min_mm, a.u_max_mm), (b.u_min_mm, b.u_max_mm));
        for (merged, whole) in merged.map.mean_nm.iter().zip(&whole.map.mean_nm) {
            assert!((merged - whole).abs() < 1e-8 || (merged.is_nan() && whole.is_nan()));
        }
    }
    // As four points at the same place.
    let (mut by_weight, mut repeated) = (empty.clone(), empty.clone());
    for (index, &point) in points.iter().enumerate() {
        let heavy = index % 7 == 0;
        by_weight.push_weighted(point, if heavy { 5e-6 } else { 1e-5 }).unwrap();
        (0..if heavy { 4 } else { 1 }).for_each(|_| repeated.push(point));
    }
    let [by_weight, repeated] = [by_weight, repeated].map(|one| one.estimate().unwrap().pose);
    assert!(pose_difference(&by_weight, &repeated) < 1e-9);
}

#[test]
fn merged_estimators_settle_on_the_weighted_fit() {
    let (points, u_mm) = lens(5_000, 8);
    let of = |range: std::ops::Range<usize>| {
        over(&points[range.clone()], &u_mm[range], settings(FitSettings::default()))
    };
    let mut merged = of(3_000..4_000);
    merged.merge(of(0..3_000)).unwrap();
    merged.merge(of(4_000..5_000)).unwrap();
    merged.settle();
    let full = fit_weighted(&points, Some(&u_mm), &al1815(), &FitSettings::default()).unwrap();
    let [pose, rms_nm, pv_nm] = off(&merged.estimate().unwrap(), &full, &points);
    assert!(pose < 1e-6 && rms_nm < 1e-6 && pv_nm < 1e-5, "{pose} {rms_nm} {pv_nm}");
}

/// Uncertainties of heights over a lens whose rim is steep count by the slope there, as in the final fit of a part.
#[test]
fn uncertainties_along_a_direction_count_by_the_slope() {
    let (points, u_mm) = lens(5_000, 9);
    let along = LiveSettings { uncertain_along: Some(UP), ..settings(FitSettings::default()) };
    let mut live = over(&points, &u_mm, along.clone());
    let first = fit(&points, &al1815(), &along.fit).unwrap();
    let of_distances = along_normal_mm(&points, &u_mm, UP, &first);
    let full = fit_weighted(&points, Some(&of_distances), &al1815(), &along.fit).unwrap();
    let other = fit_weighted(&points, Some(&u_mm), &al1815(), &along.fit).unwrap();
    assert!(
        (full.reduced_chi_square.unwrap() / other.reduced_chi_square.unwrap() - 1.0).abs() > 0.01
    );
    let [pose, rms_nm, _] = off(&live.estimate().unwrap(), &full, &points);
    assert!(pose < 1e-2 && rms_nm < 0.01, "{pose} {rms_nm}");
    live.settle();
    let found = live.estimate().unwrap();
    let [pose, rms_nm, _] = off(&found, &full, &points);
    assert!(pose < 1e-6 && rms_nm < 1e-6, "{pose} {rms_nm}");
    let least = of_distances.iter().copied().fold(f64::INFINITY, f64::min);
    assert_eq!(found.weights.unwrap().u_min_mm, least);
    for found in [[0.0; 3], [0.0, 0.0, 1.1], [f64::NAN, 0.0, 1.0]] {
        let settings = LiveSettings { uncertain_along: Some(found), ..along.clone() };
        let error = Live::new(al1815(), settings).unwrap_err().to_string();
        assert!(error.contains("expected a direction of length 1"), "{error}");
    }
}

#[test]
fn impossible_uncertainties_are_refused_and_change_nothing() {
    let (points, u_mm) = lens(200, 10);
    let mut live = over(&points, &u_mm, settings(FitSettings::default()));
    let before = told(live.estimate());
    let reference = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    let mut accumulator = Accumulator::new(reference, settings(FitSettings::default())).unwrap();
    for bad in [0.0, -0.0, -1e-6, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE / 2.0] {
        for error in [
            live.push_weighted(points[0], bad).unwrap_err(),
            accumulator.push_weighted(points[0], bad).unwrap_err(),
        ] {
            let text = error.to_string();
            assert!(
                text.contains("expected a positive finite length; leave a point out"),
                "{text}"
            );
        }
    }
    assert_eq!((told(live.estimate()), live.taken()), (before, 200));
    assert_eq!(accumulator.estimate(), None);
}

#[test]
fn points_with_and_without_uncertainties_do_not_mix() {
    let (points, u_mm) = lens(300, 11);
    let settings = settings(FitSettings::default());
    let mut live = Live::new(al1815(), settings.clone()).unwrap();
    points[..40].iter().for_each(|&point| live.push(point));
    assert_eq!(live.push_weighted(points[40], 1e-5), Err(LiveError::Mixed { points: 40 }));
    assert_eq!(live.taken(), 40);
    let weighted = over(&points[..50], &u_mm, settings.clone());
    assert_eq!(
        live.merge(weighted.clone()),
        Err(LiveError::Different { what: "kinds of weights" })
    );
    assert!(live.estimate().is_some());
    // As there is no fit of such points, there is no estimate.
    let mut live = weighted;
    live.push(points[50]);
    let none = FitError::UncertaintyCount { points: 51, found: 50 };
    assert_eq!((live.estimate(), live.failure()), (None, Some(&none)));
    live.settle();
    assert_eq!((live.estimate(), live.failure()), (None, Some(&none)));
    assert_eq!(live.push_weighted(points[51], 1e-5), Err(LiveError::Mixed { points: 1 }));

    let reference = fit(&points, &al1815(), &settings.fit).unwrap();
    let empty = Accumulator::new(reference, settings).unwrap();
    let (mut with, mut without) = (empty.clone(), empty.clone());
    points.iter().for_each(|&point| with.push_weighted(point, 1e-5).unwrap());
    points.iter().for_each(|&point| without.push(point));
    assert_eq!(without.push_weighted(points[0], 1e-5), Err(LiveError::Mixed { points: 300 }));
    assert_eq!(with.merge(without.clone()), Err(LiveError::Different { what: "kinds of weights" }));
    assert_eq!(without.merge(with.clone()), Err(LiveError::Different { what: "kinds of weights" }));
    // An empty one has neither.
    with.merge(empty.clone()).unwrap();
    let mut from_empty = empty;
    from_empty.merge(with.clone()).unwrap();
    assert_eq!(told(from_empty.estimate()), told(with.estimate()));
    with.push(points[0]);
    assert_eq!(with.estimate(), None);
}

#[test]
fn few_points_and_lattices_have_estimates_or_none() {
    let fit = FitSettings { free: vec![Parameter::Tz, Parameter::Rx], ..FitSettings::default() };
    let mut live = Live::new(Nominal::Plane, settings(fit.clone())).unwrap();
    (0..15).for_each(|i| live.push_weighted([f64::from(i), 0.0, 0.0], 1e-5).unwrap());
    assert_eq!((live.estimate(), live.taken()), (None, 15));
    // A line along x leaves the turn about x free; one place leaves all but the height.
    live.push_weighted([15.0, 0.0, 0.0], 1e-5).unwrap();
    let found = live.estimate().unwrap();
    assert_eq!(found.indeterminate, [Parameter::Rx]);
    assert!(found.figures.pv_nm.abs() < 1e-9);
    // 1 mm known ten times as well as 0 mm, at one place: 100/101.
    let mut live = Live::new(Nominal::Plane, settings(fit)).unwrap();
    for _ in 0..40 {
        live.push_weighted([1.0, 2.0, 1.0], 1e-6).unwrap();
        live.push_weighted([1.0, 2.0, 0.0], 1e-5).unwrap();
    }
    let found = live.estimate().unwrap();
    assert!((found.pose.tz_mm - 100.0 / 101.0).abs() < 1e-12, "{:?}", found.pose);
    // Points that are not finite have no weight.
    live.push_weighted([f64::NAN; 3], 1e-9).unwrap();
    let again = live.estimate().unwrap();
    assert_eq!((again.pose, again.count, again.excluded.not_finite), (found.pose, 80, 1));
    assert_eq!(again.weights, found.weights);
}

//! The running estimator with a robust loss against the robust fit of the same points.

use crate::common::{al1815, misaligned, normals, pose_difference, raster, spiral};
use asphera_form::artefact::Artefact;
use asphera_form::form_error::FormError;
use asphera_form::{
    Accumulator, Aperture, Figures, Fit, FitSettings, Grid, Live, LiveEstimate, LiveSettings, Loss,
    Nominal, PointMm, Pose, Robust, deviations, fit, fit_weighted,
};
use proptest::prelude::*;
use rand_core::SeedableRng;
use rand_pcg::Pcg64Mcg;

const GRID: Grid =
    Grid { x_min_mm: -9.0, x_max_mm: 9.0, y_min_mm: -9.0, y_max_mm: 9.0, nx: 96, ny: 96 };

fn with(loss: Loss) -> FitSettings {
    FitSettings { loss, ..FitSettings::default() }
}

/// The part of the issue: decentred by 100 µm, some 10 µm of form error, 50 nm of noise, and 5 % of the points 1 to 100 µm
/// too high.
fn part(sample: &[[f64; 2]], form_nm: f64, seed: u64) -> Vec<PointMm> {
    let error = FormError::typical(9.0);
    let error_mm = move |x: f64, y: f64| error.height_nm(x, y) * 1e-6 * form_nm / 200.0;
    let pose = Pose { tx_mm: 0.1, ty_mm: -0.06, ..misaligned() };
    let artefact = Artefact::new(al1815(), pose, &[], sample, error_mm).unwrap();
    let mut generator = Pcg64Mcg::seed_from_u64(seed);
    let noise = normals(&mut generator, 3 * sample.len());
    let point = |(index, &[x, y]): (usize, &[f64; 2])| {
        let [x, y, z] = artefact.point_mm(x, y).unwrap();
        // One in twenty, 10^(0 to 2) µm.
        let spoilt = if noise[3 * index + 1].abs() < 0.0627 {
            1e-3 * 100_f64.powf((noise[3 * index + 2].abs() / 2.0).fract())
        } else {
            0.0
        };
        [x, y, z + 5e-5 * noise[3 * index] + spoilt]
    };
    sample.iter().enumerate().map(point).collect()
}

/// How far an estimate lies from a fit of the same points: pose in shares of its uncertainty, RMS, PV and scale in shares
/// of themselves.
fn off(found: &LiveEstimate, full: &Fit, points: &[PointMm]) -> [f64; 4] {
    let all = deviations(points, &full.nominal, &full.pose);
    let figures = Figures::new(points, &all, &full.pose, &Aperture::None).unwrap();
    assert_eq!((found.count, found.method()), (full.used, full.method));
    let mut worst = 0.0_f64;
    for (found, full) in found.estimates.iter().zip(&full.estimates) {
        assert_eq!(found.parameter, full.parameter);
        worst = worst.max((found.value - full.value).abs() / full.u.unwrap());
    }
    let share = |found: f64, full: f64| (found / full - 1.0).abs();
    let scale_mm = |robust: Robust| robust.scale_mm;
    [
        worst,
        share(found.figures.rms_nm, figures.rms_nm),
        share(found.figures.pv_nm, figures.pv_nm),
        share(found.robust.map_or(f64::NAN, scale_mm), full.robust.map_or(f64::NAN, scale_mm)),
    ]
}

fn settings(fit: FitSettings) -> LiveSettings {
    LiveSettings::new(fit, GRID)
}

/// An estimator over points, with their uncertainties if there are any.
fn over(points: &[PointMm], u_mm: Option<&[f64]>, fit: &FitSettings) -> Live {
    let mut live = Live::new(al1815(), settings(fit.clone())).unwrap();
    for (index, &point) in points.iter().enumerate() {
        match u_mm {
            Some(u_mm) => live.push_weighted(point, u_mm[index]).unwrap(),
            None => live.push(point),
        }
    }
    live
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// 200 nm of form, 50 nm of noise and outliers of up to 100 µm, at a random moment of a scan outwards, along lines or
    /// in no order: pose to half its uncertainty, RMS to 0.5 %, PV to 1 %, and after settling the fit itself.
    #[test]
    fn at_any_moment_it_is_the_robust_fit_of_the_same_points(
        moment in 1_500..4_000_usize,
        seed in 0..1_000_u64,
        order in 0..3_usize,
        tukey in any::<bool>(),
        given in any::<bool>(),
        weighted in any::<bool>(),
    ) {
        let sample = if order == 1 { raster(4_000, 9.0) } else { spiral(4_000, 9.0) };
        let mut points = part(&sample, 200.0, seed);
        if order == 2 {
            (0..points.len()).for_each(|index| points.swap(index, (index * 1_237 + 11) % sample.len()));
        }
        points.truncate(moment);
        let u_mm: Vec<f64> = (0..points.len()).map(|i| 5e-5 * 2_f64.powi((i % 5) as i32 - 2)).collect();
        let u_mm = weighted.then_some(&u_mm[..]);
        let fitting = FitSettings {
            loss: if tukey { Loss::TUKEY } else { Loss::HUBER },
            loss_scale_mm: given.then_some(6e-5),
            ..FitSettings::default()
        };
        let mut live = over(&points, u_mm, &fitting);
        let full = fit_weighted(&points, u_mm, &al1815(), &fitting).unwrap();
        let found = live.estimate().unwrap();
        let [pose, rms, pv, scale] = off(&found, &full, &points);
        eprintln!(
            "{} of {moment} in order {order}, weights {weighted}, scale given {given}: pose {pose:.1e} of u, rms {rms:.0e}, pv {pv:.0e}, scale {scale:.0e}",
            full.method
        );
        prop_assert!(pose < 0.5 && rms < 5e-3 && pv < 1e-2 && scale < 0.03, "{pose} {rms} {pv} {scale}");
        let [robust, of_full] = [found.robust.unwrap(), full.robust.unwrap()];
        prop_assert_eq!((robust.loss, robust.scale_given), (of_full.loss, of_full.scale_given));
        prop_assert!(robust.below_half.abs_diff(of_full.below_half) <= 5 + moment / 200);
        prop_assert!(robust.zero.abs_diff(of_full.zero) <= 5 + moment / 200);
        prop_assert!((found.effective_points / full.effective_points - 1.0).abs() < 0.05);
        for (found, full) in found.estimates.iter().zip(&full.estimates) {
            prop_assert!((found.u.unwrap() / full.u.unwrap() - 1.0).abs() < 0.03, "{found:?} {full:?}");
        }
        // No pose leaves less than squares do.
        let squares = fit(&points, &al1815(), &FitSettings::default()).unwrap();
        let least = found.least_rms_mm / squares.residuals.rms_mm;
        prop_assert!((0.99..=1.0).contains(&least), "{least}");
        prop_assert!(found.least_rms_nm() <= found.figures.rms_nm);
        live.settle();
        let settled = live.estimate().unwrap();
        prop_assert!(pose_difference(&settled.pose, &full.pose) < 1e-9);
        prop_assert!(off(&settled, &full, &points).iter().all(|off| *off < 1e-6));
        prop_assert_eq!(settled.robust, full.robust);
    }
}

/// Points in no order with a Tukey loss that is nearly flat along one direction at some moments. There a small error of
/// the weights moves the pose far.
#[test]
fn a_nearly_flat_loss_is_followed() {
    let sample = spiral(4_000, 9.0);
    let mut all = part(&sample, 200.0, 899);
    (0..all.len()).for_each(|index| all.swap(index, (index * 1_237 + 11) % sample.len()));
    let u_mm: Vec<f64> = (0..all.len()).map(|i| 5e-5 * 2_f64.powi((i % 5) as i32 - 2)).collect();
    for moment in [2_100, 2_161, 2_300, 2_517] {
        let (points, u_mm) = (&all[..moment], Some(&u_mm[..moment]));
        let full = fit_weighted(points, u_mm, &al1815(), &with(Loss::TUKEY)).unwrap();
        let found = over(points, u_mm, &with(Loss::TUKEY)).estimate().unwrap();
        let [pose, rms, pv, scale] = off(&found, &full, points);
        eprintln!("{moment}: pose {pose:.1e} of u, rms {rms:.0e}, pv {pv:.0e}, scale {scale:.0e}");
        assert!(pose < 0.5 && rms < 5e-3 && pv < 1e-2 && scale < 0.03);
    }
}

/// The part of the issue, decentred by 100 µm with 10 µm of form error: while it grows the pose moves by hundreds of its
/// uncertainty, for that counts the form as noise. The estimate follows the fit to about one of these, figures and all to
/// a thousandth. At every other look both are looked at anew.
#[test]
fn a_coarse_part_is_followed_while_it_grows() {
    for (name, sample) in [("spiral", spiral(5_000, 9.0)), ("raster", raster(5_000, 9.0))] {
        let points = part(&sample, 10_000.0, 5);
        for loss in [Loss::HUBER, Loss::TUKEY] {
            let mut live = Live::new(al1815(), settings(with(loss))).unwrap();
            for (index, &point) in points.iter().enumerate() {
                live.push(point);
                if ![2_700, 3_500, 4_200, points.len() - 1].contains(&index) {
                    continue;
                }
                let points = &points[..=index];
                let full = fit(points, &al1815(), &with(loss)).unwrap();
                let found = live.estimate().unwrap();
                let [pose, rms, pv, scale] = off(&found, &full, points);
                eprintln!(
                    "{name} {} of {index}: pose {pose:.1e} of u, rms {rms:.0e}, pv {pv:.0e}, scale {scale:.0e}",
                    full.method
                );
                assert!(
                    pose < 1.5 && rms < 1e-3 && pv < 2e-3 && scale < 0.05,
                    "{pose} {rms} {pv} {scale}"
                );
            }
        }
    }
}

/// What was said against weights while running: the first pose is that of a patch of which nearly half lies 20 µm too high,
/// and good points that come later lie beyond every threshold about it.
#[test]
fn a_first_patch_of_outliers_shuts_nothing_out() {
    let mut points = part(&spiral(4_000, 9.0), 200.0, 9);
    for (index, point) in points.iter_mut().enumerate() {
        if index < 300 && index % 20 < 9 {
            point[2] += 0.02;
        }
    }
    for loss in [Loss::HUBER, Loss::TUKEY] {
        for moment in [1_700, 2_900, 4_000] {
            let points = &points[..moment];
            let found = over(points, None, &with(loss)).estimate().unwrap();
            let full = fit(points, &al1815(), &with(loss)).unwrap();
            let [pose, rms, ..] = off(&found, &full, points);
            eprintln!("{loss:?} of {moment}: pose {pose:.1e} of u, rms {rms:.0e}");
            assert!(pose < 0.2 && rms < 1e-4, "{pose} {rms}");
        }
    }
}

/// Weights are those of the reference, and every estimate weighs anew: parts make the whole in any order, and the whole is
/// near the fit of all points though the reference has seen a third.
#[test]
fn parts_merge_in_any_order() {
    let points = part(&spiral(6_000, 9.0), 200.0, 7);
    let u_mm: Vec<f64> = (0..points.len()).map(|i| 3e-5 * (1 + i % 4) as f64).collect();
    for u_mm in [None, Some(&u_mm[..])] {
        let of = |to: usize| {
            fit_weighted(&points[..to], u_mm.map(|u| &u[..to]), &al1815(), &with(Loss::TUKEY))
                .unwrap()
        };
        let empty = Accumulator::new(of(2_000), settings(with(Loss::TUKEY))).unwrap();
        let over = |range: std::ops::Range<usize>| {
            let mut accumulator = empty.clone();
            for index in range {
                match u_mm {
                    Some(u_mm) => accumulator.push_weighted(points[index], u_mm[index]).unwrap(),
                    None => accumulator.push(points[index]),
                }
            }
            accumulator
        };
        let whole = over(0..6_000).estimate().unwrap();
        let full = of(6_000);
        let [pose, rms, pv, scale] = off(&whole, &full, &points);
        eprintln!("whole: pose {pose:.1e} of u, rms {rms:.0e}, pv {pv:.0e}, scale {scale:.0e}");
        assert!(pose < 0.3 && rms < 5e-3 && pv < 1e-2 && scale < 0.03);
        let parts = [0..7, 7..900, 900..3_333, 3_333..3_334, 3_334..6_000];
        for order in [[0, 1, 2, 3, 4], [4, 3, 2, 1, 0], [2, 0, 4, 1, 3]] {
            let mut merged = empty.clone();
            order.iter().for_each(|&part| merged.merge(over(parts[part].clone())).unwrap());
            let merged = merged.estimate().unwrap();
            assert_eq!((merged.count, merged.excluded), (whole.count, whole.excluded));
            let off = pose_difference(&merged.pose, &whole.pose);
            let [a, b] = [&merged, &whole].map(|one| one.robust.unwrap());
            eprintln!("{order:?}: pose off by {off:.1e}");
            assert!(off < 1e-9 && (a.scale_mm / b.scale_mm - 1.0).abs() < 1e-6);
            assert_eq!((a.below_half, a.zero), (b.below_half, b.zero));
        }
    }
    let by_squares = fit(&points, &al1815(), &FitSettings::default()).unwrap();
    let refused = Accumulator::new(by_squares, settings(with(Loss::TUKEY))).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the reference was found by the criterion \"orthogonal least squares\", expected \"orthogonal Tukey M-estimate\""
    );
}

#[test]
fn merged_estimators_settle_on_the_fit_of_all_points() {
    let points = part(&spiral(4_000, 9.0), 200.0, 8);
    let mut merged = over(&points[2_000..3_000], None, &with(Loss::TUKEY));
    merged.merge(over(&points[..2_000], None, &with(Loss::TUKEY))).unwrap();
    merged.merge(over(&points[3_000..], None, &with(Loss::TUKEY))).unwrap();
    let full = fit(&points, &al1815(), &with(Loss::TUKEY)).unwrap();
    assert!(off(&merged.estimate().unwrap(), &full, &points)[0] < 0.2);
    merged.settle();
    assert!(pose_difference(&merged.estimate().unwrap().pose, &full.pose) < 1e-9);
}

/// A scale of everything by a power of two changes no more than rounding, and asking on the way changes nothing.
#[test]
fn estimates_scale_and_do_not_hang_on_when_they_are_asked_for() {
    let plane = |factor: f64| {
        let noise = normals(&mut Pcg64Mcg::seed_from_u64(4), 3_000);
        let mut live = Live::new(
            Nominal::Plane,
            LiveSettings::new(
                with(Loss::TUKEY),
                Grid {
                    x_min_mm: 0.0,
                    x_max_mm: 50.0 * factor,
                    y_min_mm: 0.0,
                    y_max_mm: 60.0 * factor,
                    nx: 20,
                    ny: 20,
                },
            ),
        )
        .unwrap();
        for (index, noise) in noise.iter().enumerate() {
            let spoilt = if index % 9 == 0 { 0.01 } else { 1e-4 * noise };
            let [x, y] = [(index % 50) as f64, (index / 50) as f64];
            live.push([x, y, 1.0 + 1e-3 * x + spoilt].map(|mm| mm * factor));
            if factor == 1.0 && index % 100 == 0 {
                live.estimate();
            }
        }
        live.estimate().unwrap()
    };
    let (one, four) = (plane(1.0), plane(4.0));
    let scale_mm = |found: &LiveEstimate| found.robust.unwrap().scale_mm;
    assert!((scale_mm(&one) * 4.0 / scale_mm(&four) - 1.0).abs() < 1e-9);
    assert!((one.pose.tz_mm * 4.0 - four.pose.tz_mm).abs() < 1e-12);
    assert!((one.pose.ry_rad - four.pose.ry_rad).abs() < 1e-13);
    // A ninth lies 10 µm too high and is left out.
    assert_eq!((one.robust.unwrap().zero, one.count), (334, 3_000));
    assert!((one.pose.tz_mm - 1.0).abs() < 2e-5, "{:?}", one.pose);
}

#[test]
fn degenerate_points_have_estimates_or_none() {
    let live = |points: &[PointMm]| {
        let mut live = Live::new(Nominal::Plane, settings(with(Loss::TUKEY))).unwrap();
        points.iter().for_each(|&point| live.push(point));
        live
    };
    assert_eq!(live(&[]).estimate(), None);
    assert_eq!(live(&[[f64::NAN; 3]; 40]).estimate(), None);
    let found = live(&[[1.0, 2.0, 3.0]; 200]).estimate().unwrap();
    assert!((found.pose.tz_mm - 3.0).abs() < 1e-12 && found.figures.pv_nm < 1e-6);
    // Exactly plane, and every seventh point 1 mm higher.
    let lattice = |i: usize| [(i % 9) as f64, (i / 9 % 9) as f64];
    let steps: Vec<PointMm> = (0..500)
        .map(|i| {
            let [x, y] = lattice(i);
            [x, y, if i % 7 == 0 { 1.0 } else { 0.0 }]
        })
        .collect();
    let found = live(&steps).estimate().unwrap();
    assert!(found.pose.tz_mm.abs() < 1e-6, "{:?}", found.pose);
    assert!((found.figures.pv_nm - 1e6).abs() < 10.0, "{:?}", found.figures);
    // Two planes of as many points: nobody knows which is meant, but the answer is one of finite numbers.
    let planes: Vec<PointMm> = (0..400)
        .map(|i| {
            let [x, y] = lattice(i);
            [x, y, (i % 2) as f64]
        })
        .collect();
    let found = live(&planes).estimate().unwrap();
    assert!((-1e-6..=1.0 + 1e-6).contains(&found.pose.tz_mm), "{:?}", found.pose);
    assert!(found.figures.rms_nm.is_finite() && found.count == 400);
    // What is not finite is told, and counts nowhere.
    let mut spoilt = steps;
    spoilt.insert(77, [f64::NAN, 0.0, 0.0]);
    let found = live(&spoilt).estimate().unwrap();
    assert_eq!((found.count, found.excluded.not_finite), (500, 1));
}

//! Uncertainties of points, and losses that let points deviate.

use asphera_form::{FitError, FitSettings, Loss, Nominal, Parameter, PointMm, fit, fit_weighted};

use crate::common::{al1815, misaligned, pose_difference};
use crate::shapes::saddle;
use crate::spoilt::{spoilt, with};

#[test]
fn breakdown_under_one_sided_outliers() {
    for nominal in [al1815(), saddle(), Nominal::Plane] {
        for share in [0.1, 0.2, 0.3] {
            let (points, outliers) = spoilt(&nominal, share, 17);
            let off = |loss: Loss| {
                let fitted = fit(&points, &nominal, &with(loss)).unwrap();
                assert!(fitted.termination.is_converged(), "{:?}", fitted.termination);
                (fitted.pose.tz_mm - misaligned().tz_mm, fitted)
            };
            let (squares_mm, _) = off(Loss::Squares);
            let (huber_mm, huber) = off(Loss::HUBER);
            let (tukey_mm, tukey) = off(Loss::TUKEY);
            let robust = tukey.robust.unwrap();
            eprintln!(
                "{} with {:.0} %: tz off by {squares_mm:.1e} mm by squares, {huber_mm:.1e} by Huber, {tukey_mm:.1e} by Tukey; scale {:.2e} mm, {} rounds, {} of {outliers} left out",
                nominal.kind(),
                100.0 * share,
                robust.scale_mm,
                robust.rounds,
                robust.zero
            );
            // Squares break down, Huber bends by about a scale, Tukey is as if there were none.
            assert!(squares_mm.abs() > 2e-2);
            assert!(huber_mm.abs() < 2e-5, "{huber_mm:e}");
            assert!(tukey_mm.abs() < 2e-6, "{tukey_mm:e}");
            assert!((0.9..2.2).contains(&(robust.scale_mm / 1e-5)), "{:e}", robust.scale_mm);
            assert!(robust.zero <= outliers + 4 && robust.zero + 4 >= outliers * 99 / 100);
            assert!(robust.below_half >= robust.zero);
            let kept = (points.len() - outliers) as f64;
            assert!((0.7..1.01).contains(&(tukey.effective_points / kept)));
            assert!(
                huber.robust.unwrap().zero == 0
                    && huber.robust.unwrap().below_half >= outliers * 95 / 100
            );
            // σ goes with the covariance: the standard deviation of the mean is σ/√n.
            assert!((0.9..1.7).contains(&(tukey.sigma_mm / 1e-5)), "{:e}", tukey.sigma_mm);
        }
    }
}

#[test]
fn without_outliers_all_losses_agree_within_the_uncertainty() {
    let (points, _) = spoilt(&al1815(), 0.0, 3);
    let squares = fit(&points, &al1815(), &with(Loss::Squares)).unwrap();
    for loss in [Loss::HUBER, Loss::TUKEY, Loss::Huber { k: 1e6 }, Loss::Tukey { k: 1e6 }] {
        let fitted = fit(&points, &al1815(), &with(loss)).unwrap();
        assert!(fitted.termination.is_converged());
        let is_plain = matches!(loss, Loss::Huber { k } | Loss::Tukey { k } if k == 1e6);
        for (robust, plain) in fitted.estimates.iter().zip(&squares.estimates) {
            let (u, most) = (plain.u.unwrap(), if is_plain { 1e-3 } else { 1.0 });
            assert!((robust.value - plain.value).abs() < most * u, "{robust:?} {plain:?}");
            let ratio = robust.u.unwrap() / u;
            assert!((0.97..1.1).contains(&ratio), "{loss:?}: {ratio}");
        }
        assert!((fitted.robust.unwrap().scale_mm / 1e-5 - 1.05).abs() < 0.05);
    }
}

/// The same weights as points repeated.
#[test]
fn a_point_of_half_the_uncertainty_counts_as_four() {
    let (points, _) = spoilt(&al1815(), 0.0, 8);
    let precise = |index: usize| index.is_multiple_of(7);
    let repeated: Vec<PointMm> = (0..points.len())
        .flat_map(|i| std::iter::repeat_n(points[i], if precise(i) { 4 } else { 1 }))
        .collect();
    let u_mm: Vec<f64> = (0..points.len()).map(|i| if precise(i) { 5e-6 } else { 1e-5 }).collect();
    let weighted = fit_weighted(&points, Some(&u_mm), &al1815(), &FitSettings::default()).unwrap();
    let plain = fit(&repeated, &al1815(), &FitSettings::default()).unwrap();
    assert!(pose_difference(&weighted.pose, &plain.pose) < 1e-12);
    assert_eq!(weighted.method, "weighted orthogonal least squares");
    let (sum, square) = u_mm.iter().fold((0.0, 0.0), |(sum, square), u| {
        let weight = (1e-5 / u).powi(2);
        (sum + weight, square + weight * weight)
    });
    assert!((weighted.effective_points / (sum * sum / square) - 1.0).abs() < 1e-12);
    // One point in seven has twice the deviation its uncertainty allows: (6 + 4)/7.
    let chi_square = weighted.reduced_chi_square.unwrap();
    assert!((chi_square / (10.0 / 7.0) - 1.0).abs() < 0.1, "{chi_square}");
    let doubled: Vec<f64> = u_mm.iter().map(|u| 2.0 * u).collect();
    let again = fit_weighted(&points, Some(&doubled), &al1815(), &FitSettings::default()).unwrap();
    assert!(pose_difference(&again.pose, &weighted.pose) < 1e-13);
    // The uncertainty of a point of mean weight doubles with them; so does not what is found.
    assert!((again.sigma_mm / weighted.sigma_mm - 1.0).abs() < 1e-9);
    assert!((again.reduced_chi_square.unwrap() / chi_square - 0.25).abs() < 1e-9);
}

#[test]
fn equal_uncertainties_change_nothing() {
    let (points, _) = spoilt(&al1815(), 0.0, 9);
    let u_mm = vec![1e-5; points.len()];
    let settings = FitSettings::default();
    let weighted = fit_weighted(&points, Some(&u_mm), &al1815(), &settings).unwrap();
    let plain = fit(&points, &al1815(), &settings).unwrap();
    assert_eq!((weighted.pose, weighted.sigma_mm), (plain.pose, plain.sigma_mm));
    assert!((weighted.reduced_chi_square.unwrap() - 1.0).abs() < 0.1);
    assert_eq!((plain.reduced_chi_square, plain.effective_points), (None, 4_000.0));
}

#[test]
fn impossible_uncertainties_and_losses_are_named() {
    let points = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]];
    let settings = FitSettings::default();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let u_mm = [1e-6, 1e-6, bad, 1e-6];
        let error = fit_weighted(&points, Some(&u_mm), &Nominal::Plane, &settings).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("the uncertainty of point 2 is ") && text.contains("leave"),
            "{text}"
        );
    }
    assert_eq!(
        fit_weighted(&points, Some(&[1.0]), &Nominal::Plane, &settings),
        Err(FitError::UncertaintyCount { points: 4, found: 1 })
    );
    for k in [0.0, -1.0, f64::INFINITY] {
        for loss in [Loss::Huber { k }, Loss::Tukey { k }] {
            assert_eq!(
                fit(&points, &Nominal::Plane, &with(loss)),
                Err(FitError::Loss { found: k })
            );
        }
    }
}

/// More than half of the points exactly on a plane: the scale is no more than rounding.
#[test]
fn an_exact_part_with_dust_is_found_exactly() {
    let mut points: Vec<PointMm> =
        (0..100).map(|i| [f64::from(i % 10), f64::from(i / 10), 2.0]).collect();
    points.iter_mut().step_by(9).for_each(|point| point[2] += 0.5);
    for loss in [Loss::HUBER, Loss::TUKEY] {
        let fitted = fit(&points, &Nominal::Plane, &with(loss)).unwrap();
        assert!((fitted.pose.tz_mm - 2.0).abs() < 1e-11, "{loss:?} {:?}", fitted.pose);
        assert_eq!(fitted.indeterminate, [Parameter::Tx, Parameter::Ty]);
    }
}

#[test]
fn the_same_bits_with_any_number_of_threads() {
    let (points, _) = spoilt(&saddle(), 0.2, 1);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&points, &saddle(), &with(Loss::TUKEY)).unwrap())
    };
    assert_eq!(on(1), on(3));
}

//! References that are made on the way: beyond 131,072 points none waits for all others.

use crate::common::{al1815, pose_difference, raster, spiral};
use crate::live::{compare, lens, settings};
use asphera_form::{FitSettings, Live, LiveEstimate, Parameter, PointMm};

fn estimate(live: &Live) -> LiveEstimate {
    live.estimate().unwrap()
}

/// The reference is made at once of 131,072 points. That of 262,144 is begun there, and has all points when half as many
/// more have come. The estimates are as near to the full fit as ever, while the lens grows and after it.
#[test]
fn the_next_reference_is_made_while_points_arrive() {
    let asked = [
        (262_143, 131_072),
        (262_144, 131_072),
        (300_000, 131_072),
        (393_215, 131_072),
        (393_216, 262_144),
        (400_000, 262_144),
    ];
    for (name, sample) in [("outwards", spiral(400_000, 9.0)), ("raster", raster(400_000, 9.0))] {
        let points = lens(&sample);
        let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
        for (index, &point) in points.iter().enumerate() {
            live.push(point);
            if let Some((_, reference)) = asked.iter().find(|(count, _)| *count == index + 1) {
                let found = estimate(&live);
                compare(&points[..=index], &found, name, 1e-8, 0.01, 1.0);
                assert_eq!(found.reference_count, *reference, "{name} at {}", index + 1);
            }
        }
        live.settle();
        compare(&points, &estimate(&live), name, 1e-11, 1e-6, 1e-5);
    }
}

/// How the points were handed over changes nothing but rounding: one by one, or in two scans that are merged before, at or
/// after the number at which a reference is due.
#[test]
fn merging_makes_the_same_reference() {
    let points = lens(&raster(400_000, 9.0));
    let over = |points: &[PointMm]| {
        let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
        points.iter().for_each(|&point| live.push(point));
        live
    };
    let whole = estimate(&over(&points));
    for cut in [250_000, 262_143, 262_144, 300_000] {
        let mut first = over(&points[..cut]);
        first.merge(over(&points[cut..])).unwrap();
        let merged = estimate(&first);
        assert_eq!((merged.count, merged.excluded), (whole.count, whole.excluded), "{cut}");
        let apart = pose_difference(&merged.pose, &whole.pose);
        eprintln!("merged at {cut}: reference at {}, {apart:e}", merged.reference_count);
        assert!(apart < 1e-8, "{cut}: {apart:e}");
        assert!((merged.figures.rms_nm - whole.figures.rms_nm).abs() < 0.01);
    }
}

/// Uncertainties of points count at the new reference as they did at the one before.
#[test]
fn points_keep_their_weights() {
    let points = lens(&spiral(400_000, 9.0));
    let u_mm = |index: usize| if index.is_multiple_of(3) { 2e-6 } else { 1e-5 };
    let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    for (index, &point) in points.iter().enumerate() {
        live.push_weighted(point, u_mm(index)).unwrap();
    }
    let running = estimate(&live);
    assert_eq!((running.count, running.reference_count), (400_000, 262_144));
    live.settle();
    let settled = estimate(&live);
    assert!(pose_difference(&running.pose, &settled.pose) < 1e-8);
    let (on_the_way, at_the_end) = (running.weights.unwrap(), settled.weights.unwrap());
    assert_eq!(
        (on_the_way.u_min_mm, on_the_way.u_max_mm),
        (at_the_end.u_min_mm, at_the_end.u_max_mm)
    );
    let [one, other] = [on_the_way, at_the_end].map(|one| one.reduced_chi_square.unwrap());
    assert!((one / other - 1.0).abs() < 1e-6, "{one} {other}");
}

/// A parameter that the first half of the points does not feel is found by a full fit at the next reference.
#[test]
fn what_the_first_points_did_not_feel_is_fitted_later() {
    // On a patch in the middle tilts and shifts are alike.
    let points = lens(&[spiral(150_000, 0.3), raster(400_000, 9.0)].concat());
    let mut live = Live::new(al1815(), settings(FitSettings::default())).unwrap();
    for (index, &point) in points.iter().enumerate() {
        live.push(point);
        if index == 140_000 {
            let found = estimate(&live);
            assert!(found.indeterminate.contains(&Parameter::Rx), "{:?}", found.indeterminate);
            assert_eq!(found.reference_count, 131_072);
        }
        if index == 262_143 {
            let found = estimate(&live);
            assert_eq!((found.reference_count, found.is_complete()), (262_144, true));
            assert_eq!(found.indeterminate, []);
        }
    }
    // From there on no point waits.
    let found = estimate(&live);
    assert_eq!((found.reference_count, found.is_complete()), (262_144, true));
}

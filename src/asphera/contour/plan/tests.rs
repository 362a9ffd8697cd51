//! Contours of sessions: what is said without one, and what limits do to a verdict.

use asphera_contour::{Method, Parameters};
use asphera_geometry::Numbers;

use super::*;
use crate::contour::{Nominal, plane_of};

fn plan(limits: ContourLimits, nominal: Option<&str>) -> ContourPlan {
    let nominal = nominal.map(|text| {
        let read = |_: &std::path::Path| Ok(text.as_bytes().to_vec());
        Nominal::of_drawing(std::path::Path::new("nominal.svg"), read).unwrap().unwrap()
    });
    let settings = ContourSettings {
        method: Method::HnnCrust,
        parameters: Parameters::new(),
        tolerance_mm: 0.0,
        gap_mm: None,
        is_airfoil: false,
        nominal,
        hints: Vec::new(),
    };
    ContourPlan { settings, slab: None, limits }
}

/// A circle of 5 mm whose radius goes up and down by a micrometre.
fn circle() -> Vec<PlaceMm> {
    let place = |index: u32| {
        let (sin, cos) = f64::from(index).to_radians().sin_cos();
        let radius = 5.0 + if index.is_multiple_of(2) { 0.001 } else { -0.001 };
        [radius * cos, radius * sin]
    };
    (0..360).map(place).collect()
}

fn verdict(status: Status) -> Verdict {
    Verdict { status, ..Verdict::default() }
}

/// The verdict once a contour was held against limits.
fn judged(plan: &ContourPlan, places: &[PlaceMm], status: Status) -> Verdict {
    let mut verdict = verdict(status);
    plan.limits.judge(&plan.contour(places), &mut verdict);
    verdict
}

#[test]
fn too_few_points_leave_the_contour_unknown_with_the_reason() {
    let plan = plan(ContourLimits::default(), None);
    for (places, distinct, why) in [
        (vec![], 0, "expected three different places or more, found 0 in 0 points"),
        (vec![[1.0, 2.0]; 4], 1, "expected three different places or more, found 1 in 4 points"),
        (vec![[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]], 3, "found all 3 on one straight line"),
    ] {
        let contour = plan.contour(&places);
        assert_eq!((contour.input.points, contour.input.distinct), (places.len(), distinct));
        assert!(contour.chains.is_empty() && contour.input.spacing_median_mm.is_none());
        assert!(contour.unknown[0].starts_with("contour: "), "{:?}", contour.unknown);
        assert!(contour.unknown[0].contains(why), "{:?}", contour.unknown);
    }
}

#[test]
fn limits_of_the_contour_decide_the_verdict() {
    let roundness_mm = |mm| ContourLimits { roundness_mm: Some(mm), ..ContourLimits::default() };
    let wide = plan(roundness_mm(0.0021), None);
    let held = judged(&wide, &circle(), Status::None);
    assert_eq!((held.status, held.checks.len()), (Status::Pass, 1));
    assert_eq!(held.checks[0].figure.name, "contour_roundness_mm");
    assert!((held.checks[0].value - 0.002).abs() < 1e-9 && held.checks[0].ok);
    assert_eq!(judged(&wide, &circle(), Status::Undecided).status, Status::Undecided);
    assert_eq!(judged(&wide, &circle(), Status::Fail).status, Status::Fail);
    let narrow = plan(roundness_mm(0.0019), None);
    let broken = judged(&narrow, &circle(), Status::Pass);
    assert_eq!(broken.status, Status::Fail);
    assert!(broken.checks[0].is_broken());
    // A square is no circle, and two points are no curve.
    let side = (0..9).map(f64::from);
    let square: Vec<PlaceMm> =
        side.flat_map(|at| [[at, 0.0], [9.0, at], [9.0 - at, 9.0], [0.0, 9.0 - at]]).collect();
    for (places, why) in [(&square[..], "no single closed curve"), (&square[..2], "found 2 in 2")] {
        let unknown = judged(&wide, places, Status::Pass);
        assert_eq!((unknown.status, unknown.checks.len()), (Status::Undecided, 0));
        assert!(unknown.reasons[0].contains(why), "{:?}", unknown.reasons);
        assert_eq!(judged(&wide, places, Status::None).status, Status::Undecided);
        assert_eq!(judged(&wide, places, Status::Fail).status, Status::Fail);
    }
    let limits = ContourLimits { deviation_mm: Some(0.1), ..ContourLimits::default() };
    let inside =
        judged(&plan(limits, Some("<svg><circle r='5.05'/></svg>")), &circle(), Status::None);
    assert_eq!(inside.status, Status::Pass);
    assert!((inside.checks[0].value - 0.051).abs() < 1e-6, "{}", inside.checks[0].value);
    let outside =
        judged(&plan(limits, Some("<svg><circle r='5.2'/></svg>")), &circle(), Status::None);
    assert_eq!(outside.status, Status::Fail);
}

#[test]
fn a_slab_takes_the_points_near_its_plane_only() {
    let mut plan = plan(ContourLimits::default(), None);
    assert_eq!(plan.place([1.0, 2.0, 9.0]), Some([1.0, 2.0]));
    let plane = plane_of([0.0, 0.0, 2.0, 10.0]).unwrap();
    plan.slab = Some(Slab { plane, within_mm: 0.5 });
    assert_eq!(plan.place([1.0, 2.0, 5.4]), Some([1.0, 2.0]));
    assert_eq!(plan.place([1.0, 2.0, 5.6]), None);
}

#[test]
fn a_flat_band_is_no_piece_of_a_large_circle_and_an_arc_is() {
    let limits = ContourLimits { roundness_mm: Some(1.0), ..ContourLimits::default() };
    let plan = plan(limits, None);
    // 60 mm of a circle of 500 mm radius, and the same 1 mm further in.
    let arc = |radius_mm: f64| {
        (0..240).map(move |index| {
            let (sin, cos) = (5e-4 * f64::from(index - 120)).sin_cos();
            [radius_mm * sin, radius_mm * cos]
        })
    };
    let ends = [[-29.94, 497.6], [-29.94, 497.9], [29.94, 497.6], [29.94, 497.9]];
    let band: Vec<PlaceMm> = arc(500.0).chain(arc(499.0)).chain(ends).collect();
    assert!(plan.contour(&band).circle.is_none());
    let line: Vec<PlaceMm> = arc(500.0).collect();
    let contour = plan.contour(&line);
    assert!((contour.circle.unwrap().diameter_mm - 1000.0).abs() < 1e-3);
    // An open line has no roundness for a limit.
    assert_eq!(judged(&plan, &line, Status::Pass).status, Status::Undecided);
}

/// A circle of 5 mm with three lobes, 8 µm high together, and 1 µm of noise.
fn lobed(draw: u32) -> Vec<PlaceMm> {
    let noise = Numbers::new(18, draw, 0);
    let place = |index: u32| {
        let angle = std::f64::consts::TAU * f64::from(index) / 500.0;
        let form_mm = 0.004 * (3.0 * angle).cos();
        let radius_mm = 5.0 + form_mm + 0.001 * noise.normal(index as usize);
        [radius_mm * angle.cos(), radius_mm * angle.sin()]
    };
    (0..500).map(place).collect()
}

#[test]
fn a_guard_band_seldom_proves_what_is_not_so() {
    let drawn: Vec<ContourReport> = {
        let plan = plan(ContourLimits::default(), Some("<svg><circle r='5'/></svg>"));
        (0..100).map(|draw| plan.contour(&lobed(draw))).collect()
    };
    let guard = Some(Guard::Probability(0.95));
    let count = |limits: ContourLimits, status: Status| {
        let statuses = drawn.iter().map(|contour| {
            let mut verdict = verdict(Status::None);
            limits.judge(contour, &mut verdict);
            verdict.status
        });
        statuses.filter(|found| *found == status).count()
    };
    let roundness = |mm| ContourLimits { roundness_mm: Some(mm), guard, ..Default::default() };
    // True is 8 µm, less a little, for no point lies on a lobe.
    assert!(count(roundness(0.0079), Status::Pass) <= 5);
    assert!(count(roundness(0.0081), Status::Fail) <= 5);
    for (limits, status) in [
        (roundness(0.02), Status::Pass),
        (roundness(0.01), Status::Undecided),
        (roundness(0.002), Status::Fail),
    ] {
        assert_eq!(count(limits, status), 100, "{limits:?}");
    }
    // True is 4 µm, on every third of the circle.
    let deviation = |mm| ContourLimits { deviation_mm: Some(mm), guard, ..Default::default() };
    assert!(count(deviation(0.0039), Status::Pass) <= 5);
    assert!(count(deviation(0.0041), Status::Fail) <= 5);
    for (limits, status) in [
        (deviation(0.012), Status::Pass),
        (deviation(0.005), Status::Undecided),
        (deviation(0.0001), Status::Fail),
    ] {
        assert_eq!(count(limits, status), 100, "{limits:?}");
    }
    // Check and reason name the guard band; without noise that is known there is none.
    let mut guarded = verdict(Status::None);
    deviation(0.005).judge(&drawn[0], &mut guarded);
    let check = &guarded.checks[0];
    let band = check.guard_band.unwrap() / check.u.unwrap();
    assert!((band - 1.645).abs() < 0.001 && (check.u.unwrap() - 0.001).abs() < 0.0002, "{check:?}");
    assert!(check.rule.as_ref().unwrap().contains("95 %") && !check.is_broken());
    let why = "nearer to its limit than its guard band";
    assert!(guarded.reasons[0].contains(why), "{guarded:?}");
    let mut bare = drawn[0].clone();
    bare.deviation.as_mut().unwrap().u_mm = None;
    let mut unknown = verdict(Status::None);
    deviation(0.1).judge(&bare, &mut unknown);
    assert_eq!(unknown.status, Status::Undecided);
    assert!(unknown.reasons[0].contains("needs an uncertainty"), "{unknown:?}");
}

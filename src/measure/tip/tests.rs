//! Centres of a ball over parts of known form.

use asphera_form::Pose;
use asphera_report::{Report, Status};
use proptest::prelude::*;

use super::*;
use crate::nominal::parse;
use crate::{Measurement, Pipeline};

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = -20\n[aperture]\nshape = \"circle\"\nradius_mm = 8\n";
const BALL_MM: f64 = 0.5;

fn tip(radius_mm: f64) -> Tip {
    Tip::new(radius_mm, 0.0, TipReads::Centre).unwrap()
}

/// Places of the part frame, 0.5 mm apart.
fn raster(half: i32) -> impl Iterator<Item = [f64; 2]> {
    (-half..=half)
        .flat_map(move |i| (-half..=half).map(move |j| [i, j].map(|k| 0.5 * f64::from(k))))
}

/// Centres of a ball that touches a graph over the places, in a pose; the gradient by central differences.
fn centres(
    places: impl Iterator<Item = [f64; 2]>,
    pose: &Pose,
    ball_mm: f64,
    height_mm: impl Fn(f64, f64) -> f64,
) -> Vec<PointMm> {
    places
        .map(|[x, y]| {
            let step = 1e-4;
            let p = (height_mm(x + step, y) - height_mm(x - step, y)) / (2.0 * step);
            let q = (height_mm(x, y + step) - height_mm(x, y - step)) / (2.0 * step);
            let stretch = (1.0 + p * p + q * q).sqrt();
            let place = [x, y, height_mm(x, y)];
            pose.to_measured(plus(place, ball_mm / stretch, [-p, -q, 1.0]))
        })
        .collect()
}

fn measured(nominal: &str, tip: Option<Tip>, points: &[PointMm]) -> Measurement {
    let mut pipeline = Pipeline::new(parse("part.toml", nominal).unwrap()).with_tip(tip);
    pipeline.take_positions(points.iter().copied());
    pipeline.finish()
}

fn pv_nm(report: &Report) -> f64 {
    report.form.as_ref().unwrap().deviation.pv_nm
}

/// Sphere with a wave of 200 nm.
fn wavy(x: f64, y: f64) -> f64 {
    (400.0 - x * x - y * y).sqrt() - 20.0 + 1e-4 * (0.8 * x).sin() * (0.6 * y).cos()
}

fn misaligned() -> Pose {
    Pose { tx_mm: 0.3, ty_mm: -0.2, tz_mm: 5.0, rx_rad: 0.004, ry_rad: -0.003, rz_rad: 0.0 }
}

/// The form error comes back to below a nanometre where it is lost in micrometres without compensation.
#[test]
fn the_form_error_is_that_of_the_surface() {
    let pose = misaligned();
    let surface = centres(raster(18), &pose, 0.0, wavy);
    let truth = measured(SPHERE, None, &surface);
    let balls = centres(raster(18), &pose, BALL_MM, wavy);
    let found = measured(SPHERE, Some(tip(BALL_MM)), &balls);
    let lowest: Vec<PointMm> = balls.iter().map(|&[x, y, z]| [x, y, z - BALL_MM]).collect();
    let without = measured(SPHERE, None, &lowest);
    let [truth, with, without] = [&truth, &found, &without].map(|of| pv_nm(&of.report));
    assert!((with - truth).abs() < 0.1, "{with} for {truth}");
    assert!(without > truth + 5_000.0, "{without}");
    let tip = found.report.points.tip.unwrap();
    assert!(tip.passes <= 4 && tip.last_move_nm < 1e-3, "{tip:?}");
    assert!(tip.uncompensated.is_none() && tip.hollow_share.is_none());
    assert!(tip.largest_height_nm > 4e4 && tip.neglected_nm.unwrap() < 0.01, "{tip:?}");
}

/// A radius of 0 leaves the report bit for bit, and a tiny one leaves its figures.
#[test]
fn without_a_radius_nothing_changes() {
    let points = centres(raster(12), &misaligned(), 0.0, wavy);
    let plain = measured(SPHERE, None, &points);
    assert_eq!(measured(SPHERE, Some(tip(0.0)), &points).report, plain.report);
    let tiny = measured(SPHERE, Some(tip(1e-12)), &points).report;
    assert!((pv_nm(&tiny) - pv_nm(&plain.report)).abs() < 1e-5);
    assert_eq!(tiny.points.used, plain.report.points.used);
}

/// A profile through the crest, and one beside it, stay profiles.
#[test]
fn profiles_stay_on_their_line() {
    for y in [0.0, 0.75] {
        let line = || (-100..=100).map(|i| [0.07 * f64::from(i), y]);
        let wave = |x: f64, y: f64| (400.0 - x * x - y * y).sqrt() - 20.0 + 1e-4 * (0.8 * x).sin();
        let height = |x: f64| wave(x, y);
        // Centres in the plane of the line are those of balls that touch beside it.
        let balls: Vec<PointMm> = line()
            .map(|[x, y]| {
                let (r, error) = (20.0 + BALL_MM, 1e-4 * (0.8 * x).sin());
                [x, y, (r * r - x * x - y * y).sqrt() - 20.0 + error]
            })
            .collect();
        let found = measured(SPHERE, Some(tip(BALL_MM)), &balls).report;
        assert!(found.profile.is_some(), "y {y}");
        let surface: Vec<PointMm> = line().map(|[x, y]| [x, y, height(x)]).collect();
        let truth = pv_nm(&measured(SPHERE, None, &surface).report);
        // Errors lie along z here: along the normal they are smaller by up to a twentieth.
        assert!((pv_nm(&found) - truth).abs() < 0.03 * truth, "{} {truth}", pv_nm(&found));
    }
}

/// The surface of unknown design is that of the contacts: a bowl seen by a ball is not a narrower bowl.
#[test]
fn an_unknown_surface_is_compensated_by_its_own_normals() {
    let unknown = "[surface]\nkind = \"unknown\"\nbase = \"sphere\"\n";
    let bowl = |x: f64, y: f64| 30.0 - (900.0 - x * x - y * y).sqrt();
    let balls = centres(raster(16), &Pose::default(), BALL_MM, bowl);
    let found = measured(unknown, Some(tip(BALL_MM)), &balls);
    let tip = found.report.points.tip.as_ref().unwrap();
    assert!(tip.uncompensated.is_none(), "{tip:?}");
    assert!((tip.hollow_share.unwrap() - BALL_MM / 30.0).abs() < 1e-4, "{tip:?}");
    let off = |&[x, y, z]: &PointMm| (z - bowl(x, y)).abs();
    let worst = found.points_mm.iter().map(off).fold(0.0, f64::max);
    assert!(worst < 1e-7 && found.points_mm.len() == balls.len(), "{worst}");
}

/// The ball does not fit into the middle of a bowl: such points are left out, counted and named.
#[test]
fn a_ball_that_does_not_fit_is_no_pass() {
    let nominal = "[surface]\nkind = \"sphere\"\nradius_mm = 2\n[aperture]\nshape = \"circle\"\nradius_mm = 1\n[fit]\nfree = [\"tz\"]\n\
                   [tolerance]\npv_nm = 1e9\n";
    let points: Vec<PointMm> = raster(2).map(|[x, y]| [x, y, 2.5]).collect();
    let report = measured(nominal, Some(tip(2.5)), &points).report;
    assert!(report.verdict.status != Status::Pass, "{:?}", report.verdict);
    let report = report.points;
    let left_out = report.flagged.get("tip_does_not_fit").copied().unwrap_or(0);
    let is_named = report.tip.unwrap().uncompensated.is_some();
    assert!(left_out > 0 || is_named, "{:?}", report.flagged);
}

#[test]
fn few_points_and_bad_radii_are_said() {
    let report = measured(SPHERE, Some(tip(BALL_MM)), &[[0.0, 0.0, 0.5]]).report;
    let figures = report.points.tip.unwrap();
    assert!(figures.uncompensated.is_some() && report.form.is_none());
    assert!(
        report.verdict.reasons.iter().any(|reason| reason.contains("lowest points of the ball"))
    );
    for radius_mm in [f64::NAN, -1.0, f64::INFINITY, 51.0] {
        let error = Tip::new(radius_mm, 0.0, TipReads::Lowest).unwrap_err().to_string();
        assert!(error.contains("expected 0 to 50 mm"), "{error}");
    }
    assert!(Tip::new(0.1, -1e-6, TipReads::Lowest).is_err());
}

/// u of the radius, of a centre, is a radius of the part too small by it: for a held radius PV changes by the sag of that.
#[test]
fn the_uncertainty_of_the_radius_has_its_effect() {
    let sphere = |x: f64, y: f64| (400.0 - x * x - y * y).sqrt() - 20.0;
    let balls = centres(raster(18), &Pose::default(), BALL_MM, sphere);
    // No contact lies on the edge, which it would cross with the radius.
    let nominal = &SPHERE.replace("radius_mm = 8", "radius_mm = 8.01");
    let with_u = Tip::new(BALL_MM, 1e-4, TipReads::Centre).unwrap();
    let of_true = pv_nm(&measured(nominal, Some(tip(BALL_MM)), &balls).report);
    let other = pv_nm(&measured(nominal, Some(tip(BALL_MM + 1e-4)), &balls).report);
    let figures = measured(nominal, Some(with_u), &balls).report.points.tip.unwrap();
    let u_nm = figures.u_pv_nm.unwrap();
    assert!(other > 5.0 && (u_nm - (other - of_true)).abs() < 0.01 * u_nm, "{u_nm} {other}");
}

#[test]
fn running_contacts_are_provisional_and_near() {
    let part = parse("part.toml", SPHERE).unwrap();
    let mut pipeline = Pipeline::new(part).with_tip(Some(tip(BALL_MM)));
    pipeline.take_positions(centres(raster(18), &misaligned(), BALL_MM, wavy));
    let form = pipeline.figures_of_all().form.unwrap();
    let texts = &form.fit.details.cautions;
    assert!(texts.iter().any(|caution| caution.text.contains("found anew")), "{texts:?}");
    assert!(form.deviation.pv_nm < 400.0, "{}", form.deviation.pv_nm);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4))]

    /// A motion of the part, and another scale of part and ball, leave the deviation.
    #[test]
    fn motion_and_scale_keep_the_deviation(
        shift in prop::array::uniform2(-30.0..30.0_f64), turn in prop::array::uniform2(-0.02..0.02_f64),
        ball_mm in 0.01..3.0_f64,
    ) {
        let nominal = "[surface]\nkind = \"sphere\"\nradius_mm = -20\n";
        let still = measured(nominal, Some(tip(ball_mm)), &centres(raster(8), &Pose::default(), ball_mm, wavy));
        let pose = Pose {
            tx_mm: shift[0], ty_mm: shift[1], tz_mm: 1.0, rx_rad: turn[0], ry_rad: turn[1], rz_rad: 0.0,
        };
        let moved = measured(nominal, Some(tip(ball_mm)), &centres(raster(8), &pose, ball_mm, wavy));
        prop_assert!((pv_nm(&still.report) - pv_nm(&moved.report)).abs() < 0.01);
        let double = "[surface]\nkind = \"sphere\"\nradius_mm = -40\n";
        let twice: Vec<PointMm> =
            centres(raster(8), &Pose::default(), ball_mm, wavy).iter().map(|at| at.map(|x| 2.0 * x)).collect();
        let scaled = measured(double, Some(tip(2.0 * ball_mm)), &twice);
        prop_assert!((2.0 * pv_nm(&still.report) - pv_nm(&scaled.report)).abs() < 0.01);
    }
}

/// The design is met whatever nominal stands for it.
#[test]
fn a_tilted_plane_is_exact() {
    let pose = Pose { rx_rad: 0.3, ry_rad: -0.2, tz_mm: 4.0, ..Pose::default() };
    let balls = centres(raster(8), &pose, BALL_MM, |_, _| 0.0);
    let found = measured("[surface]\nkind = \"plane\"\n", Some(tip(BALL_MM)), &balls);
    assert!(pv_nm(&found.report) < 1e-3);
    for point in &found.points_mm {
        assert!(pose.to_part(*point)[2].abs() < 1e-12);
    }
}

/// A centre that reaches no nominal has no contact: the report says that, and names no largest correction.
#[test]
fn a_tip_without_any_contact_is_said() {
    let nominal = "[surface]\nkind = \"sphere\"\nradius_mm = 2\n[fit]\nfree = [\"tz\"]\n";
    let points: Vec<PointMm> = raster(2).map(|[x, y]| [x, y, 6.0]).collect();
    let report = measured(nominal, Some(tip(2.5)), &points).report;
    let figures = report.points.tip.as_deref().unwrap();
    assert_eq!((figures.contacts, figures.largest_height_nm), (Some(0), 0.0), "{figures:?}");
    assert_eq!(report.verdict.status, Status::Undecided, "{:?}", report.verdict);
    assert_eq!(report.points.flagged.values().sum::<u64>(), 25, "{:?}", report.points);
}

/// With either side allowed the ball touches the side that it was on, whichever way the design looks.
#[test]
fn a_part_measured_from_either_side_is_compensated() {
    let either = |radius_mm: i32| {
        format!(
            "[surface]\nkind = \"asphere\"\nradius_mm = {radius_mm}\nconic = -0.4\nA4 = 1e-5\n[aperture]\nshape = \"circle\"\nradius_mm = 8.1\n\
             [fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"]\nside = \"either\"\n"
        )
    };
    for (radius_mm, height_sign) in [(20, 1.0), (20, -1.0), (-20, 1.0), (-20, -1.0)] {
        // Upside down the height and the places of one axis change their sign.
        let sag = move |x: f64, y: f64| {
            let (c, square) = (1.0 / f64::from(radius_mm), x * x + y * y);
            let root = (1.0 - 0.6 * c * c * square).sqrt();
            let form_mm = 1e-4 * (0.8 * x).sin() * (0.6 * y).cos();
            height_sign * (c * square / (1.0 + root) + 1e-5 * square * square + form_mm)
        };
        let truth =
            measured(&either(radius_mm), None, &centres(raster(18), &Pose::default(), 0.0, sag));
        let balls = centres(raster(18), &Pose::default(), BALL_MM, sag);
        let found = measured(&either(radius_mm), Some(tip(BALL_MM)), &balls);
        let tip = found.report.points.tip.as_deref().unwrap();
        for report in [&truth.report, &found.report] {
            assert!(
                report.form.is_some(),
                "{radius_mm} {height_sign} {:?} {:?}",
                report.verdict,
                report.points
            );
        }
        let [truth, with] = [&truth, &found].map(|of| pv_nm(&of.report));
        assert!(truth < 400.0 && (with - truth).abs() < 0.2, "{with} for {truth}: {tip:?}");
        assert!(tip.uncompensated.is_none() && tip.largest_height_nm > 2e4, "{tip:?}");
    }
}

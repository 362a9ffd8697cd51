//! Contributions of systematic errors against draws of these errors, and against what is known of spheres and flats.

use asphera_geometry::PointMm;
use asphera_geometry::vector::plus;
use asphera_report::{Report, Status, SystematicFigures};
use proptest::prelude::*;

use super::*;
use crate::nominal::parse;
use crate::random::Random;
use crate::tip::TipReads;
use crate::{Pipeline, Tip};

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = -20\n[aperture]\nshape = \"circle\"\nradius_mm = 6.1\n\
                      [fit]\nfree = [\"tx\", \"ty\", \"tz\"]\n";
const SPHERE_FREE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = -20\n[aperture]\nshape = \"circle\"\nradius_mm = 6.1\n\
                           [fit]\nfree = [\"tx\", \"ty\", \"tz\", \"radius\"]\n";
const PLANE: &str = "[surface]\nkind = \"plane\"\n";
const RADIUS_MM: f64 = 20.0;
/// Outermost points of the raster in the aperture: (5.2, 3.2) mm.
const RIM_SQUARE_MM2: f64 = 37.28;

/// A convex sphere with astigmatism of `form_mm` at 6 mm and noise.
fn sphere(form_mm: f64, noise_mm: f64, seed: u64) -> Vec<PointMm> {
    let mut random = Random(seed);
    let side = || (-17..=17).map(|i| 0.4 * f64::from(i));
    let places = side().flat_map(|x| side().map(move |y| [x, y]));
    places
        .map(|[x, y]| {
            let form_mm = form_mm * (x * x - y * y) / 36.0;
            let z = (RADIUS_MM * RADIUS_MM - x * x - y * y).sqrt() - RADIUS_MM;
            [x, y, z + form_mm + noise_mm * random.normal()]
        })
        .collect()
}

fn measured(nominal: &str, points: &[PointMm], systematic: Vec<Systematic>) -> Report {
    let mut pipeline = Pipeline::new(parse("part.toml", nominal).unwrap());
    pipeline.take_positions(points.iter().copied());
    pipeline.know_systematic(systematic);
    pipeline.finish().report
}

fn pv_and_rms(report: &Report) -> [f64; 2] {
    let deviation = &report.form.as_ref().unwrap().deviation;
    [deviation.pv_nm, deviation.rms_nm]
}

fn rows(report: &Report) -> &[SystematicFigures] {
    &report.form.as_ref().unwrap().deviation.systematic
}

fn scale_x(u: f64) -> Systematic {
    Systematic::new("scale of x", move |[x, _, _]| [u * x, 0.0, 0.0])
}

/// Standard deviation of values about `mean`.
fn spread(values: &[f64], mean: f64) -> f64 {
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
}

/// Draws of the error of a scale spread PV, RMS and the pose as far as the contributions say. A standard deviation of 120 draws is
/// good to 6.5 % (k = 1); three times that is allowed.
#[test]
fn draws_of_a_scale_spread_the_figures_by_the_contributions() {
    let u = 10e-6;
    let points = sphere(100e-6, 2e-6, 7);
    let moved: Vec<PointMm> = points.iter().map(|&at| plus(at, 1.0, [0.004, 0.0, 0.0])).collect();
    // About an origin beside the part the scale shifts it as well.
    let stated = measured(SPHERE, &moved, vec![scale_x(u)]);
    let [row] = rows(&stated) else { panic!("{:?}", rows(&stated)) };
    let mut random = Random(99);
    let (mut all, mut shifts_mm) = ([Vec::new(), Vec::new()], Vec::new());
    for _ in 0..120 {
        let error = u * random.normal();
        let drawn: Vec<PointMm> =
            moved.iter().map(|&[x, y, z]| [x * (1.0 + error), y, z]).collect();
        let report = measured(SPHERE, &drawn, Vec::new());
        for (values, value) in all.iter_mut().zip(pv_and_rms(&report)) {
            values.push(value);
        }
        shifts_mm.push(report.form.unwrap().fit.parameters["tx"].value);
    }
    let truth = pv_and_rms(&stated);
    for ((values, mean), u_nm) in
        all.iter().zip(truth).zip([row.u_pv_nm.unwrap(), row.u_rms_nm.unwrap()])
    {
        let found = spread(values, mean);
        assert!((found / u_nm - 1.0).abs() < 0.2 && u_nm > 1.0, "{found} for {u_nm}");
    }
    let tx = &row.parameters["tx"];
    let found = spread(&shifts_mm, stated.form.as_ref().unwrap().fit.parameters["tx"].value);
    assert!((found / tx.u - 1.0).abs() < 0.2 && tx.unit == "mm", "{found} for {tx:?}");
}

/// Of a part without form error every error makes its RMS larger: the RMS that draws leave is u.
#[test]
fn a_perfect_part_has_the_rms_of_the_error_itself() {
    let points = sphere(0.0, 0.0, 1);
    let report = measured(SPHERE, &points, vec![scale_x(4e-6)]);
    let u_nm = rows(&report)[0].u_rms_nm.unwrap();
    let drawn: Vec<PointMm> = points.iter().map(|&[x, y, z]| [x * (1.0 + 4e-6), y, z]).collect();
    let [_, rms_nm] = pv_and_rms(&measured(SPHERE, &drawn, Vec::new()));
    assert!(rms_nm > 1.0 && (u_nm - rms_nm).abs() < 1e-3 * rms_nm, "{u_nm} for {rms_nm}");
}

/// A sphere that grows as a whole, as by temperature, is a sphere of another radius: dR = R·u, and no deviation.
#[test]
fn a_free_radius_takes_up_an_expansion_and_a_held_one_does_not() {
    let points = sphere(50e-6, 2e-6, 3);
    let expansion = |u: f64| Systematic::new("expansion", move |at: PointMm| at.map(|mm| u * mm));
    let u = 5e-6;
    let free = measured(SPHERE_FREE, &points, vec![expansion(u)]);
    let row = &rows(&free)[0];
    assert!((row.parameters["radius"].u - RADIUS_MM * u).abs() < 1e-3 * RADIUS_MM * u, "{row:?}");
    // The form error grows with the part, by as little.
    assert!(row.u_pv_nm.unwrap() < 1e-2 && row.u_rms_nm.unwrap() < 1e-2, "{row:?}");
    let radius = &free.form.as_ref().unwrap().fit.parameters["radius"];
    assert!(radius.u.unwrap() >= row.parameters["radius"].u);
    let held = measured(SPHERE, &sphere(0.0, 0.0, 3), vec![expansion(u)]);
    let row = &rows(&held)[0];
    // Sag at the rim of a radius larger by R·u, less what a shift along z takes up: the PV of that.
    let sag_mm = |radius_mm: f64| radius_mm - (radius_mm * radius_mm - RIM_SQUARE_MM2).sqrt();
    let sag_nm = 1e6 * (sag_mm(RADIUS_MM) - sag_mm(RADIUS_MM * (1.0 + u)));
    assert!(row.u_pv_nm.unwrap() > 0.5 * sag_nm && row.u_pv_nm.unwrap() < 1.2 * sag_nm, "{row:?}");
}

/// Squareness shears a flat into itself.
#[test]
fn squareness_changes_nothing_of_a_flat() {
    let points: Vec<PointMm> = sphere(80e-6, 2e-6, 5)
        .into_iter()
        .map(|[x, y, z]| {
            let flat = z - (RADIUS_MM * RADIUS_MM - x * x - y * y).sqrt() + RADIUS_MM;
            [x, y, flat]
        })
        .collect();
    let squareness = Systematic::new("squareness", |[_, y, _]| [50e-6 * y, 0.0, 0.0]);
    let report = measured(PLANE, &points, vec![squareness]);
    let row = &rows(&report)[0];
    assert!(row.u_pv_nm.unwrap() < 1e-3 && row.u_rms_nm.unwrap() < 1e-3, "{row:?}");
    assert!(row.parameters.values().all(|of| of.u < 1e-6), "{row:?}");
}

/// The wrong radius of a ball is taken up by a free radius of the sphere, dR = dr, and not by a held one.
#[test]
fn a_free_radius_takes_up_the_radius_of_the_ball() {
    let (ball_mm, u_mm) = (0.5, 2e-4);
    // Centres over a convex sphere lie on one of R + r.
    let grown = RADIUS_MM + ball_mm;
    let side = || (-17..=17).map(|i| 0.4 * f64::from(i));
    let centres: Vec<PointMm> = side()
        .flat_map(|x| side().map(move |y| [x, y]))
        .map(|[x, y]| [x, y, (grown * grown - x * x - y * y).sqrt() - RADIUS_MM])
        .collect();
    let of = |nominal: &str, reads| {
        let tip = Tip::new(ball_mm, u_mm, reads).unwrap();
        let mut pipeline = Pipeline::new(parse("part.toml", nominal).unwrap()).with_tip(Some(tip));
        pipeline.take_positions(centres.iter().copied());
        pipeline.finish().report
    };
    for reads in [TipReads::Centre, TipReads::Lowest] {
        let free = of(SPHERE_FREE, reads);
        let row = &rows(&free)[0];
        assert_eq!(row.source, BALL);
        assert!((row.parameters["radius"].u - u_mm).abs() < 1e-3 * u_mm, "{row:?}");
        assert!(row.u_pv_nm.unwrap() < 1e-2, "{row:?}");
        let held = of(SPHERE, reads);
        let [pv_nm, rms_nm] = [rows(&held)[0].u_pv_nm.unwrap(), rows(&held)[0].u_rms_nm.unwrap()];
        // 200 nm of radius are 200·(1/cos α − 1) nm over the aperture, of which a shift takes up the mean.
        let most_nm = 1e6 * u_mm * (1.0 / (1.0_f64 - 0.09).sqrt() - 1.0);
        assert!(
            pv_nm > 0.8 * most_nm && pv_nm < 1.1 * most_nm && rms_nm > 1.0,
            "{pv_nm} {most_nm}"
        );
        let figures = held.points.tip.unwrap();
        assert_eq!((figures.u_pv_nm, figures.u_rms_nm), (Some(pv_nm), Some(rms_nm)));
    }
}

/// Squares add up with those of all else, and the words say so.
#[test]
fn uncertainties_and_intervals_count_the_contributions() {
    let points = sphere(100e-6, 3e-6, 11);
    for table in ["", "[uncertainty]\nnoise_nm = 3\n"] {
        let nominal = format!("{SPHERE}{table}");
        let without = measured(&nominal, &points, Vec::new());
        let sources = vec![scale_x(2e-6), Systematic::not_counted("a table", "it has no u")];
        let with = measured(&nominal, &points, sources);
        let known =
            |report: &Report| report.form.as_ref().unwrap().deviation.uncertainty.clone().unwrap();
        let ([old, new], rows) = ([known(&without), known(&with)], rows(&with));
        assert_eq!(rows[1].not_counted.as_deref(), Some("it has no u"));
        let expected = [
            old.u_pv_nm.hypot(rows[0].u_pv_nm.unwrap()),
            old.u_rms_nm.hypot(rows[0].u_rms_nm.unwrap()),
        ];
        assert!((new.u_pv_nm - expected[0]).abs() < 1e-9, "{new:?}");
        assert!((new.u_rms_nm - expected[1]).abs() < 1e-9, "{new:?}");
        assert!(new.pv_95_nm[0] < old.pv_95_nm[0] && new.pv_95_nm[1] > old.pv_95_nm[1], "{new:?}");
        assert!(new.rms_95_nm[0] < old.rms_95_nm[0] && new.rms_95_nm[1] > old.rms_95_nm[1]);
        assert!(new.rms_covers.ends_with(SystematicFigures::COVERED), "{}", new.rms_covers);
        assert!(!old.rms_covers.contains(SystematicFigures::COVERED));
        // The figures themselves stay.
        assert_eq!(pv_and_rms(&without), pv_and_rms(&with));
    }
}

/// A guard band is as wide as all that is known: what passes without a systematic error is undecided with it.
#[test]
fn a_guard_band_counts_the_contributions() {
    let points = sphere(100e-6, 3e-6, 11);
    let [pv_nm, rms_nm] = pv_and_rms(&measured(SPHERE, &points, Vec::new()));
    let nominal = format!(
        "{SPHERE}[sampling]\ngap_limit_mm = 1\n[tolerance]\npv_nm = {}\nrms_nm = {}\nb_nm = {}\nguard_factor = 2\n",
        pv_nm + 40.0,
        rms_nm + 10.0,
        pv_nm + 60.0,
    );
    let without = measured(&nominal, &points, Vec::new());
    assert_eq!(without.verdict.status, Status::Pass, "{:?}", without.verdict);
    let with = measured(&nominal, &points, vec![scale_x(40e-6)]);
    assert_eq!(with.verdict.status, Status::Undecided, "{:?}", with.verdict);
    let row = &rows(&with)[0];
    for (old, new) in without.verdict.checks.iter().zip(&with.verdict.checks) {
        let contribution = row.limits[&new.figure.name];
        let (old_u, new_u) = (old.u.unwrap(), new.u.unwrap());
        assert!((new_u / old_u.hypot(contribution) - 1.0).abs() < 0.02, "{new:?} {contribution}");
        assert!(new.guard_band.unwrap() > 1.9 * new_u, "{new:?}");
        assert!(new.u_covers.as_ref().unwrap().ends_with(SystematicFigures::COVERED));
    }
}

#[test]
fn sources_without_an_effect_are_said_and_count_nothing() {
    let points = sphere(100e-6, 3e-6, 13);
    let plain = measured(SPHERE, &points, Vec::new());
    assert!(rows(&plain).is_empty());
    let none = Systematic::new("nothing", |_| [0.0; 3]);
    let broken = Systematic::new("broken", |_| [f64::NAN, 0.0, 0.0]);
    let report = measured(SPHERE, &points, vec![none, broken]);
    let [zero, unknown] = rows(&report) else { panic!("{:?}", rows(&report)) };
    assert_eq!((zero.u_pv_nm, zero.u_rms_nm), (Some(0.0), Some(0.0)));
    assert!(unknown.not_counted.is_some() && unknown.u_pv_nm.is_none());
    let known =
        |report: &Report| report.form.as_ref().unwrap().deviation.uncertainty.clone().unwrap();
    assert_eq!(known(&report).u_pv_nm, known(&plain).u_pv_nm);
    assert_eq!(known(&report).rms_95_nm, known(&plain).rms_95_nm);
    // Without a fit nothing is listed, and nothing breaks.
    let report = measured(SPHERE, &points[..2], vec![scale_x(1e-6)]);
    assert!(report.form.is_none());
}

/// A profile counts them where its noise is stated.
#[test]
fn a_profile_counts_them() {
    let points: Vec<PointMm> = (-60..=60)
        .map(|i| {
            let x = 0.1 * f64::from(i);
            [x, 0.0, (400.0 - x * x).sqrt() - 20.0 + 40e-6 * (1.3 * x).sin()]
        })
        .collect();
    let nominal = format!("{SPHERE}[uncertainty]\nnoise_nm = 3\n");
    let without = measured(&nominal, &points, Vec::new());
    let with = measured(&nominal, &points, vec![scale_x(20e-6)]);
    assert!(with.profile.is_some());
    let known =
        |report: &Report| report.form.as_ref().unwrap().deviation.uncertainty.clone().unwrap();
    let u_nm = rows(&with)[0].u_rms_nm.unwrap();
    assert!(u_nm > 1.0, "{:?}", rows(&with));
    assert!((known(&with).u_rms_nm - known(&without).u_rms_nm.hypot(u_nm)).abs() < 1e-9);
}

/// Of many points some stand for all.
#[test]
fn contributions_of_many_points_are_those_of_all() {
    let side = || (-140..140).map(|i| 0.03 * f64::from(i));
    let places = side().flat_map(|x| side().map(move |y| [x, y]));
    let points: Vec<PointMm> = places
        .map(|[x, y]| {
            let form_mm =
                100e-6 * (x * x - y * y) / 36.0 + 20e-6 * (2.1 * x).sin() * (1.7 * y).cos();
            [x, y, (RADIUS_MM * RADIUS_MM - x * x - y * y).sqrt() - RADIUS_MM + form_mm]
        })
        .collect();
    assert!(points.len() > 1 << 16);
    let nominal = SPHERE.replace("radius_mm = 6.1", "radius_mm = 6.5");
    let u = 10e-6;
    let stated = measured(&nominal, &points, vec![scale_x(u)]);
    let row = &rows(&stated)[0];
    let [pv_nm, rms_nm] = pv_and_rms(&stated);
    let drawn = |error: f64| {
        let points: Vec<PointMm> =
            points.iter().map(|&[x, y, z]| [x * (1.0 + error), y, z]).collect();
        let [pv, rms] = pv_and_rms(&measured(&nominal, &points, Vec::new()));
        [(pv - pv_nm).abs(), (rms - rms_nm).abs()]
    };
    let (above, below) = (drawn(u), drawn(-u));
    for (which, found) in [row.u_pv_nm.unwrap(), row.u_rms_nm.unwrap()].into_iter().enumerate() {
        let expected = above[which].max(below[which]);
        assert!((found / expected - 1.0).abs() < 0.02, "{which}: {found} for {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// Small contributions are proportional to the error, and those of errors to either side are equal; the order of the points
    /// changes none.
    #[test]
    fn contributions_are_proportional_and_even(u in 1e-8..1e-7_f64, seed in 0_u64..1000) {
        let mut points = sphere(100e-6, 3e-6, seed);
        let of = |points: &[PointMm], u: f64| {
            let report = measured(SPHERE, points, vec![scale_x(u)]);
            let row = &rows(&report)[0];
            [row.u_pv_nm.unwrap(), row.u_rms_nm.unwrap(), row.parameters["tx"].u]
        };
        let (one, double, other) = (of(&points, u), of(&points, 2.0 * u), of(&points, -u));
        points.reverse();
        let reversed = of(&points, u);
        for which in 0..2 {
            prop_assert!((double[which] / one[which] - 2.0).abs() < 0.02, "{one:?} {double:?}");
            prop_assert!((other[which] / one[which] - 1.0).abs() < 0.02, "{one:?} {other:?}");
            prop_assert!((reversed[which] / one[which] - 1.0).abs() < 0.02, "{one:?} {reversed:?}");
        }
    }
}

//! Surfaces made from the points, losses and weights, through the whole pipeline.

use asphera_form::reference;
use asphera_geometry::{Point, PointMm};
use asphera_report::{Report, Status};

use crate::nominal::parse;
use crate::random::Random;
use crate::{Along, Measurement, Pipeline};

/// A sequence of numbers, uniform between -0.5 and 0.5 and all the same at every run.
fn uniform(seed: u64) -> impl FnMut() -> f64 {
    let mut random = Random(seed);
    move || random.centred()
}

/// A raster of `side`² points 0.1 mm apart about (x, y), on a sphere of 30 mm with a wave of 200 nm and 10 mm, and
/// noise of 10 nm.
fn bowl(side: u32, [x0, y0]: [f64; 2]) -> Vec<PointMm> {
    let mut uniform = uniform(1);
    let half = 0.05 * f64::from(side);
    let point = |index: u32| {
        let (x, y) = (0.1 * f64::from(index % side) - half, 0.1 * f64::from(index / side) - half);
        let rr = x * x + y * y;
        let sphere = rr / (30.0 + (900.0 - rr).sqrt());
        let noise: f64 = 1e-5 * 3.0_f64.sqrt() * (0..4).map(|_| uniform()).sum::<f64>();
        [x0 + x, y0 + y, sphere + 2e-4 * (0.628 * x).cos() + noise]
    };
    (0..side * side).map(point).collect()
}

/// A point with the standard uncertainty of its height, mm.
fn known_to((at_mm, u_z_mm): (PointMm, f64)) -> Point {
    Point { at_mm, u_z_mm: Some(u_z_mm) }
}

fn pipeline(part: &str) -> Pipeline {
    Pipeline::along(parse("part.toml", part).unwrap(), Along::Z)
}

fn measured(part: &str, points: &[PointMm]) -> Measurement {
    let mut pipeline = pipeline(part);
    pipeline.take_positions(points.iter().copied());
    pipeline.finish()
}

const UNKNOWN: &str = "[surface]\nkind = \"unknown\"\n[tolerance]\nrms_nm = 15\n";

#[test]
fn an_unknown_surface_is_made_from_its_points_and_the_verdict_says_so() {
    let Report { form, verdict, sampling, points, .. } =
        measured(UNKNOWN, &bowl(80, [0.0; 2])).report;
    let form = form.unwrap();
    let reference = form.reference.unwrap();
    let noise_nm = reference.noise_nm.unwrap();
    assert!((noise_nm - 10.0).abs() < 0.3, "{reference:?}");
    assert!(reference.base_rms_nm > 50.0 && reference.follows_mm < 5.0, "{reference:?}");
    assert!((form.deviation.rms_nm - 10.0).abs() < 0.3, "{:?}", form.deviation);
    assert_eq!((points.used, sampling.lfs_source.as_deref()), (6400, Some("measured")));
    assert_eq!(verdict.status, Status::Pass);
    let said = |reason: &String| reason.contains("made from these points");
    assert!(
        verdict.reasons.iter().any(said)
            && form.fit.details.cautions.iter().any(|caution| said(&caution.text))
    );
    assert!(form.nominal.starts_with("unknown; made from the points"), "{}", form.nominal);
    assert!(form.fit.method.starts_with("penalised B-splines over a"), "{}", form.fit.method);
    assert!(!form.fit.parameters.is_empty() && form.fit.free.contains(&"tz".to_owned()));
    let failed = measured(&UNKNOWN.replace("15", "5"), &bowl(80, [0.0; 2])).report.verdict;
    assert_eq!(failed.status, Status::Fail);
}

#[test]
fn while_points_arrive_the_reference_is_that_of_the_points_so_far() {
    let centre = [500.0, -300.0];
    for aperture in ["", "[aperture]\nshape = \"circle\"\nradius_mm = 3.47\n"] {
        let part = format!("{UNKNOWN}{aperture}").replace(
            "\"unknown\"\n",
            if aperture.is_empty() {
                "\"unknown\"\n"
            } else {
                "\"unknown\"\ncentre_mm = [500, -300]\n"
            },
        );
        let settings = parse("part.toml", &part).unwrap().reference.unwrap();
        let mut pipeline = pipeline(&part);
        let points = bowl(80, centre);
        let mut last = None;
        for (index, batch) in points.chunks(320).enumerate() {
            pipeline.take_positions(batch.iter().copied());
            let running = pipeline.figures();
            let Some(form) = &running.form else { continue };
            // The figures of a reference made anew from the same points.
            let so_far = &points[..points.len().min(320 * (index + 1))];
            let made = reference(so_far, &settings).unwrap();
            // The frame of a base of fewer points is turned a little: a point on the edge is in or out.
            assert!(running.points.used.abs_diff(made.fit.used as u64) < 5);
            let rms_nm = 1e6 * made.fit.residuals.rms_mm;
            let off = form.deviation.rms_nm / rms_nm - 1.0;
            assert!(off.abs() < 0.02, "{} points: {off}", so_far.len());
            let outlook = running.outlook.as_ref().unwrap();
            // No limit is broken or kept for certain before the reference stands.
            assert!(outlook.text.contains("the reference is made anew"), "{}", outlook.text);
            last = Some(running);
        }
        let running = last.unwrap();
        let form = running.form.unwrap();
        assert!(form.provisional && form.nominal.starts_with("unknown; made from the points"));
        let texts = form.fit.details.cautions.iter().map(|caution| &caution.text[..]);
        let texts: Vec<&str> = texts.collect();
        assert!(texts[0].contains("made anew from all points"), "{texts:?}");
        assert!(texts[1].contains("made from these points"), "{texts:?}");
        let map = running.map.unwrap();
        let filled = map.values_nm.iter().flatten().count();
        assert!(filled > map.values_nm.len() / 8, "{filled}");
        assert!(map.values_nm.iter().flatten().all(|nm| nm.abs() < 60.0));
        let measurement = pipeline.finish();
        let cells = measurement.cells.unwrap();
        assert_eq!(cells.values_nm.len(), map.values_nm.len());
        assert!(cells.values_nm.iter().flatten().all(|nm| nm.abs() < 60.0));
        assert!(cells.values_nm.iter().flatten().count() > map.values_nm.len() / 8);
        let last = measurement.report.form.unwrap();
        assert!((form.deviation.pv_nm / last.deviation.pv_nm - 1.0).abs() < 0.05);
        assert_eq!(form.fit.method, last.fit.method);
        let [now, then] = [&form, &last].map(|form| form.reference.as_ref().unwrap());
        assert_eq!((&now.base, &now.smoothing), (&then.base, &then.smoothing));
        assert!((now.follows_mm / then.follows_mm - 1.0).abs() < 0.2, "{now:?} {then:?}");
        assert!(now.as_of_points.unwrap() > 3_200 && then.as_of_points.is_none());
        let noise_nm = then.noise_nm.unwrap();
        assert!((noise_nm - 10.0).abs() < 0.4, "{noise_nm}");
        // The middle of the points, half a step from the centre of the raster.
        assert!((last.fit.pose.tx_mm - 500.0).abs() < 0.06, "{:?}", last.fit.pose);
    }
}

#[test]
fn points_that_make_no_surface_are_told() {
    let line: Vec<PointMm> = (0..200).map(|i| [0.1 * f64::from(i), 0.0, 0.0]).collect();
    for (points, said) in
        [(&line[..5], "at least 16 are needed"), (&line[..], "a line makes no surface")]
    {
        let report = measured(UNKNOWN, points).report;
        assert!(report.form.is_none());
        assert_eq!(report.verdict.status, Status::Undecided);
        let reasons = report.verdict.reasons.join("\n");
        assert!(reasons.contains(said), "{reasons}");
    }
    let finer = UNKNOWN.replace("\"unknown\"\n", "\"unknown\"\nknots_mm = 0.15\n");
    let reasons = measured(&finer, &bowl(40, [0.0; 2])).report.verdict.reasons.join("\n");
    assert!(reasons.contains("finer than the points"), "{reasons}");
}

const PLANE: &str = "[surface]\nkind = \"plane\"\n[fit]\n";

#[test]
fn a_loss_lets_outliers_stand_and_counts_them() {
    let mut uniform = uniform(3);
    let points: Vec<PointMm> = (0..2500)
        .map(|i| {
            let (x, y) = (f64::from(i % 50), f64::from(i / 50));
            [x, y, if i % 10 == 0 { 5e-3 } else { 2e-5 * uniform() }]
        })
        .collect();
    let fit = |rest: &str| measured(&format!("{PLANE}{rest}"), &points).report.form.unwrap().fit;
    let plain = fit("");
    assert!(plain.loss.is_none() && plain.effective_points.is_none());
    assert!(plain.parameters["tz"].value > 2e-4);
    let tukey = fit("loss = \"tukey\"\n");
    let loss = tukey.loss.unwrap();
    assert_eq!((loss.name.as_str(), loss.left_out), ("tukey", 250));
    assert!(tukey.parameters["tz"].value.abs() < 1e-6 && !loss.threshold_given);
    assert!((2000.0..2250.0).contains(&tukey.effective_points.unwrap()));
    let huber = fit("loss = \"huber\"\nthreshold_nm = 30\n");
    let loss = huber.loss.unwrap();
    assert!((loss.threshold_nm - 30.0).abs() < 1e-9 && loss.threshold_given);
    assert_eq!((loss.below_half, loss.left_out), (250, 0));
    assert!(huber.method.contains("Huber"));
}

#[test]
fn a_point_of_a_tenth_of_the_uncertainty_weighs_a_hundred_times() {
    // Two levels, 1 µm apart, the upper one known ten times as well.
    let level =
        |i: u32| if (i % 30 + i / 30).is_multiple_of(2) { (1e-3, 1e-5) } else { (0.0, 1e-4) };
    let points =
        || (0..900_u32).map(|i| ([f64::from(i % 30), f64::from(i / 30), level(i).0], level(i).1));
    let part = format!("{PLANE}free = [\"tz\"]\nweights = \"uncertainty\"\n");
    let mut known = pipeline(&part);
    known.take_positions(points().map(known_to));
    let running = known.figures().form.unwrap();
    let fit = known.finish().report.form.unwrap().fit;
    for fit in [&running.fit, &fit] {
        let tz = &fit.parameters["tz"];
        assert!((tz.value - 1e-3 / 1.01).abs() < 1e-12, "{:?}", fit.parameters);
        let weights = fit.weights.as_ref().unwrap();
        assert!((weights.u_min_nm - 10.0).abs() < 1e-9 && (weights.u_max_nm - 100.0).abs() < 1e-9);
        assert!(fit.method.starts_with("weighted"), "{}", fit.method);
        assert!(fit.details.cautions.is_empty(), "{:?}", fit.details.cautions);
        assert!((fit.effective_points.unwrap() - 900.0 / 2.0 * 1.0201 / 1.0001).abs() < 1e-6);
    }
    assert_eq!(running.deviation.rms_nm.round(), 700.0);

    let plain: Vec<PointMm> = points().map(|(point, _)| point).collect();
    let mut unknown = pipeline(&part);
    unknown.take_positions(plain.iter().copied());
    let running = unknown.figures().form.unwrap();
    assert!(
        (running.fit.parameters["tz"].value - 5e-4).abs() < 1e-12 && running.fit.weights.is_none()
    );
    let caution = &running.fit.details.cautions[0].text;
    assert!(caution.contains("the points carry none. Until the end they count alike"), "{caution}");
    let unknown = unknown.finish().report;
    let said = |reason: &String| reason.contains("the points carry none");
    assert!(unknown.verdict.reasons.iter().any(said), "{:?}", unknown.verdict);
}

/// A lens projected along a fitted plane, its aperture known or not, each point with its uncertainty along z: whenever
/// the running fit has taken all points, it is the final one.
#[test]
fn the_running_fit_of_weighted_points_is_the_final_one() {
    let mut uniform = uniform(5);
    let points: Vec<(PointMm, f64)> = bowl(60, [0.0; 2])
        .into_iter()
        .map(|[x, y, z]| {
            let u_mm = 1e-5 * 8_f64.powf(2.0 * uniform());
            // The whole is tilted by 0.6 rad.
            let (sin, cos) = 0.6_f64.sin_cos();
            ([x, cos * y - sin * z, sin * y + cos * z + 3.0 * u_mm * uniform()], u_mm)
        })
        .collect();
    let sphere = "[surface]\nkind = \"sphere\"\nradius_mm = 30\n";
    let fit = "[fit]\nfree = [\"tx\", \"ty\", \"tz\"]\nweights = \"uncertainty\"\n";
    for aperture in ["", "[aperture]\nshape = \"circle\"\nradius_mm = 4\n"] {
        let part = format!("{sphere}{aperture}{fit}");
        let mut known =
            Pipeline::along(parse("part.toml", &part).unwrap(), Along::fitted(500).unwrap());
        known.take_positions(points.iter().copied().map(known_to));
        let running = known.figures().form.unwrap();
        let last = known.finish().report.form.unwrap();
        assert_eq!(running.fit.method, last.fit.method);
        for (name, found) in &running.fit.parameters {
            let (found, last) = (found, &last.fit.parameters[name]);
            let off = (found.value - last.value).abs() / last.u.unwrap();
            assert!(off < 1e-3, "{name}: {off} of its uncertainty");
            assert!((found.u.unwrap() / last.u.unwrap() - 1.0).abs() < 1e-3);
        }
        assert!((running.deviation.rms_nm - last.deviation.rms_nm).abs() < 1e-3);
        let [a, b] = [&running, &last].map(|form| form.fit.weights.as_ref().unwrap());
        let ratio = a.reduced_chi_square.unwrap() / b.reduced_chi_square.unwrap();
        assert!((ratio - 1.0).abs() < 1e-4 && b.u_max_nm < 80.0, "{ratio} {b:?}");
        // Of cosines between z and the normals, near to that of 0.6 rad.
        // The final ones are of points beyond the aperture, too.
        let [low, high] = [a.u_min_nm / b.u_min_nm, a.u_max_nm / b.u_max_nm];
        assert!(low > 0.999 && high < 1.001, "{low} {high}");
        assert!(!aperture.is_empty() || (low < 1.001 && high > 0.999), "{low} {high}");
    }
}

/// On a slope of 45° the uncertainty of the height is √2 times that of the distance.
#[test]
fn uncertainties_of_heights_become_those_of_distances() {
    let part = "[surface]\nkind = \"plane\"\n[fit]\nweights = \"uncertainty\"\n";
    let points =
        || (0..900_u32).map(|i| ([f64::from(i % 30), f64::from(i / 30), f64::from(i % 30)], 2e-5));
    let mut known = pipeline(part);
    known.take_positions(points().map(known_to));
    let weights = known.finish().report.form.unwrap().fit.weights.unwrap();
    assert!((weights.u_min_nm - 20.0 / 2.0_f64.sqrt()).abs() < 1e-6, "{weights:?}");
    assert!((weights.u_max_nm - weights.u_min_nm).abs() < 1e-6);
}

/// Places measured again, one after the other and the other way round: the vertex is the first measurement, and so is its weight.
#[test]
fn a_place_measured_again_has_the_uncertainty_of_its_first_measurement() {
    let part = format!("{PLANE}free = [\"tz\"]\nweights = \"uncertainty\"\n");
    let place = |i: u32| [f64::from(i % 30), f64::from(i / 30), 0.0];
    let taken = |first_mm: f64, again_mm: f64| {
        let mut pipeline = pipeline(&part);
        for u_mm in [first_mm, again_mm] {
            pipeline.take_positions((0..900).map(|i| known_to((place(i), u_mm))));
        }
        let report = pipeline.finish().report;
        assert_eq!(report.points.duplicates, 900);
        report.form.unwrap().fit.weights.unwrap().u_max_nm
    };
    assert!((taken(1e-5, 3e-5) - 10.0).abs() < 1e-9 && (taken(3e-5, 1e-5) - 30.0).abs() < 1e-9);
}

/// 20,000 points of a sphere in no order, one in twelve of them 1 to 20 µm too high: at every look the running fit by
/// Tukey's loss is that of a report of the same points.
#[test]
fn the_running_fit_by_a_robust_loss_is_the_final_one() {
    let part = "[surface]\nkind = \"sphere\"\nradius_mm = 30\n[aperture]\nshape = \"circle\"\nradius_mm = 4\n[fit]\n\
                free = [\"tx\", \"ty\", \"tz\"]\nloss = \"tukey\"\n[tolerance]\nrms_nm = 1\n";
    let mut uniform = uniform(7);
    let points: Vec<PointMm> = (0..20_000)
        .map(|index| {
            let (x, y) = (4.2 * uniform(), 4.2 * uniform());
            let form_mm = 2e-4 * (0.9 * x).sin() * (0.6 * y).cos() + 2e-5 * uniform();
            let spoilt_mm =
                if index % 12 == 0 { 1e-3 * (1.0 + 19.0 * uniform().abs()) } else { 0.0 };
            [x + 0.02, y - 0.01, 30.0 - (900.0 - x * x - y * y).sqrt() + form_mm + spoilt_mm]
        })
        .collect();
    let mut growing = pipeline(part);
    let mut taken = 0;
    for look in [4_000, 9_000, 20_000] {
        growing.take_positions(points[taken..look].iter().copied());
        taken = look;
        let figures = growing.figures();
        let running = figures.form.unwrap();
        let mut whole = pipeline(part);
        whole.take_positions(points[..look].iter().copied());
        let last = whole.finish().report.form.unwrap();
        assert_eq!(running.fit.method, "orthogonal Tukey M-estimate");
        assert_eq!(running.fit.method, last.fit.method);
        assert!(running.fit.details.cautions.is_empty(), "{:?}", running.fit.details.cautions);
        for (name, found) in &running.fit.parameters {
            let last = &last.fit.parameters[name];
            let off = (found.value - last.value).abs() / last.u.unwrap();
            assert!(off < 0.2, "{name} of {look}: {off} of its uncertainty");
        }
        let rms = running.deviation.rms_nm / last.deviation.rms_nm;
        let pv = running.deviation.pv_nm / last.deviation.pv_nm;
        assert!((rms - 1.0).abs() < 5e-3 && (pv - 1.0).abs() < 1e-2, "{rms} {pv}");
        let [a, b] = [&running, &last].map(|form| form.fit.loss.as_ref().unwrap());
        assert_eq!((&a.name, a.threshold_given), (&b.name, b.threshold_given));
        assert!((a.scale_nm / b.scale_nm - 1.0).abs() < 0.02, "{a:?} {b:?}");
        assert!(a.left_out.abs_diff(b.left_out) <= 5 + b.left_out / 20, "{a:?} {b:?}");
    }
}

/// The piece of `config/nominals/off-axis.toml`, laid askew: where its aperture lies rests on the turn about the parent's axis.
#[test]
fn an_off_axis_piece_says_what_its_aperture_rests_on() {
    let nominal = include_str!("../../../config/nominals/off-axis.toml");
    let part = parse("off-axis.toml", nominal).unwrap();
    let [turn, tilt] = [0.004_f64, -0.003].map(f64::sin_cos);
    let points: Vec<PointMm> = (0..81 * 81)
        .map(|i| [0.35 * f64::from(i % 81) - 14.0, 0.35 * f64::from(i / 81) - 14.0])
        .filter_map(|[x, y]| {
            let z = part.nominal.height_mm(x, y)?;
            let [y, z] = [y * turn.1 - z * turn.0, y * turn.0 + z * turn.1];
            Some([x * tilt.1 + z * tilt.0 + 0.3, y - 0.2, z * tilt.1 - x * tilt.0 + 0.1])
        })
        .collect();
    let form = measured(nominal, &points).report.form.unwrap();
    assert!(form.deviation.rms_nm < 1e-3, "{:?}", form.deviation);
    assert_eq!(form.fit.indeterminate, ["turn about the parent's axis"]);
    let [lacks] = &form.fit.details.undetermined[..] else { panic!("one thing is not felt") };
    assert!(lacks.by_shape && lacks.combined && lacks.text.contains("held at its start"));
    let said = form.fit.details.cautions.iter().find(|one| one.kind == "held_combination");
    assert!(
        said.is_some_and(|one| one.text.contains("moves the aperture by 0.050 mm")),
        "{said:?}"
    );
    // The tilt about y is one of 0.7 mrad about the axis: the sine of 13.8° of it. With `ry` held it was 0.6 mm.
    let pose = &form.fit.pose;
    let off_mm = (pose.tx_mm - 0.3).hypot(pose.ty_mm + 0.2).hypot(pose.tz_mm - 0.1);
    assert!(off_mm < 0.04, "{off_mm}");
}

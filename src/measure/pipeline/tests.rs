//! The pipeline on points whose figures are known.

use asphera_report::Status;

use super::*;
use crate::nominal::parse;
use crate::random::Random;

const PLANE: &str = "[surface]\nkind = \"plane\"\n[tolerance]\nrms_nm = 100\n";

/// A tilted plane with a step of ±50 nm on a grid of 1 mm.
fn waffle(count: usize) -> impl Iterator<Item = PointMm> {
    (0..count * count).map(move |index| {
        let (i, j) = (index % count, index / count);
        let (x, y) = (i as f64, j as f64);
        [x, y, 1e-4 * x - 2e-4 * y + if (i + j) % 2 == 0 { 5e-5 } else { -5e-5 }]
    })
}

fn measured(part: &str, points: impl Iterator<Item = PointMm>) -> Measurement {
    let mut pipeline = Pipeline::new(parse("part.toml", part).unwrap());
    points.for_each(|point| pipeline.take_position(point));
    pipeline.finish()
}

#[test]
fn a_waffled_plane_gives_its_step() {
    let measurement = measured(PLANE, waffle(60));
    let report = measurement.report;
    let deviation = &report.form.unwrap().deviation;
    assert!((deviation.rms_nm - 50.0).abs() < 1e-3, "{deviation:?}");
    assert!((deviation.pv_nm - 100.0).abs() < 0.1, "{deviation:?}");
    assert_eq!((report.points.received, report.points.used), (3600, 3600));
    assert_eq!(report.mesh.triangles, 2 * 59 * 59);
    assert_eq!(report.sampling.coverage, Some(1.0));
    assert_eq!(report.verdict.status, Status::Pass);
    let map = measurement.map.unwrap();
    assert!(map.values_nm.iter().all(|value| value.is_finite()));
}

/// Progress is shown by handing points over piece by piece and hearing of the steps: neither moves a bit.
#[test]
fn pieces_and_listeners_change_no_figure() {
    let part = || parse("part.toml", PLANE).unwrap();
    let points: Vec<PointMm> = noisy_bowl().collect();
    let whole = {
        let mut pipeline = Pipeline::new(part());
        pipeline.take_positions(points.iter().copied());
        pipeline.finish()
    };
    for piece in [1, 777, 1024, 2000] {
        let mut pipeline = Pipeline::new(part());
        points.chunks(piece).for_each(|some| pipeline.take_positions(some.iter().copied()));
        let mut steps = Vec::new();
        let found = pipeline.finish_by_steps(&mut |step| steps.push(step));
        assert_eq!(found.report, whole.report, "pieces of {piece}");
        assert_eq!((&found.points_mm, &found.triangles), (&whole.points_mm, &whole.triangles));
        let bits = |of: &Measurement| -> Vec<u64> {
            of.deviations_nm.iter().map(|deviation| deviation.to_bits()).collect()
        };
        assert_eq!(bits(&found), bits(&whole));
        assert_eq!((steps[0], steps[steps.len() - 1]), (Step::Mesh, Step::Verdict));
        let once: std::collections::BTreeSet<&str> =
            steps.iter().map(|step| step.words()).collect();
        assert_eq!(once.len(), steps.len(), "{steps:?}");
    }
}

/// A bowl of 200 nm with noise of about 10 nm: sums of four uniform numbers.
fn noisy_bowl() -> impl Iterator<Item = PointMm> {
    let mut random = Random(1);
    let mut uniform = move || random.centred();
    (0..3600).map(move |index| {
        let (x, y) = ((index % 60) as f64, (index / 60) as f64);
        let bowl = 2e-4 * ((x - 29.5).powi(2) + (y - 29.5).powi(2)) / 1740.0;
        [x, y, bowl + 1e-5 * 3.0_f64.sqrt() * (0..4).map(|_| uniform()).sum::<f64>()]
    })
}

#[test]
fn a_guard_band_parts_the_certain_from_the_near() {
    let judged = |rms_nm: f64, pv_nm: f64| {
        let part = format!(
            "[surface]\nkind = \"plane\"\n[tolerance]\nrms_nm = {rms_nm}\npv_nm = {pv_nm}\n\
             guard_probability = 0.95\n[uncertainty]\nlong_wave_nm = 4\nlong_wave_mm = 20\n"
        );
        measured(&part, noisy_bowl()).report
    };
    let report = judged(1e4, 1e4);
    let form = report.form.unwrap();
    let told = form.deviation.uncertainty.unwrap();
    assert!(told.noise_measured && (told.noise_nm - 10.0).abs() < 0.7, "{told:?}");
    assert!(told.rms_without_noise_nm < form.deviation.rms_nm && told.u_rms_nm > 0.1);
    assert!(
        told.pv_95_nm[0] < form.deviation.pv_nm && told.u_pv_nm > 1.0 && told.draws == Some(200)
    );
    // A wave of 4 nm leaves some nanometres of tz, far more than the noise of 3600 points.
    let tz = &form.fit.parameters["tz"];
    assert!(tz.u.unwrap() > 1e-6 && tz.expanded_95.unwrap() > 1.9 * tz.u.unwrap());
    assert_eq!(report.verdict.status, Status::Pass);
    let check = &report.verdict.checks[1];
    assert!(check.rule.as_ref().unwrap().contains("ISO 14253-1"));
    assert!((check.guard_band.unwrap() / check.u.unwrap() - 1.645).abs() < 0.01, "{check:?}");

    let near = judged(form.deviation.rms_nm * 1.0001, 1e4);
    assert_eq!(near.verdict.status, Status::Undecided);
    assert!(near.verdict.reasons[0].contains("nearer to its limit than its guard band"));
    assert_eq!(judged(form.deviation.rms_nm * 0.5, 1e4).verdict.status, Status::Fail);
}

#[test]
fn too_few_points_to_measure_noise_by_leave_the_guard_band_undecided() {
    let part = "[surface]\nkind = \"plane\"\n[tolerance]\npv_nm = 1e9\nguard_factor = 2\n";
    let report = measured(part, waffle(3)).report;
    assert_eq!(report.verdict.status, Status::Undecided);
    assert!(report.verdict.reasons[0].contains("state the noise instead"), "{:?}", report.verdict);
    assert!(report.form.unwrap().deviation.uncertainty.is_none());
}

#[test]
fn gaps_conflicts_and_duplicates_are_counted_and_a_conflict_is_no_pass() {
    let odd = [[0.0, 0.0, 5e-5], [1.0, 1.0, 3.0], [f64::NAN, 0.0, 0.0]];
    let mut pipeline = Pipeline::new(parse("part.toml", PLANE).unwrap());
    waffle(20).chain(odd).for_each(|point| pipeline.take_position(point));
    pipeline.take_gaps(7);
    let report = pipeline.finish().report;
    assert_eq!(report.points.received, 410);
    assert_eq!(report.points.duplicates, 1);
    let flagged: Vec<_> = report.points.flagged.into_iter().collect();
    assert_eq!(flagged, [("conflict".into(), 1), ("missing".into(), 7), ("not_finite".into(), 1)]);
    assert!(!report.mesh.projectable);
    assert_eq!(report.verdict.status, Status::Undecided);
}

#[test]
fn a_hole_is_not_covered_and_no_pass() {
    let part = format!("{PLANE}[sampling]\ngap_limit_mm = 1.0\n");
    let hole = waffle(40).filter(|[x, y, _]| (x - 20.0).hypot(y - 20.0) > 9.0);
    let measurement = measured(&part, hole);
    let sampling = &measurement.report.sampling;
    assert!((sampling.coverage.unwrap() - 0.8).abs() < 0.05, "{sampling:?}");
    assert_eq!(measurement.report.verdict.status, Status::Undecided);
    let gaps = measurement.map.unwrap().values_nm.iter().filter(|value| value.is_nan()).count();
    assert!(gaps > 150, "{gaps}");
}

#[test]
fn too_few_points_are_undecided_not_a_panic() {
    for count in 0..3 {
        let points = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let report = measured(PLANE, points.into_iter().take(count)).report;
        assert_eq!(report.form, None);
        assert_eq!(report.verdict.status, Status::Undecided);
        assert!(report.verdict.reasons.iter().any(|reason| reason.contains("no fit")));
    }
}

#[test]
fn running_figures_approach_the_final_ones_and_do_not_disturb_them() {
    let part = parse("part.toml", PLANE).unwrap();
    let (mut looked_at, mut left_alone) = (Pipeline::new(part.clone()), Pipeline::new(part));
    for (index, point) in waffle(80).enumerate() {
        looked_at.take_position(point);
        left_alone.take_position(point);
        if index % 97 == 0 {
            looked_at.figures();
        }
    }
    let running = looked_at.figures();
    let form = running.form.unwrap();
    assert!(form.provisional);
    assert!((form.deviation.rms_nm - 50.0).abs() < 0.1, "{form:?}");
    assert!(running.convergence.points.len() > 20);
    assert!(running.map.unwrap().values_nm.iter().any(Option::is_some));
    assert_eq!(looked_at.finish().report, left_alone.finish().report);
}

/// A biconic with a Chebyshev term laid elsewhere: running and final figures name its parameters with their units.
#[test]
fn a_freeform_is_followed_while_it_is_measured() {
    const PART: &str = "[surface]\nkind = \"chebyshev\"\nhalf_x_mm = 20\nhalf_y_mm = 20\nradius_mm = 80\n\
        terms = [{ x = 3, y = 1, mm = 0.01 }]\n[aperture]\nshape = \"circle\"\nradius_mm = 9\n\
        [fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\", \"rz\", \"T3,1\"]\n[tolerance]\npv_nm = 10\n";
    let part = parse("part.toml", PART).unwrap();
    let made = parse("part.toml", &PART.replace("mm = 0.01 ", "mm = 0.012 ")).unwrap().nominal;
    let mut pipeline = Pipeline::new(part);
    for index in 0..61 * 61 {
        let [x, y] = [index % 61, index / 61].map(|step| f64::from(step) / 3.0 - 10.0);
        pipeline.take_position([x + 0.3, y, made.height_mm(x, y).unwrap() - 2.0]);
    }
    let running = pipeline.figures().form.unwrap();
    let report = pipeline.finish().report;
    let form = report.form.unwrap();
    // The running fit holds what few points hardly tell, and says so.
    assert_eq!(
        (running.provisional, &running.fit.indeterminate[..]),
        (true, &["T3,1".to_owned()][..])
    );
    assert!(running.deviation.rms_nm < 30.0, "{running:?}");
    assert!(form.fit.indeterminate.is_empty(), "{form:?}");
    for (name, expected, unit) in [("T3,1", 0.012, "mm"), ("tx", 0.3, "mm"), ("rz", 0.0, "rad")] {
        let found = &form.fit.parameters[name];
        assert!((found.value - expected).abs() < 1e-6 && found.unit == unit, "{name}: {found:?}");
    }
    assert!(form.deviation.pv_nm < 1e-2, "{form:?}");
    assert_eq!(report.verdict.status, Status::Pass, "{:?}", report.verdict);
}

#[test]
fn a_second_sheet_is_named_with_its_place_and_is_no_pass() {
    let sheet = |offset: f64, z: f64| {
        waffle(30).map(move |[x, y, w]| [x + offset, y + 0.618 * offset, w + z])
    };
    let upper = sheet(0.37, 20.0).filter(|[x, y, _]| *x > 10.0 && *y > 10.0);
    let report = measured(PLANE, sheet(0.0, 0.0).chain(upper)).report;
    let [fold] = &report.mesh.relief.folds[..] else { panic!("{:?}", report.mesh) };
    // The triangles about its rim reach some samples farther.
    assert!(fold.min_mm[0] > 3.0 && fold.min_mm[1] > 3.0, "{fold:?}");
    assert!((fold.projected_area_mm2 - 19.0 * 19.0).abs() < 60.0, "{fold:?}");
    assert!(report.mesh.relief.projection.is_some() && !report.mesh.projectable);
    assert_eq!(report.verdict.status, Status::Undecided);
    assert!(report.verdict.reasons.iter().any(|reason| reason.contains("folds")));
}

#[test]
fn repeated_places_give_their_spread() {
    let again = waffle(20).map(|[x, y, z]| [x, y, z + 2e-5]);
    let report = measured(PLANE, waffle(20).chain(again)).report;
    let repeats = &report.mesh.repeats;
    assert_eq!((repeats.places, repeats.measurements), (400, 800));
    // Two readings 20 nm apart: the standard deviation is 20/√2.
    assert!((repeats.spread_nm.unwrap() - 200.0_f64.sqrt()).abs() < 1e-6, "{repeats:?}");
    assert_eq!(report.points.duplicates, 400);
}

#[test]
fn islands_and_holes_are_counted() {
    let part = format!("{PLANE}[sampling]\ngap_limit_mm = 1.0\n");
    let kept =
        waffle(60).filter(|[x, y, _]| (x - 12.0).hypot(y - 12.0) > 5.0 && (*x < 27.0 || *x > 32.0));
    let sampling = measured(&part, kept).report.sampling;
    assert_eq!((sampling.islands, sampling.holes), (Some(2), Some(1)));
    assert!((sampling.hole_max_mm2.unwrap() - 90.0).abs() < 15.0, "{sampling:?}");
}

const BLOCK: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"rectangle\"\nwidth_mm = 96\nheight_mm = 96\n[sampling]\ngap_limit_mm = 1.0\n";

/// A waffle of 97 by 97 points about the origin, without those of a square hole.
fn block() -> impl Iterator<Item = PointMm> {
    waffle(97)
        .map(|[x, y, z]| [x - 48.0, y - 48.0, z])
        .filter(|[x, y, _]| !((9.5..20.5).contains(x) && (9.5..20.5).contains(y)))
}

#[test]
fn maps_show_a_hole_where_it_is_and_change_only_with_a_look() {
    let mut pipeline = Pipeline::new(parse("part.toml", BLOCK).unwrap());
    let mut versions = Vec::new();
    for (index, point) in block().enumerate() {
        pipeline.take_position(point);
        if index % 500 == 0 {
            versions.extend(pipeline.figures().maps.map(|maps| maps.version));
        }
    }
    let looks = *versions.last().unwrap();
    assert!(versions.is_sorted() && versions[0] == 1 && looks > 3, "{versions:?}");
    assert!((looks as usize) < versions.len(), "{versions:?}");
    let surface = pipeline.finish().surface;
    let maps = surface.maps().unwrap();
    assert_eq!((Some(maps.version), maps.version), (surface.maps_version(), looks + 1));
    assert_eq!((maps.nx, maps.ny, maps.dx_mm), (96, 96, 1.0));
    // Cell (i, j) reaches from i - 48 to i - 47, so its centre lies half a mm off.
    for (cell, share) in maps.undersampled.values.iter().enumerate() {
        let (x, y) = ((cell % 96) as f64 - 47.5, (cell / 96) as f64 - 47.5);
        let hole = (9.0..21.0).contains(&x) && (9.0..21.0).contains(&y);
        if [x, y].iter().all(|place| [9.5, 20.5].contains(place)) {
            // A triangle of the raster reaches into its corners.
            continue;
        }
        assert_eq!(share.unwrap() > 0.5, hole, "({x}, {y}): {share:?}");
        let gap_mm = maps.gap_mm.values[cell].unwrap();
        assert_eq!(gap_mm > 1.0, hole, "({x}, {y}): {gap_mm}");
        if !hole {
            assert!((gap_mm - 0.5_f64.sqrt()).abs() < 1e-3, "({x}, {y}): {gap_mm}");
        }
        assert_eq!(maps.epsilon.values[cell], Some(0.0), "a plane has no curvature");
    }
    let sigma_nm = maps.noise_sigma_nm.unwrap();
    assert!((20.0..100.0).contains(&sigma_nm), "a waffle of ±50 nm has noise of {sigma_nm} nm");
    // 2σ/h of a raster of 1 mm.
    let tilt_mrad = maps.tilt_mrad.values[0].unwrap();
    assert!((tilt_mrad - 2e-3 * sigma_nm).abs() < 1e-3 * tilt_mrad, "{tilt_mrad}");
}

#[test]
fn sections_are_to_be_had_while_points_arrive_and_break_at_a_hole() {
    let request = SectionRequest::Line { from_mm: [-47.0, 15.0], to_mm: [47.0, 15.0] };
    let mut pipeline = Pipeline::new(parse("part.toml", BLOCK).unwrap());
    assert_eq!(pipeline.section(&request), None, "there is no vertex");
    block().for_each(|point| pipeline.take_position(point));
    pipeline.figures();
    let running = pipeline.section(&request).unwrap().unwrap();
    let finished = pipeline.finish().surface.section(&request).unwrap().unwrap();
    for found in [&running, &finished] {
        let [before, after] = &found.pieces[..] else { panic!("{:?}", found.pieces) };
        assert_eq!((before.from_s_mm, before.to_s_mm, before.ends), (0.0, 56.0, "gap"));
        assert_eq!(after.from_s_mm, 68.0);
        let deviation = found.deviation.unwrap();
        assert!((deviation.pv_nm - 100.0).abs() < 1.0, "{deviation:?}");
        let known = found.points.as_ref().unwrap().deviation_nm.as_ref().unwrap();
        assert!(known.iter().all(Option::is_some));
    }
    assert!(running.pieces[1].to_s_mm <= finished.pieces[1].to_s_mm);
    let nowhere = SectionRequest::Line { from_mm: [1.0, 1.0], to_mm: [1.0, 1.0] };
    let mut pipeline = Pipeline::new(parse("part.toml", BLOCK).unwrap());
    block().for_each(|point| pipeline.take_position(point));
    pipeline.figures();
    assert!(pipeline.section(&nowhere).unwrap().is_err());
}

/// A disc of 20 mm radius on a lattice of 0.4 mm with waves of 9 mm, 100 nm high, without what lies in `missing`.
fn waves(missing: impl Fn(f64, f64) -> bool) -> Vec<PointMm> {
    let lattice = (0..10_000).map(|index| {
        let [x, y] = [index % 100, index / 100].map(|step| 0.4 * f64::from(step) - 19.8);
        let wave = (0.7 * x).sin() * (0.7 * y).cos();
        [x, y, 1e-4 * wave]
    });
    lattice.filter(|[x, y, _]| x.hypot(*y) <= 20.0 && !missing(*x, *y)).collect()
}

const DISC: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 20\n\
                    [sampling]\ngap_limit_mm = 0.4\ncoverage_min = 0.5\n[tolerance]\n";

#[test]
fn what_hides_between_the_points_is_bounded_and_counts() {
    let of =
        |limits: &str| measured(&format!("{DISC}{limits}"), waves(|_, _| false).into_iter()).report;
    let report = of("pv_nm = 230\nrms_nm = 60\n");
    let found = report.form.as_ref().unwrap().deviation.unmeasured.clone().unwrap();
    // 100 nm times 0.7², squared in both directions, seen by groups of some 3 mm; the gap of a square of 0.4 mm, at the rim up to what is allowed.
    let bend = found.bend_nm_per_mm2.unwrap();
    assert!((0.8..1.001).contains(&(bend / 49.0)), "{found:?}");
    assert!((0.28..=0.4).contains(&found.gap_mm.unwrap()), "{found:?}");
    let between_nm = found.between_nm.unwrap();
    assert!((1.0..4.0).contains(&between_nm) && found.pv_hidden_nm == Some(2.0 * between_nm));
    assert!(found.share.unwrap() < 0.02 && found.unknown.is_empty(), "{found:?}");
    assert_eq!(report.verdict.status, Status::Pass, "{:?}", report.verdict);
    assert_eq!(report.verdict.checks[0].hidden, found.pv_hidden_nm);
    // A limit nearer than what hides is neither kept nor broken.
    let pv_nm = report.form.as_ref().unwrap().deviation.pv_nm;
    let near = of(&format!("pv_nm = {}\n", pv_nm + between_nm)).verdict;
    assert_eq!(near.status, Status::Undecided);
    assert!(near.reasons[0].contains("may stand out between points"), "{near:?}");
    assert!(!near.checks[0].ok && near.checks[0].doubt.is_some() && !near.checks[0].is_broken());
    assert_eq!(of(&format!("pv_nm = {}\n", pv_nm - 1.0)).verdict.status, Status::Fail);
}

#[test]
fn a_sector_nobody_measured_may_hold_the_extremes_and_adds_to_the_rms() {
    let half = |limits: &str| {
        measured(&format!("{DISC}{limits}"), waves(|x, y| x > 8.0 && y > 0.0).into_iter()).report
    };
    // Where no probability is asked for, the coverage that is wanted says how much may be missing.
    assert_eq!(half("pv_nm = 500\n").verdict.status, Status::Pass);
    let report = half("pv_nm = 500\nguard_probability = 0.95\n");
    let found = report.form.unwrap().deviation.unmeasured.unwrap();
    assert!((0.1..0.2).contains(&found.share.unwrap()), "{found:?}");
    assert_eq!(found.extreme_missed_p, Some(2.0 * found.share.unwrap()));
    assert_eq!(report.verdict.status, Status::Undecided);
    assert!(report.verdict.reasons[0].contains("hold an extreme"), "{:?}", report.verdict);
    let wide = half("rms_nm = 80\n").verdict;
    assert_eq!(wide.status, Status::Pass, "{wide:?}");
    let rms_nm = wide.checks[0].value;
    let hidden_nm = wide.checks[0].hidden.unwrap();
    assert!((1.0..15.0).contains(&hidden_nm), "{hidden_nm}");
    let near = half(&format!("rms_nm = {}\n", rms_nm + 0.5 * hidden_nm)).verdict;
    assert_eq!(near.status, Status::Undecided, "{near:?}");
}

#[test]
fn zones_are_judged_and_their_figures_told() {
    let zones = "[[tolerance.zone]]\nouter_mm = 10\nrms_nm = 60\npv_nm = 100\n\
                 [[tolerance.zone]]\ninner_mm = 10\nouter_mm = 20\nrms_nm = 60\n";
    let report =
        measured(&format!("{DISC}pv_nm = 250\n{zones}"), waves(|_, _| false).into_iter()).report;
    assert_eq!(report.verdict.status, Status::Fail, "{:?}", report.verdict);
    let names: Vec<(&str, bool)> =
        report.verdict.checks.iter().map(|check| (&check.figure.name[..], check.ok)).collect();
    assert_eq!(
        names,
        [
            ("pv_nm", true),
            ("pv_nm 0-10 mm", false),
            ("rms_nm 0-10 mm", true),
            ("rms_nm 10-20 mm", true)
        ]
    );
    let form = report.form.unwrap();
    let of_ring: Vec<_> =
        form.figures.iter().filter(|figure| figure.variant.starts_with("from ")).collect();
    assert_eq!(of_ring.len(), 3, "{of_ring:?}");
    assert_eq!(of_ring[2].value, report.verdict.checks[3].value);
    assert!(of_ring[2].variant.starts_with("from 10 to 20 mm"));
    // Limits of zones ask for uncertainties, but name no source of error beside the noise.
    assert_eq!(form.deviation.uncertainty.unwrap().model, "noise only");
}

#[test]
fn without_a_budget_pv_and_rms_have_the_uncertainty_of_the_noise() {
    let report =
        measured("[surface]\nkind = \"plane\"\n[tolerance]\nrms_nm = 500\n", noisy_bowl()).report;
    let form = report.form.unwrap();
    let told = form.deviation.uncertainty.unwrap();
    assert_eq!((&told.model[..], told.draws, told.pv_at_most), ("noise only", None, true));
    assert!((told.noise_nm - 10.0).abs() < 1.0, "{told:?}");
    assert_eq!(report.verdict.checks[0].u, Some(told.u_rms_nm));
    let pv = form.figures.iter().find(|figure| figure.name == "PV").unwrap();
    assert_eq!(pv.u, Some(told.u_pv_nm));
}

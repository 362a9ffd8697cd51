//! Bodies whose form, area, volume and openings are known exactly, with noise of known size.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod bodies;
mod independent;
mod reductions;
mod sections;

use asphera_geometry::PointMm;
use asphera_measure::{Along, Measurement, Part, Pipeline, Wanted, sampling_of_points};
use asphera_nominal::parse;
use asphera_report::{Report, Status};

use self::bodies::{Turn, ball, cap, directions, noisy, torus, tube};

fn part(text: &str) -> Part {
    parse("part.toml", text).unwrap()
}

fn sphere(radius_mm: f64, rest: &str) -> Part {
    part(&format!("[surface]\nkind = \"sphere\"\nradius_mm = {radius_mm}\n{rest}"))
}

fn measured(part: Part, along: Along, points: &[PointMm]) -> Measurement {
    let mut pipeline = Pipeline::along(part, along);
    pipeline.take_positions(points.iter().copied());
    pipeline.finish()
}

fn report(part: Part, points: &[PointMm]) -> Report {
    measured(part, Along::NONE, points).report
}

const LIMITS: &str =
    "[sampling]\nepsilon_limit = 0.05\n[tolerance]\npv_nm = 2000.0\nrms_nm = 60.0\n";

#[test]
fn a_whole_ball_is_closed_and_has_its_radius_its_noise_and_a_pass() {
    let points = noisy(ball(20_000, 10.0), [0.0; 3], 50e-6);
    let found = report(sphere(10.0, LIMITS), &points);
    let mesh = found.mesh.reconstruction.clone().unwrap();
    assert_eq!((mesh.facets, mesh.genus, mesh.components), (2 * 20_000 - 4, Some(0), 1));
    assert!(mesh.closed && mesh.orientable && mesh.manifold && mesh.border_loops.is_empty());
    assert_eq!(mesh.betti, Some([1, 0, 1]));
    let (area, volume) = (400.0 * std::f64::consts::PI, 4000.0 / 3.0 * std::f64::consts::PI);
    assert!((mesh.area_mm2 / area - 1.0).abs() < 1e-3, "{}", mesh.area_mm2);
    assert!((mesh.volume_mm3.unwrap() / volume - 1.0).abs() < 1e-3, "{:?}", mesh.volume_mm3);
    let form = found.form.unwrap();
    assert!((form.deviation.rms_nm - 50.0).abs() < 1.0, "{}", form.deviation.rms_nm);
    let known = form.deviation.uncertainty.unwrap();
    assert!((known.noise_nm - 50.0).abs() < 2.0, "{}", known.noise_nm);
    assert!(known.u_rms_nm > 0.0 && known.noise_measured);
    let by_area = form.figures.iter().find(|figure| figure.id == "rms_by_area").unwrap();
    assert!((by_area.value - 50.0).abs() < 2.0, "{}", by_area.value);
    assert_eq!((found.sampling.coverage, found.sampling.next.len()), (Some(1.0), 0));
    assert!(found.sampling.epsilon_max.unwrap() < 0.02, "{:?}", found.sampling.epsilon_max);
    assert_eq!(found.verdict.status, Status::Pass, "{:?}", found.verdict);
    assert_eq!(found.points.used, 20_000);
}

#[test]
fn a_free_radius_is_found_and_one_that_is_held_tells_of_size() {
    let points = noisy(ball(8_000, 10.0), [5.0, -3.0, 100.0], 0.0);
    let free = "[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\", \"radius\"]\n";
    let form = report(sphere(9.999, free), &points).form.unwrap();
    let parameters = &form.fit.parameters;
    assert!((parameters["radius"].value - 10.0).abs() < 1e-9, "{parameters:?}");
    assert!((parameters["centre_z"].value - 100.0).abs() < 1e-9);
    assert!(form.deviation.pv_nm < 1e-3, "{}", form.deviation.pv_nm);
    // A ball that is 1 µm too large stands out by that everywhere.
    let held = report(sphere(9.999, ""), &points).form.unwrap().deviation;
    assert!((held.rms_nm - 1000.0).abs() < 1e-3 && held.pv_nm < 0.05, "{held:?}");
    assert!((held.min_nm - 1000.0).abs() < 0.05);
}

#[test]
fn a_wave_of_known_height_has_its_range_its_sign_and_its_place() {
    // 300 nm of the sixth Legendre polynomial: 1 at both poles, -0.41 at the least, RMS 1/√13.
    let wave = |z: f64| (231.0 * z.powi(6) - 315.0 * z.powi(4) + 105.0 * z * z - 5.0) / 16.0;
    let points: Vec<PointMm> = directions(20_000)
        .map(|way| way.map(|side| (10.0 + 300e-6 * wave(way[2])) * side))
        .collect();
    let form = report(sphere(10.0, ""), &points).form.unwrap();
    let deviation = &form.deviation;
    assert!((deviation.rms_nm - 300.0 / 13.0_f64.sqrt()).abs() < 0.1, "{}", deviation.rms_nm);
    assert!((deviation.max_nm - 300.0).abs() < 0.5, "{}", deviation.max_nm);
    assert!((deviation.min_nm + 0.414_8 * 300.0).abs() < 0.5, "{}", deviation.min_nm);
    let [x, y, z] = form.fit.pose.to_measured(deviation.at_max_mm);
    assert!(x.hypot(y) < 0.2 && z.abs() > 9.99, "{x} {y} {z}");
}

#[test]
fn half_a_ball_is_open_and_says_what_is_missing_and_from_where() {
    let half: Vec<PointMm> = ball(20_000, 10.0).into_iter().filter(|at| at[2] > 0.0).collect();
    let found = report(sphere(10.0, LIMITS), &half);
    let mesh = found.mesh.reconstruction.unwrap();
    assert!(!mesh.closed && mesh.volume_mm3.is_none());
    assert_eq!(mesh.border_loops.len(), 1);
    let border = &mesh.border_loops[0];
    assert!((border.length_mm / (20.0 * std::f64::consts::PI) - 1.0).abs() < 0.1);
    assert!(border.is_gap);
    let coverage = found.sampling.coverage.unwrap();
    assert!((coverage - 0.5).abs() < 0.01, "{coverage}");
    let next = &found.sampling.next[0];
    let approach = next.approach.unwrap();
    assert!(approach[2] < -0.99 && next.at_mm[2] < -9.9, "{next:?}");
    assert!((next.area_mm2 / (200.0 * std::f64::consts::PI) - 1.0).abs() < 0.02, "{next:?}");
    assert!((next.adds_coverage.unwrap() - 0.5).abs() < 0.01);
    assert_eq!(found.verdict.status, Status::Undecided);
    assert!(found.verdict.reasons.iter().any(|why| why.contains("sampled densely enough")));
}

#[test]
fn a_hole_is_a_gap_with_its_place_area_and_approach() {
    let out: [f64; 3] = [0.6, 0.0, 0.8];
    let pierced: Vec<PointMm> = ball(30_000, 10.0)
        .into_iter()
        .filter(|at| at.iter().zip(&out).map(|(a, b)| a * b).sum::<f64>() < 9.9)
        .collect();
    let found = report(sphere(10.0, LIMITS), &pierced);
    assert_eq!(found.sampling.holes, Some(1));
    let next = &found.sampling.next[0];
    // A cap of a sphere of height 0.1.
    let area = std::f64::consts::TAU * 10.0 * 0.1;
    assert!((next.area_mm2 / area - 1.0).abs() < 0.15, "{} {area}", next.area_mm2);
    let approach = next.approach.unwrap();
    assert!(approach.iter().zip(&out).map(|(a, b)| a * b).sum::<f64>() > 0.999, "{approach:?}");
    let missing = 1.0 - found.sampling.coverage.unwrap();
    assert!((missing / 0.005 - 1.0).abs() < 0.15, "{missing}");
}

#[test]
fn a_tube_has_two_rims_and_no_gap_and_the_area_of_its_wall() {
    let turn = Turn::about([0.3, -0.5, 0.8], 1.1);
    let points: Vec<PointMm> =
        tube(30_000, 5.0, 20.0).into_iter().map(|at| turn.moved(at, [100.0, -50.0, 7.0])).collect();
    for (axis, free) in [("x", ""), ("y", ", \"radius\"")] {
        let text = format!(
            "[surface]\nkind = \"cylinder\"\nstraight_along = \"{axis}\"\nradius_mm = 5.0\n[fit]\nfree = [\"tx\", \"ty\", \"tz\", \"rx\", \"ry\"{free}]\n"
        );
        let found = report(part(&text), &points);
        let mesh = found.mesh.reconstruction.unwrap();
        assert_eq!((mesh.border_loops.len(), mesh.genus), (2, Some(0)), "{axis}");
        assert!(mesh.border_loops.iter().all(|border| !border.is_gap));
        assert_eq!((found.sampling.coverage, found.sampling.holes), (Some(1.0), Some(0)));
        let area = 200.0 * std::f64::consts::PI;
        assert!((mesh.area_mm2 / area - 1.0).abs() < 0.02, "{}", mesh.area_mm2);
        let form = found.form.unwrap();
        assert!(form.deviation.pv_nm < 1e-3, "{axis}: {}", form.deviation.pv_nm);
        if let Some(radius) = form.fit.parameters.get("radius") {
            assert!((radius.value - 5.0).abs() < 1e-9);
        }
    }
}

#[test]
fn a_torus_has_its_topology_area_volume_and_feature_size_and_no_form() {
    let points = noisy(torus(40_000, 10.0, 3.0), [0.0; 3], 10e-6);
    let found = report(sphere(10.0, ""), &points);
    let mesh = found.mesh.reconstruction.clone().unwrap();
    assert_eq!((mesh.genus, mesh.betti), (Some(1), Some([1, 2, 1])));
    let pi = std::f64::consts::PI;
    assert!((mesh.area_mm2 / (4.0 * pi * pi * 30.0) - 1.0).abs() < 2e-3, "{}", mesh.area_mm2);
    assert!((mesh.volume_mm3.unwrap() / (2.0 * pi * pi * 90.0) - 1.0).abs() < 4e-3);
    // A torus is no sphere, and that is said.
    assert_eq!(found.verdict.status, Status::Undecided);
    assert!(found.verdict.reasons.iter().any(|why| why.contains("none of this shape")));
    // Without a nominal its feature size is the radius of the tube.
    let sampling = sampling_of_points(points, Along::NONE, Wanted::default()).figures;
    let lfs_mm = sampling.lfs_min_mm.unwrap();
    assert!((lfs_mm - 3.0).abs() < 0.3, "{lfs_mm} {:?}", sampling.unknown);
    assert_eq!(sampling.lfs_source.as_deref(), Some("measured"));
}

#[test]
fn two_balls_half_a_millimetre_apart_are_two_surfaces_and_no_verdict() {
    let mut points = ball(10_000, 5.0);
    points.extend(ball(10_000, 5.0).into_iter().map(|[x, y, z]| [x + 10.5, y, z]));
    let found = report(sphere(5.0, LIMITS), &points);
    let mesh = found.mesh.reconstruction.unwrap();
    assert_eq!((mesh.components, mesh.closed, mesh.betti), (2, true, Some([2, 0, 2])));
    assert_eq!(found.verdict.status, Status::Undecided);
    assert!(found.verdict.reasons.iter().any(|why| why.contains("2 surfaces")));
}

#[test]
fn noise_above_the_spacing_is_a_finding_and_no_closed_surface_is_invented() {
    let found = report(sphere(10.0, LIMITS), &noisy(ball(5_000, 10.0), [0.0; 3], 0.6));
    assert_eq!(found.verdict.status, Status::Undecided, "{:?}", found.verdict);
    let reasons = found.verdict.reasons.join("; ");
    assert!(reasons.contains("points lie too far apart") || reasons.contains("noise"), "{reasons}");
}

#[test]
fn few_or_flat_points_are_told_of() {
    for points in [vec![], vec![[1.0, 2.0, 3.0]], vec![[0.0; 3], [1.0, 0.0, 0.0]]] {
        let found = report(sphere(10.0, LIMITS), &points);
        assert_eq!(found.verdict.status, Status::Undecided, "{points:?}");
        assert!(found.sampling.coverage.is_none() && !found.verdict.reasons.is_empty());
        let text = serde_json::to_string(&found).unwrap();
        assert!(!text.contains("NaN") && !text.contains("inf\""), "{text}");
    }
    // A raster in the plane is a plane in space too.
    let flat: Vec<PointMm> =
        (0..900).map(|at| [f64::from(at % 30), f64::from(at / 30), 0.0]).collect();
    let found = report(part("[surface]\nkind = \"plane\"\n[tolerance]\npv_nm = 1.0\n"), &flat);
    assert_eq!(found.verdict.status, Status::Pass, "{:?}", found.verdict);
    let mesh = found.mesh.reconstruction.unwrap();
    assert!((mesh.area_mm2 - 841.0).abs() < 1e-9 && !mesh.closed);
}

#[test]
fn order_batches_and_duplicates_change_no_bit() {
    let points = noisy(ball(4_000, 10.0), [1.0, 2.0, 3.0], 1e-4);
    let mut first = report(sphere(10.0, LIMITS), &points);
    let mut turned: Vec<PointMm> = points.iter().rev().copied().collect();
    turned.extend_from_slice(&points[..7]);
    let mut second = report(sphere(10.0, LIMITS), &turned);
    assert_eq!(second.points.duplicates, 7);
    for report in [&mut first, &mut second] {
        report.points = Default::default();
        report.sampling.as_of_points = 0;
        report.mesh.reconstruction.as_mut().unwrap().as_of_points = 0;
    }
    assert_eq!(first, second);
    let mut pipeline = Pipeline::along(sphere(10.0, LIMITS), Along::NONE);
    for batch in points.chunks(37) {
        batch.iter().for_each(|point| pipeline.take(*point, []));
        let _ = pipeline.figures();
    }
    let third = pipeline.finish().report;
    assert_eq!((third.form, third.verdict), (first.form, first.verdict));
}

#[test]
fn motions_and_far_places_leave_the_figures() {
    let points = noisy(ball(4_000, 10.0), [0.0; 3], 1e-4);
    let own = report(sphere(10.0, LIMITS), &points);
    for (axis, angle, shift) in [
        ([0.0, 0.0, 1.0], 0.7, [0.0; 3]),
        ([1.0, 2.0, -1.0], 2.0, [12.0, -7.0, 3.0]),
        ([0.0, 1.0, 0.0], 1.0, [1e5, 1e5, -1e5]),
    ] {
        let turn = Turn::about(axis, angle);
        let moved: Vec<PointMm> = points.iter().map(|at| turn.moved(*at, shift)).collect();
        let found = report(sphere(10.0, LIMITS), &moved);
        let of = |report: &Report| {
            let form = report.form.as_ref().unwrap();
            let mesh = report.mesh.reconstruction.as_ref().unwrap();
            (form.deviation.pv_nm, form.deviation.rms_nm, mesh.area_mm2, mesh.facets)
        };
        let (own, found) = (of(&own), of(&found));
        assert!((own.0 - found.0).abs() < 0.1 && (own.1 - found.1).abs() < 0.01, "{shift:?}");
        assert!((own.2 - found.2).abs() < 1e-6 && own.3 == found.3, "{own:?} {found:?}");
    }
}

#[test]
fn running_figures_depend_on_how_many_points_there_were_and_on_nothing_else() {
    let points = noisy(ball(3_000, 10.0), [0.0; 3], 1e-4);
    let at = |count: usize, asks: &[usize]| {
        let mut pipeline = Pipeline::along(sphere(10.0, LIMITS), Along::NONE);
        for (taken, point) in points[..count].iter().enumerate() {
            if asks.contains(&taken) {
                let _ = pipeline.figures();
            }
            pipeline.take(*point, []);
        }
        let running = pipeline.figures();
        (running.mesh, running.form, running.sampling, running.pending)
    };
    for count in [1, 499, 500, 624, 625, 1234, 2999] {
        let never = at(count, &[]);
        assert_eq!(never, at(count, &[3, 511, 512, 700, 1000, 2000]), "{count}");
        let as_of = never.0.reconstruction.map_or(0, |mesh| mesh.as_of_points);
        assert_eq!(as_of + never.3, count as u64);
        assert_eq!(as_of > 0, count >= 500);
    }
}

#[test]
fn auto_takes_the_plane_where_points_project_and_space_where_they_fold() {
    let dome = cap(8_000, 10.0, 0.5);
    let plain = measured(sphere(-10.0, ""), Along::Z, &dome).report;
    let auto = measured(sphere(-10.0, ""), Along::AUTO, &dome).report;
    assert!(auto.mesh.reconstruction.is_none() && auto.mesh.projectable);
    assert_eq!((&auto.form, &auto.verdict), (&plain.form, &plain.verdict));
    assert!(auto.mesh.decision.unwrap().contains("the points project along z"));
    let whole = noisy(ball(8_000, 10.0), [0.0; 3], 1e-5);
    let auto = measured(sphere(10.0, ""), Along::AUTO, &whole).report;
    let none = measured(sphere(10.0, ""), Along::NONE, &whole).report;
    assert_eq!(auto.form, none.form);
    let mesh = auto.mesh.reconstruction.unwrap();
    assert!(mesh.closed && mesh.reason.contains("does not project"), "{}", mesh.reason);
    assert_eq!(auto.points.used, 8_000);
}

//! Parts that face elsewhere than z: their figures are those of the same part facing z.

use asphera_form::Pose;
use asphera_report::{PoseFigures, Report, Status};

use super::*;
use crate::nominal::parse;
use crate::{Measurement, Pipeline};

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 20\n\
    [aperture]\nshape = \"circle\"\nradius_mm = 8\n[tolerance]\npv_nm = 100\n\
    [sampling]\ngap_limit_mm = 0.6\n";
const ASPHERE: &str = "[surface]\nkind = \"asphere\"\nradius_mm = 11.65\nconic = -1.1\nA4 = 3.69e-5\n\
    [aperture]\nshape = \"rectangle\"\nwidth_mm = 10\nheight_mm = 8\n[tolerance]\npv_nm = 100\n";
const FLAT: &str = "[surface]\nkind = \"plane\"\n[aperture]\nshape = \"circle\"\nradius_mm = 8\n\
    [tolerance]\npv_nm = 100\n[sampling]\ngap_limit_mm = 0.6\n";

/// 60° from z, towards 30° from x to y.
fn tilted() -> [f64; 3] {
    let (sine, cosine) = 60.0_f64.to_radians().sin_cos();
    let (y, x) = 30.0_f64.to_radians().sin_cos();
    [sine * x, sine * y, cosine]
}

fn turned(normal: [f64; 3]) -> Plane {
    Plane::new([0.0; 3], normal).unwrap()
}

/// Points all over a disc of 9 mm, no four on a circle, the first of them as well spread as all, on a
/// surface with up to 40 nm of form error.
fn disc(count: u64, sag_mm: impl Fn(f64) -> f64) -> Vec<PointMm> {
    (0..count)
        .map(|step| {
            // 1009 has no divisor in common with the counts in use.
            let index = (step * 1009 % count) as f64;
            let radius = 9.0 * ((index + 0.5) / count as f64).sqrt();
            let (sine, cosine) = (2.399_963_229_728_653 * index).sin_cos();
            let (x, y) = (radius * cosine, radius * sine);
            let error_mm = 4e-5 * (0.9 * x + 0.3).sin() * (0.7 * y - 0.2).cos();
            [x, y, sag_mm(radius * radius) + error_mm]
        })
        .collect()
}

fn sphere() -> Vec<PointMm> {
    disc(4000, |r2| 20.0 - (400.0 - r2).sqrt())
}

fn asphere() -> Vec<PointMm> {
    disc(4000, |r2| {
        r2 / 11.65 / (1.0 + (1.0 + 0.1 * r2 / 11.65 / 11.65).sqrt()) + 3.69e-5 * r2 * r2
    })
}

fn measured(part: &str, along: Along, points: &[PointMm]) -> Measurement {
    let mut pipeline = Pipeline::along(parse("part.toml", part).unwrap(), along);
    points.iter().for_each(|point| pipeline.take_position(*point));
    pipeline.finish()
}

fn facing(plane: &Plane, points: &[PointMm]) -> Vec<PointMm> {
    points.iter().map(|point| plane.from_plane(*point)).collect()
}

fn near(found: f64, expected: f64, tolerance: f64) -> bool {
    (found - expected).abs() <= tolerance
}

fn all_near(found: &[f64], expected: &[f64], tolerance: f64) -> bool {
    found.iter().zip(expected).all(|(found, expected)| near(*found, *expected, tolerance))
}

fn assert_same_form(found: &Report, expected: &Report, tolerance_nm: f64) {
    let (found, expected) =
        (&found.form.as_ref().unwrap().deviation, &expected.form.as_ref().unwrap().deviation);
    for (found, expected) in [
        (found.rms_nm, expected.rms_nm),
        (found.pv_nm, expected.pv_nm),
        (found.max_nm, expected.max_nm),
        (found.min_nm, expected.min_nm),
    ] {
        assert!(near(found, expected, tolerance_nm), "{found} nm, facing z {expected} nm");
    }
}

fn pose(figures: &PoseFigures) -> Pose {
    let PoseFigures { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad } = *figures;
    Pose { tx_mm, ty_mm, tz_mm, rx_rad, ry_rad, rz_rad }
}

#[test]
fn a_pose_of_a_report_moves_places_as_the_pose_of_the_fit_does() {
    let figures = PoseFigures {
        tx_mm: 0.1,
        ty_mm: -3.7,
        tz_mm: 11.0,
        rx_rad: 0.3,
        ry_rad: -1.1,
        rz_rad: 2.9,
    };
    for place_mm in [[0.0; 3], [1.0, -2.0, 3.3], [-12.5, 0.1, 1e3]] {
        assert_eq!(figures.to_measured(place_mm), pose(&figures).to_measured(place_mm));
    }
}

#[test]
fn a_given_direction_gives_the_figures_of_a_part_that_faces_z() {
    for (part, points) in [(SPHERE, sphere()), (ASPHERE, asphere()), (FLAT, disc(4000, |_| 0.0))] {
        let expected = measured(part, Along::Z, &points);
        assert_eq!(expected.report.verdict.status, Status::Pass, "{:?}", expected.report.verdict);
        for normal in [tilted(), [1.0, 0.0, 0.0], [-0.3, 0.8, -2.0], [0.0, 0.0, -1.0]] {
            let plane = turned(normal);
            let along = Along::direction(normal).unwrap();
            let found = measured(part, along, &facing(&plane, &points));
            assert_eq!(found.triangles, expected.triangles);
            assert_eq!(found.report.points, expected.report.points);
            assert_same_form(&found.report, &expected.report, 1e-5);
            let (mesh, flat) = (&found.report.mesh, &expected.report.mesh);
            assert_eq!((mesh.vertices, mesh.triangles), (flat.vertices, flat.triangles));
            assert_eq!((mesh.edges, mesh.hull), (flat.edges, flat.hull));
            assert!(near(mesh.area_mm2.unwrap(), flat.area_mm2.unwrap(), 1e-10));
            let (sampling, flat) = (&found.report.sampling, &expected.report.sampling);
            for (found, expected) in [
                (sampling.coverage, flat.coverage),
                (sampling.gap_max_mm, flat.gap_max_mm),
                (sampling.epsilon_max, flat.epsilon_max),
                (sampling.hole_max_mm2, flat.hole_max_mm2),
            ] {
                let [found, expected] = [found, expected].map(Option::unwrap_or_default);
                // The aperture is foreshortened by the tilt left, some 1e-5 rad, along z it is not.
                assert!(near(found, expected, 1e-8), "{sampling:?}, facing z {flat:?}");
            }
            assert_eq!((sampling.islands, sampling.holes), (flat.islands, flat.holes));
            assert_eq!(found.report.verdict.status, Status::Pass);
            assert_eq!(mesh.projection, Some(ProjectionFigures::Given { plane: figures(&plane) }));
        }
    }
}

#[test]
fn places_and_pose_are_those_of_the_measured_frame() {
    let plane = turned(tilted());
    let points = facing(&plane, &asphere());
    let found = measured(ASPHERE, Along::direction(tilted()).unwrap(), &points);
    for (vertex, point) in found.points_mm.iter().zip(&points) {
        assert!(all_near(vertex, point, 1e-14), "{vertex:?}, measured {point:?}");
    }
    let form = found.report.form.unwrap();
    let pose = pose(&form.fit.pose);
    // The vertex lies at the origin and the axis along the normal, but for the form error.
    assert!(all_near(&pose.to_measured([0.0; 3]), &[0.0; 3], 1e-3), "{pose:?}");
    let axis = pose.to_measured([0.0, 0.0, 1.0]);
    assert!(all_near(&axis, &tilted(), 1e-3), "{pose:?}");
    // Against the plane the part lies straight; against z by 60°.
    assert!(form.fit.parameters["rx"].value.abs() < 1e-4);
    assert!(near(pose.rotation()[2][2].acos().to_degrees(), 60.0, 0.01));
    // The place of the largest deviation is where a measured point is.
    let at_mm = pose.to_measured(form.deviation.at_max_mm);
    assert!(points.iter().any(|point| all_near(point, &at_mm, 1e-12)), "{at_mm:?}");
}

#[test]
fn a_fitted_plane_gives_the_figures_of_a_part_that_faces_z() {
    let plane = turned(tilted());
    let along = Along::fitted(1000).unwrap();
    let flat = disc(4000, |_| 0.0);
    let expected = measured(FLAT, Along::Z, &flat);
    let found = measured(FLAT, along, &facing(&plane, &flat));
    assert_same_form(&found.report, &expected.report, 1e-5);
    assert_eq!(found.report.points, expected.report.points);
    assert_eq!(found.report.mesh.triangles, expected.report.mesh.triangles);
    let areas = [&found, &expected].map(|measurement| measurement.report.mesh.area_mm2.unwrap());
    assert!(near(areas[0], areas[1], 1e-7));
    assert_eq!(found.report.verdict.status, Status::Pass);
    let Some(ProjectionFigures::Fitted { plane, points: 1000 }) = &found.report.mesh.projection
    else {
        panic!("{:?}", found.report.mesh.projection)
    };
    assert!(all_near(&plane.normal, &tilted(), 1e-5), "{plane:?}");

    // The axis of a sphere is where the first points say; without an aperture that matters to no figure.
    let part =
        SPHERE.replace("shape = \"circle\"\nradius_mm = 8", "shape = \"circle\"\nradius_mm = 12");
    let expected = measured(&part, Along::Z, &sphere());
    let found = measured(&part, along, &facing(&turned(tilted()), &sphere()));
    assert_same_form(&found.report, &expected.report, 1e-5);
    assert_eq!(found.report.points, expected.report.points);
    let areas = [&found, &expected].map(|measurement| measurement.report.mesh.area_mm2.unwrap());
    assert!(near(areas[0], areas[1], 1e-3 * areas[1]), "{areas:?}");
}

/// As one fitted from the first rows of a curved part would be.
#[test]
fn a_plane_askew_to_the_part_changes_no_figure_but_by_its_triangles() {
    // A rectangle's sides follow u and v.
    let part =
        ASPHERE.replace("rectangle\"\nwidth_mm = 10\nheight_mm = 8", "circle\"\nradius_mm = 7.5");
    let expected = measured(&part, Along::Z, &asphere()).report;
    for normal in [[0.1, -0.2, 1.0], [0.0, 0.6, 0.8]] {
        let found = measured(&part, Along::direction(normal).unwrap(), &asphere()).report;
        assert_same_form(&found, &expected, 1e-3);
        assert_eq!(found.points, expected.points);
        assert_eq!(found.mesh.relief.folds, []);
        let coverages = [&found, &expected].map(|report| report.sampling.coverage.unwrap());
        assert!(near(coverages[0], coverages[1], 0.01), "{normal:?}: {coverages:?}");
        let [axis_mm, expected_mm] = [&found, &expected].map(|report| {
            let pose = pose(&report.form.as_ref().unwrap().fit.pose);
            [[0.0; 3], [0.0, 0.0, 10.0]].map(|part_mm| pose.to_measured(part_mm))
        });
        for (found, expected) in axis_mm.iter().zip(&expected_mm) {
            assert!(all_near(found, expected, 1e-6), "{found:?}, along z {expected:?}");
        }
    }
}

/// Looking at the figures changes nothing, and says how far the plane is.
#[test]
fn points_wait_for_a_plane_and_lose_nothing() {
    let points = facing(&turned(tilted()), &sphere());
    let part = parse("part.toml", SPHERE).unwrap();
    let mut pipeline = Pipeline::along(part, Along::fitted(1000).unwrap());
    for (index, point) in points.iter().enumerate() {
        pipeline.take_position(*point);
        if index + 1 == 312 {
            let figures = pipeline.figures();
            let projection = figures.mesh.projection.unwrap();
            assert_eq!(projection.to_string(), "fitting the plane: 312 of 1000");
            assert_eq!((figures.pending, figures.points.received), (312, 312));
            assert!(pipeline.mesh().0.is_empty());
        }
        if index % 97 == 0 {
            pipeline.figures();
        }
    }
    let figures = pipeline.figures();
    assert!(figures.form.is_some() && figures.sampling.coverage.is_some());
    let vertex = pipeline.mesh().0[0];
    assert!(all_near(&vertex, &points[0], 1e-14), "{vertex:?}");
    let left_alone = measured(SPHERE, Along::fitted(1000).unwrap(), &points);
    assert_eq!(pipeline.finish().report, left_alone.report);
    assert_eq!(left_alone.report.points.received, 4000);
}

#[test]
fn a_line_at_the_beginning_is_waited_out() {
    let plane = turned(tilted());
    let line = (0..1500).map(|i| plane.from_plane([0.01 * f64::from(i) - 7.5, 8.95, 0.0]));
    let points: Vec<PointMm> = line.chain(facing(&plane, &disc(4000, |_| 0.0))).collect();
    let part = parse("part.toml", FLAT).unwrap();
    let mut pipeline = Pipeline::along(part, Along::fitted(1000).unwrap());
    points[..1200].iter().for_each(|point| pipeline.take_position(*point));
    let said = pipeline.figures().mesh.projection.unwrap().to_string();
    assert_eq!(said, "fitting the plane: 1200 of 2000; fewer determined none");
    let found = measured(FLAT, Along::fitted(1000).unwrap(), &points).report.mesh.projection;
    let Some(ProjectionFigures::Fitted { plane, points: 2000 }) = found else {
        panic!("{found:?}")
    };
    assert!(all_near(&plane.normal, &tilted(), 1e-5), "{plane:?}");
}

#[test]
fn a_measurement_that_ends_early_is_fitted_from_what_there_is() {
    let points = facing(&turned(tilted()), &disc(700, |_| 0.0));
    let report = measured(FLAT, Along::fitted(1000).unwrap(), &points).report;
    assert!(matches!(report.mesh.projection, Some(ProjectionFigures::Fitted { points: 700, .. })));
    assert_eq!(report.points.received, 700);
    assert!(report.points.used > 400);
}

#[test]
fn without_a_plane_the_mesh_is_along_z_and_the_verdict_undecided() {
    let line: Vec<PointMm> = (0..50).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    for (count, reason) in [
        (50, "points on a line do not determine a plane"),
        (2, "2 points do not determine a plane"),
        (0, "0 points do not determine a plane"),
    ] {
        let report = measured(FLAT, Along::fitted(1000).unwrap(), &line[..count]).report;
        assert_eq!(report.verdict.status, Status::Undecided);
        let said = format!(
            "projected along z, for no plane could be fitted from {count} points: {reason}"
        );
        assert!(
            report.verdict.reasons.iter().any(|reason| reason.starts_with(&said)),
            "{:?}",
            report.verdict.reasons
        );
        let text = serde_json::to_string(&report).unwrap();
        assert_eq!(serde_json::from_str::<Report>(&text).unwrap(), report);
    }
}

/// Tried at 3, 6, 12, … points; 3·2¹⁸ is the last such number below 2²⁰.
#[test]
fn waiting_for_a_plane_has_an_end() {
    let mut projector = Projector::new(Along::fitted(3).unwrap());
    let (mut given, mut most) = (0_u64, 0);
    for i in 0..800_000 {
        projector.take([f64::from(i), 1.0, 2.0].into(), |point, _| {
            assert_eq!(point.at_mm, [given as f64, 1.0, 2.0]);
            given += 1;
        });
        most = most.max(projector.waiting());
    }
    assert_eq!((given, most), (800_000, 3 * (1 << 18) - 1));
    assert!(matches!(projector, Projector::Unfitted { points: 786_432, .. }));
}

#[test]
fn readings_no_mesh_admits_do_not_turn_the_plane() {
    let points = facing(&turned(tilted()), &disc(4000, |_| 0.0));
    let clean = measured(FLAT, Along::fitted(1000).unwrap(), &points).report;
    let wild = [[2e12, 0.0, 0.0], [0.0, -1e300, 5.0], [f64::NAN, 0.0, 0.0]];
    let mixed: Vec<PointMm> =
        points[..10].iter().chain(&wild).chain(&points[10..]).copied().collect();
    let report = measured(FLAT, Along::fitted(1000).unwrap(), &mixed).report;
    assert_eq!(report.mesh, clean.mesh);
    assert_eq!(
        (report.points.flagged["not_meshable"], report.points.flagged["not_finite"]),
        (2, 1)
    );
}

#[test]
fn along_z_is_said_in_no_report_and_changes_no_bit() {
    let plain = {
        let mut pipeline = Pipeline::new(parse("part.toml", SPHERE).unwrap());
        sphere().iter().for_each(|point| pipeline.take_position(*point));
        pipeline.finish()
    };
    let given = measured(SPHERE, Along::direction([0.0, 0.0, 7.0]).unwrap(), &sphere());
    assert_eq!(plain.report, given.report);
    assert_eq!(plain.points_mm, sphere());
    assert!(!serde_json::to_string(&plain.report.mesh).unwrap().contains("\"plane\""));
    assert_eq!(plain.report.mesh.projection, None);
}

/// A shell of a cylinder about y, 150° wide and open towards 60° from z. Seen from 10° from z its flank
/// turns under itself.
#[test]
fn folds_of_another_plane_are_placed_and_cured_in_the_measured_frame() {
    let shell: Vec<PointMm> = (0..4_000_u32)
        .map(|i| {
            let (u, v) = (f64::from(i) / 4_000.0, (0.618_033_988_749_895 * f64::from(i)).fract());
            let angle = (60.0 - 75.0 + 150.0 * v).to_radians();
            [10.0 * angle.sin() + 3.0, 20.0 * u, 10.0 * angle.cos() - 4.0]
        })
        .collect();
    let direction = |degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Along::direction([sine, 0.0, cosine]).unwrap()
    };
    let part = "[surface]\nkind = \"plane\"\n";
    for degrees in [0.0, 10.0] {
        let report = measured(part, direction(degrees), &shell).report;
        let [fold, ..] = &report.mesh.relief.folds[..] else { panic!("{:?}", report.mesh) };
        // The place is the middle between two of the points, on sheets that hide each other.
        let sheets = shell.iter().enumerate().find_map(|(index, p)| {
            let middle = |q: &PointMm| std::array::from_fn::<f64, 3, _>(|i| 0.5 * (p[i] + q[i]));
            let other = shell[..index].iter().find(|q| all_near(&middle(q), &fold.at_mm, 1e-12));
            other.map(|q| [*p, *q])
        });
        let seen_from = |[x, _, z]: PointMm| (x - 3.0).atan2(z + 4.0).to_degrees() - degrees;
        let mut angles = sheets.expect("two points about the place").map(seen_from);
        angles.sort_by(f64::total_cmp);
        assert!(angles[0] > 40.0 && angles[0] < 90.0 && angles[1] > 90.0, "{fold:?}: {angles:?}");
        for axis in 0..3 {
            assert!(fold.min_mm[axis] <= fold.at_mm[axis] && fold.at_mm[axis] <= fold.max_mm[axis]);
        }
        let said = report.mesh.relief.projection.as_ref().unwrap();
        let rest = said.strip_prefix("projectable on the plane with normal ").expect(said);
        let (tilt, rest) = rest.split_once("° from z towards ").expect(said);
        let (azimuth, _) = rest.split_once('°').expect(said);
        let [tilt, azimuth] = [tilt, azimuth].map(|number| number.parse::<f64>().unwrap());
        assert!(near(tilt, 60.0, 2.0) && azimuth.abs() < 3.0, "{said}");
        assert_eq!(report.verdict.status, Status::Undecided);
        assert!(report.verdict.reasons.iter().any(|reason| reason.contains(said)));
    }
    let report = measured(part, direction(60.0), &shell).report;
    assert_eq!(report.mesh.relief.folds, []);
}

#[test]
fn what_the_command_line_takes() {
    assert_eq!("z".parse(), Ok(Along::Z));
    assert_eq!("fitted".parse(), Ok(Along::fitted(1000).unwrap()));
    assert_eq!("0, -1,2.5".parse(), Ok(Along::direction([0.0, -1.0, 2.5]).unwrap()));
    let refused = |word: &str| word.parse::<Along>().unwrap_err().to_string();
    for word in ["", "x", "1,2", "1,2,3,4", "1,2,drei", "Z"] {
        let said =
            format!("expected z, fitted, none, auto or three numbers nx,ny,nz, found `{word}`");
        assert_eq!(refused(word), said);
    }
    for word in ["0,0,-0", "nan,0,1", "inf,0,0"] {
        assert!(
            refused(word).starts_with("expected a direction of finite length above 0"),
            "{word}"
        );
    }
    assert_eq!(
        Along::fitted(2).unwrap_err().to_string(),
        "expected 3 to 1000000 points to fit a plane from, found 2"
    );
}

#[test]
fn statements_for_people() {
    let plane = figures(&turned([0.0, 3.0, 4.0]));
    assert_eq!(
        ProjectionFigures::Given { plane: plane.clone() }.to_string(),
        "normal (0, 0.6, 0.8), through (0, 0, 0) mm, as given"
    );
    assert_eq!(
        ProjectionFigures::Fitted { plane, points: 1000 }.to_string(),
        "normal (0, 0.6, 0.8), through (0, 0, 0) mm, fitted from 1000 points"
    );
}

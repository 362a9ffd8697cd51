//! Sections of bodies in space: circles and lines whose length is known, and the deviation along them.

use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_measure::{Along, Pipeline, PointsSurface, surface_of_points};
use asphera_report::{SectionReport, SectionRequest};

use super::bodies::{Turn, ball, directions, noisy, torus, tube};
use super::{LIMITS, measured, part, sphere};

fn plane(normal: [f64; 3], offset_mm: f64) -> SectionRequest {
    SectionRequest::Plane { normal, offset_mm }
}

/// The section of points of which nothing is known.
fn bare(points: &[PointMm], request: &SectionRequest) -> SectionReport {
    let surface = surface_of_points(points.iter().copied(), Along::NONE).unwrap();
    let PointsSurface::InSpace(surface) = surface else { panic!("in the plane") };
    let SectionRequest::Plane { normal, offset_mm } = *request else { panic!("{request:?}") };
    let plane = asphera_surface::sections::CuttingPlane::new(normal, offset_mm).unwrap();
    surface.cut(&plane, None, true).unwrap()
}

fn limits(found: &SectionReport) -> Vec<(&'static str, &'static str)> {
    found.pieces.iter().map(|piece| (piece.begins, piece.ends)).collect()
}

#[test]
fn a_ball_is_cut_in_a_circle_with_the_deviation_along_it() {
    // 300 nm of z² about the centre: along a parallel the deviation is the same everywhere, along a meridian it is that.
    let swell = |z: f64| 300e-6 * z * z;
    let points: Vec<PointMm> = directions(20_000)
        .map(|way| way.map(|side| (10.0 + swell(way[2])) * side))
        .map(|[x, y, z]| [x + 5.0, y, z - 2.0])
        .collect();
    let found = measured(sphere(10.0, ""), Along::NONE, &points);
    let laid_off_nm = |z: f64| 300.0 * z * z;
    for (request, radius_mm) in [
        (plane([0.0, 0.0, 2.0], 2.0 * 4.0), 8.0),
        (plane([1.0, 0.0, 0.0], 5.0), 10.0),
        (plane([0.6, 0.0, 0.8], 0.6 * 5.0 - 0.8 * 2.0 + 6.0), 8.0),
    ] {
        let cut = found.surface.section(&request).unwrap().unwrap();
        assert_eq!(limits(&cut), [("closed", "closed")], "{request:?}");
        let error = cut.length_mm / (TAU * radius_mm) - 1.0;
        assert!(error.abs() < 5e-4, "{request:?}: {error}");
        let columns = cut.points.as_ref().unwrap();
        let deviations_nm = columns.deviation_nm.as_ref().unwrap();
        for (at, nm) in deviations_nm.iter().enumerate() {
            let z = (columns.z_mm[at] + 2.0) / 10.0;
            // Free centre: z² has no first order, so nothing but a small shift is taken away by the fit.
            assert!((nm.unwrap() - laid_off_nm(z)).abs() < 8.0, "{nm:?} {z}");
        }
        assert!(cut.height.is_none() && cut.reasons.is_empty(), "{:?}", cut.reasons);
        assert_eq!(cut.deviation.unwrap().length_mm, cut.length_mm);
    }
    let outside = found.surface.section(&plane([0.0, 0.0, 1.0], 9.0)).unwrap().unwrap();
    assert!(outside.pieces.is_empty());
}

#[test]
fn a_torus_is_cut_in_two_circles_and_has_no_deviation() {
    let points = torus(40_000, 20.0, 6.0);
    let cut = bare(&points, &plane([0.0, 1.0, 0.0], 0.0));
    assert_eq!(limits(&cut), [("closed", "closed"); 2]);
    for piece in &cut.pieces {
        assert!((piece.to_s_mm / (TAU * 6.0) - 1.0).abs() < 2e-3, "{piece:?}");
    }
    let level = bare(&points, &plane([0.0, 0.0, 1.0], 0.0));
    assert_eq!(limits(&level), [("closed", "closed"); 2]);
    let mut lengths: Vec<f64> = level.pieces.iter().map(|piece| piece.to_s_mm).collect();
    lengths.sort_by(f64::total_cmp);
    assert!((lengths[0] / (TAU * 14.0) - 1.0).abs() < 2e-3, "{lengths:?}");
    assert!((lengths[1] / (TAU * 26.0) - 1.0).abs() < 2e-3, "{lengths:?}");
    assert_eq!((&cut.deviation, &cut.points.unwrap().deviation_nm), (&None, &None));
}

#[test]
fn an_open_tube_is_cut_in_lines_between_its_borders() {
    let turn = Turn::about([1.0, 2.0, -0.5], 0.7);
    let points: Vec<PointMm> =
        tube(20_000, 8.0, 30.0).into_iter().map(|at| turn.moved(at, [3.0, 4.0, 5.0])).collect();
    // The plane x = 2 of the tube, 2 mm from its axis.
    let normal = turn.moved([1.0, 0.0, 0.0], [0.0; 3]);
    let offset_mm = 2.0 + normal[0] * 3.0 + normal[1] * 4.0 + normal[2] * 5.0;
    let shaft = "[surface]\nkind = \"cylinder\"\nstraight_along = \"x\"\nradius_mm = 8.0\n";
    let found = measured(part(shaft), Along::NONE, &points);
    let cut = found.surface.section(&plane(normal, offset_mm)).unwrap().unwrap();
    assert_eq!(limits(&cut), [("border", "border"); 2]);
    for piece in &cut.pieces {
        assert!((piece.to_s_mm - 30.0).abs() < 0.5, "{piece:?}");
    }
    // Facets lie inside, and yet the deviation is that of their corners: nothing.
    let deviation = cut.deviation.unwrap();
    assert!(deviation.pv_nm < 1e-3, "{deviation:?}");
}

#[test]
fn a_section_depends_on_the_points_alone_and_is_to_be_had_while_they_arrive() {
    let points = noisy(ball(12_000, 10.0), [0.0; 3], 50e-6);
    let request = plane([0.2, 0.3, 0.9], 1.5);
    let finished = measured(sphere(10.0, LIMITS), Along::NONE, &points);
    let whole = finished.surface.section(&request).unwrap().unwrap();
    let backwards: Vec<PointMm> = points.iter().rev().copied().collect();
    let other = measured(sphere(10.0, LIMITS), Along::NONE, &backwards);
    assert_eq!(other.surface.section(&request).unwrap().unwrap(), whole);

    let mut pipeline = Pipeline::along(sphere(10.0, LIMITS), Along::NONE).expecting(Some(20_000));
    assert_eq!(pipeline.section(&request), None);
    pipeline.take_positions(points.iter().copied());
    pipeline.figures();
    let running = pipeline.section(&request).unwrap().unwrap();
    let so_far = pipeline.figures().mesh.reconstruction.unwrap().as_of_points;
    let of_as_many =
        measured(sphere(10.0, LIMITS), Along::NONE, &points[..usize::try_from(so_far).unwrap()]);
    assert_eq!(running, of_as_many.surface.section(&request).unwrap().unwrap());

    for (request, upright) in [
        (
            SectionRequest::Line { from_mm: [1.0, 2.0], to_mm: [3.0, 5.0] },
            "plane there is -3,2,0,1",
        ),
        (SectionRequest::Radius { centre_mm: None, angle_rad: TAU / 4.0 }, "there is -1,0,0,0"),
        (SectionRequest::Circle { centre_mm: [0.0; 2], radius_mm: 1.0 }, "by planes alone"),
        (plane([0.0; 3], 1.0), "plane with normal (0, 0, 0)"),
    ] {
        for answer in [pipeline.section(&request), finished.surface.section(&request)] {
            let why = answer.unwrap().unwrap_err().to_string();
            assert!(why.contains(upright), "{why}");
        }
    }
}

#[test]
fn points_are_cut_in_the_plane_or_in_space_as_they_fold() {
    let flat = (0..400).map(|at| [f64::from(at % 20), f64::from(at / 20), 0.0]);
    assert!(matches!(surface_of_points(flat, Along::AUTO), Ok(PointsSurface::InPlane { .. })));
    let points = ball(4_000, 10.0);
    let found = surface_of_points(points.iter().copied(), Along::AUTO);
    assert!(matches!(found, Ok(PointsSurface::InSpace(_))));
    let why = surface_of_points(points, Along::Z).err().unwrap();
    assert!(why.contains("does not project") && why.contains("--along none"), "{why}");
    let Ok(PointsSurface::InSpace(none)) = surface_of_points([[0.0; 3]; 3], Along::NONE) else {
        panic!("one place has no plane")
    };
    assert!(none.facets().is_empty());
}

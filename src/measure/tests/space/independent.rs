//! Figures worked out again from points and triangles alone, and gaps of shapes that have a rim.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_measure::{Along, Measurement};

use super::bodies::{ball, noisy, tube};
use super::{LIMITS, measured, part, report, sphere};

fn minus(a: PointMm, b: PointMm) -> PointMm {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn length(a: PointMm) -> f64 {
    a.iter().map(|side| side * side).sum::<f64>().sqrt()
}

/// Area by Heron, volume by the signed tetrahedra about a far place, and V − E + F.
fn sums(found: &Measurement) -> (f64, f64, i64) {
    let far = [37.0, -11.0, 5.0];
    let (mut area, mut volume) = (0.0, 0.0);
    let mut edges: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for &triangle in &found.triangles {
        let [a, b, c] = triangle.map(|corner| minus(found.points_mm[corner as usize], far));
        let [x, y, z] = [minus(a, b), minus(b, c), minus(c, a)].map(length);
        let half = (x + y + z) / 2.0;
        area += (half * (half - x) * (half - y) * (half - z)).max(0.0).sqrt();
        volume += (a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
            + a[2] * (b[0] * c[1] - b[1] * c[0]))
            / 6.0;
        let [i, j, k] = triangle;
        for [from, to] in [[i, j], [j, k], [k, i]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    assert!(edges.values().all(|&count| count == 2), "every edge has two triangles");
    let euler = found.points_mm.len() as i64 - edges.len() as i64 + found.triangles.len() as i64;
    (area, volume, euler)
}

#[test]
fn the_mesh_of_a_ball_is_that_which_the_report_tells_of() {
    let points = noisy(ball(6_000, 10.0), [3.0, 1.0, -2.0], 1e-4);
    let found = measured(sphere(10.0, LIMITS), Along::NONE, &points);
    let mesh = found.report.mesh.reconstruction.clone().unwrap();
    let (area, volume, euler) = sums(&found);
    assert!((area / mesh.area_mm2 - 1.0).abs() < 1e-6, "{area}");
    // Positive: corners turn counter-clockwise seen from outside.
    assert!((volume / mesh.volume_mm3.unwrap() - 1.0).abs() < 1e-9, "{volume}");
    assert_eq!(euler, 2 - 2 * mesh.genus.unwrap());
}

#[test]
fn the_deviations_are_distances_from_the_sphere_whose_centre_no_shift_makes_better() {
    let points = noisy(ball(6_000, 10.0), [3.0, 1.0, -2.0], 1e-4);
    let found = measured(sphere(10.0, ""), Along::NONE, &points);
    let form = found.report.form.unwrap();
    let centre = ["centre_x", "centre_y", "centre_z"].map(|name| form.fit.parameters[name].value);
    let mut gradient = [0.0; 3];
    let mut squares = 0.0;
    for (point, deviation_nm) in found.points_mm.iter().zip(&found.deviations_nm) {
        let way = minus(*point, centre);
        let off = length(way) - 10.0;
        assert!((1e6 * off - deviation_nm).abs() < 1e-5, "{off} {deviation_nm}");
        (0..3).for_each(|axis| gradient[axis] += off * way[axis] / length(way));
        squares += off * off;
    }
    assert!(gradient.iter().all(|sum| sum.abs() < 1e-9), "{gradient:?}");
    let rms_nm = 1e6 * (squares / 6_000.0).sqrt();
    assert!((rms_nm - form.deviation.rms_nm).abs() < 1e-6);
    // The centre of so many points of independent noise is known to σ·√(3/n).
    let u = form.fit.parameters["centre_x"].u.unwrap();
    assert!((u / (1e-4 * (3.0 / 6_000.0_f64).sqrt()) - 1.0).abs() < 0.05, "{u}");
    let far: Vec<f64> = (0..3).map(|axis| (centre[axis] - [3.0, 1.0, -2.0][axis]) / u).collect();
    assert!(far.iter().all(|times| times.abs() < 4.0), "{far:?}");
}

#[test]
fn a_hole_in_a_wall_is_a_gap_and_the_ends_are_rims() {
    // A window of 2 mm round and 3 mm along, halfway up.
    let window = |[x, y, z]: &PointMm| y.atan2(*x).abs() < 0.2 && (z - 10.0).abs() < 1.5;
    let points: Vec<PointMm> =
        tube(40_000, 5.0, 20.0).into_iter().filter(|at| !window(at)).collect();
    let text = "[surface]\nkind = \"cylinder\"\nstraight_along = \"y\"\nradius_mm = 5.0\n";
    let found = report(part(text), &points);
    let borders = found.mesh.reconstruction.unwrap().border_loops;
    assert_eq!((borders.len(), found.sampling.holes), (3, Some(1)));
    let next = &found.sampling.next[0];
    assert!((next.area_mm2 / (2.0 * 3.0) - 1.0).abs() < 0.2, "{}", next.area_mm2);
    let approach = next.approach.unwrap();
    assert!(approach[0] > 0.999, "{approach:?}");
    assert!((next.at_mm[2] - 10.0).abs() < 0.1 && (next.at_mm[0] - 5.0).abs() < 1e-6);
    let missing = 1.0 - found.sampling.coverage.unwrap();
    assert!((missing / (6.0 / (200.0 * std::f64::consts::PI)) - 1.0).abs() < 0.25, "{missing}");
}

#[test]
fn a_plate_with_a_hole_has_a_rim_and_a_gap() {
    let spiral = (0..30_000).map(|at| {
        let r = 20.0 * (f64::from(at) / 30_000.0).sqrt();
        let (sin, cos) = (f64::from(at) * 2.399_963_229_728_653).sin_cos();
        [r * cos, r * sin, 0.0]
    });
    let points: Vec<PointMm> =
        spiral.filter(|[x, y, _]| (x - 8.0).hypot(*y) > 2.0).map(|[x, y, z]| [z, x, y]).collect();
    let found = report(part("[surface]\nkind = \"plane\"\n"), &points);
    assert_eq!(found.sampling.holes, Some(1), "{:?}", found.mesh.reconstruction);
    let next = &found.sampling.next[0];
    assert!((next.area_mm2 / (4.0 * std::f64::consts::PI) - 1.0).abs() < 0.1, "{next:?}");
    assert!(next.approach.unwrap()[0].abs() > 0.999_999);
    assert!(found.form.unwrap().deviation.pv_nm < 1e-3);
}

#[test]
fn a_power_of_two_as_scale_scales_every_length() {
    let points = noisy(ball(3_000, 8.0), [1.0, 2.0, 3.0], 1e-4);
    let doubled: Vec<PointMm> = points.iter().map(|at| at.map(|side| 2.0 * side)).collect();
    let (own, twice) = (report(sphere(8.0, ""), &points), report(sphere(16.0, ""), &doubled));
    let (one, two) = (own.form.unwrap().deviation, twice.form.unwrap().deviation);
    assert!(
        (two.pv_nm - 2.0 * one.pv_nm).abs() < 1e-5 && (two.rms_nm - 2.0 * one.rms_nm).abs() < 1e-6
    );
    let meshes = [own.mesh, twice.mesh].map(|mesh| mesh.reconstruction.unwrap());
    assert_eq!(meshes[0].facets, meshes[1].facets);
    assert_eq!(4.0 * meshes[0].area_mm2, meshes[1].area_mm2);
    assert_eq!(own.sampling.coverage, twice.sampling.coverage);
}

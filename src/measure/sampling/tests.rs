//! The sampling of parts whose gaps are known.

use std::f64::consts::SQRT_2;

use super::*;
use crate::Pipeline;
use crate::nominal::parse;
use crate::random::Random;

const SPHERE: &str = "[surface]\nkind = \"sphere\"\nradius_mm = 20\n\
    [aperture]\nshape = \"rectangle\"\nwidth_mm = 8\nheight_mm = 6\n\
    [sampling]\ngap_limit_mm = 0.1\n";

/// Points of a sphere of radius 20 mm every 0.1 mm over 10 × 8 mm, as far as they are kept.
fn cap(keep: impl Fn([f64; 2]) -> bool) -> impl Iterator<Item = PointMm> {
    (0..101 * 81)
        .map(|index| [index % 101, index / 101].map(f64::from))
        .map(|[i, j]| [0.1 * i - 5.0, 0.1 * j - 4.0])
        .filter(move |&place| keep(place))
        .map(|[x, y]| [x, y, 20.0 - (400.0 - x * x - y * y).sqrt()])
}

fn measured(part: &str, points: impl Iterator<Item = PointMm>) -> crate::Measurement {
    let mut pipeline = Pipeline::new(parse("part.toml", part).unwrap());
    points.for_each(|point| pipeline.take_position(point));
    pipeline.finish()
}

#[test]
fn a_part_that_is_covered() {
    let found = measured(SPHERE, cap(|_| true)).report.sampling;
    assert_eq!((found.coverage, found.next.len(), found.next_more), (Some(1.0), 0, 0));
    assert_eq!(found.lfs_source.as_deref(), Some("nominal"));
    assert!((found.lfs_min_mm.unwrap() / 20.0 - 1.0).abs() < 5e-3, "{found:?}");
    // Half the diagonal of a square of the raster, a little more where the surface is steep.
    let gap_mm = 0.1 / SQRT_2;
    assert!((1.0..1.02).contains(&(found.gap_max_mm.unwrap() / gap_mm)), "{found:?}");
    assert!((found.epsilon_max.unwrap() * 20.0 / gap_mm - 1.0).abs() < 0.03, "{found:?}");
    assert!(found.noise_sigma_nm.unwrap() < 1.0, "{found:?}");
    assert!((found.spacing_median_mm.unwrap() / 0.1 - 1.0).abs() < 0.02, "{found:?}");
    assert_eq!(found.overdense_fraction, Some(0.0));
    assert!(found.unknown.is_empty() && found.at_max_mm.is_some(), "{found:?}");
    assert_eq!((found.undersampled_area_mm2, found.uncovered_area_mm2), (Some(0.0), Some(0.0)));
}

#[test]
fn a_rectangle_of_missing_points_is_the_first_region_and_lies_where_it_is() {
    let inside = |[x, y]: [f64; 2]| x > 0.95 && x < 2.05 && y > -1.05 && y < 1.05;
    let measurement = measured(SPHERE, cap(|place| !inside(place)));
    let found = &measurement.report.sampling;
    // Missing are the nodes from 1 to 2 and from -1 to 1: the region reaches to those about them.
    let expected_mm2 = 1.2 * 2.2;
    let [first] = &found.next[..] else { panic!("{found:?}") };
    assert!((first.area_mm2 / expected_mm2 - 1.0).abs() < 0.02, "{first:?}");
    let open_mm2 = found.uncovered_area_mm2.unwrap() + found.undersampled_area_mm2.unwrap();
    // What is within the limit of the samples about it is covered: strips along its sides.
    let within_mm = found.gap_limit_mm.unwrap().min(0.05 * 20.0);
    let beyond_mm2 = (1.2 - 2.0 * within_mm) * (2.2 - 2.0 * within_mm);
    assert!((beyond_mm2..expected_mm2).contains(&open_mm2), "{beyond_mm2} {found:?}");
    assert!(found.uncovered_area_mm2.unwrap() > 0.8 * open_mm2, "{found:?}");
    assert!((first.adds_coverage.unwrap() - open_mm2 / 48.0).abs() < 1e-9);
    assert!((found.coverage.unwrap() + open_mm2 / 48.0 - 1.0).abs() < 1e-9);
    assert!(inside([first.at_mm[0], first.at_mm[1]]));
    let on_sphere = |[x, y, z]: PointMm| (x * x + y * y + (z - 20.0).powi(2)).sqrt() - 20.0;
    let places = first.polygons.iter().flat_map(|polygon| &polygon.outline_mm);
    assert!(places.chain([&first.at_mm]).all(|&place| on_sphere(place).abs() < 1e-6));
    assert!((first.spacing_needed_mm.unwrap() - 0.1 * SQRT_2).abs() < 1e-9);

    // Measured there as well, all is covered.
    let waypoints = measurement.next.unwrap().waypoints();
    assert_eq!((waypoints.regions, waypoints.left_out), (1, 0));
    let lines = waypoints.csv.lines().skip(1).map(|line| {
        let numbers: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
        let [1.0, x, y, z] = numbers[..] else { panic!("{line}") };
        assert!(on_sphere([x, y, z]).abs() < 2e-6, "{line}");
        [x, y, z]
    });
    let filled = measured(SPHERE, cap(|place| !inside(place)).chain(lines)).report.sampling;
    assert!(filled.coverage.unwrap() > 0.999, "{filled:?}");
}

#[test]
fn what_cannot_be_known_is_said_and_is_no_number() {
    let same = (0..50).map(|_| [1.0, 2.0, 3.0]);
    let far = (0..50).map(|index| [1e300, f64::from(index), f64::from(index % 7)]);
    let bad: [(Vec<PointMm>, &str); 4] = [
        (far.collect(), "50 of 50 lie farther than 1e12 mm from the origin"),
        (Vec::new(), "span no area"),
        (vec![[1.0, 2.0, 3.0]], "span no area"),
        (same.collect(), "span no area"),
    ];
    for (points, why) in bad {
        let report = measured("[surface]\nkind = \"plane\"\n", points.into_iter()).report;
        let found = report.sampling;
        assert!(found.unknown.iter().any(|reason| reason.contains(why)), "{found:?}");
        let figures = [
            found.coverage,
            found.gap_max_mm,
            found.gap_p99_mm,
            found.epsilon_max,
            found.epsilon_p99,
            found.noise_sigma_nm,
            found.spacing_median_mm,
            found.overdense_fraction,
            found.spacing_recommended_mm,
            found.undersampled_area_mm2,
            found.uncovered_area_mm2,
        ];
        assert_eq!(figures, [None; 11], "{found:?}");
        assert!(report.verdict.reasons.iter().any(|reason| reason.contains(why)));
    }
    // The aperture lies elsewhere: nothing of it is covered, and nothing else is known.
    let part = SPHERE.replace("[sampling]", "[fit]\nfree = [\"tz\"]\n[sampling]");
    let beside = cap(|_| true).map(|[x, y, z]| [x + 30.0, y, z]);
    let found = measured(&part, beside).report.sampling;
    assert_eq!((found.coverage, found.gap_max_mm, found.epsilon_max), (None, None, None));
    assert!(found.unknown.iter().any(|reason| reason.contains("in the aperture")), "{found:?}");
    assert_eq!(found.next.len(), 1);
    assert!((found.next[0].area_mm2 - 48.0).abs() < 1e-9);
}

#[test]
fn points_alone_tell_the_feature_size_of_a_sphere() {
    let mut mesh = Mesh::new();
    // Noise of some 10 nm, from the last digits of a product.
    let noise = |x: f64, y: f64| 3e-5 * ((1e4 * (x + 0.01).sin() * (y + 7.7)).fract().abs() - 0.5);
    mesh.extend(cap(|_| true).map(|[x, y, z]| [x, y, z + noise(x, y)]));
    mesh.flush();
    let triangles = mesh.triangles();
    let sampled = Sampled { mesh: &mesh, triangles: &triangles, plane: &Plane::XY };
    let found = of_points(sampled, Wanted::default()).figures;
    assert_eq!(found.lfs_source.as_deref(), Some("measured"), "{found:?}");
    assert!((found.lfs_min_mm.unwrap() / 20.0 - 1.0).abs() < 0.1, "{found:?}");
    assert_eq!(found.coverage, Some(1.0), "{found:?}");
}

/// Over two rings of points 1 mm apart a sphere of 20 mm leaves a cubic by 100 nm and more.
#[test]
fn what_the_nominal_bends_is_not_noise() {
    let part = SPHERE.replace("gap_limit_mm = 0.1", "gap_limit_mm = 2.0");
    let wide = cap(|place| place.iter().all(|at| (at - at.round()).abs() < 1e-6))
        .chain(cap(|[x, y]| (x - x.round()).abs() < 1e-6 && (y.fract().abs() - 0.5).abs() < 1e-6));
    let found = measured(&part, wide).report.sampling;
    assert!(found.noise_sigma_nm.unwrap() < 0.1, "{found:?}");
}

/// Noise so large that medial balls tell nothing: the curvature of windows stands for the local feature size, from
/// above and not by much, though a hundredth of the readings is wrong.
#[test]
fn noise_that_hides_medial_balls_leaves_the_curvature() {
    let mut random = Random(5);
    let mut unit = || random.next();
    // A sphere, and an ellipsoid whose least radius of curvature is that at its pole, 12²/18 mm.
    let [a_mm, b_mm, c_mm] = [12.0_f64, 20.0, 18.0];
    for (is_sphere, least_mm) in [(true, 20.0), (false, a_mm * a_mm / c_mm)] {
        let surface = |x: f64, y: f64| match is_sphere {
            true => (400.0 - x * x - y * y).sqrt(),
            false => c_mm * (1.0 - (x / a_mm).powi(2) - (y / b_mm).powi(2)).sqrt(),
        };
        let points: Vec<PointMm> = (0..350 * 350)
            .map(|index| [index % 350, index / 350].map(|i| 0.02 * (f64::from(i) - 174.5)))
            .map(|[x, y]| {
                let noise = (0..12).map(|_| unit()).sum::<f64>() - 6.0;
                let wrong = if unit() < 0.01 { 1.0 } else { 0.0 };
                [x, y, -surface(x, y) + 5e-3 * noise + wrong]
            })
            .collect();
        let wanted = Wanted::default();
        let found = sampling_of_points(points, Along::Z, wanted).figures;
        assert_eq!(found.lfs_source.as_deref(), Some("curvature"), "{found:?}");
        // Two uncertainties of the curvature are taken against it.
        let share = found.lfs_min_mm.unwrap() / least_mm;
        assert!((0.4..1.1).contains(&share), "{share}");
    }
}

/// A biconic of 20 mm along x and 35 mm along y. Its medial axis comes nearest at the centre of the stronger bend, 20 mm off.
#[test]
fn the_local_feature_size_of_a_freeform_is_that_of_its_nominal() {
    let part = SPHERE
        .replace("\"sphere\"", "\"biconic\"")
        .replace("radius_mm = 20", "radius_x_mm = 20\nradius_y_mm = 35");
    let nominal = parse("part.toml", &part).unwrap().nominal;
    let points = cap(|_| true).map(|[x, y, _]| [x, y, nominal.height_mm(x, y).unwrap()]);
    let report = measured(&part, points).report;
    let found = &report.sampling;
    assert_eq!(
        (found.coverage, found.lfs_source.as_deref()),
        (Some(1.0), Some("nominal")),
        "{found:?}"
    );
    assert!((found.lfs_min_mm.unwrap() / 20.0 - 1.0).abs() < 2e-3, "{found:?}");
    assert!(found.unknown.is_empty(), "{found:?}");
    let form = report.form.unwrap();
    assert_eq!(form.nominal, "biconic, radius_x 20 mm, radius_y 35 mm");
    assert!(form.deviation.rms_nm < 1e-3, "{form:?}");
}

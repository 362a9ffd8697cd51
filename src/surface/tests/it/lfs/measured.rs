//! From measured points with noise.
//!
//! Normals are those of the body, each tilted at random; in one test they are had from the facets of
//! a mesh, weighted by area.

use std::f64::consts::PI;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::lfs::{Accuracy, Lfs, MeasuredLfs, MedialAxis, MedialBall, Why};

use super::bodies::{
    Random, Sample, Sampled, cylinder, ellipsoid, paraboloid, paraboloid_at, sheets, sphere, torus,
};

/// Noise of 0.1 % of the spacing, and normals as wrong as such noise makes those of facets.
const USUAL: Sampled = Sampled { spacing_mm: 1.0, noise_mm: 1e-3, tilt_rad: 1e-3 };

fn accuracy(sample: &Sample, sampled: Sampled) -> Accuracy {
    Accuracy { gap_mm: sample.gap_mm, position_mm: sampled.noise_mm, normal_rad: sampled.tilt_rad }
}

fn axis(sample: &Sample, sampled: Sampled) -> MedialAxis {
    let mut measured = MeasuredLfs::new(accuracy(sample, sampled)).expect("good figures");
    measured.insert(&sample.points, &sample.normals).expect("good points");
    measured.refresh()
}

/// The figures to be kept: half of all places within 2 %, none more than 10 % too large, and nearly
/// all within their bounds.
fn keeps_the_figures(sample: &Sample, axis: &MedialAxis) {
    let (mut errors, mut outside) = (Vec::new(), 0);
    for (&point, &lfs_mm) in sample.points.iter().zip(&sample.lfs_mm) {
        let found = axis.at(point);
        let Lfs::Known { mm, lower_mm, upper_mm } = found else { panic!("{point:?}: {found:?}") };
        outside += usize::from(!(lower_mm..=upper_mm).contains(&lfs_mm));
        assert!(mm <= 1.1 * lfs_mm, "{mm} instead of {lfs_mm} at {point:?}");
        errors.push((mm / lfs_mm - 1.0).abs());
    }
    errors.sort_by(f64::total_cmp);
    let median = errors[errors.len() / 2];
    assert!(median <= 0.02, "the median error is {median}");
    assert!(outside * 1000 <= errors.len(), "{outside} of {} outside", errors.len());
}

fn figures(sample: &Sample) {
    keeps_the_figures(sample, &axis(sample, USUAL));
}

#[test]
fn spheres() {
    figures(&sphere(USUAL, 25.0, PI));
    figures(&sphere(USUAL, 100.0, 0.4));
}

#[test]
fn cylinders() {
    figures(&cylinder(USUAL, 30.0, 60.0, 1.2));
}

#[test]
fn a_slender_torus() {
    figures(&torus(USUAL, 20.0, 8.0));
}

#[test]
fn a_torus_whose_hole_is_the_neck() {
    figures(&torus(USUAL, 20.0, 14.0));
}

#[test]
fn flattened_ellipsoids() {
    // At the flat poles the ball is larger than the way to the axis.
    figures(&ellipsoid(USUAL, 40.0, 25.0));
    figures(&ellipsoid(USUAL, 40.0, 20.0));
}

#[test]
fn paraboloids() {
    figures(&paraboloid(USUAL, 40.0, 60.0));
    figures(&paraboloid(USUAL, 20.0, 40.0));
}

#[test]
fn parallel_sheets() {
    let sample = sheets(USUAL, 50.0, 10.0);
    let axis = axis(&sample, USUAL);
    keeps_the_figures(&sample, &axis);
    let half_mm = axis.half_bottleneck_mm().unwrap();
    assert!((4.7..=5.0).contains(&half_mm), "{half_mm}");
    figures(&sheets(USUAL, 50.0, 4.0));
}

/// More noise must show in the bounds: what is called known stays so, whatever the noise.
#[test]
fn noise_widens_the_bounds() {
    for body in [
        |sampled| sphere(sampled, 20.0, 2.0),
        |sampled| paraboloid(sampled, 20.0, 30.0),
        |sampled| torus(sampled, 15.0, 7.0),
        |sampled| sheets(sampled, 40.0, 10.0),
    ] as [fn(Sampled) -> Sample; 4]
    {
        for noise_mm in [0.01, 0.05, 0.2] {
            let sampled = Sampled { spacing_mm: 1.0, noise_mm, tilt_rad: f64::min(noise_mm, 0.1) };
            let sample = body(sampled);
            let axis = axis(&sample, sampled);
            let [mut low, mut high] = [0, 0];
            for (&point, &lfs_mm) in sample.points.iter().zip(&sample.lfs_mm) {
                let found = axis.at(point);
                low += usize::from(found.upper_mm() < lfs_mm);
                high += usize::from(found.lower_mm() > lfs_mm);
                if noise_mm < 0.02 {
                    let Lfs::Known { mm, .. } = found else { panic!("{found:?}") };
                    assert!(mm <= 1.1 * lfs_mm, "{noise_mm}: {found:?}, not {lfs_mm}");
                }
            }
            // Of 3,000 points a few are off by more than is taken into account.
            assert!(100 * low <= sample.points.len(), "{noise_mm}: {low} too large");
            assert_eq!(high, 0, "{noise_mm}");
        }
    }
}

#[test]
fn normals_of_facets_will_do() {
    let mut random = Random::new(3);
    let mut mesh = Mesh::new();
    for i in -30_i32..=30 {
        for j in -30_i32..=30 {
            let [x, y] = [i, j].map(|at| f64::from(at) + 0.1 * random.normal());
            let (at, normal, _) = paraboloid_at(40.0, x, y);
            let high = 1e-3 * random.normal();
            mesh.push([0, 1, 2].map(|axis| at[axis] + high * normal[axis]));
        }
    }
    mesh.flush();
    let points = mesh.points();
    let mut normals = vec![[0.0; 3]; points.len()];
    for corners in mesh.triangles() {
        let [a, b, c] = corners.map(|corner| points[corner as usize]);
        let [u, v] = [b, c].map(|end| [0, 1, 2].map(|axis| end[axis] - a[axis]));
        for corner in corners {
            for (axis, sum) in normals[corner as usize].iter_mut().enumerate() {
                let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
                *sum += u[next] * v[last] - u[last] * v[next];
            }
        }
    }
    let inside = |point: &PointMm| point[0].abs() < 28.0 && point[1].abs() < 28.0;
    let normals: Vec<Option<[f64; 3]>> =
        points.iter().zip(normals).map(|(point, normal)| inside(point).then_some(normal)).collect();
    let sampled = Sampled { tilt_rad: 2e-3, ..USUAL };
    let lfs_mm = points.iter().map(|&[x, y, _]| paraboloid_at(40.0, x, y).2).collect();
    let sample = Sample { points: points.to_vec(), normals, lfs_mm, gap_mm: 0.9 };
    keeps_the_figures(&sample, &axis(&sample, sampled));
}

fn bits(axis: &MedialAxis) -> Vec<String> {
    // The shortest decimal of a number that reads back the same stands for its bits.
    axis.balls().iter().map(|ball| format!("{ball:?}")).collect()
}

#[test]
fn neither_batches_nor_looks_change_a_bit() {
    for sample in [torus(USUAL, 15.0, 6.0), paraboloid(USUAL, 20.0, 30.0)] {
        let whole = axis(&sample, USUAL);
        let mut measured = MeasuredLfs::new(accuracy(&sample, USUAL)).unwrap();
        for (points, normals) in sample.points.chunks(701).zip(sample.normals.chunks(701)) {
            measured.insert(points, normals).unwrap();
            measured.refresh();
        }
        assert_eq!(bits(&measured.refresh()), bits(&whole));
        assert_eq!(bits(&measured.refresh()), bits(&whole));
    }
}

#[test]
fn twice_the_size_is_twice_the_feature_size() {
    let sample = torus(USUAL, 15.0, 6.0);
    let twice = |point: &PointMm| point.map(|part| 2.0 * part);
    let large = Sample {
        points: sample.points.iter().map(twice).collect(),
        normals: sample.normals.clone(),
        lfs_mm: sample.lfs_mm.iter().map(|lfs_mm| 2.0 * lfs_mm).collect(),
        gap_mm: 2.0 * sample.gap_mm,
    };
    let (small_axis, large_axis) =
        (axis(&sample, USUAL), axis(&large, Sampled { noise_mm: 2.0 * USUAL.noise_mm, ..USUAL }));
    assert_eq!(small_axis.balls().len(), large_axis.balls().len());
    for (small, large) in small_axis.balls().iter().zip(large_axis.balls()) {
        assert_eq!(2.0 * small.radius_mm, large.radius_mm);
        assert_eq!(twice(&small.centre_mm()), large.centre_mm());
    }
}

#[test]
fn far_from_the_origin() {
    let mut sample = sphere(USUAL, 25.0, 1.5);
    for point in &mut sample.points {
        *point = [point[0] + 1e8, point[1] - 1e8, point[2] + 1e7];
    }
    figures(&sample);
}

/// What comes later shrinks balls; those it does not reach stay.
#[test]
fn a_sheet_that_comes_later_is_seen() {
    let sample = sheets(USUAL, 40.0, 8.0);
    let half = sample.points.iter().position(|point| point[2].abs() < 1.0).unwrap();
    let mut measured = MeasuredLfs::new(accuracy(&sample, USUAL)).unwrap();
    measured.insert(&sample.points[..half], &sample.normals[..half]).unwrap();
    let alone = measured.refresh().at(sample.points[0]);
    assert!(matches!(alone, Lfs::Beyond { .. }), "{alone:?}");
    measured.insert(&sample.points[half..], &sample.normals[half..]).unwrap();
    assert_eq!(measured.len(), sample.points.len());
    keeps_the_figures(&sample, &measured.refresh());
}

#[test]
fn a_normal_that_comes_later_counts() {
    let sample = sphere(USUAL, 15.0, 1.0);
    let mut measured = MeasuredLfs::new(accuracy(&sample, USUAL)).unwrap();
    assert!(measured.is_empty());
    measured.insert(&sample.points, &vec![None; sample.points.len()]).unwrap();
    assert_eq!(measured.refresh().at(sample.points[0]), Lfs::Unknown(Why::NoNormals));
    for (number, &normal) in (0..).zip(&sample.normals) {
        measured.orient(number, normal).unwrap();
    }
    assert_eq!(bits(&measured.refresh()), bits(&axis(&sample, USUAL)));
    assert!(measured.orient(0, Some([0.0; 3])).is_err());
    measured.orient(u32::MAX, Some([0.0, 0.0, 1.0])).unwrap();
}

#[test]
fn sheets_nearer_than_the_gap_are_hidden() {
    let sample = sheets(USUAL, 30.0, 0.5);
    let axis = axis(&sample, USUAL);
    for &point in &sample.points {
        let found = axis.at(point);
        assert!(matches!(found, Lfs::Hidden { upper_mm } if upper_mm >= 0.25), "{found:?}");
        assert_eq!((found.mm(), found.lower_mm()), (None, 0.0));
    }
}

#[test]
fn a_plane_has_no_end() {
    let points: Vec<PointMm> =
        (0..900).map(|i| [f64::from(i % 30), f64::from(i / 30), 5.0]).collect();
    let normals = vec![Some([0.0, 0.0, 3.0]); points.len()];
    let found = |position_mm, normal_rad| {
        let mut measured =
            MeasuredLfs::new(Accuracy { gap_mm: 0.75, position_mm, normal_rad }).unwrap();
        measured.insert(&points, &normals).unwrap();
        // The same places again are no new points.
        measured.insert(&points, &normals).unwrap();
        assert_eq!(measured.len(), 1800);
        measured.refresh().at([10.0, 10.0, 5.0])
    };
    // Exact: as far as is looked. With noise a wave of 3 mm half length and 4 mm 1e-3 height may hide.
    let Lfs::Beyond { lower_mm } = found(0.0, 0.0) else { panic!("a ball under a plane") };
    assert!(lower_mm >= 1e4 * 29.0);
    let Lfs::Beyond { lower_mm } = found(1e-3, 1e-3) else { panic!("a ball under a plane") };
    assert!((300.0..1125.0).contains(&lower_mm), "{lower_mm}");
    assert_eq!(found(0.0, 0.0).mm(), Some(f64::INFINITY));
}

#[test]
fn too_little_to_know_anything() {
    let up = Some([0.0, 0.0, 1.0]);
    let found = |points: &[PointMm]| {
        let mut measured =
            MeasuredLfs::new(Accuracy { gap_mm: 1.0, position_mm: 0.0, normal_rad: 0.0 }).unwrap();
        measured.insert(points, &vec![up; points.len()]).unwrap();
        measured.refresh().at([0.0; 3])
    };
    assert_eq!(found(&[]), Lfs::Unknown(Why::NoPoints));
    assert_eq!(found(&[[1.0, 2.0, 3.0]]), Lfs::Unknown(Why::Narrow));
    let line: Vec<PointMm> = (0..100).map(|i| [f64::from(i), 2.0 * f64::from(i), 0.0]).collect();
    assert_eq!(found(&line), Lfs::Unknown(Why::Narrow));
    let sample = sphere(USUAL, 15.0, 1.0);
    let nowhere = axis(&sample, USUAL).at([f64::NAN, 0.0, 0.0]);
    assert_eq!(nowhere, Lfs::Unknown(Why::Outside));
    assert_eq!((nowhere.mm(), nowhere.upper_mm()), (None, f64::INFINITY));
}

#[test]
fn what_is_no_measurement_is_refused_whole() {
    let good = Accuracy { gap_mm: 1.0, position_mm: 0.0, normal_rad: 0.0 };
    for (accuracy, message) in [
        (Accuracy { gap_mm: 0.0, ..good }, "gap_mm is 0, but must be finite and above zero"),
        (
            Accuracy { position_mm: -1.0, ..good },
            "position_mm is -1, but must be finite and not negative",
        ),
        (
            Accuracy { normal_rad: f64::NAN, ..good },
            "normal_rad is NaN, but must be finite and not negative",
        ),
        (Accuracy { normal_rad: 0.2, ..good }, "normal_rad is 0.2, but must be at most 0.1"),
    ] {
        assert_eq!(MeasuredLfs::new(accuracy).unwrap_err().to_string(), message);
    }
    let mut measured = MeasuredLfs::new(good).unwrap();
    let (place, up) = ([0.0; 3], Some([0.0, 0.0, 1.0]));
    for (points, normals, message) in [
        (vec![place; 2], vec![up], "2 points came with 1 normals, but there must be one for each"),
        (
            vec![place, [f64::NAN, 0.0, 0.0]],
            vec![up; 2],
            "point 1 is (NaN, 0, 0) mm, but coordinates must be within ±1e12 mm",
        ),
        (
            vec![place; 2],
            vec![up, Some([0.0, f64::INFINITY, 0.0])],
            "normal 1 is (0, inf, 0), but must be finite and not zero",
        ),
        (
            vec![place],
            vec![Some([0.0; 3])],
            "normal 0 is (0, 0, 0), but must be finite and not zero",
        ),
    ] {
        assert_eq!(measured.insert(&points, &normals).unwrap_err().to_string(), message);
        assert!(measured.is_empty());
    }
}

#[test]
fn a_ball_says_where_it_touches() {
    let sample = sheets(USUAL, 30.0, 6.0);
    for ball in axis(&sample, USUAL).balls() {
        let MedialBall { at_mm, witness_mm, lower_mm, radius_mm, upper_mm, .. } = *ball;
        assert!((at_mm[2] - witness_mm[2]).abs() > 5.9);
        assert!(ball.separation_rad() > 2.5 && (ball.centre_mm()[2] - 3.0).abs() < 0.2);
        assert!(lower_mm <= radius_mm && radius_mm <= upper_mm);
    }
}

//! The plane in which a surface is projectable is found, where there is one.

use std::f64::consts::{FRAC_PI_2, PI};

use asphera_geometry::PointMm;
use asphera_surface::{Obstacle, Plane, PlaneError, Projectability, Relief, projectable_along};

use crate::shapes::{Sampled, cylinder, leaning_sheet, over_square, sphere, surveyed};

const SCATTERED: Sampled = Sampled::Scattered { count: 4_000, seed: 17 };
const RASTER: Sampled = Sampled::Raster { along: 64, across: 62 };

fn found(points: &[PointMm]) -> Projectability {
    projectable_along(points, &Relief::default()).expect("the points lie on no line")
}

fn normal(found: Projectability) -> [f64; 3] {
    match found {
        Projectability::Projectable { plane, .. } => plane.normal(),
        Projectability::Nowhere { .. } => panic!("{found:?}"),
    }
}

/// The points as seen by someone who takes the given normal for z.
fn seen_along(points: &[PointMm], normal: [f64; 3]) -> Vec<PointMm> {
    let plane = Plane::new([3.0, -2.0, 1.0], normal).expect("a normal");
    points.iter().map(|&point| plane.to_plane(point)).collect()
}

fn angle_deg(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).abs().min(1.0).acos().to_degrees()
}

#[test]
fn half_a_cylinder_scanned_along_x_is_projectable_along_its_vertical() {
    for sampled in [SCATTERED, RASTER] {
        let points = seen_along(&cylinder(sampled, -FRAC_PI_2, FRAC_PI_2), [1.0, 0.0, 0.0]);
        assert!(!surveyed(&points).projectable());
        // What was z is now the direction that the plane along x maps it to.
        let vertical = Plane::new([0.0; 3], [1.0, 0.0, 0.0]).unwrap().to_plane([0.0, 0.0, 1.0]);
        let off_deg = angle_deg(normal(found(&points)), vertical);
        assert!(off_deg < 6.0, "{off_deg}");
    }
}

#[test]
fn a_whole_sphere_is_projectable_along_nothing() {
    let found_one = found(&sphere(SCATTERED, PI));
    let Projectability::Nowhere { why: Obstacle::Fold(fold), .. } = found_one else {
        panic!("{found_one:?}");
    };
    assert!(fold.projected_area_mm2 > 0.8 * 100.0 * PI, "{fold:?}");
    // On parallels that mirror each other most samples stand above each other along the axis.
    assert!(matches!(found(&sphere(RASTER, PI)), Projectability::Nowhere { .. }));
}

#[test]
fn a_tilted_patch_is_projectable_along_its_own_normal() {
    let asphere = |x: f64, y: f64| {
        let squared = (x - 10.0).powi(2) + (y - 10.0).powi(2);
        0.02 * squared / (1.0 + (1.0 - 4e-4 * squared).sqrt()) + 1e-6 * squared * squared
    };
    for sampled in [SCATTERED, RASTER] {
        for height in [&asphere as &dyn Fn(f64, f64) -> f64, &|_, _| 0.0] {
            let turned = 70.0_f64.to_radians();
            let points =
                seen_along(&over_square(sampled, 20.0, height), [turned.sin(), 0.0, turned.cos()]);
            let plane = Plane::new([0.0; 3], [turned.sin(), 0.0, turned.cos()]).unwrap();
            let own = plane.to_plane([0.0, 0.0, 1.0]);
            let found = found(&points);
            assert!(angle_deg(normal(found), own) < 1.0, "{found:?}");
            assert!(
                matches!(found, Projectability::Projectable { steep_share: 0.0, slope_p95_rad, .. } if slope_p95_rad < 0.6)
            );
        }
    }
}

#[test]
fn a_leaning_sheet_is_projectable_along_a_slant() {
    for sampled in [SCATTERED, RASTER] {
        let points = leaning_sheet(sampled, 20.0);
        assert!(!surveyed(&points).projectable());
        let normal = normal(found(&points));
        // x cos a + z sin a grows along the sheet if tan a > 20 (0.7π - 1) / 20: from 50.2° to the
        // like angle beyond the vertical where the other sign holds.
        let [x, _, z] = normal;
        let a_deg = (-x).atan2(z).to_degrees().rem_euclid(180.0);
        assert!(a_deg > 50.0 && a_deg < 163.0, "{normal:?}: {a_deg}");
        assert!(surveyed(&seen_along(&points, normal)).projectable());
    }
}

#[test]
fn samples_above_each_other_stand_against_a_plane() {
    // Six faces of a cube: none of its samples are mixed along an axis, all are above each other.
    let face = over_square(Sampled::Raster { along: 12, across: 12 }, 12.0, |_, _| 0.0);
    let cube: Vec<PointMm> = face
        .iter()
        .flat_map(|&[a, b, _]| {
            [0.0, 12.0].into_iter().flat_map(move |c| [[a, b, c], [b, c, a], [c, a, b]])
        })
        .collect();
    assert!(matches!(found(&cube), Projectability::Nowhere { .. }));
}

#[test]
fn what_has_no_plane_is_refused() {
    let relief = Relief::default();
    let refused = |points: &[PointMm]| projectable_along(points, &relief).unwrap_err();
    assert_eq!(refused(&[]), PlaneError::TooFew { points: 0 });
    let line: Vec<PointMm> = (0..50).map(|i| [f64::from(i), 0.0, 2.0 * f64::from(i)]).collect();
    assert!(matches!(refused(&line), PlaneError::OnLine { .. }));
}

#[test]
fn more_points_than_are_tried() {
    let points =
        over_square(Sampled::Raster { along: 150, across: 140 }, 20.0, |x, y| 0.01 * x * y);
    let found = found(&points);
    assert!(angle_deg(normal(found), [0.0, 0.0, 1.0]) < 15.0, "{found:?}");
}

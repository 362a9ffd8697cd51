//! Folds are told from walls, spikes, steep flanks and noise, over several samplings.

use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use asphera_geometry::{PointMm, VertexId};
use asphera_surface::{Kind, Relief, ReliefError, Topography, topography};
use proptest::prelude::*;

use crate::random::Random;
use crate::shapes::{Sampled, cylinder, leaning_sheet, meshed, over_square, sphere, surveyed};

/// Some `side`² samples: square and oblong rasters, and scattered.
fn samplings(side: usize) -> [Sampled; 4] {
    let count = side * side;
    [
        Sampled::Raster { along: side, across: side },
        Sampled::Raster { along: 2 * side + 1, across: side / 2 },
        Sampled::Scattered { count, seed: 5 },
        Sampled::Scattered { count, seed: 9 },
    ]
}

/// The height in mm at x and y.
type Height<'a> = &'a dyn Fn(f64, f64) -> f64;

fn kinds(found: &Topography) -> Vec<Kind> {
    found.regions().iter().map(|region| region.kind).collect()
}

fn assert_folds(name: &str, points: &[PointMm]) {
    let found = surveyed(points);
    assert!(!found.projectable(), "{name}: {:?}", found.regions());
    assert!(found.triangles_of_folds().next().is_some());
}

fn assert_no_folds(name: &str, points: &[PointMm]) {
    let found = surveyed(points);
    assert!(found.projectable(), "{name}: {:?}", found.regions());
    assert_eq!(found.triangles_of_folds().count(), 0);
}

#[test]
fn a_sphere_beyond_its_equator_folds() {
    for side in [30, 60, 120] {
        for sampled in samplings(side) {
            for degrees in [120.0_f64, 150.0, 179.0] {
                let points = sphere(sampled, degrees.to_radians());
                assert_folds(&format!("{degrees} {sampled:?}"), &points);
            }
        }
    }
    // Its lower part ends 0.34 mm inside the equator: five rows of samples or spacings.
    for sampled in samplings(200) {
        assert_folds(&format!("{sampled:?}"), &sphere(sampled, 105.0_f64.to_radians()));
    }
}

#[test]
fn a_cylinder_measured_all_round_folds_with_all_its_area() {
    for side in [30, 60, 120] {
        for sampled in samplings(side) {
            let points = cylinder(sampled, 0.1234, 0.1234 + TAU);
            let found = surveyed(&points);
            let fold = found.regions().first().unwrap();
            assert_eq!(fold.kind, Kind::Fold, "{sampled:?}");
            // The projection is 10 × 20, less half a sample at the ends.
            assert!(fold.projected_area_mm2 > 160.0 && fold.projected_area_mm2 < 200.0);
            assert!(fold.rise_max_mm > 9.8 && fold.rise_max_mm <= 10.0, "{fold:?}");
            assert!(fold.height_mm() > 9.8 && fold.slope_max_rad < FRAC_PI_2);
        }
    }
}

#[test]
fn triangles_that_join_the_sheets_are_named() {
    for sampled in samplings(60) {
        let (points, triangles) = meshed(&cylinder(sampled, 0.1234, 0.1234 + TAU));
        let found = topography(&points, &triangles, &Relief::default());
        let folded: BTreeSet<usize> = found.triangles_of_folds().collect();
        for (index, corners) in triangles.iter().enumerate() {
            let heights = corners.map(|corner| points[corner as usize][2]);
            // Two well separated sheets: the upper and the lower half but for the flanks.
            let joins = heights.iter().any(|&z| z > 2.0) && heights.iter().any(|&z| z < -2.0);
            assert!(!joins || folded.contains(&index), "{sampled:?}: {heights:?}");
            assert_eq!(
                found.region_of(index).is_some_and(|r| found.regions()[r].kind == Kind::Fold),
                folded.contains(&index)
            );
        }
        assert_eq!(found.region_of(triangles.len()), None);
    }
}

#[test]
fn a_sheet_that_leans_over_folds_where_it_does() {
    for side in [30, 60, 120] {
        for sampled in samplings(side) {
            for height_mm in [10.0, 20.0, 40.0] {
                let points = leaning_sheet(sampled, height_mm);
                assert_folds(&format!("{height_mm} {sampled:?}"), &points);
                let found = surveyed(&points);
                let fold = found.regions()[0];
                if height_mm > 10.0 {
                    // Long sides reach out of the fold and are steep all the same.
                    continue;
                }
                // x(u) = 20 (u + 0.35 sin 2πu) turns back where cos 2πu = -1/0.7π.
                let u = (-1.0 / (0.7 * PI)).acos() / TAU;
                let reach = 20.0 * (u + 0.35 * (TAU * u).sin());
                let near = |x: f64, expected: f64| (x - expected).abs() < 0.5 + 150.0 / side as f64;
                assert!(
                    near(fold.max_mm[0], reach) && near(fold.min_mm[0], 20.0 - reach),
                    "{fold:?}"
                );
            }
        }
    }
}

#[test]
fn samples_above_each_other_but_for_rounding_fold() {
    // The lower half mirrors the upper one, moved by less than a rounding error of a rotation.
    let upper = sphere(Sampled::Raster { along: 40, across: 20 }, FRAC_PI_2);
    let lower = upper.iter().map(|&[x, y, z]| [x * (1.0 + 1e-14), y * (1.0 - 1e-14), -z - 0.5]);
    let points: Vec<PointMm> = upper.iter().copied().chain(lower).collect();
    assert_folds("mirrored", &points);
    // The same samples exactly above each other never meet in a mesh.
    let lower = upper.iter().map(|&[x, y, z]| [x, y, -z - 0.5]);
    let points: Vec<PointMm> = upper.iter().copied().chain(lower).collect();
    assert_eq!(meshed(&points).0.len(), upper.len());
    assert_no_folds("conflicts", &points);
}

#[test]
fn a_hemisphere_and_half_a_cylinder_have_walls_at_most() {
    for side in [30, 60, 120, 240] {
        for sampled in samplings(side) {
            for points in [sphere(sampled, FRAC_PI_2), cylinder(sampled, -FRAC_PI_2, FRAC_PI_2)] {
                let found = surveyed(&points);
                assert!(kinds(&found).iter().all(|&kind| kind == Kind::Wall), "{sampled:?}");
            }
        }
    }
}

#[test]
fn steps_pillars_and_steep_flanks_are_walls_without_one_entangled_vertex() {
    for side in [30, 60, 120] {
        let spacing_mm = 20.0 / side as f64;
        for sampled in samplings(side) {
            let shapes: [(&str, Height); 5] = [
                ("step", &|x, _| if x > 9.9 { 5.0 * spacing_mm } else { 0.0 }),
                ("high step", &|x, _| if x > 9.9 { 30.0 * spacing_mm } else { 0.0 }),
                ("slant", &|x, y| if x + 0.37 * y > 11.9 { 8.0 * spacing_mm } else { 0.0 }),
                ("pillar", &|x, y| {
                    if (x - 10.0).hypot(y - 10.0) < 4.0 { 8.0 * spacing_mm } else { 0.0 }
                }),
                ("cone", &|x, y| 80.0_f64.to_radians().tan() * (x - 10.0).hypot(y - 10.0)),
            ];
            for (name, height_mm) in shapes {
                let found = surveyed(&over_square(sampled, 20.0, height_mm));
                let regions = found.regions();
                assert!(!regions.is_empty(), "{name} {sampled:?}");
                for region in regions {
                    assert_eq!(region.kind, Kind::Wall, "{name} {sampled:?}: {region:?}");
                    assert_eq!(region.entangled, 0, "{name} {sampled:?}: {region:?}");
                }
            }
        }
    }
}

#[test]
fn a_step_on_a_raster_to_the_last_figure() {
    // Columns at 0.5, 1.5, …, the step between those at 9.5 and 10.5.
    let sampled = Sampled::Raster { along: 20, across: 20 };
    let found = surveyed(&over_square(sampled, 20.0, |x, _| if x > 10.0 { 6.0 } else { 0.0 }));
    let [step] = found.regions() else { panic!("{:?}", found.regions()) };
    assert_eq!((step.kind, step.vertices, step.triangles), (Kind::Wall, 40, 38));
    assert_eq!((step.min_mm, step.max_mm), ([9.5, 0.5, 0.0], [10.5, 19.5, 6.0]));
    assert_eq!((step.projected_area_mm2, step.rise_max_mm, step.height_mm()), (19.0, 6.0, 6.0));
    assert_eq!((step.slope_max_rad, step.at_mm), (6.0_f64.atan(), [10.0, 0.5, 3.0]));
    assert_eq!(
        step.to_string(),
        "wall at (10, 0.5, 3) mm, from (9.5, 0.5, 0) to (10.5, 19.5, 6) mm: 40 vertices, \
         38 triangles, 19 mm² projected, rise up to 6 mm, slope up to 80.54°"
    );
}

#[test]
fn gentle_surfaces_and_noise_have_no_region() {
    for side in [30, 60, 120] {
        let mut random = Random::new(3);
        for sampled in samplings(side) {
            let flank = |x: f64, y: f64| 3.0_f64.sqrt() * (x - 10.0).hypot(y - 10.0);
            let noise_mm = 0.1 * 20.0 / side as f64;
            for points in [
                over_square(sampled, 20.0, flank),
                over_square(sampled, 20.0, |_, _| noise_mm * random.normal()),
            ] {
                let found = surveyed(&points);
                assert!(found.regions().is_empty(), "{sampled:?}: {:?}", found.regions());
            }
        }
    }
}

#[test]
fn an_asphere_with_a_flank_of_60_degrees_has_no_region() {
    // z = c r² / (1 + √(1 - (1 + k) c² r²)) with k = -0.4 and 1/c = 10 mm: dz/dr = 1.73 at r = 9.4.
    let sag = |r: f64| 0.1 * r * r / (1.0 + (1.0 - 0.6 * 0.01 * r * r).sqrt());
    let slope = ((sag(9.3) - sag(9.299)) / 0.001).atan().to_degrees();
    assert!(slope > 53.0 && slope < 62.0, "{slope}");
    for sampled in samplings(120) {
        let points: Vec<PointMm> = over_square(sampled, 19.0, |x, y| (x - 9.5).hypot(y - 9.5))
            .into_iter()
            .filter(|point| point[2] < 9.3)
            .map(|[x, y, r]| [x, y, sag(r)])
            .collect();
        assert!(surveyed(&points).regions().is_empty(), "{sampled:?}");
    }
}

#[test]
fn single_samples_off_are_spikes_upwards_and_downwards() {
    let mut points = over_square(Sampled::Raster { along: 30, across: 30 }, 30.0, |x, _| 0.1 * x);
    for (index, off_mm) in [(7 * 30 + 8, 9.0), (20 * 30 + 21, -12.0)] {
        points[index][2] += off_mm;
    }
    let found = surveyed(&points);
    assert_eq!(kinds(&found), [Kind::Spike; 2]);
    for region in found.regions() {
        assert_eq!((region.alone, region.entangled), (1, 0));
        let [x, y, _] = region.at_mm;
        let near = |at: [f64; 2]| (x - at[0]).hypot(y - at[1]) < 1.0;
        assert!(near([8.5, 7.5]) || near([21.5, 20.5]), "{region:?}");
    }
    let scattered = Sampled::Scattered { count: 10_000, seed: 11 };
    for share in [0.002, 0.01, 0.05] {
        let mut random = Random::new(12);
        let points = over_square(scattered, 20.0, |_, _| {
            if random.unit() < share { 1.0 + 4.0 * random.unit() } else { 0.0 }
        });
        let kinds = kinds(&surveyed(&points));
        assert!(kinds.len() > 10 && !kinds.contains(&Kind::Fold), "{share}");
        // One on the outline does not stand off on all sides.
        let walls = kinds.iter().filter(|&&kind| kind == Kind::Wall).count();
        assert!(20 * walls <= kinds.len(), "{share}: {walls} of {}", kinds.len());
    }
}

#[test]
fn a_scan_line_off_is_a_spike() {
    for width in [1, 2] {
        let off = |_: f64, y: f64| if y > 10.0 && y < f64::from(10 + width) { 7.0 } else { 0.0 };
        let found = surveyed(&over_square(Sampled::Raster { along: 25, across: 25 }, 25.0, off));
        assert_eq!(kinds(&found), [Kind::Spike], "{width}");
    }
    let off = |_: f64, y: f64| if y > 10.0 && y < 13.0 { 7.0 } else { 0.0 };
    let found = surveyed(&over_square(Sampled::Raster { along: 25, across: 25 }, 25.0, off));
    assert_eq!(kinds(&found), [Kind::Wall; 2], "a wider ridge has two flanks");
}

#[test]
fn only_heights_above_the_smallest_step_count() {
    // Three passes over the same places that repeat to 1 nm, with noise of 50 nm in height.
    let mut random = Random::new(8);
    let raster = Sampled::Raster { along: 20, across: 20 }.places();
    let points: Vec<PointMm> = (0..3)
        .flat_map(|_| raster.clone())
        .map(|[u, v]| {
            let [dx, dy, dz] = std::array::from_fn(|_| random.unit());
            [u + 1e-6 * dx, v + 1e-6 * dy, 5e-5 * dz]
        })
        .collect();
    let (points, triangles) = meshed(&points);
    assert!(topography(&points, &triangles, &Relief::default()).regions().is_empty());
    let none = Relief::new(Relief::SLOPE_LIMIT_RAD, 0.0).unwrap();
    assert!(!topography(&points, &triangles, &none).regions().is_empty());
}

#[test]
fn limits_are_checked() {
    for slope_limit_rad in [0.0, -1.0, FRAC_PI_2, f64::NAN] {
        let refused = Relief::new(slope_limit_rad, 0.0).unwrap_err();
        assert!(matches!(refused, ReliefError::SlopeLimit { .. }));
    }
    for step_mm in [-1e-9, f64::INFINITY, f64::NAN] {
        assert!(matches!(Relief::new(1.0, step_mm), Err(ReliefError::Step { .. })));
    }
    let default = Relief::new(Relief::SLOPE_LIMIT_RAD, 1e-4).unwrap();
    assert_eq!(default, Relief::default());
}

#[test]
fn little_or_nothing_to_look_at() {
    let relief = Relief::default();
    assert!(topography(&[], &[], &relief).regions().is_empty());
    assert!(topography(&[[0.0; 3]], &[], &relief).projectable());
    let upright = [[0.0, 0.0, 0.0], [1.0, 0.0, 9.0], [0.0, 1.0, 0.0]];
    let found = topography(&upright, &[[0, 1, 2]], &relief);
    assert_eq!(kinds(&found), [Kind::Wall]);
    // What a mesh never holds makes no panic: a height that is no number, corners in one place.
    let broken = [[0.0, 0.0, 0.0], [1.0, 0.0, f64::NAN], [0.0, 0.0, 9.0], [0.0, 1.0, 9.0]];
    topography(&broken, &[[0, 1, 2], [1, 3, 2]], &relief);
}

/// A surface with a fold, a step and spikes side by side, sampled by chance.
fn mixture(seed: u64) -> Vec<PointMm> {
    let scattered = |seed| Sampled::Scattered { count: 400, seed };
    let mut random = Random::new(seed);
    let step = over_square(scattered(seed), 15.0, |x, _| if x > 7.0 { 9.0 } else { 0.0 });
    let spikes =
        over_square(scattered(seed + 1), 15.0, |_, _| if random.unit() < 0.02 { 8.0 } else { 0.0 });
    let moved =
        |points: Vec<PointMm>, x_mm: f64| points.into_iter().map(move |[x, y, z]| [x + x_mm, y, z]);
    leaning_sheet(scattered(seed + 2), 30.0)
        .into_iter()
        .chain(moved(step, 30.0))
        .chain(moved(spikes, 60.0))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn the_report_does_not_depend_on_order_corner_or_numbering(seed in 0_u64..1_000) {
        let (points, triangles) = meshed(&mixture(seed));
        let relief = Relief::default();
        let found = topography(&points, &triangles, &relief);
        prop_assert!(!found.regions().is_empty());
        let mut random = Random::new(seed);
        let new_of_old = shuffled(points.len(), &mut random);
        let mut renumbered = vec![[0.0; 3]; points.len()];
        for (old, &new) in new_of_old.iter().enumerate() {
            renumbered[new] = points[old];
        }
        let order = shuffled(triangles.len(), &mut random);
        let mut turned = vec![[0; 3]; triangles.len()];
        for (index, corners) in triangles.iter().enumerate() {
            let mut corners = corners.map(|corner| new_of_old[corner as usize] as VertexId);
            corners.rotate_left(index % 3);
            turned[order[index]] = corners;
        }
        let again = topography(&renumbered, &turned, &relief);
        prop_assert_eq!(again.regions(), found.regions());
        for (before, &after) in order.iter().enumerate() {
            prop_assert_eq!(again.region_of(after), found.region_of(before));
        }
    }

    #[test]
    fn scale_scales(seed in 0_u64..1_000, power in -20_i32..20) {
        let (points, triangles) = meshed(&mixture(seed));
        let scale = 2.0_f64.powi(power);
        let scaled: Vec<PointMm> = points.iter().map(|point| point.map(|x| scale * x)).collect();
        let found = topography(&points, &triangles, &Relief::new(1.3, 1e-4).unwrap());
        let relief = Relief::new(1.3, scale * 1e-4).unwrap();
        let again = topography(&scaled, &triangles, &relief);
        prop_assert_eq!(again.regions().len(), found.regions().len());
        for (before, after) in found.regions().iter().zip(again.regions()) {
            prop_assert_eq!(after.kind, before.kind);
            prop_assert_eq!(after.min_mm, before.min_mm.map(|x| scale * x));
            prop_assert_eq!(after.at_mm, before.at_mm.map(|x| scale * x));
            prop_assert_eq!(after.projected_area_mm2, scale * scale * before.projected_area_mm2);
            prop_assert_eq!(after.slope_max_rad, before.slope_max_rad);
        }
    }

    #[test]
    fn a_turn_about_z_and_a_shift_keep_the_regions(
        seed in 0_u64..1_000,
        turn in 0.0..TAU,
        shift in prop::array::uniform3(-1e3..1e3),
    ) {
        let (points, triangles) = meshed(&mixture(seed));
        let (sine, cosine) = turn.sin_cos();
        let moved: Vec<PointMm> = points
            .iter()
            .map(|&[x, y, z]| {
                [cosine * x - sine * y + shift[0], sine * x + cosine * y + shift[1], z + shift[2]]
            })
            .collect();
        let found = topography(&points, &triangles, &Relief::default());
        let again = topography(&moved, &triangles, &Relief::default());
        prop_assert_eq!(again.regions().len(), found.regions().len());
        for (before, after) in found.regions().iter().zip(again.regions()) {
            prop_assert_eq!(after.kind, before.kind);
            prop_assert_eq!(after.entangled, before.entangled);
            prop_assert_eq!(after.vertices, before.vertices);
            let area = before.projected_area_mm2;
            prop_assert!((after.projected_area_mm2 - area).abs() < 1e-9 * (1.0 + area));
            prop_assert!((after.rise_max_mm - before.rise_max_mm).abs() < 1e-9);
        }
    }
}

/// The numbers below `count` in a random order (Fisher and Yates).
fn shuffled(count: usize, random: &mut Random) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    for last in (1..count).rev() {
        order.swap(last, (random.unit() * (last + 1) as f64) as usize);
    }
    order
}

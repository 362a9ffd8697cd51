//! Coverage of an aperture against areas that are known, and what to measure next.

use std::f64::consts::PI;

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::coverage::{
    Aperture, Coverage, CoverageError, CoveredAreas, Patch, Polygon, Reference, Spacing, Target,
    Waypoint, cover, waypoints,
};
use proptest::prelude::*;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

fn meshed(points: impl IntoIterator<Item = PointMm>) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.extend(points);
    mesh.flush();
    mesh
}

fn covered(mesh: &Mesh, aperture: Option<&Aperture>, target: &Target) -> Coverage {
    let triangles = mesh.triangles();
    let found = cover(mesh.points(), &triangles, &[], aperture, target, |_, _| None)
        .expect("the mesh is whole");
    assert_sums(&found);
    found
}

/// The areas add up, those of the regions too, and each region is drawn as large as it is.
fn assert_sums(found: &Coverage) {
    let Some(areas) = found.areas else { return };
    let CoveredAreas { aperture_mm2, covered_mm2, undersampled_mm2, uncovered_mm2, .. } = areas;
    let total_mm2 = covered_mm2 + undersampled_mm2 + uncovered_mm2;
    assert!((total_mm2 - aperture_mm2).abs() <= 1e-11 * aperture_mm2, "{areas:?}");
    let of = |area: fn(&Patch) -> f64| found.patches.iter().map(area).sum::<f64>();
    let left_mm2 = of(Patch::missing_mm2) + found.remainder_mm2;
    let open_mm2 = undersampled_mm2 + uncovered_mm2;
    assert!((left_mm2 - open_mm2).abs() <= 1e-9 * aperture_mm2, "{left_mm2} of {open_mm2}");
    for patch in &found.patches {
        assert!(patch.missing_mm2() <= patch.area_mm2 + 1e-12 * aperture_mm2);
        let drawn_mm2: f64 = patch.polygons.iter().map(|polygon| polygon.area_mm2).sum();
        let sagitta_mm2 = 1e-4 * aperture_mm2;
        assert!(
            (drawn_mm2 - patch.area_mm2).abs() <= sagitta_mm2,
            "{drawn_mm2}: {}",
            patch.area_mm2
        );
        let rings_mm2: f64 = patch.polygons.iter().map(shoelace_mm2).sum();
        assert!((rings_mm2 - drawn_mm2).abs() <= 1e-9 * aperture_mm2);
        assert!(patch.polygons.iter().any(|polygon| contains(polygon, patch.inside_mm)));
    }
    assert!(found.patches.is_sorted_by(|left, right| left.missing_mm2() >= right.missing_mm2()));
}

fn shoelace_mm2(polygon: &Polygon) -> f64 {
    let ring = |places: &[[f64; 2]]| {
        let pairs = places.iter().zip(places.iter().cycle().skip(1));
        let [x, y] = places[0];
        let twice = pairs.map(|(p, q)| (p[0] - x) * (q[1] - y) - (p[1] - y) * (q[0] - x));
        0.5 * twice.sum::<f64>()
    };
    polygon.rings().map(|line| ring(&line.places_mm)).sum()
}

fn contains(polygon: &Polygon, [x, y]: [f64; 2]) -> bool {
    let crossings = polygon.rings().flat_map(|ring| {
        let places = &ring.places_mm;
        places.iter().zip(places.iter().cycle().skip(1)).filter(|(p, q)| {
            (p[1] > y) != (q[1] > y) && p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]) > x
        })
    });
    crossings.count() % 2 == 1
}

/// Nodes of a raster of pitch 1 over 0..=width, 0..=height.
fn nodes(width: i32, height: i32) -> impl Iterator<Item = [f64; 2]> + Clone {
    (0..=height).flat_map(move |j| (0..=width).map(move |i| [f64::from(i), f64::from(j)]))
}

fn flat([x, y]: [f64; 2]) -> PointMm {
    [x, y, 0.0]
}

/// The area of a unit square within a distance of ½ to 1/√2 of its corners: quarters of discs, of which two
/// neighbours have half a segment in common.
fn near_corners_mm2(reach: f64) -> f64 {
    let segment = reach * reach * (0.5 / reach).acos() - 0.5 * (reach * reach - 0.25).sqrt();
    PI * reach * reach - 4.0 * segment
}

/// The width of a strip along a line of samples every mm that is within the target of them.
fn strip_mm() -> f64 {
    let reach: f64 = 1.2 * 0.5_f64.sqrt();
    let [half, height] = [0.5, (reach * reach - 0.25).sqrt()];
    height * half + reach * reach * (half / reach).asin()
}

/// Half the diagonal of the raster's squares is within, a missing line is not.
fn target() -> Target {
    Target::spacing_mm(1.2)
}

fn near(found: f64, expected: f64, share: f64) -> bool {
    (found - expected).abs() <= share * expected
}

#[test]
fn a_raster_that_fits_its_aperture_covers_it() {
    let mesh = meshed(nodes(30, 20).map(flat));
    let aperture = Aperture::rectangle([15.0, 10.0], 30.0, 20.0).unwrap();
    let found = covered(&mesh, Some(&aperture), &target());
    assert_eq!(found.coverage(), Some(1.0));
    assert_eq!((found.patches.len(), found.remainder_patches), (0, 0));
    let gap = found.gap_mm.unwrap();
    assert!(near(gap.median, (0.5 / PI).sqrt(), 1e-6) && gap.max == 0.5_f64.sqrt(), "{gap:?}");
    assert!(near(near_corners_mm2(gap.p99), 0.99, 1e-6), "{gap:?}");
    assert_eq!(found.triangles.covered, 1200);
    // A raster of just the target's spacing meets it.
    let found = covered(&mesh, Some(&aperture), &Target::spacing_mm(1.0));
    assert_eq!(found.coverage(), Some(1.0));
    // One a little finer is met nowhere in the middle of squares: all was scanned, and is to be scanned again.
    let found = covered(&mesh, Some(&aperture), &Target::spacing_mm(0.99));
    let areas = found.areas.unwrap();
    let beyond_mm2 = 600.0 * (1.0 - near_corners_mm2(0.99 * 0.5_f64.sqrt()));
    assert!(near(areas.undersampled_mm2, beyond_mm2, 1e-3), "{areas:?}, not {beyond_mm2}");
    assert_eq!(areas.uncovered_mm2, 0.0);
    assert_eq!(found.patches.len(), 1);
    assert!(near(found.patches[0].area_mm2, 600.0, 1e-12));
    assert_eq!(found.patches[0].polygons.len(), 1);
}

#[test]
fn areas_in_a_circle_and_a_ring_are_those_of_the_formula() {
    let mesh = meshed(nodes(40, 40).map(flat));
    for offset in [0.0, 0.31] {
        let centre = [20.0 + offset, 20.0 - offset];
        for (aperture, expected) in [
            (Aperture::circle(centre, 15.2).unwrap(), PI * 15.2 * 15.2),
            (Aperture::annulus(centre, 6.0, 15.0).unwrap(), PI * (225.0 - 36.0)),
        ] {
            let areas = covered(&mesh, Some(&aperture), &target()).areas.unwrap();
            assert!(near(areas.covered_mm2, expected, 1e-13), "{areas:?}, not {expected}");
            assert!(areas.uncovered_mm2 <= 1e-10);
        }
    }
}

#[test]
fn a_rectangle_of_missing_points_is_first_and_as_large_as_it_is() {
    // Missing are the nodes strictly inside 30..90 × 40..80.
    let inside = |[x, y]: [f64; 2]| x > 30.0 && x < 90.0 && y > 40.0 && y < 80.0;
    let mesh = meshed(nodes(140, 120).filter(|&place| !inside(place)).map(flat));
    for aperture in [
        Aperture::rectangle([70.0, 60.0], 140.0, 120.0).unwrap(),
        Aperture::circle([65.0, 60.0], 58.0).unwrap(),
    ] {
        let found = covered(&mesh, Some(&aperture), &target());
        let first = &found.patches[0];
        assert!(near(first.area_mm2, 2400.0, 0.02), "{}", first.area_mm2);
        let beyond_mm2 = (60.0 - 2.0 * strip_mm()) * (40.0 - 2.0 * strip_mm());
        assert!(near(first.uncovered_mm2, beyond_mm2, 0.01), "{first:?}, not {beyond_mm2}");
        assert_eq!((found.patches.len(), first.polygons.len()), (1, 1));
        assert!(inside(first.inside_mm) && first.polygons[0].holes.is_empty());
        assert!(near(first.spacing.mm().unwrap(), 1.2, 1e-15));
        assert!(first.gap_max_mm.is_some_and(|gap| near(gap, 20.0, 0.05)), "{first:?}");
        let open = &first.polygons[0].outline.open;
        assert!(open.iter().all(|open| !open), "samples are all around");
    }
    // Without an aperture the outline of the data stands in.
    let found = covered(&mesh, None, &target());
    assert_eq!(found.reference, Reference::DataOutline);
    assert!(near(found.areas.unwrap().aperture_mm2, 140.0 * 120.0, 1e-12));
    assert!(near(found.patches[0].area_mm2, 2400.0, 0.02));
}

/// A raster of 160 × 120 with a stripe over x 60..100 in which `keep` says which nodes stay.
fn striped(jitter: f64, keep: impl Fn(i32, i32) -> bool) -> Mesh {
    let mut rng = Pcg64::seed_from_u64(5);
    let mut off = || jitter * ((rng.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0);
    let kept =
        nodes(160, 120).filter(|&[x, y]| x <= 60.0 || x >= 100.0 || keep(x as i32, y as i32));
    let points: Vec<PointMm> = kept.map(|[x, y]| [x + off(), y + off(), 0.0]).collect();
    meshed(points)
}

#[test]
fn a_stripe_at_a_tenth_of_the_density_is_one_region() {
    let aperture = Aperture::rectangle([80.0, 60.0], 156.0, 110.0).unwrap();
    let area_mm2 = 40.0 * 110.0;
    let lines: fn(i32, i32) -> bool = |x, _| x % 10 == 0;
    let along: fn(i32, i32) -> bool = |_, y| y % 10 == 0;
    let both: fn(i32, i32) -> bool = |x, y| x % 3 == 0 && y % 3 == 0;
    // What is near no sample of the stripe, nor of the raster beside it.
    let strip_mm = strip_mm();
    let between_mm = 40.0 - 2.0 * strip_mm;
    let of_lines_mm2 = (40.0 - 8.0 * strip_mm) * 110.0;
    let of_rows_mm2 = between_mm * (110.0 - 22.0 * strip_mm);
    let of_both_mm2 = between_mm * 110.0 * (1.0 - PI * 0.72 / 9.0);
    for (name, keep, beyond_mm2) in
        [("lines", lines, of_lines_mm2), ("along", along, of_rows_mm2), ("both", both, of_both_mm2)]
    {
        for jitter in [0.0, 0.05] {
            let mesh = striped(jitter, keep);
            let found = covered(&mesh, Some(&aperture), &target());
            let first = &found.patches[0];
            assert!(near(first.area_mm2, area_mm2, 0.02), "{name}: {}", first.area_mm2);
            assert!(found.patches.len() == 1, "{name}: {:?}", found.patches.len());
            assert!(
                first.undersampled_mm2 > 0.98 * first.missing_mm2(),
                "{name}: {}",
                first.uncovered_mm2
            );
            let found_mm2 = found.areas.unwrap().undersampled_mm2;
            assert!(near(found_mm2, beyond_mm2, 0.02), "{name}: {found_mm2}, not {beyond_mm2}");
        }
    }
}

#[test]
fn a_wedge_left_out_of_a_spiral_is_first_and_as_large_as_it_is() {
    let (pitch, turns) = (1.0, 150.0);
    let wedge = |[x, y]: [f64; 2]| (0.3..1.3).contains(&y.atan2(x));
    let count = (PI * turns * turns) as i32;
    let spiral = (0..count).map(|i| {
        let turn = (4.0 * PI * f64::from(i)).sqrt();
        let radius = pitch * turn / (2.0 * PI);
        [radius * turn.cos(), radius * turn.sin()]
    });
    // Where the scan was left and taken up again there is a sample on each turn.
    let edges = (1..150).flat_map(|turn| {
        [0.3_f64, 1.3].map(|angle| {
            let radius = pitch * (f64::from(turn) + angle / (2.0 * PI));
            [radius * angle.cos(), radius * angle.sin()]
        })
    });
    let mesh = meshed(spiral.filter(|&place| !wedge(place)).chain(edges).map(flat));
    let radius_mm = 146.0;
    let aperture = Aperture::circle([0.0; 2], radius_mm).unwrap();
    let found = covered(&mesh, Some(&aperture), &Target::spacing_mm(1.5));
    let expected_mm2 = 0.5 * radius_mm * radius_mm;
    let first = &found.patches[0];
    assert!(near(first.area_mm2, expected_mm2, 0.02), "{} not {expected_mm2}", first.area_mm2);
    // But for a strip along either edge.
    let beyond_mm2 = expected_mm2 - 2.0 * radius_mm * 1.02;
    assert!(near(first.uncovered_mm2, beyond_mm2, 0.02), "{first:?}");
    assert!(wedge(first.inside_mm));
    assert_eq!(first.polygons.len(), 1);
    assert!(
        found.remainder_mm2 + found.patches[1..].iter().map(|it| it.area_mm2).sum::<f64>() < 30.0
    );
}

#[test]
fn what_is_outside_the_hull_is_uncovered() {
    // The upper half of a disc is not scanned yet, nor a seam of 0.4 around the rest.
    let mesh = meshed(nodes(40, 20).map(flat));
    let aperture = Aperture::rectangle([20.0, 20.0], 40.8, 40.8).unwrap();
    let found = covered(&mesh, Some(&aperture), &target());
    let areas = found.areas.unwrap();
    assert_eq!((areas.covered_mm2, areas.undersampled_mm2), (800.0, 0.0));
    assert!(near(areas.uncovered_mm2, 40.8 * 40.8 - 800.0, 1e-13));
    // One region, without most of the seam.
    assert_eq!(found.patches.len(), 1);
    let first = &found.patches[0];
    let upper_mm2 = 20.4 * 40.8;
    assert!(
        first.area_mm2 >= upper_mm2 - 16.0 && first.area_mm2 <= upper_mm2 + 16.0,
        "{}",
        first.area_mm2
    );
    assert_eq!((first.gap_max_mm, first.epsilon_max), (None, None));
    assert!(found.remainder_patches > 20 && found.remainder_mm2 < 33.0);
}

#[test]
fn an_aperture_beside_the_data_or_without_any_is_one_region() {
    let aperture = Aperture::circle([500.0, 0.0], 10.0).unwrap();
    let line = meshed((0..9).map(|i| [f64::from(i), f64::from(i), 0.0]));
    let same = meshed((0..9).map(|_| [1.0, 2.0, 3.0]));
    for mesh in
        [meshed(nodes(20, 20).map(flat)), Mesh::new(), meshed([[500.0, 0.0, 0.0]]), line, same]
    {
        let found = covered(&mesh, Some(&aperture), &target());
        assert_eq!(found.coverage(), Some(0.0));
        assert_eq!((found.gap_mm, found.epsilon, found.lfs_min_mm), (None, None, None));
        assert_eq!(found.patches.len(), 1);
        let first = &found.patches[0];
        assert_eq!((first.area_mm2, first.gap_max_mm), (aperture.area_mm2(), None));
        assert!(near(first.spacing.mm().unwrap(), 1.2, 1e-15));
        let found = covered(&Mesh::new(), None, &target());
        assert_eq!((found.areas, found.coverage()), (None, None));
        assert!(found.patches.is_empty());
    }
}

#[test]
fn what_is_refused() {
    let mesh = meshed(nodes(3, 3).map(flat));
    let triangles = mesh.triangles();
    for target in [Target::epsilon(0.0), Target::epsilon(-1.0), Target::spacing_mm(f64::NAN)] {
        let found = cover(mesh.points(), &triangles, &[], None, &target, |_, _| None);
        assert!(matches!(found, Err(CoverageError::Target(_))), "{found:?}");
    }
    let mut points = mesh.points().to_vec();
    points[3][2] = f64::NAN;
    let found = cover(&points, &triangles, &[], None, &target(), |_, _| None);
    assert_eq!(found, Err(CoverageError::Point { vertex: 3 }));
    // An inner triangle is missing, or one is there alone.
    let aperture = Aperture::circle([1.0; 2], 1.0).unwrap();
    let mut holed = triangles.clone();
    holed.remove(holed.len() / 2);
    for aperture in [None, Some(&aperture)] {
        let found = cover(mesh.points(), &holed, &[], aperture, &target(), |_, _| None);
        assert_eq!(found, Err(CoverageError::NotAMesh { triangles: holed.len() }));
    }
}

#[test]
fn where_the_local_feature_size_is_not_known_nothing_is_covered_by_epsilon() {
    let mesh = meshed(nodes(20, 20).map(flat));
    let triangles = mesh.triangles();
    let aperture = Aperture::rectangle([10.0, 10.0], 20.0, 20.0).unwrap();
    let found = |lfs: &(dyn Fn(f64, f64) -> Option<f64> + Sync)| {
        let found = cover(mesh.points(), &triangles, &[], Some(&aperture), &Target::default(), lfs)
            .unwrap();
        assert_sums(&found);
        found
    };
    let half = found(&|x, _| (x <= 10.0).then_some(50.0));
    let areas = half.areas.unwrap();
    assert_eq!((areas.covered_mm2, areas.undersampled_mm2), (200.0, 200.0));
    assert_eq!(areas.lfs_unknown_mm2, 200.0);
    assert_eq!(half.lfs_min_mm, Some(50.0));
    assert!(near(half.epsilon.unwrap().max, 0.5_f64.sqrt() / 50.0, 1e-12));
    let never = found(&|_, _| None);
    assert_eq!((never.coverage(), never.epsilon, never.lfs_min_mm), (Some(0.0), None, None));
    assert_eq!(never.patches[0].spacing, Spacing::Unknown);
    for no_number in [0.0, -1.0, f64::NAN] {
        assert_eq!(found(&|_, _| Some(no_number)), never);
    }
    let plane = found(&|_, _| Some(f64::INFINITY));
    assert_eq!((plane.coverage(), plane.epsilon.unwrap().max), (Some(1.0), 0.0));
    // A target of spacing needs no local feature size.
    let both = Target { spacing_mm: Some(1.2), ..Target::default() };
    let spacing = |target: &Target| {
        let found = cover(mesh.points(), &triangles, &[], Some(&aperture), target, |_, _| None);
        found.unwrap().coverage()
    };
    assert_eq!((spacing(&target()), spacing(&both)), (Some(1.0), Some(0.0)));
}

#[test]
fn triangles_left_out_are_not_covered() {
    let mesh = meshed(nodes(9, 9).map(flat));
    let triangles = mesh.triangles();
    let aperture = Aperture::rectangle([4.5, 4.5], 9.0, 9.0).unwrap();
    let found = cover(mesh.points(), &triangles, &[3, 70], Some(&aperture), &target(), |_, _| None)
        .unwrap();
    assert_sums(&found);
    assert_eq!((found.triangles.bridging, found.areas.unwrap().uncovered_mm2), (2, 1.0));
}

#[test]
fn a_notch_in_the_outline_is_not_counted_without_an_aperture() {
    let notch = |[x, y]: [f64; 2]| x > 20.0 && x < 40.0 && y > 30.0;
    let hole = |[x, y]: [f64; 2]| x > 10.0 && x < 20.0 && y > 10.0 && y < 20.0;
    let kept = nodes(60, 60).filter(|&place| !notch(place) && !hole(place));
    let mesh = meshed(kept.map(flat));
    let found = covered(&mesh, None, &target());
    // But for triangles in the corners of notch and hole.
    let areas = found.areas.unwrap();
    assert!(near(areas.aperture_mm2, 3600.0 - 600.0, 0.01), "{areas:?}");
    let beyond_mm2 = (10.0 - 2.0 * strip_mm()).powi(2);
    let found_mm2 = areas.uncovered_mm2 + areas.undersampled_mm2;
    assert!((found_mm2 - beyond_mm2).abs() < 5.0, "{areas:?}, not {beyond_mm2}");
    let first = &found.patches[0];
    assert!(hole(first.inside_mm), "{first:?}");
    let whole = Aperture::rectangle([30.0, 30.0], 60.0, 60.0).unwrap();
    let found = covered(&mesh, Some(&whole), &target());
    assert!(notch(found.patches[0].inside_mm) && hole(found.patches[1].inside_mm));
    assert!(near(found.patches[0].area_mm2, 600.0, 0.02));
    assert_eq!(found.patches.len(), 2);
}

#[test]
fn measuring_at_the_waypoints_covers_what_was_left() {
    let inside = |[x, y]: [f64; 2]| x > 10.0 && x < 40.0 && y > 12.0 && y < 50.0;
    let oblique = |[x, y]: [f64; 2]| y + x > 90.0 && y + x < 100.0;
    let start = nodes(60, 60).filter(|&place| !inside(place) && !oblique(place) && place[1] < 57.0);
    for aperture in [
        Aperture::rectangle([30.0, 30.0], 60.0, 60.0).unwrap(),
        Aperture::circle([30.0, 30.0], 31.0).unwrap(),
    ] {
        let mut mesh = meshed(start.clone().map(flat));
        let before = covered(&mesh, Some(&aperture), &target());
        let places = waypoints(&before.patches, None, 100_000).unwrap();
        let wanted: f64 = before.patches.iter().map(|patch| patch.samples_needed().unwrap()).sum();
        let count = places.len() as f64;
        assert!(count < 1.6 * wanted && count > 0.9 * wanted, "{count} for {wanted}");
        let in_its_patch = |place: &Waypoint| {
            before.patches[place.patch - 1].polygons.iter().any(|it| contains(it, place.at_mm))
        };
        assert!(places.iter().filter(|place| !in_its_patch(place)).count() <= places.len() / 50);
        mesh.insert(&places.iter().map(|place| flat(place.at_mm)).collect::<Vec<_>>());
        let after = covered(&mesh, Some(&aperture), &target());
        let (before, after) = (before.coverage().unwrap(), after.coverage().unwrap());
        assert!(before < 0.65 && after > 0.985, "{before} to {after}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Scattered points, any aperture: the sums hold, and a grid of places finds the same area.
    #[test]
    fn a_grid_of_places_finds_the_same(
        seed in 0_u64..1_000_000,
        count in 3_usize..120,
        shape in 0_usize..4,
        centre in prop::array::uniform2(-0.2..1.2_f64),
        size in 0.05..0.9_f64,
        spacing in 0.03..0.4_f64,
        far in prop::sample::select(vec![0.0, 1e6]),
    ) {
        let mut rng = Pcg64::seed_from_u64(seed);
        let mut unit = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mesh = meshed((0..count).map(|_| [far + unit(), unit(), 0.1 * unit()]));
        let [x, y] = [centre[0] + far, centre[1]];
        let aperture = match shape {
            0 => Aperture::circle([x, y], size),
            1 => Aperture::annulus([x, y], 0.4 * size, size),
            2 => Aperture::rectangle([x, y], size, 1.7 * size),
            _ => {
                // A star with a hole.
                let ring = |spikes: i32, scale: f64| {
                    (0..2 * spikes).map(|i| {
                        let r = size * scale * if i % 2 == 0 { 1.0 } else { 0.45 };
                        let (sin, cos) = (f64::from(i) * PI / f64::from(spikes)).sin_cos();
                        [x + r * cos, y + r * sin]
                    }).collect::<Vec<_>>()
                };
                Aperture::polygon(&ring(5, 1.0), &[ring(3, 0.3)])
            }
        }.unwrap();
        let target = Target::spacing_mm(spacing);
        let found = covered(&mesh, Some(&aperture), &target);
        let open = &found.patches;
        let [low, high] = aperture.bounds_mm();
        let cells = 120;
        let (mut inside, mut within) = (0, 0);
        for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
            let share = |k: i32| (f64::from(k) + 0.5) / f64::from(cells);
            let at = [low[0] + share(i) * (high[0] - low[0]), low[1] + share(j) * (high[1] - low[1])];
            if aperture.contains(at) {
                inside += 1;
                within += i32::from(open.iter().flat_map(|it| &it.polygons).any(|it| contains(it, at)));
            }
        }
        let cell_mm2 = (high[0] - low[0]) * (high[1] - low[1]) / f64::from(cells * cells);
        prop_assert!(near(f64::from(inside) * cell_mm2, aperture.area_mm2(), 0.02));
        let open_mm2: f64 = open.iter().map(|patch| patch.area_mm2).sum();
        let seen_mm2 = f64::from(within) * cell_mm2;
        prop_assert!((seen_mm2 - open_mm2).abs() <= 0.03 * aperture.area_mm2(), "{seen_mm2}, not {open_mm2}");
    }

    /// On lattices, borders of the aperture through samples and along sides.
    #[test]
    fn lattices_with_the_border_on_them(
        kept in prop::collection::vec(any::<bool>(), 81),
        low in prop::array::uniform2(-1_i32..6),
        size in prop::array::uniform2(1_i32..9),
        round in any::<bool>(),
    ) {
        let places = nodes(8, 8).zip(&kept).filter_map(|(place, keep)| keep.then_some(place));
        let mesh = meshed(places.map(flat));
        let [x, y] = low.map(f64::from);
        let [width, height] = size.map(f64::from);
        let aperture = if round {
            Aperture::circle([x + 1.0, y + 1.0], width)
        } else {
            Aperture::polygon(&[[x, y], [x + width, y], [x + width, y + height], [x, y + 1.0]], &[])
        }.unwrap();
        let with = covered(&mesh, Some(&aperture), &target());
        prop_assert!(with.coverage().is_some());
        let without = covered(&mesh, None, &target());
        prop_assert_eq!(without.coverage().is_some(), mesh.counts().triangles > 0);
    }
}

//! Reduction against its rule taken literally, against ε and noise as they are defined, and against
//! surfaces whose figures are known.

use asphera_surface::reduce::{
    Fate, Reducer, Spacing, Split, Target, TargetError, average, crumpled_fraction,
    curvature_bound, noise_limit_mm, noise_of, reduce, spread,
};
use asphera_surface::{Criteria, Mesh, PointMm, Rejection, VertexId, assess};
use proptest::prelude::*;

use crate::lenses::{grid_lens, lfs_mm, spiral_lens};
use crate::patterns::{PITCH_MM, jittered_raster, raster, scattered};
use crate::shapes::{Random, Sampled, over_square};

fn meshed(points: &[PointMm]) -> Mesh {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    mesh
}

fn distance_mm(p: PointMm, q: PointMm) -> f64 {
    ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2) + (p[2] - q[2]).powi(2)).sqrt()
}

fn chosen(points: &[PointMm], kept: &[VertexId]) -> Vec<PointMm> {
    kept.iter().map(|&index| points[index as usize]).collect()
}

fn thinned(points: &[PointMm], spacing_mm: f64) -> Vec<PointMm> {
    let spacing = Spacing::given(spacing_mm).expect("a length");
    let mut reducer = Reducer::new();
    points.iter().for_each(|&point| _ = reducer.take(point, spacing));
    reducer.points().to_vec()
}

/// The rule taken literally: every point against all kept before it.
fn literally(points: &[(PointMm, f64)]) -> Vec<u64> {
    let mut kept: Vec<(u64, PointMm)> = Vec::new();
    for (index, &(point, spacing_mm)) in (0..).zip(points) {
        let near =
            |&(_, other): &(u64, PointMm)| distance_mm(point, other) < spacing_mm * (1.0 - 1e-9);
        if !kept.iter().any(near) {
            kept.push((index, point));
        }
    }
    kept.into_iter().map(|(index, _)| index).collect()
}

proptest! {
    #[test]
    fn any_points_with_any_spacings_follow_the_rule(
        // Steps of a quarter, so that many distances agree with a spacing; spacings over seven
        // powers of two.
        points in prop::collection::vec(
            (prop::array::uniform3(-12_i16..12), prop::sample::select(vec![
                0.0, 0.25, 0.26, 0.5, 0.75, 1.0, 1.1, 2.0, 3.0, 7.9, 16.0,
            ])),
            0..150,
        ),
        offset in prop::sample::select(vec![0.0, 1e3, -1e6]),
    ) {
        let points: Vec<(PointMm, f64)> = points
            .into_iter()
            .map(|(p, spacing)| (p.map(|steps| offset + 0.25 * f64::from(steps)), spacing))
            .collect();
        let mut reducer = Reducer::new();
        let mut fates = Vec::new();
        for &(point, spacing_mm) in &points {
            fates.push(reducer.take(point, Spacing::given(spacing_mm).unwrap()));
        }
        prop_assert_eq!(reducer.arrivals(), literally(&points));
        for (&(point, spacing_mm), fate) in points.iter().zip(fates) {
            match fate {
                Fate::Kept(number) => prop_assert_eq!(reducer.points()[number as usize], point),
                Fate::Dropped { by } => {
                    let by = reducer.points()[by as usize];
                    prop_assert!(distance_mm(by, point) < spacing_mm);
                }
                Fate::Rejected(_) => prop_assert!(false, "all points are finite"),
            }
        }
    }

    #[test]
    fn scattered_points_of_any_scale_follow_the_rule(
        seed in 0_u64..1000,
        scale in -30_i32..30,
        per_spacing in 0.5..20.0,
    ) {
        let side_mm = 2.0_f64.powi(scale);
        let spacing_mm = side_mm / per_spacing;
        let points: Vec<(PointMm, f64)> = over_square(
            Sampled::Scattered { count: 300, seed },
            side_mm,
            |x, y| 0.3 * (x - y),
        )
        .into_iter()
        .map(|point| (point, spacing_mm * (1.0 + 0.4 * point[0] / side_mm)))
        .collect();
        let mut reducer = Reducer::new();
        for &(point, spacing_mm) in &points {
            reducer.take(point, Spacing::given(spacing_mm).unwrap());
        }
        prop_assert_eq!(reducer.arrivals(), literally(&points));
    }

    #[test]
    fn sides_at_the_noise_limit_keep_every_facet_from_crumpling(
        corners in prop::array::uniform3(prop::array::uniform3(-1.0..1.0)),
        share in 1.0_f64..3.0,
    ) {
        let side_mm = distance_mm(corners[0], corners[1])
            .min(distance_mm(corners[1], corners[2]))
            .min(distance_mm(corners[2], corners[0]));
        prop_assume!(side_mm > 1e-3);
        let lfs_mm = 5.0;
        let sigma_mm = (side_mm / share).powi(2) / (12.0_f64.sqrt() * lfs_mm);
        prop_assert!((noise_limit_mm(sigma_mm, lfs_mm) * share - side_mm).abs() < 1e-12);
        let target = Target::new(0.1, 100.0).unwrap();
        let found =
            crumpled_fraction(&corners, [[0, 1, 2]], &target, sigma_mm, |_| Some(lfs_mm));
        prop_assert_eq!(found, Some(0.0));
    }
}

#[test]
fn the_noise_limit_is_where_equilateral_facets_begin_to_crumple() {
    let target = Target::new(0.1, 100.0).unwrap();
    let crumpled = |side_mm: f64| {
        let apex = [0.5 * side_mm, 0.75_f64.sqrt() * side_mm, 3.0];
        let points = [[0.0, 0.0, 3.0], [side_mm, 0.0, 3.0], apex];
        crumpled_fraction(&points, [[0, 1, 2]], &target, 1e-5, |_| Some(10.0))
    };
    let limit_mm = noise_limit_mm(1e-5, 10.0);
    assert!((limit_mm - 0.018_612).abs() < 1e-6, "{limit_mm}");
    assert_eq!(crumpled(limit_mm * (1.0 + 1e-6)), Some(0.0));
    assert_eq!(crumpled(limit_mm * (1.0 - 1e-6)), Some(1.0));
}

#[test]
fn noise_tilts_facets_as_much_as_stated() {
    // The side at which a right-angled facet crumples gives its tilt: both sides of (2) over
    // 2A·lfs.
    let (sigma_mm, lfs_mm) = (1e-5, 10.0);
    let mut random = Random::new(3);
    let legs_mm = 0.02;
    let count = 40_000;
    let squares: f64 = (0..count)
        .map(|_| {
            let [z0, z1, z2] = [(); 3].map(|()| sigma_mm * random.normal());
            ((z1 - z0) / legs_mm).powi(2) + ((z2 - z0) / legs_mm).powi(2)
        })
        .sum();
    let tilt_rad = (squares / f64::from(count)).sqrt();
    let circumradius_mm = legs_mm * 0.5_f64.sqrt();
    // At this local feature size both are equal, by Monte Carlo.
    let even_mm = circumradius_mm / tilt_rad;
    let points = [[0.0, 0.0, 0.0], [legs_mm, 0.0, 0.0], [0.0, legs_mm, 0.0]];
    let target = Target::new(0.1, 100.0).unwrap();
    let crumpled = |share: f64| {
        let lfs_mm = share * even_mm;
        crumpled_fraction(&points, [[0, 1, 2]], &target, sigma_mm, |_| Some(lfs_mm))
    };
    assert_eq!((crumpled(0.98), crumpled(1.02)), (Some(0.0), Some(1.0)), "{even_mm} {lfs_mm}");
}

#[test]
fn a_raster_stays_a_raster() {
    let points = raster(40);
    // Every second point of every second row: those between are nearer than two pitches.
    let kept = thinned(&points, 2.0 * PITCH_MM);
    assert_eq!(kept.len(), 400);
    let found = spread(&kept).unwrap();
    assert!((found.min_mm - 2.0 * PITCH_MM).abs() < 1e-8, "{found:?}");
    assert_eq!(thinned(&points, 0.99 * PITCH_MM), points);
}

#[test]
fn fills_between_the_covering_and_the_packing_bound() {
    let side_mm = 1.0;
    // Jammed in no order, disks of this size fill 0.547 of the plane, where the lattice fills 0.907
    // (J. Feder, Journal of Theoretical Biology 87 (1980) 237-254): a share of 0.60, never quite
    // reached.
    for (name, sampled, expected) in [
        ("scattered", Sampled::Scattered { count: 200_000, seed: 5 }, 0.54..0.62),
        ("raster", Sampled::Raster { along: 450, across: 450 }, 0.8..1.02),
    ] {
        for spacing_mm in [0.011, 0.0173, 0.02, 0.03] {
            let kept = thinned(&over_square(sampled, side_mm, |_, _| 0.0), spacing_mm).len() as f64;
            let hexagonal = side_mm * side_mm / (spacing_mm * spacing_mm * 0.75_f64.sqrt());
            let filled = kept / hexagonal;
            assert!(expected.contains(&filled), "{name} {spacing_mm}: {filled}");
        }
    }
}

/// The share of the lens crumpled by noise, and its largest ε.
fn condition(points: &[PointMm], target: &Target, sigma_mm: f64) -> (f64, f64) {
    let mesh = meshed(points);
    let crumpled = crumpled_fraction(mesh.points(), mesh.triangles(), target, sigma_mm, lfs_mm);
    let lfs = |x: f64, y: f64| lfs_mm([x, y, 0.0]).expect("a known size");
    let survey = assess(mesh.points(), mesh.triangles(), &Criteria::default(), lfs);
    (crumpled.expect("triangles"), survey.sampling().epsilon_max.expect("triangles"))
}

/// A tenth of the points of each lens, at their own density: too dense for their noise, and not
/// once reduced.
#[test]
fn lenses_too_dense_for_their_noise_pass_once_reduced() {
    let sigma_mm = 20e-6;
    for (name, points) in
        [("grid", grid_lens(527, sigma_mm, 1)), ("spiral", spiral_lens(104_433, sigma_mm, 2))]
    {
        for epsilon in [0.05, 0.01, 0.006] {
            let target = Target::new(epsilon, 20.0).unwrap().with_noise(sigma_mm).unwrap();
            let (crumpled, _) = condition(&points, &target, sigma_mm);
            assert!(crumpled > 0.95, "{name}: {crumpled}");
            let mesh = meshed(&points);
            let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
            assert_eq!(reduction.tally.total(), points.len() as u64);
            assert_eq!(
                reduction.tally.epsilon.kept,
                reduction.kept.len() as u64,
                "{name} {epsilon}"
            );
            let kept = chosen(mesh.points(), &reduction.kept);
            assert!(kept.len() < points.len() / 3, "{name} {epsilon}: {}", kept.len());
            let (crumpled, reached) = condition(&kept, &target, sigma_mm);
            assert_eq!(crumpled, 0.0, "{name} {epsilon}");
            assert!(reached <= epsilon, "{name} {epsilon}: {reached}");
        }
    }
}

/// Each point of the surface, not only each measured one, has a kept one within ε·lfs.
#[test]
fn the_kept_points_are_an_epsilon_sample_of_the_surface() {
    let points = grid_lens(300, 0.0, 1);
    let mesh = meshed(&points);
    for epsilon in [0.02, 0.002, 0.000_5] {
        let target = Target::new(epsilon, 20.0).unwrap();
        let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
        let kept = chosen(mesh.points(), &reduction.kept);
        assert!(kept.len() < points.len(), "{epsilon}");
        // Places of the surface between those measured.
        for place in grid_lens(299, 0.0, 1).into_iter().step_by(97) {
            let nearest_mm =
                kept.iter().map(|&q| distance_mm(place, q)).fold(f64::INFINITY, f64::min);
            assert!(nearest_mm <= epsilon * lfs_mm(place).unwrap(), "{epsilon} at {place:?}");
        }
    }
}

#[test]
fn where_noise_and_epsilon_disagree_the_noise_prevails_and_is_counted() {
    let sigma_mm = 20e-6;
    let points = grid_lens(200, sigma_mm, 4);
    let mesh = meshed(&points);
    // The noise limit is 28 µm; ε would want 11 µm less the gap.
    let target = Target::new(0.001, 20.0).unwrap().with_noise(sigma_mm).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
    let tally = reduction.tally;
    assert_eq!(tally.noise.kept + tally.noise.dropped, points.len() as u64, "{tally:?}");
    let kept = chosen(mesh.points(), &reduction.kept);
    let (crumpled, reached) = condition(&kept, &target, sigma_mm);
    assert_eq!(crumpled, 0.0);
    assert!(reached > 0.001, "{reached}");
}

#[test]
fn a_cloud_not_dense_enough_is_kept_whole_and_said_so() {
    let points = jittered_raster(50, 0.05, 3);
    let mesh = meshed(&points);
    let target = Target::new(0.001, 100.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(1.0));
    assert_eq!(reduction.kept.len(), points.len());
    assert_eq!(reduction.tally.sparse, Split { kept: 2500, dropped: 0 });
    assert_eq!(reduction.sparse_triangles, mesh.counts().triangles);
    assert!((reduction.sparse_area_mm2 - mesh.area().projected_mm2).abs() < 1e-12);
}

#[test]
fn unknown_feature_sizes_keep_all_points() {
    let points = raster(20);
    let mesh = meshed(&points);
    let target = Target::new(0.5, 100.0).unwrap().with_noise(1e-3).unwrap();
    for unknown in [None, Some(0.0), Some(-1.0), Some(f64::NAN)] {
        let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| unknown);
        assert_eq!(reduction.tally.unknown, Split { kept: 400, dropped: 0 });
        assert_eq!(reduction.kept.len(), 400);
    }
}

#[test]
fn a_plane_is_as_large_as_its_feature_size_is_taken_to_be() {
    let points = over_square(Sampled::Raster { along: 200, across: 200 }, 10.0, |_, _| 1.0);
    let mesh = meshed(&points);
    let target = Target::new(0.1, 10.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(f64::INFINITY));
    // Spacing near 0.9 mm, over 10 mm.
    assert!((80..200).contains(&reduction.kept.len()), "{}", reduction.kept.len());
}

#[test]
fn a_spike_stays_to_be_found() {
    let mut points = raster(60);
    points[1234][2] += 1.0;
    let mesh = meshed(&points);
    let target = Target::new(0.01, 5.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(2.0));
    assert!(reduction.kept.contains(&1234));
    assert!(reduction.kept.len() < 1800, "{}", reduction.kept.len());
}

#[test]
fn few_points_and_none() {
    let target = Target::new(0.05, 1.0).unwrap();
    for points in [vec![], vec![[1.0, 2.0, 3.0]], vec![[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]]
    {
        let mesh = meshed(&points);
        let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(1.0));
        assert_eq!(reduction.kept.len(), points.len());
        assert_eq!(reduction.tally.sparse.kept, points.len() as u64);
        assert_eq!(noise_of(&mesh), None);
        assert_eq!(curvature_bound(&points, 0.0), None);
    }
    assert_eq!(spread(&[[0.0; 3]]), None);
    assert_eq!(crumpled_fraction(&[], [], &target, 1e-6, |_| Some(1.0)), None);
}

#[test]
fn points_in_one_place_and_points_that_are_none() {
    let mut reducer = Reducer::new();
    let spacing = Spacing::given(1e-3).unwrap();
    let far = [1e12, -1e12, 5.0];
    assert_eq!(reducer.take(far, spacing), Fate::Kept(0));
    assert_eq!(reducer.take(far, spacing), Fate::Dropped { by: 0 });
    assert_eq!(reducer.take([0.0, f64::NAN, 0.0], spacing), Fate::Rejected(Rejection::NotFinite));
    assert_eq!(reducer.take([0.0, 2e12, 0.0], spacing), Fate::Rejected(Rejection::OutOfRange));
    assert_eq!(reducer.take([0.0; 3], spacing), Fate::Kept(1));
    assert_eq!(reducer.arrivals(), [0, 4]);
    assert_eq!((reducer.tally().rejected, reducer.tally().total()), (2, 5));
    assert_eq!(reducer.tally().given, Split { kept: 2, dropped: 1 });
}

#[test]
fn targets_that_make_no_sense_are_refused() {
    for epsilon in [0.0, -0.1, 1.01, f64::NAN, f64::INFINITY] {
        let error = Target::new(epsilon, 1.0).unwrap_err();
        assert!(
            matches!(error, TargetError::Epsilon(found) if found.to_bits() == epsilon.to_bits())
        );
    }
    assert_eq!(Target::new(0.05, 0.0), Err(TargetError::LfsMax(0.0)));
    assert!(Target::new(0.05, f64::INFINITY).is_err());
    let target = Target::new(0.05, 1.0).unwrap();
    assert_eq!(target.with_noise(-1.0), Err(TargetError::Noise(-1.0)));
    assert!(target.with_noise(f64::NAN).is_err());
    assert_eq!(Spacing::given(-0.1), Err(TargetError::Spacing(-0.1)));
    assert!(Spacing::given(f64::NAN).is_err());
    assert_eq!(
        Target::new(0.0, 1.0).unwrap_err().to_string(),
        "epsilon is 0, expected a number above 0 and up to 1"
    );
}

#[test]
fn noise_is_found_beneath_form_and_outliers() {
    let sigma_mm = 30e-6;
    let points = grid_lens(142, sigma_mm, 9);
    let found = noise_of(&meshed(&points)).unwrap();
    assert!((found.sigma_mm / sigma_mm - 1.0).abs() < 0.05, "{found:?}");
    let mut spoiled = points;
    let mut random = Random::new(10);
    for point in &mut spoiled {
        if random.unit() < 0.02 {
            point[2] += 100.0 * sigma_mm * random.normal();
        }
    }
    // An outlier spoils the quadrics of the twenty vertices about it as well.
    let found = noise_of(&meshed(&spoiled)).unwrap();
    assert!((0.95..2.0).contains(&(found.sigma_mm / sigma_mm)), "{found:?}");
}

#[test]
fn curvature_is_bounded_from_above_and_not_by_much() {
    let radius_mm = 50.0;
    for sigma_mm in [0.0, 1e-5] {
        let mut random = Random::new(11);
        let points: Vec<PointMm> = scattered(40_000, 8.0, 12)
            .into_iter()
            .map(|[x, y, z]| [x, y, z + sigma_mm * random.normal()])
            .collect();
        let found = curvature_bound(&points, sigma_mm).unwrap();
        assert_eq!(found.windows, 64);
        let share = found.radius_mm / radius_mm;
        assert!((0.9..1.001).contains(&share), "{sigma_mm}: {found:?}");
    }
}

#[test]
fn averages_have_the_uncertainty_they_state() {
    let sigma_mm = 50e-6;
    let radius_mm = 50.0;
    let truth = scattered(200_000, 2.0, 13);
    let mut random = Random::new(14);
    let noisy: Vec<PointMm> =
        truth.iter().map(|&[x, y, z]| [x, y, z + sigma_mm * random.normal()]).collect();
    for (spacing_mm, largest_u_mm) in [(0.02, 0.45 * sigma_mm), (0.2, 0.1 * sigma_mm)] {
        let mut reducer = Reducer::new();
        for &point in &noisy {
            reducer.take(point, Spacing::given(spacing_mm).unwrap());
        }
        let kept = reducer.points();
        let found = average(&noisy, kept, sigma_mm, |_| Some(radius_mm));
        assert_eq!(found.points.iter().map(|p| p.measurements).sum::<u64>(), 200_000);
        let mut squares = Vec::new();
        for ((point, &before), &arrival) in found.points.iter().zip(kept).zip(reducer.arrivals()) {
            assert_eq!(point.point_mm[..2], before[..2]);
            let error_mm = point.point_mm[2] - truth[arrival as usize][2];
            squares.push((error_mm / point.u_mm).powi(2));
        }
        let reduced = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        let allowed = 0.02 + 3.0 / (2.0 * squares.len() as f64).sqrt();
        assert!((reduced - 1.0).abs() < allowed, "{spacing_mm}: {reduced}, {} kept", squares.len());
        let mut u_mm: Vec<f64> = found.points.iter().map(|point| point.u_mm).collect();
        u_mm.sort_by(f64::total_cmp);
        assert!(u_mm[u_mm.len() / 2] < largest_u_mm, "{spacing_mm}: {}", u_mm[u_mm.len() / 2]);
    }
}

#[test]
fn averages_shift_a_smooth_surface_by_no_more_than_they_state() {
    let radius_mm = 50.0;
    let points = scattered(20_000, 2.0, 15);
    for (spacing_mm, sigma_mm) in [(0.05, 1e-3), (0.3, 1e-3), (0.3, 0.0)] {
        let kept = thinned(&points, spacing_mm);
        let found = average(&points, &kept, sigma_mm, |_| Some(radius_mm));
        assert!(found.averaged * 10 > 9 * kept.len() as u64);
        for (point, before) in found.points.iter().zip(&kept) {
            let shift_mm = (point.point_mm[2] - before[2]).abs();
            // A quadric on the sphere leaves the fourth order alone.
            let allowed_mm = point.bias_bound_mm.unwrap_or(1e-7);
            assert!(shift_mm <= allowed_mm + 1e-13, "{spacing_mm}: {shift_mm} {point:?}");
        }
    }
}

#[test]
fn a_point_without_surroundings_stays_as_it_was() {
    let kept = [[0.0, 0.0, 1.0], [10.0, 0.0, 2.0]];
    let points = [kept[0], kept[1], [0.1, 0.0, 5.0], [0.2, 0.0, 9.0]];
    let found = average(&points, &kept, 1e-3, |_| None);
    assert_eq!(found.averaged, 0);
    assert_eq!(found.points.iter().map(|p| p.point_mm).collect::<Vec<_>>(), kept);
    assert!(found.points.iter().all(|p| p.u_mm == 1e-3 && p.measurements == 1));
}

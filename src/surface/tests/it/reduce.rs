//! Reduction against its rule taken literally, against ε and noise as they are defined, and against
//! surfaces whose figures are known.

use asphera_geometry::{PointMm, Rejection, VertexId};
use asphera_mesh::Mesh;
use asphera_surface::noise::{Advice, Along, Noise, assess_spacing};
use asphera_surface::reduce::{
    About, Bound, Fate, Keep, Reducer, Spacing, Split, Target, TargetError, curvature_bound,
    reduce, spread,
};
use asphera_surface::{Criteria, assess};
use proptest::prelude::*;

use crate::lenses::{grid_lens, lfs_mm, rastered_lens, spiral_lens, whole_lens};
use crate::patterns::{PITCH_MM, jittered_raster, raster, scattered};
use crate::random::Random;
use crate::shapes::{Sampled, over_square};

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

pub(crate) fn thinned(points: &[PointMm], spacing_mm: f64) -> Vec<PointMm> {
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
    // (E. L. Hinrichsen, J. Feder, T. Jøssang, Journal of Statistical Physics 44 (1986) 793-827,
    // doi:10.1007/BF01011908): a share of 0.60, never quite reached.
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

fn along_z(sigma_mm: f64) -> Noise {
    Noise::new(sigma_mm, Along::Z).expect("a length")
}

/// The share of a surface that is too dense for its noise, and its largest ε.
fn condition(
    points: &[PointMm],
    target: &Target,
    lfs_mm: impl Fn(PointMm) -> Option<f64>,
) -> (f64, f64) {
    let mesh = meshed(points);
    let lfs = |x: f64, y: f64| lfs_mm([x, y, 0.0]).expect("a known size");
    let found =
        assess_spacing(points, mesh.triangles(), target.criteria(), |_, _| target.noise(), lfs);
    // Only slivers are told apart.
    assert!(found.outline_area_mm2 < 0.05 * found.area_mm2, "{} {found:?}", points.len());
    let survey = assess(mesh.points(), mesh.triangles(), &Criteria::default(), lfs);
    let epsilon = survey.sampling().epsilon_max.expect("triangles");
    (found.overdense_fraction.expect("a known noise"), epsilon)
}

/// A tenth of the points of each lens, at their own density and with a noise for which that fails
/// and the one the measured lenses were thinned to passes: it passes once reduced, every facet of it.
#[test]
fn lenses_too_dense_for_their_noise_pass_once_reduced() {
    for (name, points, sigma_mm) in [
        ("grid", grid_lens(527, 100e-6, 1), 100e-6),
        ("spiral", spiral_lens(104_433, 650e-6, 2), 650e-6),
    ] {
        let whole = Target::new(0.05, 20.0).unwrap().with_noise(along_z(sigma_mm)).unwrap();
        let mesh = meshed(&points);
        let (overdense, _) = condition(&points, &whole, lfs_mm);
        assert!(overdense > 0.95, "{name}: {overdense}");
        let mut kept_before = 0;
        for keep in [Keep::Fewest, Keep::Truest, Keep::Most] {
            let target = whole.keeping(keep);
            let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
            assert!(reduction.overdense);
            assert_eq!(reduction.tally.total(), points.len() as u64);
            assert_eq!(reduction.tally.epsilon.retained, reduction.retained.len() as u64);
            let kept = chosen(mesh.points(), &reduction.retained);
            let (overdense, reached) = condition(&kept, &target, lfs_mm);
            eprintln!("{name} {keep:?}: {} of {} {reached}", kept.len(), points.len());
            assert_eq!(overdense, 0.0, "{name} {keep:?}");
            assert!(reached <= 0.05, "{name} {keep:?}: {reached}");
            assert!(
                kept.len() > kept_before && 10 * kept.len() < 6 * points.len(),
                "{name} {keep:?}"
            );
            kept_before = kept.len();
            // Nothing is left to do.
            let mesh = meshed(&kept);
            let again =
                reduce(mesh.points(), mesh.triangles(), &target.keeping(Keep::Most), lfs_mm);
            assert_eq!((again.overdense, again.retained.len()), (false, kept.len()));
        }
    }
}

/// The whole lens, to slopes of 45°: the facets of what is kept pass, not only the distances of kept points.
#[test]
fn a_steep_lens_passes_the_check_once_reduced() {
    for (points, sigma_mm) in [
        (whole_lens(60_000, 0.0, 3), 0.0),
        (whole_lens(300_000, 1e-4, 3), 1e-4),
        (rastered_lens(0.05), 0.0),
        (rastered_lens(0.03), 0.0),
    ] {
        let count = points.len();
        let mesh = meshed(&points);
        for epsilon in [0.05, 0.02] {
            let target = Target::new(epsilon, 20.0).unwrap().with_noise(along_z(sigma_mm)).unwrap();
            for keep in [Keep::Fewest, Keep::Truest] {
                let target = target.keeping(keep);
                let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
                let kept = chosen(mesh.points(), &reduction.retained);
                let (overdense, reached) = condition(&kept, &target, lfs_mm);
                let mended = reduction.mended;
                eprintln!(
                    "{count} {epsilon} {keep:?}: {} kept, {mended} mended, {reached}",
                    kept.len()
                );
                assert!(reached <= epsilon, "{count} {epsilon} {keep:?}: {reached}");
                assert_eq!(overdense, 0.0, "{count} {epsilon} {keep:?}");
                assert_eq!(reduction.tally.retained(), kept.len() as u64);
                assert_eq!(reduction.tally.total(), points.len() as u64);
                if keep == Keep::Fewest {
                    assert!(20 * mended < kept.len() as u64, "{mended}");
                    assert!(5 * kept.len() < count, "{}", kept.len());
                }
            }
        }
    }
}

/// Waves with slopes of 57°: some facets of what the rule keeps are longer than ε allows, and are mended.
#[test]
fn facets_on_a_slope_are_mended() {
    let points = over(28.0, |x, y| 1.5 * (x + 0.3 * y).sin());
    let mesh = meshed(&points);
    let everywhere_mm = |_: PointMm| Some(8.0);
    let target = Target::new(0.05, 20.0).unwrap().with_noise(along_z(0.0)).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, everywhere_mm);
    assert!(reduction.mended > 0, "the rule alone passes: the test tests nothing");
    assert_eq!(reduction.shortfall, None);
    let kept = chosen(mesh.points(), &reduction.retained);
    assert!(condition(&kept, &target, everywhere_mm).1 <= 0.05);
    assert!(2 * kept.len() < points.len(), "{}", kept.len());
}

/// The noises for which both lenses fail at the density they were measured with and pass at that
/// to which they were thinned: the intervals that the documentation of the noise states.
#[test]
fn noises_that_agree_with_the_outcome_of_the_lenses() {
    let target = Target::new(0.05, 20.0).unwrap();
    for (points, thinned, area_mm2, from_nm, to_nm) in [
        (2_782_224.0, 1_023_300.0, 25.0, 75.0, 124.0),
        (1_044_336.0, 301_698.0, 81.0 * std::f64::consts::PI, 390.0, 726.0),
    ] {
        let spacing_mm = |points: f64| (area_mm2 / points).sqrt();
        for (sigma_nm, fails, thinned_fails) in [
            (from_nm - 1.0, false, false),
            (from_nm + 1.0, true, false),
            (to_nm - 1.0, true, false),
            (to_nm + 1.0, true, true),
        ] {
            let bound_mm = target.criteria().even_bound_mm(1e-6 * sigma_nm);
            assert_eq!(spacing_mm(points) < bound_mm, fails, "{sigma_nm}");
            assert_eq!(spacing_mm(thinned) < bound_mm, thinned_fails, "{sigma_nm}");
        }
    }
}

/// Whatever the order and slope, no facet is left that noise turns too far, and one the check finds
/// is thinned.
#[test]
fn the_check_and_the_reduction_agree() {
    let cases: Vec<(&str, Vec<PointMm>)> = [
        Sampled::Raster { along: 120, across: 120 },
        Sampled::Raster { along: 200, across: 70 },
        Sampled::Scattered { count: 15_000, seed: 3 },
        Sampled::Scattered { count: 8_000, seed: 17 },
    ]
    .into_iter()
    .flat_map(|sampled| {
        [("level", 0.0), ("steep", 2.0)].map(|(name, slope)| {
            (name, over_square(sampled, 1.0, move |x, y| slope * x + 0.02 * (x * x + y * y)))
        })
    })
    .collect();
    let lfs_mm = |_: PointMm| Some(4.0);
    for (number, (name, points)) in cases.iter().enumerate() {
        let mesh = meshed(points);
        for sigma_mm in [1e-5, 5e-5, 1e-4, 2e-4, 4e-4, 8e-4] {
            let target = Target::new(0.05, 20.0).unwrap().with_noise(along_z(sigma_mm)).unwrap();
            let (overdense, _) = condition(points, &target, lfs_mm);
            for keep in [Keep::Fewest, Keep::Truest, Keep::Most] {
                let what = format!("{name} {number}, {sigma_mm}, {keep:?}: {overdense}");
                let target = target.keeping(keep);
                let reduction = reduce(points, mesh.triangles(), &target, lfs_mm);
                assert_eq!(reduction.overdense, overdense > 0.0, "{what}");
                let whole = reduction.retained.len() == points.len();
                if keep == Keep::Most {
                    assert_eq!(whole, overdense == 0.0, "{what}");
                }
                assert!(!whole || overdense == 0.0, "{what}");
                let kept = chosen(points, &reduction.retained);
                let (overdense, epsilon) = condition(&kept, &target, lfs_mm);
                assert_eq!(overdense, 0.0, "{what}, {} kept", kept.len());
                // Where noise needs nearly what ε allows, on steep slopes nothing is left between.
                let conflict = *name == "steep" && sigma_mm > 2e-4;
                assert!(conflict || epsilon <= 0.05, "{what}: {epsilon}");
            }
        }
    }
}

#[test]
fn spacings_between_what_noise_needs_and_epsilon_allows() {
    let target = Target::new(0.05, 100.0).unwrap().with_noise(along_z(1e-4)).unwrap();
    let about = About { gap_mm: 0.002, gap_nearby_mm: 0.003, cosine: 0.9 };
    let of = |keep| target.keeping(keep).spacing(Some(20.0), about);
    let narrowest_mm = target.criteria().packed_bound_mm(along_z(1e-4), 0.003, 0.9);
    assert_eq!((of(Keep::Most).mm(), of(Keep::Most).bound()), (narrowest_mm, Bound::Epsilon));
    // Equation (1).
    let widest_mm = 0.05 * (20.0 - 0.002) / 1.05 - 0.002;
    assert!((of(Keep::Fewest).mm() / widest_mm - 1.0).abs() < 1e-12);
    let Some(Advice::Between { recommended_mm, .. }) = target.criteria().advice(0.9e-4, 20.0)
    else {
        panic!("noise and sampling can be satisfied")
    };
    assert!((of(Keep::Truest).mm() / recommended_mm - 1.0).abs() < 1e-12);
    // Noise needs more than ε allows.
    let spacing = target
        .keeping(Keep::Most)
        .spacing(Some(0.1), About { gap_mm: 0.0, gap_nearby_mm: 0.0, cosine: 1.0 });
    assert_eq!(spacing.bound(), Bound::Noise);
    assert!((spacing.mm() / (1e-4 / 0.05 * (1.05 * 6.0_f64.sqrt() + 0.1325)) - 1.0).abs() < 1e-5);
    // Without noise the denser the better.
    let still = Target::new(0.05, 100.0).unwrap();
    for keep in [Keep::Truest, Keep::Most] {
        assert_eq!(still.keeping(keep).spacing(Some(20.0), about).mm(), 0.0);
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
        let kept = chosen(mesh.points(), &reduction.retained);
        assert!(kept.len() < points.len(), "{epsilon}");
        // Places of the surface between those measured.
        for place in grid_lens(299, 0.0, 1).into_iter().step_by(97) {
            let nearest_mm =
                kept.iter().map(|&q| distance_mm(place, q)).fold(f64::INFINITY, f64::min);
            assert!(nearest_mm <= epsilon * lfs_mm(place).unwrap(), "{epsilon} at {place:?}");
        }
    }
}

/// Points in no order over a square have few corners of their hull. Along the curved sides of a cylinder the facets there are chords
/// that leave it by half a millimetre.
#[test]
fn curved_sides_of_points_in_no_order_are_an_epsilon_sample() {
    let mut random = Random::new(15);
    let mut place = || [16.0 * random.unit() - 8.0, 16.0 * random.unit() - 8.0];
    let on = |[x, y]: [f64; 2]| [x, y, 15.0 - (225.0 - x * x).sqrt()];
    let points: Vec<PointMm> = (0..40_000).map(|_| on(place())).collect();
    let mesh = meshed(&points);
    let lfs_mm = |_: PointMm| Some(15.0);
    let epsilon = 0.05;
    let target = Target::new(epsilon, 20.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
    assert_eq!(reduction.shortfall, None);
    let kept = chosen(mesh.points(), &reduction.retained);
    assert!(kept.len() < 1_200, "{}", kept.len());
    for &point in points.iter().step_by(7) {
        let nearest_mm = kept.iter().map(|&q| distance_mm(point, q)).fold(f64::INFINITY, f64::min);
        assert!(nearest_mm <= epsilon * 15.0, "{point:?}");
    }
}

/// Where the measured points are not dense enough along the outline, no reduction could be, and none falls short of it.
#[test]
fn sparse_outlines_are_no_shortfall_of_the_reduction() {
    let mut random = Random::new(15);
    let mut place = || [28.0 * random.unit() - 14.0, 28.0 * random.unit() - 14.0];
    let on = |[x, y]: [f64; 2]| [x, y, 15.0 - (225.0 - x * x).sqrt()];
    let points: Vec<PointMm> = (0..40_000).map(|_| on(place())).collect();
    let mesh = meshed(&points);
    let everywhere_mm = |_: PointMm| Some(8.0);
    let target = Target::new(0.05, 20.0).unwrap().with_noise(along_z(0.0)).unwrap();
    let before = condition(&points, &target, everywhere_mm).1;
    assert!(before > 0.05, "{before}");
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, everywhere_mm);
    assert_eq!(reduction.shortfall, None);
    let kept = chosen(mesh.points(), &reduction.retained);
    assert!(2 * kept.len() < points.len(), "{}", kept.len());
    assert!(condition(&kept, &target, everywhere_mm).1 < 1.01 * before);
}

#[test]
fn where_noise_and_epsilon_disagree_the_noise_prevails_and_is_counted() {
    let sigma_mm = 20e-6;
    let points = grid_lens(200, sigma_mm, 4);
    let mesh = meshed(&points);
    // Noise needs at least 2.58 · 20 µm; ε would want 11 µm less the gap.
    let target = Target::new(0.001, 20.0).unwrap().with_noise(along_z(sigma_mm)).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, lfs_mm);
    let tally = reduction.tally;
    assert_eq!(tally.noise.retained + tally.noise.dropped, points.len() as u64, "{tally:?}");
    let kept = chosen(mesh.points(), &reduction.retained);
    let (overdense, reached) = condition(&kept, &target, lfs_mm);
    assert_eq!(overdense, 0.0);
    assert!(reached > 0.001, "{reached}");
    let short = reduction.shortfall.unwrap();
    assert!(short.facets > 0 && short.epsilon_max > 0.001, "{short:?}");
}

#[test]
fn a_cloud_not_dense_enough_is_kept_whole_and_said_so() {
    let points = jittered_raster(50, 0.05, 3);
    let mesh = meshed(&points);
    let target = Target::new(0.001, 100.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(1.0));
    assert_eq!(reduction.retained.len(), points.len());
    // Nothing was dropped that could mend it.
    assert_eq!(reduction.shortfall, None);
    assert_eq!(reduction.tally.sparse, Split { retained: 2500, dropped: 0 });
    assert_eq!(reduction.sparse_triangles, mesh.counts().triangles);
    assert!((reduction.sparse_area_mm2 - mesh.area().projected_mm2).abs() < 1e-12);
}

#[test]
fn unknown_feature_sizes_keep_all_points() {
    let points = raster(20);
    let mesh = meshed(&points);
    let target = Target::new(0.5, 100.0).unwrap().with_noise(along_z(1e-3)).unwrap();
    for unknown in [None, Some(0.0), Some(-1.0), Some(f64::NAN)] {
        let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| unknown);
        assert_eq!(reduction.tally.unknown, Split { retained: 400, dropped: 0 });
        assert_eq!(reduction.retained.len(), 400);
    }
}

#[test]
fn a_plane_is_as_large_as_its_feature_size_is_taken_to_be() {
    let points = over_square(Sampled::Raster { along: 200, across: 200 }, 10.0, |_, _| 1.0);
    let mesh = meshed(&points);
    let target = Target::new(0.1, 10.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(f64::INFINITY));
    // Spacing near 0.9 mm, over 10 mm.
    assert!((80..200).contains(&reduction.retained.len()), "{}", reduction.retained.len());
}

#[test]
fn a_spike_stays_to_be_found() {
    let mut points = raster(60);
    points[1234][2] += 1.0;
    let mesh = meshed(&points);
    let target = Target::new(0.01, 5.0).unwrap();
    let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(2.0));
    assert!(reduction.retained.contains(&1234));
    assert!(reduction.retained.len() < 1800, "{}", reduction.retained.len());
}

#[test]
fn few_points_and_none() {
    let target = Target::new(0.05, 1.0).unwrap();
    for points in [vec![], vec![[1.0, 2.0, 3.0]], vec![[0.0; 3], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]]
    {
        let mesh = meshed(&points);
        let reduction = reduce(mesh.points(), mesh.triangles(), &target, |_| Some(1.0));
        assert_eq!(reduction.retained.len(), points.len());
        assert_eq!(reduction.tally.sparse.retained, points.len() as u64);
        assert_eq!(curvature_bound(&points, 0.0), None);
    }
    assert_eq!(spread(&[[0.0; 3]]), None);
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
    assert_eq!(reducer.tally().given, Split { retained: 2, dropped: 1 });
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
    assert_eq!(target.with_noise(along_z(2e12)), Err(TargetError::Noise(2e12)));
    for tilt_rad in [0.0, -0.1, 1.6, f64::INFINITY] {
        assert_eq!(target.with_tilt_limit(tilt_rad), Err(TargetError::Tilt(tilt_rad)));
    }
    assert_eq!(target.with_tilt_limit(0.02).unwrap().criteria().tilt_limit_rad(), 0.02);
    assert_eq!(Spacing::given(-0.1), Err(TargetError::Spacing(-0.1)));
    assert!(Spacing::given(f64::NAN).is_err());
    assert_eq!(
        Target::new(0.0, 1.0).unwrap_err().to_string(),
        "epsilon is 0, expected a number above 0 and up to 1"
    );
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

/// A hundredth of the readings wrong, by up to 10,000 times the noise, to one side or to both.
#[test]
fn wrong_readings_do_not_bend_the_surface() {
    let sigma_mm = 1e-5;
    for (share, off_mm) in [(0.01, 0.1), (0.01, 1e-3), (0.2, 0.01)] {
        for sides in [1, 2] {
            let mut random = Random::new(17);
            let points: Vec<PointMm> = scattered(40_000, 8.0, 12)
                .into_iter()
                .map(|[x, y, z]| {
                    let wrong = random.unit() < share;
                    let up = sides == 1 || random.unit() < 0.5;
                    let spike_mm = if up { off_mm } else { -off_mm } * random.unit();
                    [x, y, z + sigma_mm * random.normal() + if wrong { spike_mm } else { 0.0 }]
                })
                .collect();
            let found = curvature_bound(&points, sigma_mm).unwrap();
            let truth = found.radius_mm / 50.0;
            assert!((0.88..1.005).contains(&truth), "{share} {off_mm} {sides}: {found:?}");
        }
    }
}

/// Of a torus and an ellipsoid seen along z, the least radius of curvature over the patch is known: a window's
/// quadric averages over it, so the bound may be above that by what the curvature changes over a window.
#[test]
fn curvature_is_that_of_tori_and_ellipsoids() {
    let (ring_mm, tube_mm) = (30.0, 12.0);
    let torus = |x: f64, y: f64| {
        let out_mm = x.hypot(y + ring_mm) - ring_mm;
        (tube_mm * tube_mm - out_mm * out_mm).sqrt()
    };
    // Over its pole, 2c/a² and c/b² are the curvatures.
    let [a_mm, b_mm, c_mm] = [20.0_f64, 35.0, 15.0];
    let ellipsoid = |x: f64, y: f64| c_mm * (1.0 - (x / a_mm).powi(2) - (y / b_mm).powi(2)).sqrt();
    for (name, points, least_mm) in [
        ("torus", over(4.0, torus), tube_mm),
        ("ellipsoid", over(2.0, ellipsoid), a_mm * a_mm / c_mm),
    ] {
        let found = curvature_bound(&points, 0.0).unwrap();
        let share = found.radius_mm / least_mm;
        // Second derivatives grow off the pole: the bound is then below the radius at it, never above by much.
        assert!((0.8..1.01).contains(&share), "{name}: {share} {found:?}");
    }
}

fn over(side_mm: f64, height_mm: impl Fn(f64, f64) -> f64) -> Vec<PointMm> {
    let half_mm = 0.5 * side_mm;
    let sampled = Sampled::Raster { along: 160, across: 160 };
    over_square(sampled, side_mm, |x, y| height_mm(x - half_mm, y - half_mm))
}

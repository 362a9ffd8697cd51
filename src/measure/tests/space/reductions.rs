//! Reductions of bodies whose local feature size is known, held against it by brute force.

use std::f64::consts::PI;

use asphera_geometry::PointMm;
use asphera_measure::{
    ReducedInSpace, ReductionLimits, ReductionState, Wanted, reduce_in_space, sampling_of_points,
};

use super::bodies::{Turn, ball, cap, noisy, torus, tube};
use super::{Along, part, sphere};

fn by_epsilon(epsilon: f64) -> ReductionLimits {
    ReductionLimits { epsilon: Some(epsilon), rho: None }
}

/// The largest distance from places of the true surface to the nearest kept point, over the local feature size at each.
fn largest_epsilon(found: &ReducedInSpace, places: &[(PointMm, f64)]) -> f64 {
    let of = |(at, lfs_mm): &(PointMm, f64)| {
        let away = |kept: &PointMm| (0..3).map(|axis| (kept[axis] - at[axis]).powi(2)).sum::<f64>();
        let nearest = found.retained_mm.iter().map(away).fold(f64::INFINITY, f64::min);
        nearest.sqrt() / lfs_mm
    };
    places.iter().map(of).fold(0.0, f64::max)
}

fn topology(state: &ReductionState) -> (u64, Option<i64>, u64, u64) {
    (state.components, state.genus, state.border_loops, state.flaws)
}

#[test]
fn a_ball_is_reduced_to_hardly_twice_the_points_that_a_sphere_needs() {
    let points = ball(60_000, 10.0);
    // Other places than those of the points.
    let places: Vec<(PointMm, f64)> = ball(30_011, 10.0).into_iter().map(|at| (at, 10.0)).collect();
    for epsilon in [0.3, 0.1, 0.05] {
        for nominal in [true, false] {
            let part = nominal.then(|| sphere(10.0, ""));
            let found = reduce_in_space(&points, part.as_ref(), by_epsilon(epsilon), None).unwrap();
            let kept = found.retained_mm.len();
            let worst = largest_epsilon(&found, &places);
            let least = 4.0 * PI / (1.5 * 3.0_f64.sqrt() * epsilon * epsilon);
            let times = kept as f64 / least;
            eprintln!(
                "{epsilon} {nominal}: {kept} kept, {times:.2} of a hexagonal cover, largest ε {worst:.4}, share {}, lfs {:?}",
                found.share, found.lfs_mm
            );
            // A share of the limit is the gap of the points themselves.
            assert!(times < 2.0 / (1.0 - 0.022 / epsilon).powi(2), "{epsilon}: {times}");
            assert!(times > 0.8, "{epsilon} {nominal}: {times}");
            let known = if nominal { 1.0 } else { found.lfs_mm[1] / 10.0 };
            assert!(worst <= epsilon * known, "{epsilon} {nominal}: {worst}");
            assert!(
                found.after.epsilon_max <= epsilon && found.away_max_mm <= 10.0 * epsilon * known
            );
            assert_eq!(found.lfs_source, if nominal { "nominal" } else { "measured" });
            assert_eq!(topology(&found.after), (1, Some(0), 0, 0));
            assert_eq!(found.after.facets as usize, 2 * kept - 4);
            // Each was measured.
            let mut all = points.clone();
            all.sort_by(|a, b| a.partial_cmp(b).unwrap());
            assert!(
                found.retained_mm.iter().all(|kept| {
                    all.binary_search_by(|at| at.partial_cmp(kept).unwrap()).is_ok()
                })
            );
        }
    }
}

#[test]
fn a_torus_keeps_its_handle_and_its_limit() {
    let (ring, tube) = (20.0, 6.0);
    let points = torus(60_000, ring, tube);
    let lfs_mm = f64::min(tube, ring - tube);
    let places: Vec<(PointMm, f64)> =
        torus(20_011, ring, tube).into_iter().map(|at| (at, lfs_mm)).collect();
    for epsilon in [0.3, 0.15] {
        let found = reduce_in_space(&points, None, by_epsilon(epsilon), Some(0.0)).unwrap();
        let worst = largest_epsilon(&found, &places);
        eprintln!(
            "{epsilon}: {} kept, largest ε {worst:.4}, share {}, lfs {:?}",
            found.retained_mm.len(),
            found.share,
            found.lfs_mm
        );
        assert!(worst <= epsilon * 1.02, "{epsilon}: {worst}");
        assert!((found.lfs_mm[0] / lfs_mm - 1.0).abs() < 0.05, "{:?}", found.lfs_mm);
        assert_eq!(topology(&found.after), (1, Some(1), 0, 0));
        let least =
            4.0 * PI * PI * ring * tube / (1.5 * 3.0_f64.sqrt() * (epsilon * lfs_mm).powi(2));
        let times = found.retained_mm.len() as f64 / least;
        assert!(times > 0.8 && times < 3.0, "{epsilon}: {times}");
    }
}

#[test]
fn the_reduction_depends_on_the_places_alone_and_samples_as_it_says() {
    let points = noisy(cap(20_000, 10.0, 0.9), [3.0, -2.0, 1.0], 20e-6);
    let limits = ReductionLimits { epsilon: Some(0.1), rho: Some(0.08) };
    let part = sphere(10.0, "");
    let found = reduce_in_space(&points, Some(&part), limits, None).unwrap();
    let mut others: Vec<PointMm> = points.iter().rev().copied().collect();
    others.extend(&points[..100]);
    others.push([f64::NAN, 0.0, 0.0]);
    let again = reduce_in_space(&others, Some(&part), limits, None).unwrap();
    assert_eq!((again.duplicates, again.rejected), (100, 1));
    assert_eq!(again.retained_mm, found.retained_mm);
    assert_eq!(topology(&found.after), topology(&found.before));
    assert_eq!(found.after.border_loops, 1);
    // The smaller of both shares.
    assert!(found.after.rho_max <= 0.08, "{}", found.after.rho_max);
    let wanted = Wanted::new(Some(0.1), Some(0.08), None);
    let sampling =
        sampling_of_points(found.retained_mm.iter().copied(), Along::NONE, wanted).figures;
    assert!(sampling.gap_max_mm.unwrap() <= 0.8, "{:?}", sampling.gap_max_mm);
    // The border stays: the area is that of a cap, but for facets that lie within.
    let area = found.after.area_mm2 / found.before.area_mm2;
    assert!(area > 0.985, "{area}");
    let sigma_nm = 1e6 * found.sigma_mm.unwrap();
    assert!((sigma_nm - 20.0).abs() < 2.0, "{sigma_nm}");
}

#[test]
fn tubes_keep_both_borders_and_plates_their_outline() {
    let turn = Turn::about([1.0, 2.0, -0.5], 0.7);
    let points: Vec<PointMm> =
        tube(30_000, 8.0, 30.0).into_iter().map(|at| turn.moved(at, [3.0, 4.0, 5.0])).collect();
    let shaft = part("[surface]\nkind = \"cylinder\"\nstraight_along = \"x\"\nradius_mm = 8.0\n");
    let found = reduce_in_space(&points, Some(&shaft), by_epsilon(0.2), None).unwrap();
    assert_eq!(topology(&found.after), (1, Some(0), 2, 0));
    assert!(found.after.epsilon_max <= 0.2 && found.retained_mm.len() < 2_000);
    // A plane bends nowhere: a fifth of its width is the limit.
    let plate: Vec<PointMm> = (0..10_000)
        .map(|at| [f64::from(at % 100) * 0.1, f64::from(at / 100) * 0.1, 0.0])
        .map(|at| turn.moved(at, [0.0; 3]))
        .collect();
    let flat = part("[surface]\nkind = \"plane\"\n");
    let found = reduce_in_space(&plate, Some(&flat), by_epsilon(0.1), None).unwrap();
    assert_eq!(topology(&found.after), (1, Some(0), 1, 0));
    assert!(found.lfs_mm[0].is_infinite() && found.after.gap_max_mm <= 0.2 * 9.9);
    assert!(found.retained_mm.len() < 80, "{}", found.retained_mm.len());
}

#[test]
fn what_cannot_be_kept_is_refused_with_its_place() {
    let points = ball(3_000, 10.0);
    let part = sphere(10.0, "");
    let refused = |points: &[PointMm], limits| {
        reduce_in_space(points, Some(&part), limits, None).unwrap_err()
    };
    let why = refused(&points, by_epsilon(0.01));
    assert!(why.contains("all 5996 facets of the points have larger gaps"), "{why}");
    let advised = why.split("--epsilon ").nth(1).unwrap().trim();
    let found = reduce_in_space(&points, Some(&part), by_epsilon(advised.parse().unwrap()), None);
    assert_eq!(found.unwrap().after.components, 1);
    // Half of the ball hardly measured: its points stay, and the others go.
    let mut uneven = ball(60_000, 10.0);
    uneven.retain(|at| at[2] > 0.0);
    uneven.extend(points.iter().filter(|at| at[2] < -0.3));
    let found = reduce_in_space(&uneven, Some(&part), by_epsilon(0.03), None).unwrap();
    let lower = |all: &[PointMm]| all.iter().filter(|at| at[2] < -1.0).count();
    assert_eq!(lower(&found.retained_mm), lower(&points));
    assert!(found.retained_mm.len() < 10_000 && found.sparse.facets > 2_500, "{:?}", found.sparse);
    assert!((found.sparse.area_mm2 / (200.0 * PI) - 1.0).abs() < 0.1, "{:?}", found.sparse);
    assert!(found.sparse.widest_at_mm.unwrap()[2] < 0.0);
    // A hole that is narrower than the kept points are apart would be closed: more of them keep it open, or none do.
    let holed: Vec<PointMm> = ball(60_000, 10.0).into_iter().filter(|at| at[2] < 9.97).collect();
    let why = refused(&holed, by_epsilon(0.9));
    assert!(why.contains("border") && why.contains("mm: allow less"), "{why}");
    let why = refused(&holed, by_epsilon(0.1));
    assert!(why.contains("border loops 1, found 0 about (") && why.contains("9.9"), "{why}");
    let narrow = reduce_in_space(&holed, Some(&part), by_epsilon(0.04), None).unwrap();
    assert_eq!(topology(&narrow.after), (1, Some(0), 1, 0));
    let why = refused(&points[..3], by_epsilon(0.1));
    assert!(!why.is_empty());
}

//! HNN-Crust against its definition on the mesh: the nearest sample and the half neighbour are Delaunay neighbours or are reached along
//! such, which the cells of the search know nothing of.

use std::f64::consts::TAU;

use asphera_contour::curves::{hnn_crust, one_sided_hnn_crust};
use asphera_contour::{Graph, PlaceMm, SampleId, Samples, Triangulation};
use asphera_geometry::predicates::compare_distances;
use proptest::prelude::*;

use crate::places::{Random, circle, lattice, scattered};

/// The edges that both ends choose, and those that one does.
fn of_mesh(set: &Triangulation) -> [Graph; 2] {
    let chosen = |sample: SampleId| -> Vec<SampleId> {
        let Some(nearest) = set.nearest(sample) else { return Vec::new() };
        let [at, first] = [sample, nearest.to].map(|it| set.place(it));
        let is_behind = |other: SampleId| {
            compare_distances(at, set.place(other), first, set.place(other)).is_lt()
        };
        [Some(nearest.to), set.nearest_of(sample, is_behind)].into_iter().flatten().collect()
    };
    let chosen: Vec<Vec<SampleId>> = (0..set.len() as SampleId).map(chosen).collect();
    let all = (0..).zip(&chosen).flat_map(|(p, both)| both.iter().map(move |&q| [p, q]));
    let mutual = all.clone().filter(|&[p, q]| chosen[q as usize].contains(&p));
    [Graph::new(mutual), Graph::new(all)]
}

fn agree(points: &[PlaceMm]) -> bool {
    let samples = Samples::new(points).unwrap();
    let found = [hnn_crust(&samples), one_sided_hnn_crust(&samples)];
    found == of_mesh(&Triangulation::new(samples))
}

/// A closed curve with lobes, its samples jittered along it and off it.
fn flower(count: usize, noise_mm: f64, random: &mut Random) -> Vec<PlaceMm> {
    let lobes = (random.between(0.0, 13.0)).floor();
    let mut place = |index: usize| {
        let angle = TAU * (index as f64 + random.between(0.0, 0.6)) / count as f64;
        let radius = 10.0 + 3.0 * (lobes * angle).cos() + random.between(-noise_mm, noise_mm);
        [radius * angle.cos(), radius * angle.sin()]
    };
    (0..count).map(&mut place).collect()
}

/// Clusters whose spread and distance differ by many powers of two.
fn clusters(count: usize, random: &mut Random) -> Vec<PlaceMm> {
    let centres: Vec<(PlaceMm, f64)> = (0..5)
        .map(|_| {
            let size = 10_f64.powf(random.between(-12.0, 6.0));
            ([random.between(-1e9, 1e9), random.between(-1.0, 1.0)], size)
        })
        .collect();
    let mut place = |index: usize| {
        let (centre, size) = centres[index % centres.len()];
        centre.map(|middle| middle + random.between(-size, size))
    };
    (0..count).map(&mut place).collect()
}

/// Points of several kinds: the number of the kind, then how many.
fn family(kind: usize, count: usize, seed: u64) -> Vec<PlaceMm> {
    let mut random = Random::new(seed);
    match kind {
        0 => scattered(count, seed),
        1 => lattice(count, seed),
        2 => flower(count, 0.0, &mut random),
        3 => flower(count, random.between(0.0, 1.0), &mut random),
        4 => circle(count.max(1)),
        5 => clusters(count, &mut random),
        // Far off, where few bits are left.
        6 => {
            let steps = |value: f64| 1e12 - 2_f64.powi(-13) * (8.0 * value).floor();
            scattered(count, seed).into_iter().map(|place| place.map(steps)).collect()
        }
        // Ever smaller, towards the origin.
        7 => (0..count as i32)
            .map(|index| {
                let size = 2_f64.powi(-(index % 120));
                [random.between(-1.0, 1.0), random.between(-1.0, 1.0)].map(|value| value * size)
            })
            .collect(),
        // A line, and places off it.
        8 => (0..count)
            .map(|index| {
                [if index % 17 == 0 { random.share() } else { 0.5 }, random.between(0.0, 9.0)]
            })
            .collect(),
        // Each place up to four times.
        9 => scattered(count / 2, seed).into_iter().cycle().take(2 * count).collect(),
        // Circles about one place, on which many are equally far.
        10 => (0..count)
            .map(|index| {
                let (sin, cos) = (TAU * (index % 8) as f64 / 8.0).sin_cos();
                [(index / 8) as f64 * cos, (index / 8) as f64 * sin]
            })
            .collect(),
        // A turned lattice: rounding hides which of two are equally far.
        11 => {
            let (sin, cos) = random.between(0.0, TAU).sin_cos();
            let turned = |[x, y]: PlaceMm| [x * cos - y * sin, x * sin + y * cos];
            lattice(count, seed).into_iter().map(turned).collect()
        }
        // A curve, and a twentieth of outliers.
        _ => {
            let mut points = flower(count, 0.0, &mut random);
            points.iter_mut().step_by(20).for_each(|place| {
                *place = [random.between(-50.0, 50.0), random.between(-50.0, 50.0)];
            });
            points
        }
    }
}

const KINDS: usize = 13;

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn of_all_kinds_of_points(kind in 0..KINDS, count in 0_usize..400, seed in 0_u64..100_000) {
        prop_assert!(agree(&family(kind, count, seed)), "kind {kind}, {count} points, seed {seed}");
    }

    #[test]
    fn of_any_points(points in prop::collection::vec([-4_i8..5, -4..5], 0..60), scale in -120_i32..30) {
        let points: Vec<PlaceMm> =
            points.iter().map(|place| place.map(|value| f64::from(value) * 2_f64.powi(scale))).collect();
        prop_assert!(agree(&points));
    }
}

#[test]
fn of_few_points() {
    for count in 0..12 {
        for kind in 0..KINDS {
            assert!(agree(&family(kind, count, 3)), "kind {kind}, {count} points");
        }
    }
}

#[test]
fn of_many_points() {
    for kind in 0..KINDS {
        for count in [2_000, 5_000] {
            assert!(agree(&family(kind, count, 1)), "kind {kind}, {count} points");
        }
    }
    for kind in [0, 2, 5] {
        assert!(agree(&family(kind, 100_000, 1)), "kind {kind}");
    }
}

#[test]
fn by_any_number_of_threads() {
    let points = family(KINDS - 1, 30_000, 5);
    let samples = Samples::new(&points).unwrap();
    let expected = hnn_crust(&samples);
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| hnn_crust(&samples)), expected);
    }
}

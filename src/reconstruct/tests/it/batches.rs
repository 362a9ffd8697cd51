//! Surfaces that take points in batches: after each they are what all points make at once.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use asphera_geometry::PointMm;
use asphera_reconstruct::{LocalSurface, local};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::shapes::{ball, moebius, places, shuffle, torus, uniform};

pub(crate) type Cloud = fn(&mut Pcg64) -> Vec<PointMm>;

pub(crate) const CLOUDS: [(&str, Cloud); 12] = [
    ("exact ball", |_| ball(900, 0.0, 1)),
    ("noisy ball", |random| ball(900, 0.02, random.next_u64())),
    ("random ball", scattered_ball),
    ("exact torus rings", |_| torus(40, 24).0),
    ("exact raster on a cylinder", |_| cylinder()),
    ("dense lines far apart", lines),
    ("knot tube", |_| knot()),
    ("Möbius band", |_| moebius(80, 9).0),
    ("blade with sharp edges", |_| blade()),
    ("crossing sheets", crossing_sheets),
    ("bad and repeated points", bad_points),
    ("clusters far apart", clusters),
];

fn scattered_ball(random: &mut Pcg64) -> Vec<PointMm> {
    (0..1_000)
        .map(|_| {
            let (z, turn) = (2.0 * uniform(random) - 1.0, TAU * uniform(random));
            let radius = (1.0 - z * z).max(0.0).sqrt();
            [10.0 * radius * turn.cos(), 10.0 * radius * turn.sin(), 10.0 * z]
        })
        .collect()
}

fn cylinder() -> Vec<PointMm> {
    let place = |i: u32, j: u32| {
        let turn = TAU * f64::from(i) / 48.0;
        [5.0 * turn.cos(), 5.0 * turn.sin(), 0.5 * f64::from(j)]
    };
    (0..20).flat_map(|j| (0..48).map(move |i| place(i, j))).collect()
}

fn lines(random: &mut Pcg64) -> Vec<PointMm> {
    let mut points = Vec::new();
    for j in 0..6 {
        for i in 0..150 {
            points.push([0.05 * f64::from(i), f64::from(j), 1e-3 * uniform(random)]);
        }
    }
    points
}

fn knot() -> Vec<PointMm> {
    let middle = |t: f64| {
        let out = 3.0 + (3.0 * t).cos();
        [out * (2.0 * t).cos(), out * (2.0 * t).sin(), 1.5 * (3.0 * t).sin()]
    };
    let ring = |i: u32| {
        let t = TAU * f64::from(i) / 160.0;
        let (at, next) = (middle(t), middle(t + 1e-4));
        let way = [next[0] - at[0], next[1] - at[1], next[2] - at[2]];
        let flat = way[0].hypot(way[1]);
        let long = flat.hypot(way[2]);
        let side = [-way[1] / flat, way[0] / flat, 0.0];
        let up = [
            side[1] * way[2] / long,
            -side[0] * way[2] / long,
            (side[0] * way[1] - side[1] * way[0]) / long,
        ];
        (0..10).map(move |j| {
            let turn = TAU * f64::from(j) / 10.0;
            [0, 1, 2].map(|axis| at[axis] + 0.3 * (turn.cos() * side[axis] + turn.sin() * up[axis]))
        })
    };
    (0..160).flat_map(ring).collect()
}

/// A thin plate whose two sides meet in sharp edges.
fn blade() -> Vec<PointMm> {
    let mut points = Vec::new();
    for i in 0..30 {
        for j in 0..=30 {
            let across = f64::from(j) / 30.0;
            let thick = 0.8 * across * (1.0 - across);
            points.push([0.2 * f64::from(i), 4.0 * across, thick]);
            if thick > 0.0 {
                points.push([0.2 * f64::from(i), 4.0 * across, -thick]);
            }
        }
    }
    points
}

fn crossing_sheets(random: &mut Pcg64) -> Vec<PointMm> {
    (0..900)
        .map(|at| {
            let [u, v] = [uniform(random) - 0.5, uniform(random) - 0.5];
            [10.0 * u, 10.0 * v, if at % 2 == 0 { 2.0 * u } else { -3.0 * u + 0.1 * v }]
        })
        .collect()
}

fn bad_points(random: &mut Pcg64) -> Vec<PointMm> {
    let mut points = ball(500, 0.0, 1);
    for at in 0..200 {
        points.push(points[7 * at % 500]);
    }
    points.extend([[f64::NAN; 3], [1e13, 0.0, 0.0], [f64::INFINITY; 3], [0.0, -0.0, 1e-300]]);
    points.extend([[0.0; 3], [-1e-200, 0.0, 0.0], [1e12, -1e12, 1e12]]);
    points.extend([[2.0; 3]; 40]);
    shuffle(&mut points, random.next_u64());
    points
}

fn clusters(random: &mut Pcg64) -> Vec<PointMm> {
    let mut points = Vec::new();
    for (origin, scale) in [(0.0, 1e-9), (1e9, 1.0), (-3e11, 1e3), (1.0, 1e-3)] {
        points.extend(
            ball(200, 0.0, random.next_u64())
                .iter()
                .map(|point| point.map(|value| origin + scale * value)),
        );
    }
    points
}

/// Batches of random sizes, and some of one point and of none.
pub(crate) fn batch_sizes(random: &mut Pcg64, mut left: usize, most: usize) -> Vec<usize> {
    let mut sizes = Vec::new();
    while left > 0 {
        let size = (random.next_u64() as usize % (most + 1)).min(left);
        sizes.push(size);
        left -= size;
    }
    sizes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn after_every_batch_the_surface_is_that_of_all_points_at_once(seed in 0_u64..100_000) {
        for (name, cloud) in CLOUDS {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut points = cloud(&mut random);
            if random.next_u64() % 3 == 0 {
                shuffle(&mut points, seed);
            }
            let most = 1 + random.next_u64() as usize % 300;
            let mut surface = LocalSurface::new();
            let mut held: BTreeSet<[u32; 3]> = BTreeSet::new();
            let mut count = 0;
            for size in batch_sizes(&mut random, points.len(), most) {
                let changes = surface.insert(&points[count..count + size]).unwrap();
                count += size;
                for facet in &changes.removed {
                    prop_assert!(held.remove(facet), "{name}: {facet:?} was not there");
                }
                for &facet in &changes.added {
                    prop_assert!(held.insert(facet), "{name}: {facet:?} was there");
                }
                if most > 30 || random.next_u64() % 16 == 0 || count == points.len() {
                    let expected = local(&points[..count]).unwrap();
                    let found = surface.surface();
                    prop_assert_eq!(&found, &expected, "{} after {} points", name, count);
                    let sorted = |mut facet: [u32; 3]| { facet.sort_unstable(); facet };
                    let facets: BTreeSet<_> = expected.facets.iter().copied().map(sorted).collect();
                    prop_assert_eq!(&held, &facets, "{} after {} points", name, count);
                }
            }
            prop_assert_eq!(surface.received(), points.len());
        }
    }

    #[test]
    fn the_order_of_points_changes_no_place_of_a_facet(seed in 0_u64..100_000) {
        for (name, cloud) in CLOUDS {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut points = cloud(&mut random);
            let expected = places(&points, &local(&points).unwrap().facets);
            shuffle(&mut points, seed + 1);
            let mut surface = LocalSurface::new();
            let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            for batch in points.chunks(100) {
                one.install(|| surface.insert(batch)).unwrap();
            }
            let found = places(&points, &surface.into_surface().facets);
            prop_assert_eq!(&found, &expected, "{}", name);
        }
    }
}

#[test]
fn the_surface_by_place_is_that_of_the_places_in_order() {
    for (name, cloud) in CLOUDS {
        let points = cloud(&mut Pcg64::seed_from_u64(3));
        let mut surface = LocalSurface::new();
        points.chunks(77).for_each(|batch| {
            surface.insert(batch).unwrap();
        });
        let found = surface.by_place();
        let is_place = |value: &f64| value.is_finite() && value.abs() <= 1e12;
        let mut places: Vec<PointMm> =
            points.iter().copied().filter(|point| point.iter().all(is_place)).collect();
        assert_eq!(found.rejected, points.len() - places.len(), "{name}");
        for value in places.as_flattened_mut() {
            *value = if value.abs() < 1e-40 { 0.0 } else { *value };
        }
        places.sort_by(|a, b| a.partial_cmp(b).unwrap());
        places.dedup();
        assert_eq!(found.points_mm, places, "{name}");
        assert_eq!(found.duplicates + found.rejected, points.len() - places.len(), "{name}");
        assert_eq!(found.surface, local(&places).unwrap(), "{name}");
    }
}

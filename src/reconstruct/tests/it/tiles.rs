//! The graph method by tiles: what it gives of all points in memory, bit for bit.

use std::collections::BTreeMap;

use asphera_geometry::PointMm;
use asphera_reconstruct::{
    GraphChoices, GraphError, LandmarkOrder, LeftOut, PointGraph, TileError, TileShelf,
    TileShelfFailure, TiledGraph, TiledSurface,
};
use proptest::prelude::*;
use rand_core::SeedableRng as _;
use rand_pcg::Pcg64;

use crate::batches::{CLOUDS, Cloud};
use crate::graph::{any_choices, one_of, random_torus};
use crate::shapes::{ball, shuffle, torus};

/// A shelf in memory, which may fail after so many pieces.
struct Pieces {
    pieces: BTreeMap<u32, Vec<u8>>,
    left: usize,
}

impl TileShelf for Pieces {
    fn put(&mut self, piece: u32, bytes: &[u8]) -> Result<(), TileShelfFailure> {
        self.left = self.left.checked_sub(1).ok_or("the disk is full")?;
        self.pieces.insert(piece, bytes.to_vec());
        Ok(())
    }

    fn get(&mut self, piece: u32, bytes: &mut Vec<u8>) -> Result<(), TileShelfFailure> {
        bytes.clone_from(self.pieces.get(&piece).ok_or("no such piece")?);
        Ok(())
    }

    fn forget(&mut self, piece: u32) {
        self.pieces.remove(&piece).unwrap();
    }
}

fn tiled(
    points: &[PointMm],
    kappa: usize,
    choices: &GraphChoices,
    tile_points: usize,
    left: usize,
) -> Result<TiledSurface, TileError> {
    let shelf = Pieces { pieces: BTreeMap::new(), left };
    let mut graph = TiledGraph::new(shelf, kappa, tile_points)?;
    // However they come.
    let (one, other) = points.split_at(points.len() / 3);
    graph.take(one)?;
    for part in other.chunks(101) {
        graph.take(part)?;
    }
    graph.surface(choices, &mut |_| {})
}

/// Fails unless tiles give what memory gives.
fn assert_same(
    name: &str,
    points: &[PointMm],
    kappa: usize,
    choices: &GraphChoices,
    tile_points: usize,
) -> usize {
    let graph = PointGraph::new(points, kappa, &mut |_| {}).unwrap();
    let mut expected = graph.surface(choices, &mut |_| {}).unwrap();
    let found = tiled(points, kappa, choices, tile_points, usize::MAX).unwrap();
    expected.map.cells.clear();
    assert_eq!(found.map, expected.map, "{name}: tiles of {tile_points}");
    assert_eq!(found.no_surface, expected.no_surface, "{name}");
    let numbers = |facet: &[u32; 3]| facet.map(|corner| found.numbers[corner as usize]);
    let facets: Vec<[u32; 3]> = found.facets.iter().map(numbers).collect();
    assert_eq!(facets, expected.reconstruction.facets, "{name}: tiles of {tile_points}");
    let mut landmarks = expected.map.landmarks.clone();
    landmarks.sort_unstable();
    assert_eq!(found.numbers, landmarks, "{name}");
    let places: Vec<PointMm> = landmarks.iter().map(|&number| points[number as usize]).collect();
    assert_eq!(found.landmarks_mm, places, "{name}");
    let mut left_out: BTreeMap<LeftOut, usize> = BTreeMap::new();
    for &(_, why) in &expected.reconstruction.left_out {
        *left_out.entry(why).or_default() += 1;
    }
    assert_eq!(found.left_out, Vec::from_iter(left_out), "{name}");
    found.tiles
}

const FLATS: Cloud = |_| flats();

/// Three sheets, each a raster with one z.
fn flats() -> Vec<PointMm> {
    (0..3_000).map(|at| [at % 40, at / 40 % 25, at / 1_000 * 7].map(f64::from)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn tiles_of_any_size_give_what_memory_gives(seed in 0_u64..100_000) {
        for (name, cloud) in CLOUDS.into_iter().chain([("flats", FLATS)]) {
            let mut random = Pcg64::seed_from_u64(seed);
            let mut points = cloud(&mut random);
            if random.next_u64() % 2 == 0 {
                shuffle(&mut points, seed);
            }
            let (choices, kappa) = any_choices(&mut random, LandmarkOrder::Sweep);
            let size = one_of(&mut random, &[17, 64, 300, 1_000, 9_000]) as usize;
            assert_same(name, &points, kappa, &choices, size);
        }
    }
}

#[test]
fn balls_tori_and_parts_are_those_of_memory() {
    let choices = GraphChoices::default();
    let mut two = ball(4_000, 1e-3, 5);
    two.extend(ball(4_000, 1e-3, 6).into_iter().map(|[x, y, z]| [x + 20.0, y, z + 3.0]));
    shuffle(&mut two, 3);
    for (name, points) in [
        ("ball", ball(12_000, 1e-3, 2)),
        ("rings", torus(300, 100).0),
        ("random torus", random_torus(20_000, 3)),
        ("two balls", two),
        ("flats", flats()),
    ] {
        let mut sizes = Vec::new();
        for tile_points in [256, 1_024, 8_192, 1 << 20] {
            sizes.push(assert_same(name, &points, 15, &choices, tile_points));
        }
        assert!(sizes[0] > 8 && sizes[3] == 1, "{name}: {sizes:?}");
    }
}

#[test]
fn tiles_of_a_few_points_each_are_enough() {
    let choices = GraphChoices { hops: 3, threshold: 2, ..GraphChoices::default() };
    let points = ball(300, 0.02, 4);
    for tile_points in [1, 2, 5, 16] {
        assert_same("ball", &points, 8, &choices, tile_points);
    }
    for points in [&[][..], &[[1.0; 3]], &[[1.0; 3]; 90], &[[f64::NAN; 3]; 9], &ball(20, 0.0, 1)] {
        assert_same("few", points, 15, &choices, 2);
    }
}

#[test]
fn a_shelf_that_fails_and_numbers_out_of_range_are_errors() {
    let points = ball(2_000, 1e-3, 7);
    let choices = GraphChoices::default();
    for left in [0, 1, 7, 30] {
        let failed = tiled(&points, 15, &choices, 64, left).unwrap_err();
        assert!(matches!(failed, TileError::Shelf(_)), "{failed}");
    }
    let priority = GraphChoices { order: LandmarkOrder::Priority, ..choices };
    let failed = tiled(&points, 15, &priority, 64, usize::MAX).unwrap_err();
    assert!(matches!(failed, TileError::Order), "{failed}");
    let failed = tiled(&points, 0, &choices, 64, usize::MAX).unwrap_err();
    assert!(matches!(failed, TileError::Graph(GraphError::Neighbours { found: 0 })), "{failed}");
    let none = GraphChoices { hops: 0, ..choices };
    let failed = tiled(&points, 15, &none, 64, usize::MAX).unwrap_err();
    assert!(matches!(failed, TileError::Graph(GraphError::Hops { found: 0 })), "{failed}");
}

//! A mesh of which little is in memory is the mesh of the same points, or an error.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use asphera_geometry::{PointMm, RANGE_MM, VertexId};
use asphera_mesh::{Mesh, PagedMesh, Part, Shelf, ShelfError, ShelfFailure, check};
use proptest::prelude::*;

use crate::patterns::{PITCH_MM, jittered_raster, raster, sag_mm, scattered, spiral};

/// 32 records a chunk.
type Tiny = PagedMesh<Rack, 5>;

/// As many bytes as three chunks have.
const THREE: usize = 3 * Tiny::CHUNK_BYTES;

/// A shelf in memory whose owner still has a hand on it.
#[derive(Clone, Default)]
struct Rack(Rc<RefCell<Inside>>);

#[derive(Default)]
struct Inside {
    chunks: BTreeMap<u32, Vec<u8>>,
    /// What was put before the last put.
    stale: BTreeMap<u32, Vec<u8>>,
    full: bool,
    locked: bool,
    /// How many chunks can be got before it locks.
    left: Option<usize>,
}

impl Shelf for Rack {
    fn put(&mut self, chunk: u32, bytes: &[u8]) -> Result<(), ShelfFailure> {
        let mut inside = self.0.borrow_mut();
        if inside.full {
            return Err("the rack is full".into());
        }
        if let Some(stale) = inside.chunks.insert(chunk, bytes.to_vec()) {
            inside.stale.insert(chunk, stale);
        }
        Ok(())
    }

    fn get(&mut self, chunk: u32, bytes: &mut [u8]) -> Result<(), ShelfFailure> {
        let mut inside = self.0.borrow_mut();
        if let Some(left) = inside.left {
            inside.locked = left == 0;
            inside.left = Some(left.saturating_sub(1));
        }
        if inside.locked {
            return Err("the rack is locked".into());
        }
        bytes.copy_from_slice(inside.chunks.get(&chunk).ok_or("no such chunk")?);
        Ok(())
    }
}

/// Lines in one direction, as a line scanner has them.
fn lines(count: usize, columns: usize) -> Vec<PointMm> {
    (0..count * columns)
        .map(|index| {
            let (line, column) = (index / columns, index % columns);
            let wiggle = 0.02 * ((index * 7919 % 1000) as f64 / 500.0 - 1.0);
            let (x, y) = ((column as f64 + wiggle) * PITCH_MM, 1.5 * line as f64 * PITCH_MM);
            [x, y, sag_mm(x, y)]
        })
        .collect()
}

/// Triangles and points of the mesh, the triangles as [`Mesh::triangles`] has them.
fn read(mesh: &Tiny) -> Result<(Vec<[VertexId; 3]>, Vec<PointMm>), ShelfError> {
    let (mut triangles, mut points) = (Vec::new(), Vec::new());
    mesh.for_each_triangle(|mut corners| {
        let least = (0..3).min_by_key(|&i| corners[i]).expect("three are not none");
        corners.rotate_left(least);
        triangles.push(corners);
    })?;
    triangles.sort_unstable();
    mesh.for_each_points(|first, some| {
        assert_eq!(first as usize, points.len());
        points.extend_from_slice(some);
    })?;
    Ok((triangles, points))
}

fn assert_same(paged: &Tiny, flat: &Mesh) {
    let (triangles, points) = read(paged).expect("the rack is whole");
    assert!(points == flat.points());
    assert!(triangles == flat.triangles());
    assert_eq!(paged.counts(), flat.counts());
}

/// Meshes the points twice, batch by batch.
fn assert_meshed_alike(points: &[PointMm], batch: usize, memory_bytes: usize) -> Tiny {
    let (mut paged, mut flat) = (Tiny::new(Rack::default(), memory_bytes), Mesh::new());
    for batch in points.chunks(batch) {
        paged.insert(batch).expect("the rack is whole");
        flat.insert(batch);
        let paging = paged.paging();
        assert_eq!((paging.failed_puts, paging.last_failure), (0, None));
        assert!(paging.budget_bytes <= memory_bytes.max(THREE));
    }
    assert_same(&paged, &flat);
    paged
}

#[test]
fn every_order_of_arrival_with_three_chunks() {
    for points in [
        raster(60),
        jittered_raster(60, 0.05, 5),
        lines(40, 90),
        spiral(3_600),
        scattered(2_000, 1.0, 6),
    ] {
        for batch in [1, 77, 1024, points.len()] {
            let paged = assert_meshed_alike(&points, batch, THREE);
            let paging = paged.paging();
            assert_eq!(paging.budget_bytes, THREE);
            assert!(paging.written_bytes as usize > points.len() * 72 - 2 * THREE, "{paging:?}");
        }
    }
}

#[test]
fn a_mesh_with_room_touches_no_shelf() {
    let paged = assert_meshed_alike(&raster(60), 1024, 1 << 30);
    let paging = paged.paging();
    assert_eq!((paging.written_bytes, paging.read_bytes), (0, 0));
}

#[test]
fn less_memory_than_a_chunk() {
    for memory_bytes in [0, 1, Tiny::CHUNK_BYTES - 1] {
        let paged = assert_meshed_alike(&lines(20, 50), 200, memory_bytes);
        assert_eq!(paged.paging().budget_bytes, THREE);
    }
}

#[test]
fn memory_is_bounded_and_a_scan_reads_little_back() {
    let memory_bytes = 60 * Tiny::CHUNK_BYTES;
    let rack = Rack::default();
    let mut paged = Tiny::new(rack.clone(), memory_bytes);
    for batch in lines(400, 100).chunks(100) {
        paged.insert(batch).unwrap();
        // A chunk on its way, tables, and the batch.
        assert!(paged.resident_bytes() < memory_bytes + Tiny::CHUNK_BYTES + 250_000);
    }
    let paging = paged.paging();
    let all_bytes = 40_000 * 72;
    assert!(paging.written_bytes > all_bytes * 9 / 10, "{paging:?}");
    assert!(paging.written_bytes < all_bytes * 12 / 10, "{paging:?}");
    // The hull beside the scan stands on vertices of long ago.
    assert!(paging.read_bytes < all_bytes / 3, "{paging:?}");
    // Four chunks of each five were put, at least.
    assert!(rack.0.borrow().chunks.len() > 40_000 / 32 * 3 * 4 / 5);
}

#[test]
fn late_points_where_the_scan_began() {
    let mut points = lines(80, 60);
    // Between the first lines, then in the middle, then outside beside the beginning.
    points.extend((0..40).map(|i| [(f64::from(i) + 0.4) * PITCH_MM, 0.7 * PITCH_MM, 1.0]));
    points.extend((0..40).map(|i| [(f64::from(i) + 0.6) * PITCH_MM, 60.7 * PITCH_MM, 1.0]));
    points.extend((0..40).map(|i| [-0.1, f64::from(i) * PITCH_MM, 1.0]));
    for batch in [60, 500] {
        let paged = assert_meshed_alike(&points, batch, 2 * THREE);
        assert!(paged.paging().read_bytes > 0);
    }
}

#[test]
fn a_late_point_is_found_without_reading_the_scan() {
    let mut paged = Tiny::new(Rack::default(), 12 * THREE);
    for batch in lines(400, 100).chunks(100) {
        paged.insert(batch).unwrap();
    }
    let all_bytes = 40_000 * 72;
    for line in [3.2, 200.7, 120.2, 350.7, 30.7] {
        let before = paged.paging().read_bytes;
        paged.insert(&[[50.4 * PITCH_MM, line * 1.5 * PITCH_MM, 0.0]]).unwrap();
        let read_bytes = paged.paging().read_bytes - before;
        assert!(0 < read_bytes && read_bytes < all_bytes / 10, "{line}: {read_bytes}");
    }
}

#[test]
fn repeats_conflicts_and_nonsense() {
    let mut points = lines(30, 40);
    for index in (0..points.len()).step_by(7) {
        let [x, y, z] = points[index / 3];
        points[index] = [x, y, z + [0.0, 0.5][index % 2]];
    }
    points[10] = [f64::NAN, 0.0, 0.0];
    points[500] = [0.0, 2.0 * RANGE_MM, 0.0];
    points.extend_from_within(..90);
    for batch in [1, 64, 400] {
        let paged = assert_meshed_alike(&points, batch, THREE);
        let counts = paged.counts();
        assert!(counts.duplicates > 100 && counts.conflicts > 50 && counts.rejected > 1);
    }
}

#[test]
fn nothing_one_point_and_a_profile() {
    let mut paged = assert_meshed_alike(&[], 1, THREE);
    assert!(paged.insert(&[]).is_ok());
    assert_meshed_alike(&[[1.0, 2.0, 3.0]], 1, THREE);
    let mut profile: Vec<PointMm> =
        (0..500).map(|i| [f64::from(i), 2.0 * f64::from(i), 0.0]).collect();
    assert_meshed_alike(&profile, 100, THREE);
    profile.push([0.0, 7.0, 0.0]);
    assert_meshed_alike(&profile, 100, THREE);
}

#[test]
fn a_single_point_is_read_back() {
    let points = lines(40, 60);
    let rack = Rack::default();
    let mut paged = Tiny::new(rack.clone(), THREE);
    paged.insert(&points).unwrap();
    for vertex in (0..points.len()).step_by(311) {
        assert_eq!(paged.point(vertex as VertexId).unwrap(), Some(points[vertex]));
    }
    assert_eq!(paged.point(points.len() as VertexId).unwrap(), None);
    rack.0.borrow_mut().locked = true;
    for vertex in [3, 2, 1, 0] {
        assert!(matches!(paged.point(vertex), Err(ShelfError::Read { chunk: 2, .. })));
    }
    // Reading is no change: when the rack opens, all is there.
    rack.0.borrow_mut().locked = false;
    assert_eq!(paged.point(0).unwrap(), Some(points[0]));
}

#[test]
fn a_full_shelf_costs_memory_and_nothing_else() {
    let points = lines(60, 60);
    let rack = Rack::default();
    let (mut paged, mut flat) = (Tiny::new(rack.clone(), 2 * THREE), Mesh::new());
    let (before, after) = points.split_at(1_200);
    paged.insert(before).unwrap();
    rack.0.borrow_mut().full = true;
    for batch in after.chunks(100) {
        paged.insert(batch).unwrap();
    }
    flat.insert(&points);
    let paging = paged.paging();
    assert!(paging.failed_puts > 0 && paging.resident_bytes > 10 * THREE, "{paging:?}");
    assert_eq!(paging.last_failure.as_deref(), Some("the rack is full"));
    assert_same(&paged, &flat);
    // A rack that is full and locked: still an error, of reading alone.
    rack.0.borrow_mut().locked = true;
    let mut failed = 0;
    for vertex in (0..points.len() as VertexId).cycle().step_by(32).take(300) {
        match paged.point(vertex) {
            Ok(point) => assert_eq!(point, Some(points[vertex as usize])),
            Err(error) => {
                assert!(matches!(error, ShelfError::Read { part: Part::Points, .. }), "{error}");
                failed += 1;
            }
        }
    }
    assert!(failed > 30, "{failed}");
    *rack.0.borrow_mut() = Inside { full: false, locked: false, ..rack.0.take() };
    // There is room again: the memory is given back.
    let more = [[0.0, 1.0, 0.0], [0.1, 1.0, 0.0]];
    paged.insert(&more).unwrap();
    flat.insert(&more);
    assert!(paged.resident_bytes() < paging.resident_bytes / 2, "{:?}", paged.paging());
    assert_same(&paged, &flat);
}

/// Meshes a scan, does something to the shelf, and inserts a late point.
fn late_point_after(harm: impl FnOnce(&mut Inside)) -> (Tiny, Result<(), ShelfError>) {
    let rack = Rack::default();
    let mut paged = Tiny::new(rack.clone(), THREE);
    for batch in lines(60, 60).chunks(100) {
        paged.insert(batch).expect("no harm is done yet");
    }
    harm(&mut rack.0.borrow_mut());
    let late = paged.insert(&[[10.4 * PITCH_MM, 0.7 * PITCH_MM, 0.0]]);
    (paged, late)
}

fn assert_lost(paged: &mut Tiny) {
    assert!(matches!(paged.insert(&[[0.0; 3]]), Err(ShelfError::Lost)));
    assert!(matches!(paged.for_each_triangle(|_| panic!("none is shown")), Err(ShelfError::Lost)));
    assert!(matches!(paged.for_each_points(|_, _| panic!("nor here")), Err(ShelfError::Lost)));
    assert!(matches!(paged.point(0), Err(ShelfError::Lost)));
    let counts = paged.counts();
    assert_eq!((counts.pushed, counts.vertices), (3_600, 3_600));
}

#[test]
fn a_shelf_that_cannot_be_read() {
    let (mut paged, late) = late_point_after(|inside| inside.locked = true);
    let Err(ShelfError::Read { source, .. }) = late else { panic!("{late:?}") };
    assert_eq!(source.to_string(), "the rack is locked");
    assert_lost(&mut paged);
}

#[test]
fn a_read_that_fails_at_any_time() {
    let mut points = lines(12, 40);
    points.extend_from_within(..30);
    points.extend((0..30).map(|i| [(f64::from(i) + 0.4) * PITCH_MM, 0.7 * PITCH_MM, 1.0]));
    for left in (0..).step_by(53) {
        let rack = Rack::default();
        rack.0.borrow_mut().left = Some(left);
        let mut paged = Tiny::new(rack, THREE);
        let done = points.chunks(100).try_for_each(|batch| paged.insert(batch));
        let Err(error) = done else {
            assert!(left > 100, "{left}");
            return;
        };
        assert!(matches!(error, ShelfError::Read { .. }), "{error}");
        assert!(matches!(paged.insert(&points), Err(ShelfError::Lost)));
        assert_eq!(paged.counts().pushed % 100, 0);
    }
}

#[test]
fn every_damaged_byte_is_found() {
    for at in [0, 1, 100, Tiny::CHUNK_BYTES - 1] {
        let (mut paged, late) = late_point_after(|inside| {
            inside.chunks.values_mut().for_each(|bytes| bytes[at] ^= 0x10);
        });
        let Err(ShelfError::Damaged { expected, found, .. }) = late else { panic!("{late:?}") };
        assert_ne!(expected, found);
        assert_lost(&mut paged);
    }
}

#[test]
fn old_and_exchanged_chunks_are_found() {
    let (mut paged, late) = late_point_after(|inside| {
        let stale = std::mem::take(&mut inside.stale);
        assert!(!stale.is_empty());
        inside.chunks.extend(stale);
        // Chunks that were put only once are exchanged.
        let (key, last) = inside.chunks.pop_last().unwrap();
        let others = inside.chunks.values_mut();
        let left = others.fold(last, |before, bytes| std::mem::replace(bytes, before));
        inside.chunks.insert(key, left);
    });
    assert!(matches!(late, Err(ShelfError::Damaged { .. })), "{late:?}");
    assert_lost(&mut paged);
}

#[test]
fn a_damaged_chunk_ends_the_reading_of_all() {
    let rack = Rack::default();
    let mut paged = Tiny::new(rack.clone(), THREE);
    paged.insert(&lines(60, 60)).unwrap();
    let flip = || rack.0.borrow_mut().chunks.values_mut().for_each(|bytes| bytes[7] ^= 1);
    flip();
    let error = read(&paged).unwrap_err();
    assert!(matches!(error, ShelfError::Damaged { part: Part::Triangles, .. }), "{error}");
    flip();
    let (triangles, points) = read(&paged).unwrap();
    assert_eq!(check::delaunay(&points, triangles), Ok(()));
}

proptest! {
    #[test]
    fn runs_over_a_small_lattice(
        runs in prop::collection::vec(
            (0_i8..9, 0_i8..9, -1_i8..=1, -1_i8..=1, 1_i8..12),
            1..40,
        ),
        batch in 1_usize..80,
    ) {
        let points: Vec<PointMm> = runs
            .into_iter()
            .flat_map(|(x, y, dx, dy, count)| (0..count).map(move |i| [x + i * dx, y + i * dy]))
            .map(|[x, y]| [f64::from(x) * 0.003, f64::from(y) * 0.003, 0.0])
            .collect();
        assert_meshed_alike(&points, batch, THREE);
    }
}

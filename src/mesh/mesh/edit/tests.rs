//! Every edited mesh against one made of the rest alone.

use std::f64::consts::TAU;

use asphera_geometry::{PointMm, RANGE_MM, Rejection, TINY_MM, VertexId};
use proptest::prelude::*;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg64;

use crate::delaunay::Cells;
use crate::regressions::beside_source;
use crate::{EditError, Location, Mesh, Outcome, check};

/// The mesh must be that of its vertices, numbers apart, and sound inside.
fn assert_as_new(mesh: &Mesh) {
    mesh.assert_sound();
    let vertices: Vec<VertexId> = mesh.vertices().collect();
    let points: Vec<PointMm> =
        vertices.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
    let mut new = Mesh::new();
    new.insert(&points);
    let expected: Vec<[VertexId; 3]> =
        new.triangles().into_iter().map(|corners| corners.map(|c| vertices[c as usize])).collect();
    assert!(mesh.triangles() == expected, "the triangles differ");
    assert_eq!(check::delaunay(&points, new.triangles()), Ok(()));
    let (counts, new) = (mesh.counts(), new.counts());
    let of = |counts: crate::Counts| [counts.vertices, counts.triangles, counts.edges, counts.hull];
    assert_eq!(of(counts), of(new));
    assert_eq!(counts.withdrawn, mesh.withdrawn().len() as u64);
    assert_eq!(
        counts.pushed,
        counts.vertices
            + counts.withdrawn
            + counts.duplicates
            + counts.conflicts
            + counts.rejected
            + counts.pending
    );
}

/// Removes all vertices in an order drawn by lot.
fn remove_all(points: &[PointMm], seed: u64) {
    let mut mesh = Mesh::new();
    mesh.insert(points);
    let mut left: Vec<VertexId> = mesh.vertices().collect();
    let mut rng = Pcg64::seed_from_u64(seed);
    while !left.is_empty() {
        let vertex = left.swap_remove(rng.next_u32() as usize % left.len());
        let point = mesh.points()[vertex as usize];
        assert_eq!(mesh.remove(vertex), Ok(point));
        assert_eq!(mesh.remove(vertex), Err(EditError::Withdrawn { vertex }));
        assert!(!mesh.is_vertex(vertex));
        assert_as_new(&mesh);
    }
    assert_eq!(mesh.locate(0.0, 0.0), Location::Empty);
    // What is left of it is as good as an empty one.
    mesh.insert(points);
    assert_as_new(&mesh);
}

fn lattice(columns: u32, rows: u32, pitch: f64, corner: [f64; 2]) -> Vec<PointMm> {
    (0..columns * rows)
        .map(|i| {
            let [column, row] = [i % columns, i / columns].map(f64::from);
            [corner[0] + pitch * column, corner[1] + pitch * row, column * row]
        })
        .collect()
}

fn scattered(count: usize, seed: u64) -> Vec<PointMm> {
    let mut rng = Pcg64::seed_from_u64(seed);
    let mut unit = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    (0..count).map(|_| [unit(), unit(), unit()]).collect()
}

#[test]
fn a_lattice_and_scattered_points_down_to_nothing() {
    for seed in 0..4 {
        remove_all(&lattice(9, 8, 1.0, [-3.0, 2.0]), seed);
        remove_all(&lattice(2, 20, 0.1, [0.0, 0.0]), seed);
        remove_all(&scattered(150, seed), seed);
    }
}

#[test]
fn far_away() {
    for seed in 0..4 {
        remove_all(&lattice(10, 8, 1e-3, [1e6, -1e6]), seed);
    }
    remove_all(&lattice(4, 4, 0.5e12, [-1e12, -0.75e12]), 5);
}

#[test]
fn a_line_and_what_stands_beside_it() {
    let line = |count: u32| (0..count).map(|i| [f64::from(i) * 0.75, f64::from(i) * 0.5, 0.0]);
    remove_all(&line(20).collect::<Vec<_>>(), 1);
    for beside in [vec![[3.0, 7.0, 0.0]], vec![[3.0, 7.0, 0.0], [4.0, -7.0, 0.0]]] {
        let points: Vec<PointMm> = line(20).chain(beside).collect();
        for seed in 0..8 {
            remove_all(&points, seed);
        }
        // All that stands beside it first, and back again.
        let mut mesh = Mesh::new();
        mesh.insert(&points);
        for vertex in 20..points.len() as VertexId {
            mesh.remove(vertex).unwrap();
            assert_as_new(&mesh);
        }
        assert_eq!(mesh.counts().triangles, 0);
        assert_eq!(mesh.locate(0.375, 0.25), Location::OnEdge { edge: [0, 1] });
        assert_eq!(mesh.locate(0.375, 0.5), Location::OffLine);
        mesh.insert(&points[20..]);
        assert_as_new(&mesh);
    }
}

#[test]
fn the_centre_of_rings() {
    let mut points = vec![[0.0; 3]];
    for ring in 1..=3 {
        points.extend((0..360).map(|step| {
            let angle = TAU * f64::from(step) / 360.0;
            let radius = f64::from(ring) * 0.5;
            [radius * angle.cos(), radius * angle.sin(), 0.0]
        }));
    }
    let mut mesh = Mesh::new();
    mesh.insert(&points);
    for vertex in [0, 1, 721, 2, 500, 3, 901] {
        mesh.remove(vertex).unwrap();
        assert_as_new(&mesh);
    }
}

#[test]
fn the_centre_of_a_circle_of_lattice_points() {
    // x² + y² = 5²·13²·17² has 108 solutions, all on one circle exactly.
    let radius = 5_i32 * 13 * 17;
    let mut points = vec![[0.0; 3]];
    for x in -radius..=radius {
        let y = f64::from(radius * radius - x * x).sqrt();
        if y.fract() == 0.0 {
            points.push([f64::from(x), y, 0.0]);
            points.push([f64::from(x), -y, 0.0]);
        }
    }
    let mut mesh = Mesh::new();
    mesh.insert(&points);
    assert_eq!(mesh.neighbours(0).unwrap().vertices.len(), 108);
    for vertex in [0, 17, 90] {
        mesh.remove(vertex).unwrap();
        assert_as_new(&mesh);
    }
}

#[test]
fn a_vertex_with_more_neighbours_than_a_quadratic_algorithm_could_bear() {
    let count = 30_000_u32;
    let mut points: Vec<PointMm> = (0..count).map(|i| [f64::from(i), 0.0, 0.0]).collect();
    points.extend([[100.0, 5e4, 0.0], [200.0, 9e4, 0.0], [300.0, -1e4, 0.0]]);
    let mut mesh = Mesh::new();
    mesh.insert(&points);
    for vertex in count..count + 2 {
        assert!(mesh.neighbours(vertex).unwrap().vertices.len() > 20_000);
        mesh.remove(vertex).unwrap();
        mesh.insert(&[]);
    }
    assert_eq!(mesh.counts().triangles, u64::from(count) - 1);
    mesh.remove(count + 2).unwrap();
    assert_eq!((mesh.counts().triangles, mesh.counts().edges), (0, u64::from(count) - 1));
}

#[test]
fn further_measurements_in_the_place_do_not_take_over() {
    let mut mesh = Mesh::new();
    mesh.insert(&lattice(3, 3, 1.0, [0.0, 0.0]));
    mesh.insert(&[[1.0, 1.0, 1.0], [1.0, 1.0, 5.0], [f64::NAN, 0.0, 0.0]]);
    assert_eq!(mesh.remove(4), Ok([1.0, 1.0, 1.0]));
    assert_as_new(&mesh);
    assert_eq!(mesh.outcome(4), Some(Outcome::Withdrawn(4)));
    assert_eq!(mesh.outcome(9), Some(Outcome::Duplicate { of: 4 }));
    assert_eq!(mesh.outcome(10), Some(Outcome::Conflict { of: 4, height_mm: 4.0 }));
    assert_eq!(mesh.repeats(4).map(crate::Repeats::count), Some(3));
    assert_eq!(mesh.points()[4], [1.0, 1.0, 1.0]);
    assert_eq!((mesh.counts().vertices, mesh.counts().withdrawn), (8, 1));
    // Measured again, twice.
    mesh.push([1.0, 1.0, 2.0]);
    mesh.push([1.0, 1.0, 2.0]);
    assert_eq!(mesh.remove(9), Err(EditError::NoSuchVertex { vertex: 9, vertices: 9 }));
    mesh.flush();
    assert_eq!(mesh.outcome(12), Some(Outcome::Vertex(9)));
    assert_eq!(mesh.outcome(13), Some(Outcome::Duplicate { of: 9 }));
    assert_eq!(mesh.locate(1.0, 1.0), Location::At { vertex: 9 });
    assert_as_new(&mesh);
}

#[test]
fn heights_are_set_within_the_range() {
    let mut mesh = Mesh::new();
    mesh.insert(&lattice(3, 3, 1.0, [0.0, 0.0]));
    let before = mesh.triangles();
    assert_eq!(mesh.set_height(4, 7.5), Ok(1.0));
    assert_eq!(mesh.set_height(4, -TINY_MM / 2.0), Ok(7.5));
    assert_eq!(mesh.points()[4].map(f64::to_bits), [1.0, 1.0, 0.0].map(f64::to_bits));
    for (z_mm, rejection) in [
        (f64::NAN, Rejection::NotFinite),
        (f64::INFINITY, Rejection::NotFinite),
        (RANGE_MM.next_up(), Rejection::OutOfRange),
    ] {
        let refused = EditError::Height { vertex: 4, rejection };
        assert_eq!(mesh.set_height(4, z_mm), Err(refused));
    }
    let none = EditError::NoSuchVertex { vertex: 9, vertices: 9 };
    assert_eq!(mesh.set_height(9, 0.0), Err(none));
    assert_eq!(none.to_string(), "there is no vertex 9 in a mesh that has taken 9");
    assert_eq!(mesh.triangles(), before);
    mesh.insert(&[[1.0, 1.0, 1.0]]);
    assert_eq!(mesh.outcome(9), Some(Outcome::Conflict { of: 4, height_mm: 1.0 }));
    mesh.remove(4).unwrap();
    assert_eq!(mesh.set_height(4, 0.0), Err(EditError::Withdrawn { vertex: 4 }));
}

#[test]
fn cells_are_used_again() {
    let points = lattice(20, 20, 1.0, [0.0, 0.0]);
    let mut mesh = Mesh::new();
    mesh.insert(&points);
    // As many duplicates as make do with the cells there are, and more.
    for round in 0..10 {
        mesh.insert(&points);
        for vertex in mesh.vertices().skip(17 * round).take(100).collect::<Vec<_>>() {
            mesh.remove(vertex).unwrap();
        }
        mesh.insert(&points);
    }
    assert_as_new(&mesh);
    assert_eq!(mesh.counts().vertices, 400);
    assert_eq!(Cells::len(mesh.delaunay.cells()), 2 * 800);
}

/// What is done to a mesh.
#[derive(Clone, Debug)]
enum Step {
    /// Points along a row of a small lattice.
    Run { from: [i8; 2], step: [i8; 2], count: i8 },
    /// Any nodes of it.
    Nodes(Vec<[i8; 2]>),
    /// So many vertices, the first by its rank among those left.
    Remove { rank: usize, count: usize },
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let node = || prop::array::uniform2(0_i8..7);
    let run = (node(), prop::array::uniform2(-1_i8..=1), 1_i8..8)
        .prop_map(|(from, step, count)| Step::Run { from, step, count });
    let nodes = prop::collection::vec(node(), 1..8).prop_map(Step::Nodes);
    let remove =
        (any::<usize>(), 1_usize..10).prop_map(|(rank, count)| Step::Remove { rank, count });
    prop::collection::vec(prop_oneof![run, nodes, remove], 1..24)
}

proptest! {
    #![proptest_config(beside_source())]

    #[test]
    fn insertions_and_removals_in_any_order(
        steps in steps(),
        pitch in prop::sample::select(vec![1.0, 0.1]),
    ) {
        let point = |[x, y]: [i8; 2]| [f64::from(x) * pitch, f64::from(y) * pitch, 0.0];
        let mut mesh = Mesh::new();
        for step in steps {
            match step {
                Step::Run { from: [x, y], step: [dx, dy], count } => {
                    let along = (0..count).map(|i| point([x + i * dx, y + i * dy]));
                    mesh.insert(&along.collect::<Vec<_>>());
                }
                Step::Nodes(nodes) => {
                    mesh.insert(&nodes.into_iter().map(point).collect::<Vec<_>>());
                }
                Step::Remove { rank, count } => {
                    for _ in 0..count {
                        let left: Vec<VertexId> = mesh.vertices().collect();
                        if let Some(&vertex) = left.get(rank % left.len().max(1)) {
                            mesh.remove(vertex).unwrap();
                        }
                    }
                }
            }
            assert_as_new(&mesh);
        }
    }

    #[test]
    fn scattered_points_come_and_go(
        points in prop::collection::vec(prop::array::uniform2(-1.0_f64..1.0), 1..120),
        lots in prop::collection::vec(any::<u16>(), 1..100),
    ) {
        let mut mesh = Mesh::new();
        let lots = lots.chunks(25).chain(std::iter::repeat(&[][..]));
        for (chunk, lots) in points.chunks(30).zip(lots) {
            mesh.insert(&chunk.iter().map(|&[x, y]| [x, y, 0.0]).collect::<Vec<_>>());
            for &lot in lots {
                let left: Vec<VertexId> = mesh.vertices().collect();
                if !left.is_empty() {
                    mesh.remove(left[usize::from(lot) % left.len()]).unwrap();
                }
            }
            assert_as_new(&mesh);
        }
    }
}

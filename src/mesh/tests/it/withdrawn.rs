//! Scans from which vertices are withdrawn while they go on, against the mesh of those left.

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, check};
use proptest::prelude::*;

use crate::scans;

/// The mesh is the one that the vertices give which are left, numbers apart.
fn assert_that_of_the_others(mesh: &Mesh) {
    let there: Vec<VertexId> = mesh.vertices().collect();
    let points: Vec<PointMm> = there.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
    let mut new = Mesh::new();
    new.insert(&points);
    assert_eq!(check::delaunay(&points, new.triangles()), Ok(()));
    let expected: Vec<[VertexId; 3]> =
        new.triangles().into_iter().map(|corners| corners.map(|c| there[c as usize])).collect();
    assert!(mesh.triangles() == expected, "the triangles differ");
    assert_eq!(mesh.counts().hull, new.counts().hull);
}

/// Where the last line ended is not where it did once no triangle is left.
#[test]
fn a_line_inside_after_all_triangles_went() {
    let level = |x: f64, y: f64, count: u32| -> Vec<PointMm> {
        (0..count).map(|i| [x + f64::from(i) * 0.125, y, 0.0]).collect()
    };
    let mut mesh = Mesh::new();
    mesh.insert(&[&[[4.0, -1.0, 0.0]], &level(0.0, 0.0, 10)[..]].concat());
    for vertex in 0..10 {
        mesh.remove(vertex).unwrap();
    }
    assert_eq!((mesh.counts().vertices, mesh.counts().triangles), (1, 0));
    mesh.insert(&[[-100.0, 103.0, 0.0], [100.0, -107.0, 0.0], [100.0, 111.0, 0.0]]);
    mesh.insert(&level(50.0, 50.0, 8));
    assert_that_of_the_others(&mesh);
}

#[test]
fn scans_of_every_kind_with_every_third_withdrawn() {
    for scan in scans::all() {
        let mut mesh = Mesh::new();
        let batches = 1 + scan.points.len() / 4;
        for batch in scan.points.chunks(batches) {
            mesh.insert(batch);
            let there: Vec<VertexId> = mesh.vertices().step_by(3).collect();
            for vertex in there {
                mesh.remove(vertex).unwrap();
            }
            assert_that_of_the_others(&mesh);
        }
        mesh.insert(&scan.points);
        assert_that_of_the_others(&mesh);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Lines come, and all but some of the mesh goes, over and over.
    #[test]
    fn lines_come_and_go(
        rounds in prop::collection::vec((0_u8..8, 0_u8..8, 1_u8..4, -1_i8..=1, 0_usize..40, 0_usize..12), 1..8),
    ) {
        let mut mesh = Mesh::new();
        for (x, y, rows, slope, from, kept) in rounds {
            let lines = (0..rows * 10).map(|i| {
                let (row, along) = (f64::from(i / 10), f64::from(i % 10));
                [f64::from(x) + along, f64::from(y) + row + f64::from(slope) * along, 0.0]
            });
            mesh.insert(&lines.collect::<Vec<_>>());
            let there: Vec<VertexId> = mesh.vertices().collect();
            for (index, &vertex) in there.iter().enumerate() {
                if !(from..from + kept).contains(&index) {
                    mesh.remove(vertex).unwrap();
                }
            }
            assert_that_of_the_others(&mesh);
        }
    }
}

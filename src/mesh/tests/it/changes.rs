//! What changed since a revision, against a comparison of all triangles then and now.

use std::collections::BTreeSet;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{ChangedPart, Changes, HEIGHTS_REMEMBERED, Mesh, Revision};
use proptest::prelude::*;

use crate::patterns::{PITCH_MM, raster, scattered};

/// The mesh at some moment.
struct Moment {
    revision: Revision,
    triangles: BTreeSet<[VertexId; 3]>,
    points: Vec<PointMm>,
}

impl Moment {
    fn of(mesh: &Mesh) -> Moment {
        Moment {
            revision: mesh.revision(),
            triangles: mesh.triangles().into_iter().collect(),
            points: mesh.points().to_vec(),
        }
    }

    fn assert_changes(&self, mesh: &Mesh) -> ChangedPart {
        let Changes::Part(part) = mesh.changed_since(self.revision) else {
            panic!("everything changed")
        };
        let raised =
            |vertex: VertexId| part.raised.contains(&vertex) || part.inserted.contains(&vertex);
        for (vertex, then) in (0..).zip(&self.points) {
            assert!(raised(vertex) || *then == mesh.points()[vertex as usize]);
        }
        let now: BTreeSet<[VertexId; 3]> = mesh.triangles().into_iter().collect();
        let changed = |corners: &&[VertexId; 3]| {
            !self.triangles.contains(*corners)
                || corners.iter().any(|corner| part.raised.contains(corner))
        };
        let expected: Vec<[VertexId; 3]> = now.iter().filter(changed).copied().collect();
        assert_eq!(part.triangles, expected);
        // All that is new and all that went lies in the box.
        let gone = self.triangles.difference(&now);
        for &corner in gone.chain(&part.triangles).flatten() {
            let [x, y, _] = mesh.points()[corner as usize];
            let bounds = part.bounds_mm.expect("something changed");
            assert!((bounds.low[0]..=bounds.high[0]).contains(&x), "{corner}: {bounds:?}");
            assert!((bounds.low[1]..=bounds.high[1]).contains(&y), "{corner}: {bounds:?}");
        }
        part
    }
}

#[test]
fn nothing_and_everything() {
    let mut mesh = Mesh::new();
    let start = mesh.revision();
    assert_eq!(start, Revision::default());
    assert_eq!(mesh.changed_since(start), Changes::Part(ChangedPart::default()));
    mesh.insert(&raster(10));
    mesh.push([5.0, 5.0, 5.0]);
    let now = mesh.revision();
    let nothing = ChangedPart { inserted: 100..100, ..ChangedPart::default() };
    assert_eq!(mesh.changed_since(now), Changes::Part(nothing));
    let Changes::Part(all) = mesh.changed_since(start) else { panic!("it is remembered") };
    assert_eq!((all.triangles, all.inserted), (mesh.triangles(), 0..100));
    // A revision that this mesh has not reached yet.
    assert_eq!(Mesh::new().changed_since(now), Changes::Everything);
}

#[test]
fn a_scan_goes_on_and_an_outlier_is_withdrawn() {
    let points = raster(60);
    let mut mesh = Mesh::new();
    mesh.insert(&points[..3_000]);
    let before = Moment::of(&mesh);
    mesh.insert(&points[3_000..3_060]);
    let row = before.assert_changes(&mesh);
    assert!(row.triangles.len() < 130, "{}", row.triangles.len());
    let bounds = row.bounds_mm.unwrap();
    assert!(bounds.low[1] >= 48.0 * PITCH_MM && bounds.high[1] <= 51.0 * PITCH_MM, "{bounds:?}");

    let before = Moment::of(&mesh);
    mesh.remove(1_234).unwrap();
    mesh.set_height(77, 1.0).unwrap();
    let edits = before.assert_changes(&mesh);
    assert!(edits.triangles.len() < 20);
    assert_eq!((edits.withdrawn, edits.raised), (vec![1_234], vec![77]));
    assert!(edits.inserted.is_empty());
}

#[test]
fn what_comes_and_goes_again_is_no_change() {
    let mut mesh = Mesh::new();
    mesh.insert(&scattered(200, 1.0, 1));
    let before = Moment::of(&mesh);
    mesh.insert(&[[0.5, 0.5, 0.0], [3.0, 3.0, 0.0]]);
    mesh.remove(200).unwrap();
    mesh.remove(201).unwrap();
    let part = before.assert_changes(&mesh);
    assert_eq!((part.triangles.len(), part.bounds_mm), (0, None));
    assert_eq!((part.inserted, part.withdrawn), (200..202, vec![200, 201]));
}

#[test]
fn heights_are_remembered_so_far() {
    let mut mesh = Mesh::new();
    mesh.insert(&raster(5));
    let first = mesh.revision();
    mesh.set_height(3, 1.0).unwrap();
    let second = mesh.revision();
    for index in 0..HEIGHTS_REMEMBERED {
        assert_ne!(mesh.changed_since(first), Changes::Everything, "after {index}");
        mesh.set_height(7, index as f64).unwrap();
    }
    assert_eq!(mesh.changed_since(first), Changes::Everything);
    let Changes::Part(part) = mesh.changed_since(second) else { panic!("it is remembered") };
    assert_eq!(part.raised, [7]);
    assert_eq!(part.triangles.len(), mesh.star(7).unwrap().len());
}

proptest! {
    #[test]
    fn any_changes_since_any_moment(
        steps in prop::collection::vec(
            (0_u8..4, prop::collection::vec(prop::array::uniform2(-5_i8..=5), 1..12)),
            1..16,
        ),
    ) {
        let mut mesh = Mesh::new();
        let mut moments = vec![Moment::of(&mesh)];
        for (kind, nodes) in steps {
            let points = nodes.iter().map(|&[x, y]| [x.into(), y.into(), 0.0]);
            match kind {
                0 => mesh.insert(&points.collect::<Vec<PointMm>>()),
                1 => {
                    let [x, y] = nodes[0].map(f64::from);
                    if let Some(vertex) = mesh.nearest(x, y) {
                        mesh.set_height(vertex, x * y).unwrap();
                    }
                }
                _ => {
                    for [x, y] in nodes.into_iter().map(|node| node.map(f64::from)) {
                        if let Some(vertex) = mesh.nearest(x, y) {
                            mesh.remove(vertex).unwrap();
                        }
                    }
                }
            }
            for moment in &moments {
                moment.assert_changes(&mesh);
            }
            moments.push(Moment::of(&mesh));
        }
    }
}

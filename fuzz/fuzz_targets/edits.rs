//! Vertices withdrawn between the batches of a scan: what is left is the mesh of the others.

#![no_main]

use arbitrary::Arbitrary;
use asphera_fuzz::laws;
use asphera_fuzz::scan::Scan;
use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Location, Mesh, check};
use libfuzzer_sys::fuzz_target;

/// A scan and what is withdrawn after each of its batches, over and over.
#[derive(Arbitrary, Debug)]
struct EditedScan {
    edits: Vec<Edit>,
    scan: Scan,
}

#[derive(Arbitrary, Clone, Copy, Debug)]
enum Edit {
    /// The mesh is left alone.
    None,
    /// Vertices a stride apart.
    Some { from: u16, stride: u8, count: u8 },
    /// The last of them.
    Last { count: u8 },
    /// All but some.
    AllBut { from: u16, count: u8 },
    /// All on one side of a vertex, which leaves lines.
    Beyond { vertex: u16, axis: bool, above: bool, also_there: bool },
}

impl Edit {
    /// Which of the vertices that are there are to go.
    fn chosen(self, mesh: &Mesh) -> Vec<VertexId> {
        let there: Vec<VertexId> = mesh.vertices().collect();
        let count = there.len();
        if count == 0 {
            return there;
        }
        match self {
            Edit::None => Vec::new(),
            Edit::Some { from, stride, count: wanted } => {
                let index = |step: usize| (usize::from(from) + step * usize::from(stride)) % count;
                (0..usize::from(wanted)).map(|step| there[index(step)]).collect()
            }
            Edit::Last { count: wanted } => {
                there[count.saturating_sub(usize::from(wanted))..].to_vec()
            }
            Edit::AllBut { from, count: kept } => {
                let first = usize::from(from) % count;
                let kept = first..first + usize::from(kept % 16);
                (0..count).filter(|index| !kept.contains(index)).map(|index| there[index]).collect()
            }
            Edit::Beyond { vertex, axis, above, also_there } => {
                let on = |vertex: VertexId| mesh.points()[vertex as usize][usize::from(axis)];
                let limit = on(there[usize::from(vertex) % count]);
                let goes = |&vertex: &VertexId| {
                    let on = on(vertex);
                    (if above { on > limit } else { on < limit }) || (also_there && on == limit)
                };
                there.into_iter().filter(goes).collect()
            }
        }
    }
}

fuzz_target!(|edited: EditedScan| {
    let points = edited.scan.points();
    let mut mesh = Mesh::new();
    for (index, batch) in edited.scan.batches(&points).into_iter().enumerate() {
        mesh.insert(batch);
        if !edited.edits.is_empty() {
            for vertex in edited.edits[index % edited.edits.len()].chosen(&mesh) {
                // Some are chosen twice.
                if mesh.is_vertex(vertex) {
                    let point = mesh.points()[vertex as usize];
                    assert_eq!(mesh.remove(vertex), Ok(point));
                }
                assert!(mesh.remove(vertex).is_err());
            }
        }
        is_that_of_the_others(&mesh);
    }
    // What was left unused must not be met again.
    mesh.insert(&points);
    is_that_of_the_others(&mesh);
});

/// The mesh is the one that the vertices give which are left, numbers apart.
fn is_that_of_the_others(mesh: &Mesh) {
    let there: Vec<VertexId> = mesh.vertices().collect();
    let points: Vec<PointMm> = there.iter().map(|&vertex| mesh.points()[vertex as usize]).collect();
    let mut new = Mesh::new();
    new.insert(&points);
    assert_eq!(check::delaunay(&points, new.triangles()), Ok(()));
    assert!(laws::by_coordinates(mesh) == laws::by_coordinates(&new), "the triangles differ");
    let (counts, expected) = (mesh.counts(), new.counts());
    assert_eq!(counts.vertices, expected.vertices);
    assert_eq!(counts.triangles, expected.triangles);
    assert_eq!((counts.edges, counts.hull), (expected.edges, expected.hull));
    assert_eq!(counts.withdrawn as usize, mesh.withdrawn().len());
    for &vertex in there.iter().step_by(1 + there.len() / 8) {
        let [x, y, _] = mesh.points()[vertex as usize];
        assert_eq!(mesh.locate(x, y), Location::At { vertex });
        assert_eq!(mesh.nearest(x, y), Some(vertex));
    }
}

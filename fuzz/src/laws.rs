//! What must hold for a mesh of any points.

use std::collections::HashMap;

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, Outcome, check};

use crate::scan::shuffle;

/// The mesh is Delaunay, and what it says of itself agrees with its triangles.
pub fn hold(mesh: &Mesh) {
    let triangles = mesh.triangles();
    assert_eq!(check::delaunay(mesh.points(), triangles.iter().copied()), Ok(()));
    assert!(triangles.windows(2).all(|pair| pair[0] < pair[1]), "the triangles are not in order");
    assert!(triangles.iter().all(|&[a, b, c]| a < b && a < c), "a triangle starts elsewhere");

    let mut edges: HashMap<[VertexId; 2], u32> = HashMap::new();
    for &[a, b, c] in &triangles {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            *edges.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    let counts = mesh.counts();
    let vertices = mesh.points().len() as u64;
    assert_eq!((counts.vertices, counts.triangles), (vertices, triangles.len() as u64));
    if triangles.is_empty() {
        assert_eq!((counts.edges, counts.hull), (vertices.saturating_sub(1), vertices));
    } else {
        let hull = edges.values().filter(|&&sides| sides == 1).count() as u64;
        assert_eq!((counts.edges, counts.hull), (edges.len() as u64, hull));
        assert_eq!(counts.vertices + counts.triangles, counts.edges + 1, "Euler");
    }
    assert_eq!(counts.pending, 0);
    let taken = counts.vertices + counts.duplicates + counts.conflicts + counts.rejected;
    assert_eq!(counts.pushed, taken);
}

/// Each point is the next vertex, or stands exactly where an earlier one does, or is no number.
pub fn all_is_accounted_for(mesh: &Mesh, points: &[PointMm]) {
    let mut next = 0;
    for (index, point) in points.iter().enumerate() {
        let stands_at = |vertex: VertexId| {
            let [x, y, _] = mesh.points()[vertex as usize];
            [x, y] == [point[0], point[1]].map(as_vertices_carry)
        };
        match mesh.outcome(index).expect("every point has been taken") {
            Outcome::Vertex(vertex) => {
                assert_eq!(vertex, next);
                assert!(stands_at(vertex));
                next += 1;
            }
            Outcome::Duplicate { of } | Outcome::Conflict { of, .. } => {
                assert!(of < next, "{of} had not arrived when {index} did");
                assert!(stands_at(of));
            }
            Outcome::Rejected(_) => {
                assert!(point.iter().any(|mm| !mm.is_finite() || mm.abs() > 1e12));
            }
            other => panic!("{index}: {other:?}"),
        }
    }
    assert_eq!(next as usize, mesh.points().len());
    assert_eq!(mesh.outcome(points.len()), None);
}

/// One batch, batches of one, the reverse and a shuffled order give the same triangles.
pub fn order_does_not_matter(mesh: &Mesh, points: &[PointMm], seed: u64) {
    let expected = by_coordinates(mesh);
    let again = |points: &[PointMm], batch: usize| {
        let mut mesh = Mesh::new();
        for batch in points.chunks(batch) {
            mesh.insert(batch);
        }
        mesh
    };
    let whole = points.len().max(1);
    let mut turned = points.to_vec();
    turned.reverse();
    let mut shuffled = points.to_vec();
    shuffle(&mut shuffled, seed);
    for (points, batch, how) in [
        (points, whole, "at once"),
        (points, 1, "one by one"),
        (&turned, whole, "reversed"),
        (&turned, 100, "reversed in hundreds"),
        (&shuffled, whole, "shuffled"),
        (&shuffled, 17, "shuffled in batches"),
    ] {
        assert!(by_coordinates(&again(points, batch)) == expected, "{how} the triangles differ");
    }
    let same_order = again(points, whole);
    assert!(same_order.points() == mesh.points() && same_order.triangles() == mesh.triangles());
}

/// A coordinate below the least that counts is zero.
fn as_vertices_carry(mm: f64) -> f64 {
    if mm.abs() < 1e-40 { 0.0 } else { mm }
}

/// The bits of its corners' coordinates, from the smallest corner on, counter-clockwise.
pub type Triangle = [[u64; 2]; 3];

/// The triangles by the places of their corners, in a fixed order.
pub fn by_coordinates(mesh: &Mesh) -> Vec<Triangle> {
    let place = |vertex: VertexId| {
        let [x, y, _] = mesh.points()[vertex as usize];
        [x.to_bits(), y.to_bits()]
    };
    let mut triangles: Vec<Triangle> = mesh
        .triangles()
        .into_iter()
        .map(|corners| {
            let mut places = corners.map(place);
            let first = (0..3).min_by_key(|&i| places[i]).unwrap_or(0);
            places.rotate_left(first);
            places
        })
        .collect();
    triangles.sort_unstable();
    triangles
}

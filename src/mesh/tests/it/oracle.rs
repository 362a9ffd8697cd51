//! Points in general position against a batch triangulation: the same set of triangles.

use std::collections::{BTreeSet, HashMap};

use asphera_geometry::{PointMm, VertexId};
use asphera_mesh::{Mesh, check};
use spade::{DelaunayTriangulation, Point2, Triangulation};

use crate::patterns::{jittered_raster, scattered, spiral};

/// Each triangle with its smallest corner first, in the order it turns.
fn canonical(triangles: impl Iterator<Item = [VertexId; 3]>) -> BTreeSet<[VertexId; 3]> {
    triangles
        .map(|[a, b, c]| {
            if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            }
        })
        .collect()
}

fn bulk(points: &[PointMm]) -> BTreeSet<[VertexId; 3]> {
    let index: HashMap<[u64; 2], VertexId> =
        (0..).zip(points).map(|(i, p)| ([p[0].to_bits(), p[1].to_bits()], i)).collect();
    let places = points.iter().map(|p| Point2::new(p[0], p[1])).collect();
    let mesh: DelaunayTriangulation<Point2<f64>> =
        DelaunayTriangulation::bulk_load(places).expect("the places are finite");
    let corner = |place: Point2<f64>| index[&[place.x.to_bits(), place.y.to_bits()]];
    canonical(mesh.inner_faces().map(|face| face.positions().map(corner)))
}

fn assert_same_triangles(points: &[PointMm]) {
    let mut mesh = Mesh::new();
    mesh.extend(points.iter().copied());
    mesh.flush();
    assert_eq!(mesh.points(), points);
    assert!(canonical(mesh.triangles().into_iter()) == bulk(points), "the triangles differ");
    assert_eq!(check::delaunay(mesh.points(), mesh.triangles()), Ok(()));
}

#[test]
fn scattered_points() {
    for (count, seed) in [(3, 1), (4, 2), (10, 3), (100, 4), (1_000, 5), (20_000, 6)] {
        assert_same_triangles(&scattered(count, 10.0, seed));
    }
}

#[test]
fn a_jittered_raster() {
    assert_same_triangles(&jittered_raster(150, 0.1, 7));
}

#[test]
fn a_spiral() {
    assert_same_triangles(&spiral(20_000));
}

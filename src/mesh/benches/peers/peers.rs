//! The other implementations: their types, filled outside the clock, and their calls, inside it.

use asphera_geometry::PointMm;
use spade::{DelaunayTriangulation, Point2, Triangulation};

use crate::clock::timed;

/// After so many seconds an incremental triangulation of spade is given up.
pub(crate) const CAP_S: f64 = 30.0;

/// Points spade inserts between two looks at the clock.
const LOOK_POINTS: usize = 1000;

/// Costs and result of a triangulation.
#[derive(Clone, Copy)]
pub(crate) struct Triangulated {
    pub(crate) seconds: f64,
    /// Points inserted: all of them unless it was given up.
    pub(crate) points: usize,
    pub(crate) triangles: u64,
}

pub(crate) fn for_delaunator(points: &[PointMm]) -> Vec<delaunator::Point> {
    points.iter().map(|&[x, y, _]| delaunator::Point { x, y }).collect()
}

pub(crate) fn for_spade(points: &[PointMm]) -> Vec<Point2<f64>> {
    points.iter().map(|&[x, y, _]| Point2::new(x, y)).collect()
}

pub(crate) fn delaunator(points: &[delaunator::Point]) -> Triangulated {
    let (mesh, seconds) = timed(|| delaunator::triangulate(points));
    Triangulated { seconds, points: points.len(), triangles: mesh.len() as u64 }
}

/// Spade's bulk load into its own order of vertices.
pub(crate) fn spade_bulk(points: &[Point2<f64>]) -> Triangulated {
    bulk(points, DelaunayTriangulation::bulk_load)
}

/// Spade's bulk load that keeps the order of the vertices.
pub(crate) fn spade_bulk_stable(points: &[Point2<f64>]) -> Triangulated {
    bulk(points, DelaunayTriangulation::bulk_load_stable)
}

fn bulk(
    points: &[Point2<f64>],
    load: impl FnOnce(Vec<Point2<f64>>) -> Result<Spade, spade::InsertionError>,
) -> Triangulated {
    let owned = points.to_vec();
    let (mesh, seconds) = timed(|| load(owned).expect(IN_RANGE));
    Triangulated { seconds, points: points.len(), triangles: mesh.num_inner_faces() as u64 }
}

/// Spade point by point in order of arrival, each searched from the one before; given up after
/// [`CAP_S`].
pub(crate) fn spade_incremental(points: &[Point2<f64>]) -> Triangulated {
    let mut mesh = Spade::new();
    let mut last = None;
    let mut done = Triangulated { seconds: 0.0, points: 0, triangles: 0 };
    for batch in points.chunks(LOOK_POINTS) {
        if done.seconds >= CAP_S {
            break;
        }
        let ((), seconds) = timed(|| {
            for &point in batch {
                let inserted = match last {
                    Some(hint) => mesh.insert_with_hint(point, hint),
                    None => mesh.insert(point),
                };
                last = Some(inserted.expect(IN_RANGE));
            }
        });
        done.seconds += seconds;
        done.points += batch.len();
    }
    Triangulated { triangles: mesh.num_inner_faces() as u64, ..done }
}

type Spade = DelaunayTriangulation<Point2<f64>>;

const IN_RANGE: &str =
    "coordinates of scans are zero or lie inside spade's range of 2^-142 to 2^201";

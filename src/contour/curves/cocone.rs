//! Cocone in the plane.

use std::cmp::Ordering;

use asphera_geometry::predicates::{compare_distances, estimated_orientation, in_circle};
use rayon::prelude::*;

use super::gathan::normal_of_hull;
use crate::triangulation::{EdgeId, TriangleId};
use crate::{Graph, PlaceMm, SampleId, Triangulation};

/// Cocone: edges whose Voronoi edge meets the cocone of both ends, thinned to a curve.
///
/// The pole of a sample is the farthest vertex of its Voronoi cell; of a cell without end it lies in the mean of the directions of
/// its two rays. The cocone is the part of the cell within π/8 of the line across the way to the pole. Of the candidates on one
/// side of that way a sample keeps the nearest, and an edge stays if both its ends keep it. So no sample has more than two edges.
///
/// For smooth curves without ends, sampled with ε < 0.05, it is exactly the edges between samples that follow each other: their
/// source states that bound for surfaces. Between the ends of an open curve it may put an edge, as their poles need not lie across
/// it. N. Amenta, S. Choi, T. K. Dey, N. Leekha, International Journal of Computational Geometry and Applications 12 (2002)
/// 125-141, in the plane; thinning is our choice, and under the condition there is nothing to thin. Distances of samples and
/// Voronoi edges that are points are decided exactly. Voronoi vertices and angles are rounded. The tangent of π/8 is no ratio of
/// whole numbers, so no vertex lies exactly on the border of a cocone. Of equally far poles the first counter-clockwise from the edge
/// to the smallest neighbour counts. Linear time after the triangulation.
pub fn cocone(triangulation: &Triangulation) -> Graph {
    if triangulation.triangles().is_empty() {
        // On a line every Voronoi edge is a line across it.
        return crate::graphs::delaunay(triangulation);
    }
    let samples = || (0..triangulation.len() as SampleId).into_par_iter();
    let poles: Vec<PlaceMm> = samples().map(|sample| way_to_pole(triangulation, sample)).collect();
    let is_candidate: Vec<bool> = (0..triangulation.edges().len() as EdgeId)
        .into_par_iter()
        .map(|edge| {
            let ends = triangulation.ends(edge);
            ends.iter().all(|&end| meets(triangulation, edge, end, poles[end as usize]))
                && !is_point(triangulation, edge)
        })
        .collect();
    let nearest = |sample: SampleId| {
        let (at, pole) = (triangulation.place(sample), poles[sample as usize]);
        let mut nearest: [Option<(SampleId, EdgeId)>; 2] = [None; 2];
        let spokes = triangulation.spokes(sample).iter();
        for spoke in spokes.filter(|spoke| is_candidate[spoke.edge as usize]) {
            let to = triangulation.place(spoke.to);
            let across = pole[0] * (to[1] - at[1]) - pole[1] * (to[0] - at[0]);
            // Exactly along the way to the pole an edge leads to neither side.
            let side = match across.total_cmp(&0.0) {
                _ if across == 0.0 => continue,
                Ordering::Less => &mut nearest[0],
                _ => &mut nearest[1],
            };
            // Spokes come by the numbers of their ends: of equally near ones the smallest stays.
            let is_nearer = side.is_none_or(|(other, _)| {
                compare_distances(at, to, at, triangulation.place(other)).is_lt()
            });
            if is_nearer {
                *side = Some((spoke.to, spoke.edge));
            }
        }
        nearest.map(|it| it.map(|(_, edge)| edge))
    };
    let nearest: Vec<[Option<EdgeId>; 2]> = samples().map(nearest).collect();
    Graph::of_edges(triangulation, |edge| {
        triangulation.ends(edge).iter().all(|&end| nearest[end as usize].contains(&Some(edge)))
    })
}

/// The way from a sample to its pole, of any length.
fn way_to_pole(triangulation: &Triangulation, sample: SampleId) -> PlaceMm {
    let (at, fan) = (triangulation.place(sample), triangulation.fan(sample));
    if fan.sectors.contains(&None) {
        return normal_of_hull(triangulation, at, &fan);
    }
    let mut farthest = (0.0, [0.0; 2]);
    for &triangle in fan.sectors.iter().flatten() {
        let way = match place_of(triangulation, triangle) {
            Some(place) => [place[0] - at[0], place[1] - at[1]],
            None => return endless_way(triangulation, triangle),
        };
        let squared_mm2 = way[0] * way[0] + way[1] * way[1];
        if squared_mm2 > farthest.0 {
            farthest = (squared_mm2, way);
        }
    }
    farthest.1
}

/// Whether the Voronoi edge of an edge meets the cocone of one of its ends.
///
/// Both halves of what lies outside the cocone are convex: an edge misses it where both its ends lie in one of them.
fn meets(triangulation: &Triangulation, edge: EdgeId, sample: SampleId, pole: PlaceMm) -> bool {
    let edge = triangulation.edges()[edge as usize];
    let (ends, triangles) = (edge.ends, edge.triangles());
    let half_at = |side: usize| {
        let way = match triangles[side] {
            Some(triangle) => way_to_vertex(triangulation, sample, triangle),
            None => {
                // A ray, whose far end lies in its direction: left of the edge or right of it.
                let ends = ends.map(|end| triangulation.place(end));
                let [from, to] = if side == 0 { ends } else { [ends[1], ends[0]] };
                [from[1] - to[1], to[0] - from[0]]
            }
        };
        half(way, pole)
    };
    let halves = [half_at(0), half_at(1)];
    halves[0] == 0 || halves[0] != halves[1]
}

/// The half of what lies outside the cocone that a way leads into, 1 towards the pole and -1 away from it; 0 within the cocone.
fn half(way: PlaceMm, pole: PlaceMm) -> i8 {
    let dot = |a: PlaceMm, b: PlaceMm| a[0] * b[0] + a[1] * b[1];
    let along = dot(way, pole);
    if along.abs() <= COS_CONE * dot(way, way).sqrt() * dot(pole, pole).sqrt() {
        0
    } else if along > 0.0 {
        1
    } else {
        -1
    }
}

/// The way from a sample to a Voronoi vertex; to one too far off for a place a direction.
fn way_to_vertex(triangulation: &Triangulation, sample: SampleId, triangle: TriangleId) -> PlaceMm {
    match place_of(triangulation, triangle) {
        Some(place) => {
            let at = triangulation.place(sample);
            [place[0] - at[0], place[1] - at[1]]
        }
        None => endless_way(triangulation, triangle),
    }
}

/// The centre of a triangle's circle; none of a triangle that rounding cannot tell from a line: it would lie on either side.
fn place_of(triangulation: &Triangulation, triangle: TriangleId) -> Option<PlaceMm> {
    let corners = triangulation.triangles()[triangle as usize];
    let [a, b, c] = corners.map(|corner| triangulation.place(corner));
    let (twice, bound) = estimated_orientation(a, b, c);
    (twice > bound).then(|| triangulation.centres_mm()[triangle as usize])
}

/// The direction of the centre of a triangle's circle where it is too far off for a place.
fn endless_way(triangulation: &Triangulation, triangle: TriangleId) -> PlaceMm {
    let corners = triangulation.triangles()[triangle as usize];
    let [a, b, c] = corners.map(|corner| triangulation.place(corner));
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let [b2, c2] = [bx * bx + by * by, cx * cx + cy * cy];
    [cy * b2 - by * c2, bx * c2 - cx * b2]
}

/// Whether the Voronoi edge of an edge is a point: both triangles beside it have one circle, and either diagonal would do.
fn is_point(triangulation: &Triangulation, edge: EdgeId) -> bool {
    let triangles = triangulation.edges()[edge as usize].triangles();
    let ([Some(left), Some(_)], [_, Some(apex)]) = (triangles, triangulation.opposite(edge)) else {
        return false;
    };
    let corners = triangulation.triangles()[left as usize];
    let [a, b, c] = corners.map(|corner| triangulation.place(corner));
    in_circle(a, b, c, triangulation.place(apex)).is_eq()
}

/// The cosine of 67.5°: the cocone opens by 22.5° from the tangent.
const COS_CONE: f64 = 0.382_683_432_365_089_8;

//! The medial axis of a curve, from the Voronoi diagram of its samples.

use crate::polylines::middle;
use crate::triangulation::{EdgeId, distance_mm};
use crate::{Graph, PlaceMm, Triangulation};
use asphera_geometry::BoundsMm;

/// The medial axis of a curve through samples in mm: the Voronoi edges of all Delaunay edges that are none of the curve.
///
/// Of dense samples it comes as near to the medial axis of the curve as one likes (J. W. Brandt, V. R. Algazi, CVGIP: Image
/// Understanding 55 (1992) 329-338). Edges that run to infinity or very far are cut ten extents of the samples away. Linear time.
pub fn medial_axis_mm(triangulation: &Triangulation, curve: &Graph) -> Vec<[PlaceMm; 2]> {
    let far_mm = FAR * extent_mm(triangulation);
    let edges = (0..triangulation.edges().len() as EdgeId).filter(|&edge| {
        let [p, q] = triangulation.ends(edge);
        !curve.joins(p, q)
    });
    let mut axis: Vec<[PlaceMm; 2]> =
        edges.filter_map(|edge| dual_mm(triangulation, edge, far_mm)).collect();
    // The centre of a triangle of the curve alone ends no other Voronoi edge.
    let centres = triangulation.triangles().iter().zip(triangulation.centres_mm());
    axis.extend(centres.filter_map(|(&[a, b, c], &centre)| {
        let of_curve = curve.joins(a, b) && curve.joins(b, c) && curve.joins(a, c);
        let is_near = distance_mm(centre, triangulation.place(a)) <= far_mm;
        (of_curve && is_near).then_some([centre, centre])
    }));
    axis
}

/// The Voronoi edge of a Delaunay edge, from its right to its left, cut far off; none if all of it is far off.
fn dual_mm(triangulation: &Triangulation, edge: EdgeId, far_mm: f64) -> Option<[PlaceMm; 2]> {
    let [p, q] = triangulation.ends_mm(edge);
    let length_mm = distance_mm(p, q);
    let left = [(p[1] - q[1]) / length_mm, (q[0] - p[0]) / length_mm];
    let foot = middle(p, q);
    let centres = triangulation.centres_mm();
    // How far left of the edge the Voronoi edge ends on each side. A rounded centre may lie beside the bisector, and is kept.
    let [left_end, right_end] = triangulation.edges()[edge as usize].triangles().map(|triangle| {
        let centre = centres[triangle? as usize];
        let along_mm = (centre[0] - foot[0]) * left[0] + (centre[1] - foot[1]) * left[1];
        Some((centre, along_mm))
    });
    let end = |end: Option<(PlaceMm, f64)>, sign: f64| {
        let (centre, along_mm) = match end {
            Some((centre, along_mm)) if along_mm.is_finite() => (Some(centre), along_mm),
            _ => (None, sign * f64::INFINITY),
        };
        let cut_mm = along_mm.clamp(-far_mm, far_mm);
        let place = [foot[0] + cut_mm * left[0], foot[1] + cut_mm * left[1]];
        (if cut_mm == along_mm { centre.unwrap_or(place) } else { place }, cut_mm)
    };
    let ((from, from_mm), (to, to_mm)) = (end(right_end, -1.0), end(left_end, 1.0));
    let is_far = from_mm == to_mm && from_mm.abs() == far_mm;
    (!is_far).then_some([from, to])
}

/// The diagonal of the box round the samples in mm.
fn extent_mm(triangulation: &Triangulation) -> f64 {
    let places = triangulation.samples().places();
    let corners = BoundsMm::about(places.iter().copied()).corners();
    corners.map_or(0.0, |[low, high]| distance_mm(low, high))
}

/// Extents of the samples beyond which the axis is cut: a curve never comes nearer to what lies there than to its own far side.
const FAR: f64 = 10.0;

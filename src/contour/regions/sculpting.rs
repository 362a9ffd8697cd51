//! Sculpting: a curve carved out of the convex hull.

use super::peeling::{Peeling, Verdict};
use crate::triangulation::{EdgeId, TriangleId, distance_mm};
use crate::{Graph, Triangulation};

/// The border that remains when triangles are carved off the hull until all samples lie on it.
///
/// A triangle may go if exactly one of its sides is border and the corner opposite is not. That whose circumcircle stands out farthest
/// beyond its side on the border goes first:
///
/// h = |pq|/2 · tan(θ/2)
///
/// h is the height of the circle beyond the side pq in mm, θ the angle of the triangle opposite. The border is one closed curve without
/// crossings. Samples that no allowed step brings to it stay alone. The form in the plane of J.-D. Boissonnat, *Geometric structures for
/// three-dimensional shape representation*, ACM Transactions on Graphics 3 (1984) 266-286; the text was not at hand. No
/// condition is proven. Heights are compared in doubles, equal ones by coordinates. n·log n time.
pub fn sculpting(triangulation: &Triangulation) -> Graph {
    if triangulation.triangles().is_empty() {
        return Graph::of_edges(triangulation, |_| true);
    }
    let mut peeling = Peeling::new(triangulation);
    let hull = peeling.hull();
    // Heights are at least 0: they order as their bits do.
    let key =
        |side: EdgeId, triangle: TriangleId| height_mm(triangulation, side, triangle).to_bits();
    peeling.peel(hull, key, |_, _| Verdict::Go);
    peeling.border()
}

/// How far the circumcircle of a triangle stands out beyond one of its sides, in mm.
fn height_mm(triangulation: &Triangulation, side: EdgeId, triangle: TriangleId) -> f64 {
    let ends = triangulation.ends(side);
    let corners = triangulation.triangles()[triangle as usize];
    let Some(apex) = corners.into_iter().find(|corner| !ends.contains(corner)) else { return 0.0 };
    let [p, q, apex] = [ends[0], ends[1], apex].map(|sample| triangulation.place(sample));
    let [px, py, qx, qy] = [p[0] - apex[0], p[1] - apex[1], q[0] - apex[0], q[1] - apex[1]];
    let cross = (px * qy - py * qx).abs();
    let dot = px * qx + py * qy;
    let product = distance_mm(apex, p) * distance_mm(apex, q);
    // Both are tan(θ/2); each loses nothing where it is taken.
    let tangent = if dot >= 0.0 { cross / (product + dot) } else { (product - dot) / cross };
    0.5 * distance_mm(p, q) * tangent
}

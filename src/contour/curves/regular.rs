//! The r-regular shape.

use asphera_geometry::predicates::{compare_angle_sum, scalar_product};

use crate::{Graph, PlaceMm, Triangulation};

/// The r-regular shape: edges whose two opposite angles together are below δ, in radians from above 0 to π.
///
/// That is the angle under which the circumcircles of the two triangles meet. Of a shape whose border can be rolled along by
/// discs of radius r on both sides, sampled with a spacing below sin(π/8)·r, δ = π/2 gives the border. D. Attali, *r-regular
/// shape reconstruction from unorganized points*, SoCG 1997, 248-253; the text was not at hand, the default is ours. δ = π/2
/// is decided exactly, other values in doubles. Linear time.
///
/// # Panics
///
/// If δ is not above 0, or is above π.
pub fn regular_shape(triangulation: &Triangulation, delta_rad: f64) -> Graph {
    let most = std::f64::consts::PI;
    assert!(delta_rad > 0.0 && delta_rad <= most, "expected δ above 0 up to π, found {delta_rad}");
    let is_exact = delta_rad == std::f64::consts::FRAC_PI_2;
    Graph::of_edges(triangulation, |edge| {
        let [p, q] = triangulation.ends_mm(edge);
        let apexes =
            triangulation.opposite(edge).map(|apex| apex.map(|apex| triangulation.place(apex)));
        match apexes {
            [Some(left), Some(right)] if is_exact => compare_angle_sum(p, q, left, right).is_lt(),
            [Some(apex), None] | [None, Some(apex)] if is_exact => {
                scalar_product(apex, p, q).is_gt()
            }
            [None, None] => true,
            // Of the two angles the one on the left comes first, whichever way they are added.
            [left, right] => {
                let angle = |apex: Option<PlaceMm>| apex.map_or(0.0, |apex| angle_rad(apex, p, q));
                angle(left) + angle(right) < delta_rad
            }
        }
    })
}

/// The angle at an apex between the ways to two places, in radians from 0 to π.
pub(super) fn angle_rad(apex: PlaceMm, p: PlaceMm, q: PlaceMm) -> f64 {
    let [px, py, qx, qy] = [p[0] - apex[0], p[1] - apex[1], q[0] - apex[0], q[1] - apex[1]];
    (px * qy - py * qx).abs().atan2(px * qx + py * qy)
}

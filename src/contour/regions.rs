//! Methods that find the area that points were taken in: parts with holes.
//!
//! Points are of the area itself (a dot pattern), of its border, or of both. All regions are made of triangles of the exact Delaunay
//! triangulation. *Regular* is the removal of a triangle with exactly one side on the border whose corner opposite does not lie
//! there: it leaves a simple polygon simple.

mod a_shape;
mod alpha;
mod auto;
mod chi;
mod ct;
mod discern;
mod ec;
mod gabriel;
mod holders;
mod peeling;
mod sculpting;
mod simple;
mod ways;

pub use a_shape::{a_shape, connecting_a_mm};
pub use alpha::{alpha_curve, alpha_shape, connecting_alpha_mm, joining_alpha_mm};
pub use auto::auto_shape;
pub use chi::{chi_default_mm, chi_length_mm, chi_shape};
pub use ct::ct_shape;
pub use discern::{Sampling, discern, petals};
pub use ec::ec_shape;
pub use gabriel::{relaxed_gabriel, shape_hull_graph};
pub use sculpting::sculpting;
pub use simple::simple_shape;

use crate::Triangulation;
use crate::triangulation::TriangleId;

/// The radius of the circumcircle of a triangle in mm; infinite where rounding makes it a line.
fn radius_mm(triangulation: &Triangulation, triangle: TriangleId) -> f64 {
    let [a, b, c] = triangulation.sides(triangle).map(|side| triangulation.length_mm(side));
    a * b * c / (2.0 * doubled_area_mm2(triangulation, triangle))
}

/// Twice the area of a triangle in mm².
fn doubled_area_mm2(triangulation: &Triangulation, triangle: TriangleId) -> f64 {
    let corners = triangulation.triangles()[triangle as usize];
    let [a, b, c] = corners.map(|corner| triangulation.place(corner));
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}

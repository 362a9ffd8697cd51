//! Surfaces that do not project: what is said of them instead of figures.
//!
//! A mesh in the plane holds one height at a place. Of a surface with two sheets there, such as a closed body, it joins
//! points of both, and its areas, gaps and defects are those of nothing.

use asphera_geometry::PointMm;
use asphera_mesh::Mesh;
use asphera_surface::{Kind, Plane, Relief, Topography, projectable_along};

/// Why a mesh is none of its surface, or none if nothing says so. `relief` is what was found steep of it.
pub(super) fn folded(mesh: &Mesh, relief: &Topography, plane: &Plane) -> Option<String> {
    let folds = relief.regions().iter().filter(|region| region.kind == Kind::Fold);
    let places = folds.clone().count();
    if let Some(fold) = folds.into_iter().next() {
        let [x, y, z] = plane.from_plane(fold.at_mm);
        let triangles = fold.triangles;
        let folds = match places {
            1 => "at one place,".to_owned(),
            places => format!("in {places} places, the largest"),
        };
        return Some(format!(
            "the surface does not project: it folds {folds} about ({x:.4}, {y:.4}, {z:.4}) mm with {triangles} triangles. Its mesh would join points that lie one above the other, so it has no figures"
        ));
    }
    let counts = mesh.counts();
    (counts.conflicts as f64 > STRAY * counts.pushed as f64).then(|| {
        let (conflicts, pushed) = (counts.conflicts, counts.pushed);
        format!(
            "the surface does not project: {conflicts} of {pushed} points lie above or below others, so its mesh has no figures"
        )
    })
}

/// Count and extents of the points of such a surface, and what to do. `measured_mm` are they in the measured frame.
pub(super) fn still_true(measured_mm: &[PointMm]) -> (String, String) {
    let along = projectable_along(measured_mm, &Relief::default());
    let advice = along.map_or_else(|error| error.to_string(), |found| found.to_string());
    (extents(measured_mm), format!("{advice}; {CURE}"))
}

fn extents(measured_mm: &[PointMm]) -> String {
    let range = |axis: usize| {
        let of_axis = measured_mm.iter().map(|point| point[axis]);
        of_axis
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], mm| [low.min(mm), high.max(mm)])
    };
    let [x, y, z] = [0, 1, 2].map(|axis| {
        let [low, high] = range(axis);
        format!("{low:.4} to {high:.4}")
    });
    format!("{} points, x {x}, y {y}, z {z} mm", measured_mm.len())
}

const CURE: &str = "mesh it in space with --along none, or measure it in pieces that each face one direction, named with --along or [projection]";

/// A larger share of the points above or below others is a second sheet, a smaller one is wrong readings.
const STRAY: f64 = 0.01;

#[cfg(test)]
mod tests;

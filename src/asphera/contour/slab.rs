//! The points of a body near a plane, as its section there.

use asphera_contour::PlaceMm;
use asphera_geometry::PointMm;
use asphera_surface::Plane;

/// A plane and how far from it points may lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// The plane.
    pub(crate) plane: Plane,
    /// Distance up to which points count, mm.
    pub(crate) within_mm: f64,
}

/// The plane a·x + b·y + c·z = d, lengths in mm; none where a, b and c are all zero, or a number is not finite.
pub(crate) fn plane_of([a, b, c, d]: [f64; 4]) -> Option<Plane> {
    let share = d / (a * a + b * b + c * c);
    Plane::new([a, b, c].map(|it| share * it), [a, b, c]).ok()
}

impl Slab {
    /// The place of a point on the plane, and its distance from it in mm. Coordinates are x and y where the plane is z = d.
    pub(crate) fn lay(&self, point: PointMm) -> (PlaceMm, f64) {
        let [u, v, w] = self.plane.to_plane(point);
        ([u, v], w.abs())
    }

    /// The places of points that count.
    ///
    /// # Errors
    ///
    /// The distance of the nearest point in mm, where none counts and there are points.
    pub(crate) fn places(
        &self,
        points: impl Iterator<Item = PointMm>,
    ) -> Result<Vec<PlaceMm>, f64> {
        let mut nearest_mm = f64::INFINITY;
        let mut places = Vec::new();
        for (place, off_mm) in points.map(|point| self.lay(point)) {
            nearest_mm = nearest_mm.min(off_mm);
            if off_mm <= self.within_mm {
                places.push(place);
            }
        }
        if places.is_empty() && nearest_mm.is_finite() { Err(nearest_mm) } else { Ok(places) }
    }
}

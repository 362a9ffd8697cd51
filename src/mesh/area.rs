//! Areas of a mesh, summed with compensation.

use asphera_geometry::{PointMm, Sum, Triangle, VertexId};

/// Area of a set of triangles in mm².
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Area {
    /// Sum of the triangles as they lie in space.
    pub lifted_mm2: f64,
    /// Sum of their projections on the x-y plane: of a whole mesh, the area of the convex hull.
    pub projected_mm2: f64,
}

/// Area of `triangles`, whose corners are indices into `points`.
///
/// The sums are compensated: their rounding error does not grow with the number of triangles.
///
/// # Panics
///
/// When a corner is not the index of a point.
pub fn area(points: &[PointMm], triangles: impl IntoIterator<Item = [VertexId; 3]>) -> Area {
    let (mut lifted, mut projected) = (Sum::default(), Sum::default());
    for corners in triangles {
        let triangle = Triangle::new(points, corners);
        lifted.add(triangle.area_mm2());
        projected.add(triangle.projected_area_mm2());
    }
    Area { lifted_mm2: lifted.total(), projected_mm2: projected.total() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tilted_square_is_larger_than_its_projection() {
        // Slope 3/4 along x: the lifted area is 5/4 of the projected one.
        let points = [[0.0, 0.0, 0.0], [4.0, 0.0, 3.0], [4.0, 4.0, 3.0], [0.0, 4.0, 0.0]];
        let found = area(&points, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(found, Area { lifted_mm2: 20.0, projected_mm2: 16.0 });
        assert_eq!(area(&points, []), Area::default());
    }
}

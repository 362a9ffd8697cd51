//! Areas of a mesh, summed with compensation.

use crate::triangle::Triangle;
use crate::{PointMm, VertexId};

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

/// A running sum with the compensation of A. Neumaier, ZAMM 54 (1974) 39-51,
/// doi:10.1002/zamm.19740540106. What each addition loses is found without asking which term is larger
/// (D. E. Knuth, The Art of Computer Programming 2, section 4.2.2, theorem B).
#[derive(Clone, Copy, Default)]
pub(crate) struct Sum {
    rounded: f64,
    lost: f64,
}

impl Sum {
    #[inline(always)]
    pub(crate) fn add(&mut self, term: f64) {
        let sum = self.rounded + term;
        let of_term = sum - self.rounded;
        self.lost += (self.rounded - (sum - of_term)) + (term - of_term);
        self.rounded = sum;
    }

    /// Adds what another sum has come to, with its compensation.
    pub(crate) fn join(&mut self, other: Sum) {
        self.add(other.rounded);
        self.add(other.lost);
    }

    pub(crate) fn total(self) -> f64 {
        self.rounded + self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_keeps_what_a_plain_one_loses() {
        let mut sum = Sum::default();
        [1.0, 1e100, 1.0, -1e100].into_iter().for_each(|term| sum.add(term));
        assert_eq!(sum.total(), 2.0);
    }

    #[test]
    fn a_tilted_square_is_larger_than_its_projection() {
        // Slope 3/4 along x: the lifted area is 5/4 of the projected one.
        let points = [[0.0, 0.0, 0.0], [4.0, 0.0, 3.0], [4.0, 4.0, 3.0], [0.0, 4.0, 0.0]];
        let found = area(&points, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(found, Area { lifted_mm2: 20.0, projected_mm2: 16.0 });
        assert_eq!(area(&points, []), Area::default());
    }
}

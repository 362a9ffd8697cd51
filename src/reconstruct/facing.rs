//! Sides of a surface by where it was looked at from.

use asphera_geometry::PointMm;

use crate::geometry::{dot, double_area};
use crate::prove::corners;
use crate::surface::Reconstruction;
use crate::turning::Turning;

impl Reconstruction {
    /// The same facets, each open patch turned so that its area vector has a part along `way`, which leads from the surface to what
    /// looked at it.
    ///
    /// Closed patches stay turned outwards, and patches that face as much away as along keep their side. A surface of one side stays as
    /// it is. `points_mm` are the points that it was made of. Linear time.
    pub fn facing(mut self, points_mm: &[PointMm], way: PointMm) -> Reconstruction {
        let Some(Turning { patch, patches, .. }) = Turning::of(points_mm.len(), &self.facets)
        else {
            return self;
        };
        let mut sums = vec![[0.0; 2]; patches];
        for (&facet, &patch) in self.facets.iter().zip(&patch) {
            let normal = double_area(corners(points_mm, facet));
            let [along, size] = &mut sums[patch as usize];
            *along += dot(normal, way);
            *size += (dot(normal, normal) * dot(way, way)).sqrt();
        }
        for (facet, patch) in self.facets.iter_mut().zip(patch) {
            let [along, size] = sums[patch as usize];
            // The area vector of a closed patch is 0 but for rounding.
            if along < -1e-9 * size {
                facet.swap(1, 2);
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::local;

    /// A raster on a slope and, beside it, a closed ball.
    fn cloud() -> Vec<PointMm> {
        let raster = (0..64).map(|at| {
            let (x, y) = (f64::from(at % 8), f64::from(at / 8));
            [x, y, 0.3 * x + 0.01 * x * y]
        });
        let body = (0..300).map(|at| {
            let z = 1.0 - (2.0 * f64::from(at) + 1.0) / 300.0;
            let (sin, cos) = (2.399_963 * f64::from(at)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            [across * cos, across * sin, z].map(|value| 40.0 + 4.0 * value)
        });
        raster.chain(body).collect()
    }

    fn area_vector(points: &[PointMm], facets: &[[u32; 3]]) -> PointMm {
        facets.iter().fold([0.0; 3], |sum, &facet| {
            let normal = double_area(corners(points, facet));
            [0, 1, 2].map(|axis| sum[axis] + normal[axis])
        })
    }

    #[test]
    fn open_patches_face_the_way_and_closed_ones_stay() {
        let points = cloud();
        let made = local(&points).unwrap();
        let of_body = |made: &Reconstruction| {
            let is_body = |facet: &&[u32; 3]| facet[0] >= 64;
            made.facets.iter().filter(is_body).copied().collect::<Vec<_>>()
        };
        assert!(made.facets.len() - of_body(&made).len() >= 96, "{}", made.facets.len());
        for way in [[0.0, 0.0, 1.0], [0.0, 0.0, -2.0], [-1.0, 0.0, 0.1], [5.0, 0.0, 0.1]] {
            let found = made.clone().facing(&points, way);
            assert!(dot(area_vector(&points, &found.facets), way) > 0.0, "{way:?}");
            assert_eq!(of_body(&found), of_body(&made), "{way:?}");
            assert_eq!(found.left_out, made.left_out);
            assert!(found.facets.iter().zip(&made.facets).all(|(a, b)| a[0] == b[0]));
        }
    }
}

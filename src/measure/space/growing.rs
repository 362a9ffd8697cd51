//! The mesh in space of the points of a station, kept up to date while they arrive.
//!
//! A look is of the points up to a number. The mesh takes points up to the number of the next look, batch by batch, and waits there
//! until that look was taken. So a look costs its proof and its figures, and its mesh is that of its points whoever asks when.

use asphera_geometry::PointMm;
use asphera_reconstruct::LocalSurface;

use super::meshed::Meshed;

/// The mesh up to now.
#[derive(Default)]
pub(super) struct GrowingMesh {
    surface: LocalSurface,
}

impl GrowingMesh {
    /// Takes batches of points that have arrived, none beyond a number of points.
    pub(super) fn follow(&mut self, points_mm: &[PointMm], most: usize) {
        let most = most.min(points_mm.len());
        while let Some(batch) = points_mm[..most].get(self.taken()..self.taken() + BATCH) {
            if self.surface.insert(batch).is_err() {
                return;
            }
        }
    }

    /// The mesh of the first so many points.
    ///
    /// # Errors
    ///
    /// Why there is none, in words.
    pub(super) fn mesh(&mut self, points_mm: &[PointMm]) -> Result<Meshed, String> {
        let is_followed = points_mm
            .get(self.taken()..)
            .is_some_and(|new| new.is_empty() || self.surface.insert(new).is_ok());
        // What was followed is not what is asked for, or is too much: then these points are meshed at once.
        if is_followed { Meshed::of_surface(&self.surface) } else { Meshed::of(points_mm) }
    }

    fn taken(&self) -> usize {
        self.surface.received()
    }
}

/// Points of a batch.
const BATCH: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    fn spiral(count: usize) -> Vec<PointMm> {
        (0..count)
            .map(|index| {
                let z = 1.0 - (2 * index + 1) as f64 / count as f64;
                let (out, turn) = ((1.0 - z * z).sqrt(), 2.399_963 * index as f64);
                [5.0 * out * turn.cos(), 5.0 * out * turn.sin(), 5.0 * z]
            })
            .collect()
    }

    /// The mesh is that of the points asked for, whatever was taken before.
    #[test]
    fn a_look_is_of_its_points() {
        let mut points = spiral(6_000);
        points.insert(700, points[20]);
        points.insert(900, [f64::NAN; 3]);
        for followed in [0, 999, 1_000, 4_500, 6_002] {
            let mut growing = GrowingMesh::default();
            growing.follow(&points[..followed], followed);
            assert_eq!(growing.taken(), followed / 1_000 * 1_000);
            for count in [5_000, 2_000, 6_002] {
                let (found, expected) = (
                    growing.mesh(&points[..count]).unwrap(),
                    Meshed::of(&points[..count]).unwrap(),
                );
                assert_eq!(found.points_mm, expected.points_mm);
                assert_eq!(found.facets, expected.facets, "{count} of {followed}");
                assert_eq!(found.left_out, expected.left_out);
                assert_eq!(
                    (found.duplicates, found.rejected),
                    (expected.duplicates, expected.rejected)
                );
            }
        }
    }
}

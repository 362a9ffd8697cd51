//! The scale of the samples: what counts as a gap where nothing is said.

use asphera_geometry::{PointMm, VertexId};
use rayon::prelude::*;

use super::wanted::Wanted;
use super::{CHUNK, Sampled};

/// The scale of the samples.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// The distance points have on average.
    distance_mm: Option<f64>,
    /// The largest gap allowed.
    pub(super) gap_mm: Option<f64>,
}

impl Scale {
    pub(super) fn of(sampled: Sampled<'_>, wanted: Wanted) -> Scale {
        let points = sampled.mesh.points();
        let area_mm2 = projected_mm2(points, sampled.triangles);
        let distance_mm = (area_mm2 / points.len() as f64).sqrt();
        let distance_mm = (distance_mm > 0.0 && distance_mm.is_finite()).then_some(distance_mm);
        // On a flat surface ε allows anything, and a triangulation fills every hole.
        let gap_mm = wanted.gap_mm.or(distance_mm.map(|distance_mm| GAP * distance_mm));
        Scale { distance_mm, gap_mm }
    }

    /// The length from which an edge bridges a gap.
    pub(super) fn reach_mm(&self) -> Option<f64> {
        Some(REACH * self.distance_mm?)
    }
}

/// Area of the hull in mm².
fn projected_mm2(points: &[PointMm], triangles: &[[VertexId; 3]]) -> f64 {
    let twice_mm2 = |&[a, b, c]: &[VertexId; 3]| {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] =
            [a, b, c].map(|corner| points[corner as usize]);
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    };
    let chunks: Vec<f64> =
        triangles.par_chunks(CHUNK).map(|chunk| chunk.iter().map(twice_mm2).sum::<f64>()).collect();
    0.5 * chunks.into_iter().sum::<f64>()
}

/// The largest gap allowed where nothing is said, in average distances.
const GAP: f64 = 4.0;
/// The length of an edge that bridges, in the same.
const REACH: f64 = 6.0;

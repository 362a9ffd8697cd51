//! The reach: the smallest local feature size of the whole surface.
//!
//! Of a nominal it is the smallest value of its table over the aperture ([`super::meridian`], [`super::freeform`]), whatever
//! of that was measured: right to what the table says of its error. Without an aperture it is that of a nominal of
//! revolution out to the farthest point. Of a freeform without one, or where the points are the source, it is the
//! smallest at the points that count. There it is only of what was measured, and of what of that the local feature size is
//! known of: no less than the true one but for the errors of the values, so that ρ is a lower bound.

use asphera_form::{Aperture, Pose};
use asphera_geometry::PointMm;
use rayon::prelude::*;

use super::lfs::Known;
use super::{CHUNK, Remembered};

impl Remembered {
    /// The reach of a part at `pose` over its aperture, in mm: infinite over a plane, `None` where it is not known.
    /// Takes time in proportion to the points only where it is theirs.
    pub fn reach_mm(&self, aperture: &Aperture, points: &[PointMm], pose: &Pose) -> Option<f64> {
        let inner_mm = aperture.hole_mm();
        match &self.0 {
            Known::Nothing => None,
            // Without an aperture its disc reaches to the farthest point.
            Known::Nominal { meridian, .. } => meridian.least_mm(inner_mm),
            Known::Freeform(freeform) if *aperture != Aperture::None => {
                Some(freeform.least_mm(inner_mm))
            }
            Known::Freeform(_) | Known::Points(_) => {
                let counts = |point: PointMm| {
                    let [x, y, _] = pose.to_part(point);
                    aperture.contains(x, y)
                };
                least_at(points, counts, self.lfs_mm(pose))
            }
        }
    }
}

/// The smallest local feature size at the points that count, in mm; `None` where it is known at none.
fn least_at(
    points: &[PointMm],
    counts: impl Fn(PointMm) -> bool + Sync,
    lfs_mm: impl Fn(f64, f64) -> Option<f64> + Sync,
) -> Option<f64> {
    let at = |&point: &PointMm| {
        let found = lfs_mm(point[0], point[1]).filter(|mm| *mm > 0.0);
        found.filter(|_| counts(point))
    };
    points.par_iter().with_min_len(CHUNK).filter_map(at).reduce_with(f64::min)
}

#[cfg(test)]
mod tests;

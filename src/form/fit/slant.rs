//! Uncertainties along a direction as uncertainties along the normal.

use crate::{Fit, Nominal, PointMm, Pose};

/// How a direction of the measured frame stands on the normals of a nominal in its place.
#[derive(Clone, Debug)]
pub(crate) struct Slant {
    nominal: Nominal,
    pose: Pose,
    turn: [[f64; 3]; 3],
    direction: [f64; 3],
}

impl Slant {
    /// `direction` is of unit length.
    pub(crate) fn new(direction: [f64; 3], nominal: &Nominal, pose: &Pose) -> Slant {
        Slant { nominal: nominal.clone(), pose: *pose, turn: pose.rotation(), direction }
    }

    /// The cosine between the direction and the normal at the place of a point, at least [`LEAST_SHARE`]; 1 where
    /// the nominal has no slope.
    pub(crate) fn share(&self, point: PointMm) -> f64 {
        let [x, y, _] = self.pose.to_part(point);
        let [p, q] = self.nominal.gradient(x, y);
        if !(p.is_finite() && q.is_finite()) {
            return 1.0;
        }
        let length = (1.0 + p * p + q * q).sqrt();
        let normal = self.turn.map(|row| (row[2] - row[0] * p - row[1] * q) / length);
        let along: f64 = normal.iter().zip(&self.direction).map(|(a, b)| a * b).sum();
        along.abs().max(LEAST_SHARE)
    }
}

/// Standard uncertainties along `direction`, a unit vector of the measured frame, as uncertainties along the normal of
/// the nominal as fitted: one for each point, in mm, for [`crate::fit_weighted`].
///
/// A height that is off by u moves the distance by u times the cosine between the two. Where the normal stands all but
/// upright on the direction, the height says nothing of the distance; a tenth of it is taken at least. `O(n)`.
pub fn along_normal_mm(
    points: &[PointMm],
    uncertainties_mm: &[f64],
    direction: [f64; 3],
    fit: &Fit,
) -> Vec<f64> {
    let slant = Slant::new(direction, &fit.nominal, &fit.pose);
    let pairs = points.iter().zip(uncertainties_mm);
    pairs.map(|(&point, u_mm)| slant.share(point) * u_mm).collect()
}

/// Smallest share of a height that counts for the distance.
const LEAST_SHARE: f64 = 0.1;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FitSettings, fit};

    /// A plane that rises by `slope` along x.
    fn slanted(slope: f64) -> Fit {
        let points: Vec<PointMm> = (0..64)
            .map(|i| (f64::from(i % 8), f64::from(i / 8)))
            .map(|(x, y)| [x, y, slope * x])
            .collect();
        fit(&points, &Nominal::Plane, &FitSettings::default()).expect("a plane")
    }

    #[test]
    fn heights_over_a_slope_count_by_its_cosine_down_to_a_tenth() {
        let along = |slope: f64, direction| {
            along_normal_mm(&[[1.0, 2.0, slope]], &[3e-6], direction, &slanted(slope))[0]
        };
        let up = [0.0, 0.0, 1.0];
        assert!((along(0.0, up) - 3e-6).abs() < 1e-18);
        assert!((along(1.0, up) - 3e-6 * 0.5_f64.sqrt()).abs() < 1e-18);
        assert!((along(0.75, [1.0, 0.0, 0.0]) - 0.6 * 3e-6).abs() < 1e-18);
        // Along the plane itself.
        assert!((along(0.0, [0.0, 1.0, 0.0]) - 3e-7).abs() < 1e-18);
    }
}

//! A ball that rests on the simulated part.

use asphera_measure::Tip;

use super::super::super::path::PlaceMm;
use super::Simulated;

impl Simulated {
    /// Reading of a ball tip whose centre stands over a place, mm: it touches the part, form error and all, where the part's normal
    /// leads to that centre. `None` where the nominal has no height.
    pub(super) fn touched_mm(&self, tip: &Tip, index: usize, [x_mm, y_mm]: PlaceMm) -> Option<f64> {
        let radius_mm = tip.radius_mm();
        let mut normal = [0.0, 0.0, 1.0];
        for _ in 0..STEPS {
            let at = [x_mm - radius_mm * normal[0], y_mm - radius_mm * normal[1]];
            normal = self.normal(at)?;
        }
        let at = [x_mm - radius_mm * normal[0], y_mm - radius_mm * normal[1]];
        let centre_mm = self.height_mm(index, at)? + radius_mm * normal[2];
        Some(centre_mm - tip.centre_mm([0.0; 3], [0.0, 0.0, 1.0])[2])
    }

    /// Unit normal of the part with its form error, by central differences.
    fn normal(&self, [x_mm, y_mm]: PlaceMm) -> Option<[f64; 3]> {
        let height = |x_mm: f64, y_mm: f64| self.smooth_mm([x_mm, y_mm]);
        let p = (height(x_mm + STEP_MM, y_mm)? - height(x_mm - STEP_MM, y_mm)?) / (2.0 * STEP_MM);
        let q = (height(x_mm, y_mm + STEP_MM)? - height(x_mm, y_mm - STEP_MM)?) / (2.0 * STEP_MM);
        let stretch = (1.0 + p * p + q * q).sqrt();
        Some([-p / stretch, -q / stretch, 1.0 / stretch])
    }
}

/// Steps to the contact: each leaves the radius of the ball times the curvature of the part of the way.
const STEPS: usize = 60;
/// Half a step of the differences, mm. What it adds to the slopes is below their rounding.
const STEP_MM: f64 = 1e-4;

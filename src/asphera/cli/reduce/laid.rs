//! A part where it lies among the points.

use asphera_form::{FitSettings, Nominal, Pose, fit};
use asphera_geometry::PointMm;

use asphera_measure::Part;

/// A part of which the design is known, with where it lies.
pub(super) struct Laid<'a> {
    pub(super) part: &'a Part,
    pub(super) pose: Pose,
    /// The nominal with its fitted shape.
    nominal: Nominal,
}

impl<'a> Laid<'a> {
    /// Fits the part to a thinned choice of points. That is enough: local feature sizes change little over a shift, and
    /// deviations are averaged from any surface near the points.
    ///
    /// # Errors
    ///
    /// Why it cannot be fitted, in words.
    pub(super) fn new(part: &'a Part, points: &[PointMm]) -> Result<Laid<'a>, String> {
        let settings = FitSettings {
            free: part.free.clone(),
            aperture: part.aperture.clone(),
            ..FitSettings::default()
        };
        let step = points.len().div_ceil(FITTED_POINTS);
        let chosen: Vec<PointMm> = points.iter().copied().step_by(step).collect();
        match fit(&chosen, &part.nominal, &settings) {
            Ok(fit) => Ok(Laid { part, pose: fit.pose, nominal: fit.nominal }),
            Err(error) => Err(asphera_report::error_chain(&error)),
        }
    }

    /// The height of the nominal at the x and y of a point, in the frame of the points; `None` where it has none.
    ///
    /// It is found by Newton's method along z, from the point on.
    pub(super) fn height_mm(&self, [x, y, z]: PointMm) -> Option<f64> {
        let [_, _, up] = self.pose.rotation();
        let mut z_mm = z;
        for _ in 0..STEPS {
            let [px, py, pz] = self.pose.to_part([x, y, z_mm]);
            let over_mm = pz - self.nominal.height_mm(px, py)?;
            let [along_x, along_y] = self.nominal.gradient(px, py);
            let step_mm = over_mm / (up[2] - along_x * up[0] - along_y * up[1]);
            if !step_mm.is_finite() {
                return None;
            }
            z_mm -= step_mm;
            // Steps shrink to their square, so the next would be lost in rounding.
            if step_mm.abs() <= SETTLED_MM {
                return Some(z_mm);
            }
        }
        None
    }
}

/// Points the nominal is fitted to.
const FITTED_POINTS: usize = 100_000;
const STEPS: usize = 20;
const SETTLED_MM: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_those_of_the_nominal_where_it_lies() {
        let text = "[surface]\nkind = \"asphere\"\nradius_mm = 20\nconic = -0.5\n";
        let part = asphera_nominal::parse("part.toml", text).unwrap();
        let nominal = part.nominal.clone();
        let pose = Pose {
            tx_mm: 0.3,
            ty_mm: -0.2,
            tz_mm: 5.0,
            rx_rad: 0.02,
            ry_rad: -0.03,
            ..Pose::default()
        };
        let laid = Laid { part: &part, pose, nominal };
        for [x, y] in [[0.0, 0.0], [3.0, -2.0], [-7.0, 5.0], [9.0, 0.1]] {
            let [px, py, pz] = pose.to_measured([x, y, part.nominal.height_mm(x, y).unwrap()]);
            for off_mm in [0.0, 1e-5, -0.1] {
                let found_mm = laid.height_mm([px, py, pz + off_mm]).unwrap();
                assert!((found_mm - pz).abs() < 1e-13, "{x} {y} {off_mm}: {}", found_mm - pz);
            }
        }
        assert_eq!(laid.height_mm([1e3, 0.0, 0.0]), None);
    }
}

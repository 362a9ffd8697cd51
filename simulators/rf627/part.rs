//! What the simulated scanner looks at.

use std::f64::consts::TAU;

/// A surface over the plane of x and y, mm, with waves as its form error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Radius of curvature in mm, the centre above the surface; `None`: a plane.
    pub radius_mm: Option<f64>,
    /// Amplitude of the waves in µm.
    pub wave_um: f64,
    /// Length of the waves along x and y in mm.
    pub wave_length_mm: f64,
    /// Half the width of the part along x in mm; there is nothing beyond.
    pub half_width_mm: f64,
}

impl Part {
    /// Height in mm; `None` where there is no part.
    pub fn height_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let r2 = x_mm * x_mm + y_mm * y_mm;
        let shape_mm = match self.radius_mm {
            None => 0.0,
            // Free of cancellation; beyond the equator there is no part.
            Some(radius_mm) if r2 < radius_mm * radius_mm => {
                r2 / (radius_mm + (radius_mm * radius_mm - r2).sqrt() * radius_mm.signum())
            }
            Some(_) => return None,
        };
        let phase = |place_mm: f64| (TAU * place_mm / self.wave_length_mm).sin();
        let wave_mm = self.wave_um * 1e-3 * phase(x_mm) * phase(y_mm);
        (x_mm.abs() <= self.half_width_mm).then_some(shape_mm + wave_mm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_rises_as_its_sagitta() {
        let part =
            Part { radius_mm: Some(5.0), wave_um: 0.0, wave_length_mm: 1.0, half_width_mm: 4.5 };
        assert!((part.height_mm(3.0, 0.0).unwrap() - 1.0).abs() < 1e-15);
        assert_eq!((part.height_mm(4.6, 0.0), part.height_mm(4.0, 4.0)), (None, None));
        let domed = Part { radius_mm: Some(-5.0), ..part };
        assert!((domed.height_mm(0.0, 3.0).unwrap() + 1.0).abs() < 1e-15);
    }
}

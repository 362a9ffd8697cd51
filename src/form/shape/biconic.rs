//! The biconic: two radii and two conic constants under one root.

use std::sync::Arc;

use super::argument::count;
use super::section::ConicSection;
use super::taylor::{defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// A biconic: `z = (x²/Rx + y²/Ry)/(1 + √(1 − (1+κx)·x²/Rx² − (1+κy)·y²/Ry²))` (ISO 10110-12:2019; Zemax'
/// BICONICX, which gives the x direction by its parameters 1 and 2).
///
/// This is not the sum of two acylinders, which some programs call by the same name: the two agree on the
/// axes and differ by terms in x²·y².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biconic {
    x: ConicSection,
    y: ConicSection,
}

impl Biconic {
    /// From its sections along x and along y. Parameters `radius_x` and `conic_x`, `radius_y` and
    /// `conic_y`; those of a flat section are left out.
    pub fn new(x: ConicSection, y: ConicSection) -> Biconic {
        Biconic { x, y }
    }

    fn terms(&self, x_mm: f64, y_mm: f64) -> Option<Terms> {
        let [cx, cy] = [self.x.curvature_per_mm(), self.y.curvature_per_mm()];
        let a = (1.0 + self.x.conic()) * cx * cx;
        let b = (1.0 + self.y.conic()) * cy * cy;
        let square = 1.0 - (a * x_mm * x_mm + b * y_mm * y_mm);
        (square > 0.0).then(|| {
            let root = square.sqrt();
            let z = (cx * x_mm * x_mm + cy * y_mm * y_mm) / (1.0 + root);
            Terms { a, b, root, z }
        })
    }
}

/// a = (1+κx)·cx², b = (1+κy)·cy², the root s of 1 − a·x² − b·y², and the height z.
struct Terms {
    a: f64,
    b: f64,
    root: f64,
    z: f64,
}

impl Shape for Biconic {
    fn kind(&self) -> &'static str {
        KIND
    }

    /// From z·(1+s) = cx·x² + cy·y², differentiated twice, with s·s_x = −a·x and s·s_y = −b·y.
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let Terms { a, b, root: s, z } = self.terms(x_mm, y_mm)?;
        let [cx, cy] = [self.x.curvature_per_mm(), self.y.curvature_per_mm()];
        let [s_x, s_y] = [-a * x_mm / s, -b * y_mm / s];
        let [s_xx, s_xy, s_yy] = [-(a + s_x * s_x) / s, -s_x * s_y / s, -(b + s_y * s_y) / s];
        let one = 1.0 + s;
        let z_x = (2.0 * cx * x_mm - z * s_x) / one;
        let z_y = (2.0 * cy * y_mm - z * s_y) / one;
        defined(Jet {
            z_mm: z,
            gradient: [z_x, z_y],
            hessian_per_mm: [
                (2.0 * (cx - z_x * s_x) - z * s_xx) / one,
                -(z_x * s_y + z_y * s_x + z * s_xy) / one,
                (2.0 * (cy - z_y * s_y) - z * s_yy) / one,
            ],
        })
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.terms(x_mm, y_mm).and_then(|terms| number(terms.z))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = self.x.parameters(NAMES_X);
        parameters.extend(self.y.parameters(NAMES_Y));
        parameters
    }

    /// ∂z/∂c = (x² − z·∂s/∂c)/(1+s) and ∂z/∂κ = −z·∂s/∂κ/(1+s), for either direction.
    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let Terms { root: s, z, .. } = self.terms(x_mm, y_mm)?;
        let one = 1.0 + s;
        let by = |section: &ConicSection, t: f64| {
            let c = section.curvature_per_mm();
            let by_c = (t + z * (1.0 + section.conic()) * c * t / s) / one;
            [-c * c * by_c, z * c * c * t / (2.0 * s * one)]
        };
        let (x, y) = derivatives.split_at_mut(self.x.count());
        let pairs = [(x, by(&self.x, x_mm * x_mm)), (y, by(&self.y, y_mm * y_mm))];
        for (places, values) in pairs {
            places.iter_mut().zip(values).for_each(|(place, value)| *place = value);
        }
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(KIND, values, self.x.count() + self.y.count())?;
        let (x, y) = values.split_at(self.x.count());
        Ok(Arc::new(Biconic {
            x: self.x.with_values(KIND, NAMES_X, x)?,
            y: self.y.with_values(KIND, NAMES_Y, y)?,
        }))
    }

    /// The ellipse a·x² + b·y² = 1 comes nearest at the end of its shorter axis.
    fn domain_mm(&self) -> f64 {
        self.x.domain_mm().min(self.y.domain_mm())
    }
}

const KIND: &str = "biconic";
const NAMES_X: [&str; 2] = ["radius_x", "conic_x"];
const NAMES_Y: [&str; 2] = ["radius_y", "conic_y"];

//! A surface that is a series of functions: coefficients times a basis.

use std::fmt;
use std::sync::Arc;

use super::{Jet, Shape, ShapeError, ShapeParameter};
use crate::basis::{Basis, Scale};

/// `z = Σ c_j·f_j(x/X, y/Y)` with coefficients in mm, without a base surface.
///
/// Its parameters are the coefficients, by the names of the basis.
#[derive(Clone, Debug)]
pub struct Series<B> {
    basis: Arc<B>,
    scale: Scale,
    coefficients_mm: Vec<f64>,
}

impl<B: Basis + 'static> Series<B> {
    /// The series of the coefficients, one a term of the basis, over half widths or a radius.
    pub fn new(basis: B, scale: Scale, coefficients_mm: &[f64]) -> Result<Series<B>, ShapeError> {
        Series::of(Arc::new(basis), scale, coefficients_mm)
    }

    fn of(basis: Arc<B>, scale: Scale, coefficients_mm: &[f64]) -> Result<Series<B>, ShapeError> {
        let (kind, expected) = (basis.kind(), basis.terms());
        if coefficients_mm.len() != expected {
            return Err(ShapeError::Count { kind, found: coefficients_mm.len(), expected });
        }
        if let Some(term) = coefficients_mm.iter().position(|value| !value.is_finite()) {
            return Err(ShapeError::Value {
                kind,
                parameter: basis.name(term),
                found: coefficients_mm[term],
                expected: "a finite number",
            });
        }
        Ok(Series { basis, scale, coefficients_mm: coefficients_mm.to_vec() })
    }

    /// The basis.
    pub fn basis(&self) -> &B {
        &self.basis
    }

    /// The half widths or the radius by which places are normalised.
    pub fn scale(&self) -> Scale {
        self.scale
    }

    /// The coefficients in mm, in the order of the terms.
    pub fn coefficients_mm(&self) -> &[f64] {
        &self.coefficients_mm
    }

    /// The normalised place, if the basis is defined there.
    fn place(&self, x_mm: f64, y_mm: f64) -> Option<[f64; 2]> {
        let [u, v] = self.scale.normalised(x_mm, y_mm);
        self.basis.contains(u, v).then_some([u, v])
    }
}

impl<B: Basis + fmt::Debug + 'static> Shape for Series<B> {
    fn kind(&self) -> &'static str {
        self.basis.kind()
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let [u, v] = self.place(x_mm, y_mm)?;
        let mut jet = Jet::default();
        self.basis.each_jet(u, v, &mut |term, normalised| {
            let coefficient = self.coefficients_mm[term];
            jet.z_mm += coefficient * normalised.value;
            for (sum, slope) in jet.gradient.iter_mut().zip(normalised.gradient) {
                *sum += coefficient * slope;
            }
            for (sum, bend) in jet.hessian_per_mm.iter_mut().zip(normalised.hessian) {
                *sum += coefficient * bend;
            }
        });
        let (across, along) = (self.scale.half_x_mm(), self.scale.half_y_mm());
        jet.gradient = [jet.gradient[0] / across, jet.gradient[1] / along];
        let [xx, xy, yy] = jet.hessian_per_mm;
        jet.hessian_per_mm = [xx / (across * across), xy / (across * along), yy / (along * along)];
        jet.z_mm.is_finite().then_some(jet)
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let [u, v] = self.place(x_mm, y_mm)?;
        let mut z_mm = 0.0;
        self.basis.each_value(u, v, &mut |term, value| z_mm += self.coefficients_mm[term] * value);
        z_mm.is_finite().then_some(z_mm)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let coefficients = self.coefficients_mm.iter().enumerate();
        let parameter = |(term, &value)| ShapeParameter {
            name: self.basis.name(term),
            unit: "mm".to_owned(),
            value,
        };
        coefficients.map(parameter).collect()
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let [u, v] = self.place(x_mm, y_mm)?;
        self.basis.each_value(u, v, &mut |term, value| derivatives[term] = value);
        derivatives.iter().all(|derivative| derivative.is_finite()).then_some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        Ok(Arc::new(Series::of(Arc::clone(&self.basis), self.scale, values)?))
    }

    fn domain_mm(&self) -> f64 {
        self.basis.reach() * self.scale.half_x_mm().min(self.scale.half_y_mm())
    }
}

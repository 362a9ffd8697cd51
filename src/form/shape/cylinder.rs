//! Cylinders and acylinders with their axis along y.

use std::sync::Arc;

use super::argument::count;
use super::even_powers::EvenPowers;
use super::section::{ConicSection, NAMES};
use super::taylor::{defined, number};
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// A surface that does not change along y: `z = conic(x) + Σ A_n·x^n`, n even from 2 on
/// (ISO 10110-12:2019, non-circular cylinder).
///
/// A cylinder that does not change along x is [`super::Toroid::unrotated`].
#[derive(Clone, Debug, PartialEq)]
pub struct Cylinder {
    circular: bool,
    section: ConicSection,
    powers: EvenPowers,
}

impl Cylinder {
    /// A circular cylinder of the radius in mm, positive where the axis lies on the +z side; half of it,
    /// on the vertex side of the axis. Its only parameter is `radius`. Fails on a radius that is 0 or not
    /// finite.
    pub fn new(radius_mm: f64) -> Result<Cylinder, ShapeError> {
        let section = ConicSection::checked(CYLINDER, NAMES, radius_mm, 0.0)?;
        Ok(Cylinder { circular: true, section, powers: EvenPowers::new(CYLINDER, &[])? })
    }

    /// An acylinder from its section and the terms (order, coefficient in mm^(1−order)). Parameters
    /// `radius` and `conic`, unless flat, and `A2`, `A4` … of the terms given. Fails on an order that is
    /// odd, 0 or given twice, and on a coefficient that is not finite.
    pub fn acylinder(section: ConicSection, terms: &[(u8, f64)]) -> Result<Cylinder, ShapeError> {
        Ok(Cylinder { circular: false, section, powers: EvenPowers::new(ACYLINDER, terms)? })
    }

    fn of_section(&self) -> usize {
        if self.circular { 1 } else { self.section.count() }
    }
}

impl Shape for Cylinder {
    fn kind(&self) -> &'static str {
        if self.circular { CYLINDER } else { ACYLINDER }
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        let t = x_mm * x_mm;
        let z = self.section.at(t)?.plus(self.powers.at(t)).of_square(x_mm);
        y_mm.is_finite().then_some(())?;
        defined(Jet {
            z_mm: z.value,
            gradient: [z.first, 0.0],
            hessian_per_mm: [z.second, 0.0, 0.0],
        })
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        let t = x_mm * x_mm;
        y_mm.is_finite().then_some(())?;
        number(self.section.sag_mm(t)? + self.powers.value(t))
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = self.section.parameters(NAMES);
        parameters.truncate(self.of_section());
        parameters.extend(self.powers.parameters());
        parameters
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let t = x_mm * x_mm;
        y_mm.is_finite().then_some(())?;
        let (section, powers) = derivatives.split_at_mut(self.of_section());
        self.section.write_derivatives(t, section)?;
        self.powers.write_derivatives(t, powers);
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(self.kind(), values, self.of_section() + self.powers.count())?;
        if let (true, &[radius_mm]) = (self.circular, values) {
            return Ok(Arc::new(Cylinder::new(radius_mm)?));
        }
        let (section, powers) = values.split_at(self.of_section());
        Ok(Arc::new(Cylinder {
            circular: false,
            section: self.section.with_values(ACYLINDER, NAMES, section)?,
            powers: self.powers.with_values(ACYLINDER, powers)?,
        }))
    }

    fn domain_mm(&self) -> f64 {
        self.section.domain_mm()
    }
}

const CYLINDER: &str = "cylinder";
const ACYLINDER: &str = "acylinder";

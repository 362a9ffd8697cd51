//! Plane, sphere and conic of revolution.

use std::sync::Arc;

use super::argument::count;
use super::section::{ConicSection, NAMES};
use super::taylor::number;
use super::{Jet, Shape, ShapeError, ShapeParameter};

/// A plane, a sphere or a conic of revolution about z, the vertex at the origin.
///
/// Of a sphere, and of every conic with κ > −1, it is the half on the vertex side of the equator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conic {
    figure: Figure,
    section: ConicSection,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Figure {
    Plane,
    Sphere,
    Conic,
}

impl Conic {
    /// The conic whose meridian is the section; a plane if that is flat. Parameters `radius` and `conic`,
    /// or none.
    pub fn new(section: ConicSection) -> Conic {
        let figure = if section.is_flat() { Figure::Plane } else { Figure::Conic };
        Conic { figure, section }
    }

    /// The plane z = 0, without parameters.
    pub fn plane() -> Conic {
        Conic::new(ConicSection::FLAT)
    }

    /// A sphere of the radius of curvature in mm, positive where the centre lies on the +z side. Its only
    /// parameter is `radius`. Fails on a radius that is 0 or not finite.
    pub fn sphere(radius_mm: f64) -> Result<Conic, ShapeError> {
        let section = ConicSection::checked("sphere", NAMES, radius_mm, 0.0)?;
        Ok(Conic { figure: Figure::Sphere, section })
    }

    fn count(&self) -> usize {
        match self.figure {
            Figure::Plane => 0,
            Figure::Sphere => 1,
            Figure::Conic => 2,
        }
    }
}

impl Shape for Conic {
    fn kind(&self) -> &'static str {
        match self.figure {
            Figure::Plane => "plane",
            Figure::Sphere => "sphere",
            Figure::Conic => "conic",
        }
    }

    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet> {
        self.section.at(x_mm * x_mm + y_mm * y_mm)?.revolved(x_mm, y_mm)
    }

    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.section.sag_mm(x_mm * x_mm + y_mm * y_mm).and_then(number)
    }

    fn parameters(&self) -> Vec<ShapeParameter> {
        let mut parameters = self.section.parameters(NAMES);
        parameters.truncate(self.count());
        parameters
    }

    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()> {
        let both = self.section.by_shape(x_mm * x_mm + y_mm * y_mm)?;
        derivatives.iter_mut().zip(both).for_each(|(derivative, value)| *derivative = value);
        Some(())
    }

    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError> {
        count(self.kind(), values, self.count())?;
        let radius_mm = values.first().copied().unwrap_or(f64::INFINITY);
        let conic = values.get(1).copied().unwrap_or(0.0);
        let section = match self.figure {
            Figure::Plane => self.section,
            _ => ConicSection::checked(self.kind(), NAMES, radius_mm, conic)?,
        };
        Ok(Arc::new(Conic { figure: self.figure, section }))
    }

    fn domain_mm(&self) -> f64 {
        self.section.domain_mm()
    }
}

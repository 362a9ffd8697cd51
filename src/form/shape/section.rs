//! The conic section through the vertex, on which most shapes are built.

use super::argument::{finite, parameter, radius};
use super::taylor::Taylor;
use super::{ShapeError, ShapeParameter};

/// A conic section `z = c·s²/(1 + √(1 − (1+κ)·c²·s²))` through its vertex, c = 1/R, s the distance from the
/// axis (ISO 10110-12:2019, the first term of its aspheres).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConicSection {
    radius_mm: f64,
    curvature_per_mm: f64,
    conic: f64,
}

impl ConicSection {
    /// The straight line z = 0. As a base it adds no parameters.
    pub const FLAT: ConicSection =
        ConicSection { radius_mm: f64::INFINITY, curvature_per_mm: 0.0, conic: 0.0 };

    /// From the radius of curvature at the vertex in mm, positive where the centre lies on the +z side,
    /// and the conic constant κ: 0 circle, −1 parabola. Fails on a radius that is 0 or not finite, and on
    /// a conic constant that is not finite.
    pub fn new(radius_mm: f64, conic: f64) -> Result<ConicSection, ShapeError> {
        ConicSection::checked("conic section", NAMES, radius_mm, conic)
    }

    /// Radius of curvature at the vertex in mm; infinite if flat.
    pub fn radius_mm(&self) -> f64 {
        self.radius_mm
    }

    /// Conic constant; 0 if flat.
    pub fn conic(&self) -> f64 {
        self.conic
    }

    /// Whether it is [`ConicSection::FLAT`].
    pub fn is_flat(&self) -> bool {
        self.curvature_per_mm == 0.0
    }

    pub(super) fn checked(
        kind: &'static str,
        names: [&str; 2],
        radius_mm: f64,
        conic: f64,
    ) -> Result<ConicSection, ShapeError> {
        let radius_mm = radius(kind, names[0], radius_mm)?;
        let conic = finite(kind, names[1], conic)?;
        Ok(ConicSection { radius_mm, curvature_per_mm: radius_mm.recip(), conic })
    }

    pub(super) fn curvature_per_mm(&self) -> f64 {
        self.curvature_per_mm
    }

    /// Distance from the axis in mm at which the root ends; infinite for κ ≤ −1.
    pub(super) fn domain_mm(&self) -> f64 {
        let shape = 1.0 + self.conic;
        if shape > 0.0 && !self.is_flat() {
            self.radius_mm.abs() / shape.sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// φ = √(1 − (1+κ)·c²·t) at t = s²; `None` from the end of the domain on, where the slope is infinite.
    pub(super) fn root(&self, t: f64) -> Option<f64> {
        let c = self.curvature_per_mm;
        let square = 1.0 - (1.0 + self.conic) * (c * c * t);
        (square > 0.0).then(|| square.sqrt())
    }

    pub(super) fn sag_mm(&self, t: f64) -> Option<f64> {
        self.root(t).map(|phi| self.curvature_per_mm * t / (1.0 + phi))
    }

    /// z = c·t/(1+φ), dz/dt = c/(2φ) and d²z/dt² = (1+κ)·c³/(4φ³).
    pub(super) fn at(&self, t: f64) -> Option<Taylor> {
        let c = self.curvature_per_mm;
        let phi = self.root(t)?;
        Some(Taylor {
            value: c * t / (1.0 + phi),
            first: c / (2.0 * phi),
            second: (1.0 + self.conic) * c * c * c / (4.0 * phi * phi * phi),
        })
    }

    /// ∂z/∂R = −c²·t/(φ·(1+φ)) and ∂z/∂κ = c³·t²/(2φ·(1+φ)²).
    ///
    /// The first comes from ∂z/∂c = t/(1+φ) + (1+κ)·c²·t²/(φ·(1+φ)²) with (1+κ)·c²·t = 1 − φ² put in.
    pub(super) fn by_shape(&self, t: f64) -> Option<[f64; 2]> {
        let c = self.curvature_per_mm;
        let phi = self.root(t)?;
        let w = c * c * t;
        let one = 1.0 + phi;
        Some([-w / (phi * one), c * t * w / (2.0 * phi * one * one)])
    }

    /// How many parameters it adds to a shape: radius and conic, none if flat.
    pub(super) fn count(&self) -> usize {
        if self.is_flat() { 0 } else { 2 }
    }

    pub(super) fn parameters(&self, names: [&str; 2]) -> Vec<ShapeParameter> {
        let both =
            [parameter(names[0], "mm", self.radius_mm), parameter(names[1], "1", self.conic)];
        both.into_iter().take(self.count()).collect()
    }

    /// The section with [`ConicSection::count`] other values.
    pub(super) fn with_values(
        &self,
        kind: &'static str,
        names: [&str; 2],
        values: &[f64],
    ) -> Result<ConicSection, ShapeError> {
        match values {
            [radius_mm, conic] => ConicSection::checked(kind, names, *radius_mm, *conic),
            _ => Ok(*self),
        }
    }

    /// Writes the derivatives by the parameters at t into the first [`ConicSection::count`] places.
    pub(super) fn write_derivatives(&self, t: f64, derivatives: &mut [f64]) -> Option<()> {
        let both = self.by_shape(t)?;
        derivatives.iter_mut().zip(both).take(self.count()).for_each(|(d, value)| *d = value);
        Some(())
    }
}

/// Names of the parameters of the only section of a shape.
pub(super) const NAMES: [&str; 2] = ["radius", "conic"];

//! Polynomial bases: what form deviations are spelled in, and freeforms made of.
//!
//! A [`Basis`] is a sequence of functions of a *normalised place* (u, v): x and y over the half widths of a
//! [`Scale`]. [`Zernike`] and [`Q2d`] live on the unit disc, [`Product`] on the square or everywhere.
//! [`expand`] finds the coefficients of scattered values; [`Series`](crate::shape::Series) makes a surface of
//! coefficients.

mod disc;
mod expand;
mod gram;
mod indices;
mod moments;
mod normal;
mod passes;
mod product;
mod q2d;
mod recurrence;
mod terms;
mod zernike;

use std::fmt;

use thiserror::Error;

pub use disc::Disc;
pub use expand::{ExpandError, Expansion, LargestResidual, expand, residuals};
pub use indices::{Counting, LARGEST_INDEX, aberration};
pub use product::{Product, ProductError};
pub use q2d::{Q2d, Q2dError};
pub use zernike::{LARGEST_ORDER, Normalisation, Zernike, ZernikeError, zernike_value};

/// Functions f_0 to f_{N−1} of a normalised place (u, v).
///
/// All terms are found in one pass by recurrences, in `O(terms)`. Implementations are smooth to rounding
/// everywhere in their domain, the centre included.
pub trait Basis: fmt::Debug + Send + Sync {
    /// Name in reports: `Fringe Zernike series`.
    fn kind(&self) -> &'static str;

    /// Number of terms.
    fn terms(&self) -> usize;

    /// Name of a term below [`Basis::terms`], unique within the basis: `Z5`, `Z(4,-2)`, `T2,3`, `X2Y1`.
    fn name(&self, term: usize) -> String;

    /// Whether the basis is defined at a place. Never at one that is not finite.
    fn contains(&self, u: f64, v: f64) -> bool;

    /// Largest distance √(u² + v²) within which every place is in the domain; infinite if all are.
    fn reach(&self) -> f64;

    /// Shows the value of every term at a place, each once, in no stated order, to `visit`.
    ///
    /// Beyond the domain the values are those of the polynomials, or not finite.
    fn each_value(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, f64));

    /// As [`Basis::each_value`], with gradient and Hessian.
    fn each_jet(&self, u: f64, v: f64, visit: &mut dyn FnMut(usize, NormalisedJet));

    /// Writes the values of every term, one row a term, at a block of places. `rows` has
    /// [`Basis::terms`] entries.
    fn block(&self, u: &[f64; LANES], v: &[f64; LANES], rows: &mut [[f64; LANES]]);

    /// The basis as functions of the disc, if it is one: [`expand`] is then several times faster.
    fn on_disc(&self) -> Option<&Disc> {
        None
    }
}

/// Value and derivatives of a term with respect to the normalised place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct NormalisedJet {
    /// The value.
    pub value: f64,
    /// ∂/∂u and ∂/∂v.
    pub gradient: [f64; 2],
    /// ∂²/∂u², ∂²/∂u∂v and ∂²/∂v².
    pub hessian: [f64; 3],
}

/// Places of a block: 64 rows of 37 terms are 19 kB, which a first-level cache holds.
pub const LANES: usize = 64;

/// From mm to normalised places: half widths about the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    half_x_mm: f64,
    half_y_mm: f64,
}

/// A half width or radius that is not a positive finite number.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
#[error("normalisation {name} is {value_mm} mm, expected a positive number")]
pub struct ScaleError {
    /// Which: `radius`, `half width along x`, `half width along y`.
    pub name: &'static str,
    /// Its value in mm.
    pub value_mm: f64,
}

impl Scale {
    /// Normalises by a radius.
    pub fn round(radius_mm: f64) -> Result<Scale, ScaleError> {
        positive("radius", radius_mm)?;
        Ok(Scale { half_x_mm: radius_mm, half_y_mm: radius_mm })
    }

    /// Normalises x and y by half the sides of a rectangle. A basis of the disc then lives on an ellipse.
    pub fn rectangle(half_x_mm: f64, half_y_mm: f64) -> Result<Scale, ScaleError> {
        positive("half width along x", half_x_mm)?;
        positive("half width along y", half_y_mm)?;
        Ok(Scale { half_x_mm, half_y_mm })
    }

    /// Half width along x, or the radius, in mm.
    pub fn half_x_mm(&self) -> f64 {
        self.half_x_mm
    }

    /// Half width along y, or the radius, in mm.
    pub fn half_y_mm(&self) -> f64 {
        self.half_y_mm
    }

    /// The normalised place.
    pub fn normalised(&self, x_mm: f64, y_mm: f64) -> [f64; 2] {
        [x_mm / self.half_x_mm, y_mm / self.half_y_mm]
    }
}

fn positive(name: &'static str, value_mm: f64) -> Result<(), ScaleError> {
    if value_mm.is_finite() && value_mm > 0.0 { Ok(()) } else { Err(ScaleError { name, value_mm }) }
}

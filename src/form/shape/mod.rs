//! What every nominal shape can say of itself: height, slopes, bend, and how its parameters move it.
//!
//! A shape is the graph z(x, y) of the part frame: vertex (or centre of the mirror) at the origin, +z the
//! side on which a positive deviation lies.
//!
//! | surface | shape | Zemax, whose file gives its numbers |
//! | --- | --- | --- |
//! | plane, sphere, conic | [`Conic`] | STANDARD |
//! | asphere in powers of r | [`EvenAsphere`], [`OddAsphere`] | EVENASPH, ODDASPHE |
//! | asphere in Forbes' polynomials | [`QAsphere`] | QED_TYPE |
//! | cylinder, acylinder | [`Cylinder`] along y, [`Toroid::unrotated`] along x | TOROIDAL |
//! | toroid | [`Toroid`] | TOROIDAL |
//! | biconic | [`Biconic`] | BICONICX |
//! | X-ray mirror from p, q, θ | [`Mirror`] | |
//! | Zernike, Chebyshev, Legendre, XY, 2-D-Q departures | [`Series`] | FZERNSAG, SZERNSAG, CHEBYSHV, XPOLYNOM |
//! | a table of heights, a smooth fit to points | [`SagGrid`], [`SplineSurface`] | GRID_SAG |
//! | a base and what departs from it | [`Sum`] | |
//! | a piece away from the vertex | [`OffAxis`] | |

mod argument;
mod at_first_use;
mod biconic;
mod conic;
mod cylinder;
mod even_powers;
mod grid;
mod mirror;
mod off_axis;
mod power;
mod q;
mod q_basis;
mod raster;
mod section;
mod series;
mod spline;
mod sum;
mod taylor;
mod toroid;

use std::fmt;
use std::sync::Arc;

use thiserror::Error;

pub use biconic::Biconic;
pub use conic::Conic;
pub use cylinder::Cylinder;
pub use grid::{Nodes, SagGrid, SagGridError};
pub use mirror::Mirror;
pub use off_axis::OffAxis;
pub use power::{EvenAsphere, OddAsphere};
pub use q::{Projection, QAsphere};
pub use section::ConicSection;
pub use series::Series;
pub(crate) use spline::weights as spline_weights;
pub use spline::{Cells, LARGEST_SIDE, SplineError, SplineSurface};
pub use sum::Sum;
pub use toroid::Toroid;

/// Height, slopes and second derivatives of a shape at one place of the part frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jet {
    /// Height in mm.
    pub z_mm: f64,
    /// ∂z/∂x and ∂z/∂y.
    pub gradient: [f64; 2],
    /// ∂²z/∂x², ∂²z/∂x∂y and ∂²z/∂y² in 1/mm.
    pub hessian_per_mm: [f64; 3],
}

impl Jet {
    /// The mean of the principal curvatures and half their difference, 1/mm, positive where the surface bends towards +z.
    ///
    /// The curvatures of a graph are the eigenvalues of the second fundamental form `H/√(1+|∇z|²)` against the first,
    /// `1 + ∇z·∇zᵀ`: with mean M and Gaussian curvature G they are `M ± √(M² − G)`.
    pub(crate) fn mean_curvature(&self) -> [f64; 2] {
        let Jet { gradient: [p, q], hessian_per_mm: [r, s, t], .. } = *self;
        let w = 1.0 + p * p + q * q;
        let mean = ((1.0 + q * q) * r - 2.0 * p * q * s + (1.0 + p * p) * t) / (2.0 * w * w.sqrt());
        let gaussian = (r * t - s * s) / (w * w);
        [mean, (mean * mean - gaussian).max(0.0).sqrt()]
    }
}

/// A parameter of a shape, with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeParameter {
    /// Its name, unique within the shape: `radius`, `conic`, `A4`, `Z5`, `C2,3`.
    pub name: String,
    /// Its unit: `mm`, `rad`, `1`, `mm^-3`.
    pub unit: String,
    /// Its value in that unit.
    pub value: f64,
}

impl ShapeParameter {
    /// Whether it is a radius of curvature, of either sign: by its name `radius`, `radius_x`, `radius_y` or
    /// `rotation_radius`. A fit steps it in its curvature.
    pub fn is_radius(&self) -> bool {
        // Parts of a sum have their number before the name.
        let name = self.name.rsplit('.').next().unwrap_or_default();
        matches!(name, "radius" | "radius_x" | "radius_y" | "rotation_radius")
    }
}

/// A nominal surface as a graph over the x-y plane of the part frame.
///
/// Implementations are exact to rounding, everywhere in their domain, the vertex included: no
/// difference quotient, no `0/0` at r = 0.
pub trait Shape: fmt::Debug + Send + Sync {
    /// Name in reports: `toroid`, `Q-bfs asphere`.
    fn kind(&self) -> &'static str;

    /// Height and derivatives at a place in mm; `None` beyond the domain and for places that are not finite.
    fn jet(&self, x_mm: f64, y_mm: f64) -> Option<Jet>;

    /// Height at a place in mm. The same as that of [`Shape::jet`], to rounding, at less cost.
    fn sag_mm(&self, x_mm: f64, y_mm: f64) -> Option<f64> {
        self.jet(x_mm, y_mm).map(|jet| jet.z_mm)
    }

    /// The parameters in an order of their own that never changes for a given shape.
    fn parameters(&self) -> Vec<ShapeParameter>;

    /// Writes ∂z/∂parameter at a place, one entry a parameter, in mm over the parameter's unit. `None`, with
    /// the entries left in any state, where there is no [`Shape::jet`].
    fn by_parameters(&self, x_mm: f64, y_mm: f64, derivatives: &mut [f64]) -> Option<()>;

    /// This shape with other values of its parameters, in the order of [`Shape::parameters`].
    fn with_parameters(&self, values: &[f64]) -> Result<Arc<dyn Shape>, ShapeError>;

    /// Distance from the origin within which every place has a height, in mm; infinite if all have.
    fn domain_mm(&self) -> f64;

    /// A place on the axis of the parent and its direction, where this is a piece of another shape; its own frame, mm.
    fn parent_axis_mm(&self) -> Option<[[f64; 3]; 2]> {
        None
    }
}

/// Why numbers make no shape.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ShapeError {
    /// A value that the parameter cannot have.
    #[error("{parameter} of the {kind} is {}, expected {expected}", shown(*found))]
    Value {
        /// The kind of shape.
        kind: &'static str,
        /// The parameter.
        parameter: String,
        /// The value.
        found: f64,
        /// Range of its values.
        expected: &'static str,
    },
    /// A wrong number of values.
    #[error("{found} values for the {expected} parameters of the {kind}")]
    Count {
        /// The kind of shape.
        kind: &'static str,
        /// Values given.
        found: usize,
        /// Parameters there are.
        expected: usize,
    },
}

/// A number as an error shows it: none of hundreds of digits.
fn shown(value: f64) -> String {
    let size = value.abs();
    let is_short = !value.is_finite() || size == 0.0 || (1e-6..1e15).contains(&size);
    if is_short { value.to_string() } else { format!("{value:e}") }
}

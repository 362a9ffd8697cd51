//! Nominal surfaces, orthogonal least-squares fits, and the form deviation.
//!
//! The way through the crate: a [`Nominal`] says what the part should be, of revolution or any [`shape`];
//! [`fit`] lays it into the measured points and gives a [`Pose`] and, if wanted, the shape parameters, by
//! least squares, with uncertainties ([`fit_weighted`]) or with a robust [`Loss`]; [`minimum_zone`] does the
//! same for the narrowest zone. [`deviations`] and [`Figures`] say what remains. [`Live`] gives the same figures, provisional,
//! while points still arrive. Where no design is known, [`reference()`] makes one from the points, and
//! [`LiveReference`] keeps one up while they arrive. [`artefact`] makes data whose fit is known exactly.
//!
//! Figures by the standards are the crate `asphera-figures`; how sure all of it is, and limits, are
//! `asphera-uncertainty`. They build on [`linear`], the linear problem under a fit.
//!
//! Lengths are millimetres and angles radians. Two frames occur: the *part frame*, in which the nominal
//! has its vertex at the origin and its axis along +z, and the *measured frame*, in which the points are.
//! A deviation is measured minus nominal along the normal of the nominal, positive on the +z side.
//!
//! Deliberately absent: input and output, clocks, logging.
//! Sums run over fixed chunks that are joined in order, so results do not depend on the thread count.

mod aperture;
pub mod artefact;
pub mod basis;
mod contact;
mod deviation;
mod fit;
pub mod form_error;
pub mod linear;
mod live;
mod middle;
mod minimum_zone;
mod nominal;
mod pose;
pub mod shape;
mod spline_fit;
mod taylor;

pub use aperture::{Aperture, ApertureError};
pub use contact::{Touch, Touched, Untouched};
pub use deviation::{Figures, NM_PER_MM, deviations};
pub use fit::{
    Caution, Combination, Covariance, Estimate, Excluded, Fit, FitError, FitSettings, Freedoms,
    HIGHEST_MM, Loss, METHOD, MeasuredFrom, Residuals, Robust, Termination, Undetermined, Units,
    along_normal_mm, fit, fit_weighted, suspected_units,
};
pub use live::{Accumulator, Grid, Live, LiveError, LiveEstimate, LiveSettings, LiveWeights, Map};
pub use middle::middle_mm;
pub use minimum_zone::{
    Certificate, Contact, Criterion, LinearZone, Side, ZoneFit, ZoneSettings, ZoneTermination,
    minimum_zone,
};
pub use nominal::{Asphere, Curvatures, Foot, Nominal, NominalError, Parameter, ParameterError};
pub use pose::{Motion, Pose};
pub use spline_fit::{
    Base, Knots, LiveReference, Reference, ReferenceError, ReferenceSettings, Smoothing, SplineFit,
    SplineFitError, fit_spline, provisional, reference,
};

/// A point as x, y, z in mm.
pub type PointMm = [f64; 3];

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;

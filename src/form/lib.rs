//! Nominal surfaces, orthogonal least-squares fits, and the form deviation.
//!
//! The way through the crate: a [`Nominal`] says what the part should be; [`fit`] lays it into the
//! measured points and gives a [`Pose`] and, if wanted, the shape parameters; [`deviations`] and
//! [`Figures`] say what remains; [`verdict`] holds that against a [`Tolerance`]. [`Live`] gives the same
//! figures, provisional, while points still arrive. [`artefact`] makes data whose fit is known exactly.
//!
//! [`figures`] are those of form by the optical standards, [`texture`] filters a deviation and gives its areal
//! parameters.
//!
//! Lengths are millimetres and angles radians. Two frames occur: the *part frame*, in which the nominal
//! has its vertex at the origin and its axis along +z, and the *measured frame*, in which the points are.
//! A deviation is measured minus nominal along the normal of the nominal, positive on the +z side.
//!
//! Deliberately absent: input and output, clocks, logging, weights, robust and minimum-zone criteria.
//! Sums run over fixed chunks that are joined in order, so results do not depend on the thread count.

mod aperture;
pub mod artefact;
mod deviation;
pub mod figures;
mod fit;
mod foot;
mod linearised;
mod live;
mod model;
mod nominal;
mod parameter;
mod pose;
mod refine;
mod selection;
pub mod shape;
mod solve;
mod start;
mod svd;
pub mod texture;
mod triangle;
mod verdict;
pub mod zernike;

pub use aperture::{Aperture, ApertureError};
pub use deviation::{Figures, deviations};
pub use fit::{Estimate, Fit, FitError, FitSettings, METHOD, fit};
pub use foot::Foot;
pub use live::{Grid, Live, LiveError, LiveEstimate, LiveSettings, Map};
pub use nominal::{Asphere, Curvatures, Nominal, NominalError};
pub use parameter::{Parameter, ParameterError};
pub use pose::Pose;
pub use refine::Termination;
pub use selection::Excluded;
pub use verdict::{Check, Reason, Status, Tolerance, Verdict, verdict};

/// A point as x, y, z in mm.
pub type PointMm = [f64; 3];

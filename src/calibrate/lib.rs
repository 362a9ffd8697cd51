//! Errors of a measuring machine, from artefacts of known shape.
//!
//! A machine has [`Parameter`]s: offsets and tilts of its probe, squareness and scales of its axes. [`calibrate`]
//! finds them from a sphere of known radius, or a flat, measured in one [`Pose`] or several. Where the poses differ
//! by turns or shifts, the form error of the artefact is found beside them: it turns with the artefact, the errors
//! of the machine do not (reversal). A [`Correction`] takes the errors out of later points. [`AxisErrors`] are those of one
//! axis along its travel, which a laser interferometer or an autocollimator finds.
//!
//! Lengths are mm, angles rad. All parameters are small: the correction is linear in them. The crate holds no input
//! or output and reads no clock; results do not depend on the thread count.

#![forbid(unsafe_code)]

mod artefact;
mod axis_errors;
mod check;
mod columns;
mod correction;
mod correlation;
mod error;
mod fit;
mod map;
mod parameter;
mod result;
mod rows;
mod start;

pub use artefact::{Artefact, Pose, Settings};
pub use axis_errors::{AxisErrors, AxisErrorsError};
pub use correction::{Axes, Correction};
pub use error::CalibrateError;
pub use fit::calibrate;
pub use map::HeightMap;
pub use parameter::{Machine, Parameter, Quantity};
pub use result::{Calibration, Estimate, Term};

/// The example of the README.
#[cfg(doctest)]
#[doc = include_str!("README.md")]
struct Readme;

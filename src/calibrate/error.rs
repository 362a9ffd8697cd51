//! Reasons why nothing can be found.

use thiserror::Error;

use crate::artefact::HIGHEST_ORDER;
use crate::parameter::{Machine, Parameter};

/// Why there is no calibration.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum CalibrateError {
    /// There is no pose.
    #[error("no measurement of the artefact is given, expected at least one")]
    NoPose,
    /// A pose has too few points.
    #[error(
        "measurement {pose} has {points} points, expected more than the {unknowns} unknowns in all"
    )]
    TooFewPoints {
        /// Number of the pose, from 1.
        pose: usize,
        /// How many it has.
        points: usize,
        /// Unknowns of all poses.
        unknowns: usize,
    },
    /// A reading is not finite.
    #[error("point {point} of measurement {pose} is not finite")]
    NotFinite {
        /// Number of the pose, from 1.
        pose: usize,
        /// Number of the point, from 1.
        point: usize,
    },
    /// A turn or shift is not finite.
    #[error("turn or shift of measurement {pose} is not finite")]
    BadPose {
        /// Number of the pose, from 1.
        pose: usize,
    },
    /// Readings of another machine.
    #[error("point {point} of measurement {pose} is of another machine, expected {}", machine.word())]
    OtherMachine {
        /// Number of the pose, from 1.
        pose: usize,
        /// Number of the point, from 1.
        point: usize,
        /// Expected.
        machine: Machine,
    },
    /// A radius or its uncertainty is out of range.
    #[error(
        "radius {radius_mm} mm with u {u_radius_mm} mm, expected more than 0, and u from 0 to a tenth of it"
    )]
    BadRadius {
        /// The radius.
        radius_mm: f64,
        /// Its uncertainty.
        u_radius_mm: f64,
    },
    /// A parameter that the machine has not, or twice.
    #[error("parameter {} is not among those of a {} machine, or stands twice", parameter.word(), machine.word())]
    BadParameter {
        /// Which.
        parameter: Parameter,
        /// Of which machine.
        machine: Machine,
    },
    /// An order too high.
    #[error("order {order} of height or form errors, expected at most {HIGHEST_ORDER}")]
    BadOrder {
        /// The order.
        order: u32,
    },
    /// The form error cannot be told from the machine's errors.
    #[error(
        "the form of the artefact needs two measurements at least that differ by a turn or a shift: \
         in one place it cannot be told from errors of the machine"
    )]
    NoReversal,
    /// Points lie in one place or on a line.
    #[error("the points of measurement {pose} lie on a line or in one place, expected an area")]
    NoArea {
        /// Number of the pose, from 1.
        pose: usize,
    },
    /// The artefact is not what was said.
    #[error("{found}; is it the right artefact, and are lengths in mm?")]
    NotTheArtefact {
        /// What was found.
        found: String,
    },
    /// The fit ran on.
    #[error(
        "the fit did not come to rest in {iterations} steps; errors must be small against the artefact"
    )]
    NotConverged {
        /// Steps taken.
        iterations: u32,
    },
}

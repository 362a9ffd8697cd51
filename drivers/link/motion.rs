//! Orders to axes, and what becomes of them.

use crate::{Fault, FaultKind};

/// Order to a device that moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Move these axes, all from rest, as nearly at once as the device can start them.
    Move(Vec<AxisMove>),
    /// Find home with every axis of the device. It is [`MotionEvent::Arrived`] when each knows its place.
    Home,
    /// Run the program of the device from its first command. It is [`MotionEvent::Arrived`] when its last one is complete.
    Run,
    /// Halt every axis. It goes before everything that waits to be sent, and drops it.
    Halt,
}

/// Move of an axis to an absolute place.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisMove {
    /// Name of the axis: that of its channel.
    pub axis: String,
    /// Place in the unit of the channel: mm or rad.
    pub to: f64,
    /// Speed in that unit per s, above 0.
    pub speed: f64,
    /// Acceleration in that unit per s²; `None`: that which the device has.
    pub acceleration: Option<f64>,
}

/// Outcome of an order, as a driver reports it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MotionEvent {
    /// All axes that were sent stand, and the device reports no trouble.
    Arrived,
    /// All axes stand after [`Motion::Halt`].
    Halted,
    /// The move was not begun, or broke off. The driver has sent its halt where an axis may move.
    Failed(MotionFailure),
}

/// Failure of a move.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MotionFailure {
    /// Kind of it.
    pub kind: MotionTrouble,
    /// One sentence with values and cure, lower case, no full stop.
    pub detail: String,
}

/// Kinds of failure of a move.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MotionTrouble {
    /// The device, or its driver, did not accept the order.
    Refused,
    /// The axis does not know its place: it was not homed.
    Unreferenced,
    /// The axis ran into a limit.
    Limit,
    /// The axis did not follow its motor.
    Stalled,
    /// Someone else moved or stopped the axis.
    Interrupted,
    /// No answer within the time allowed.
    Unanswered,
    /// The device reports another fault of its own.
    Device,
}

impl MotionFailure {
    /// A failure with its sentence.
    pub fn new(kind: MotionTrouble, detail: impl Into<String>) -> MotionFailure {
        MotionFailure { kind, detail: detail.into() }
    }

    /// The failure of an order to a device without axes.
    pub fn without_axes() -> MotionFailure {
        let detail = "the driver of this device moves nothing: name a device with axes as Zaber's";
        MotionFailure::new(MotionTrouble::Refused, detail)
    }
}

impl From<&MotionFailure> for Fault {
    fn from(failure: &MotionFailure) -> Fault {
        let kind = match failure.kind {
            MotionTrouble::Refused | MotionTrouble::Unreferenced => FaultKind::Refused,
            MotionTrouble::Unanswered => FaultKind::Timeout,
            MotionTrouble::Limit
            | MotionTrouble::Stalled
            | MotionTrouble::Interrupted
            | MotionTrouble::Device => FaultKind::Device,
        };
        Fault { kind, detail: failure.detail.clone() }
    }
}

//! A scanner as the core knows it: someone arms it, and it gives orders.

use std::fmt::Debug;

use asphera_link::{Motion, MotionEvent, MotionFailure, Nanos, Reading};
use asphera_report::ScanFigures;

use super::ScanDecision;
use crate::station::kinematics::Point;

/// Order to a device.
#[derive(Clone, Debug, PartialEq)]
pub struct Order {
    /// (line, device on that line).
    pub device: (usize, usize),
    /// What it shall do.
    pub motion: Motion,
}

/// Why a scanner cannot be armed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ArmError {
    /// There is nothing to arm.
    #[error(
        "the configuration has no [scan.plan] and no device with a program: something else drives the scan"
    )]
    NoPlan,
    /// It is armed.
    #[error("the scan is armed already")]
    Armed,
    /// The scan is over.
    #[error("the scan is over: start a session for another one")]
    Ended,
    /// The program broke off. Its points would be measured twice.
    #[error("the program broke off: start a session for another run")]
    BrokenOff,
}

/// Scanner of a station: the one place that orders moves.
pub trait Scanner: Debug + Send {
    /// From now on it moves, as soon as the devices are ready. A plan that was halted goes on with the piece it was on.
    ///
    /// # Errors
    ///
    /// When it is armed already, the scan is over, or it cannot go on.
    fn arm(&mut self, now: Nanos) -> Result<(), ArmError>;

    /// Someone stops it: everything is halted, whatever the state.
    fn stop(&mut self, now: Nanos);

    /// The session ends: an armed scan is halted.
    fn session_ends(&mut self, now: Nanos);

    /// Takes what was decided after a pass. Nothing happens where nothing is to be decided any more.
    fn decide(&mut self, _now: Nanos, _decision: &ScanDecision) {}

    /// Whether someone is to decide what follows.
    fn wants_decision(&self) -> bool {
        false
    }

    /// Whether a fail that is certain ends the scan, as long as it goes on.
    fn ends_on_certain_fail(&self) -> bool {
        false
    }

    /// Whether silence of the devices is no end of the scan: they measure when they are ordered to.
    fn keeps_session(&self) -> bool {
        false
    }

    /// Where the probe stands, (x, y) in mm; `None` before the axes answered.
    fn place_mm(&self) -> Option<[f64; 2]> {
        None
    }

    /// Time since the first move in s.
    fn spent_s(&self, now: Nanos) -> f64;

    /// Whether the scan is over.
    fn is_ended(&self) -> bool;

    /// A device gave a reading.
    fn reading(&mut self, _now: Nanos, _stream: usize, _reading: &Reading) {}

    /// A link was lost, or a device on it is not to be trusted any more.
    fn interrupted(&mut self, now: Nanos, line: usize, name: &str);

    /// A link opened. A machine that ran on after the loss of its link is halted first of all.
    fn opened(&mut self, line: usize);

    /// A driver says what became of an order.
    fn motion(&mut self, now: Nanos, event: &MotionEvent);

    /// An order was not begun, or broke off.
    fn failed(&mut self, now: Nanos, failure: &MotionFailure);

    /// Goes on where it waits for the devices.
    fn advance(&mut self, now: Nanos, is_ready: bool);

    /// Does what is due.
    fn timeout(&mut self, now: Nanos);

    /// When [`Scanner::timeout`] is to be called, if at all.
    fn poll_timeout(&self) -> Option<Nanos>;

    /// The next order.
    fn poll_order(&mut self) -> Option<Order>;

    /// Flags a point that is not one of the scan.
    fn judge(&mut self, point: &mut Point);

    /// State for people.
    fn figures(&self, now: Nanos) -> ScanFigures;

    /// A halt could not be sent: it is sent when the link opens.
    fn unhalted(&mut self, device: (usize, usize));
}

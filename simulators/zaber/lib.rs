//! A simulated Zaber stage that obeys moves of the ASCII protocol.
//!
//! [`Stage`] is the device without a link: commands in, replies out, time as an argument. Its axes run trapezoids within their travel.
//! [`SharedStage`] is a stage that several connections and a gauge share; [`SharedStage::serve`] answers one connection. Commands are read
//! by code of its own, not by the driver's.

#![forbid(unsafe_code)]

mod axis;
mod serve;
mod stage;

pub use axis::AxisSettings;
pub use serve::{Received, SharedStage};
pub use stage::{Fault, Stage};

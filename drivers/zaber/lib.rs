//! Zaber stages with the ASCII protocol, as a source of positions.
//!
//! The state machine is that of [`asphera_described`]: the stage is asked for its position again and again. This
//! crate knows Zaber's replies, warning flags and checksum. It never moves anything.
//!
//! It opens no port and reads no clock.

#![forbid(unsafe_code)]

mod family;
mod reply;
mod settings;
mod warning;

pub use family::FAMILY;
pub use settings::{Axis, Microstep, Settings};
pub use warning::{WARNINGS, Warning};

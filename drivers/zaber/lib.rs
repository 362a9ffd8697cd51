//! Zaber stages with the ASCII protocol: positions, and moves on order.
//!
//! The state machine of the positions is that of [`asphera_described`]: the stage is asked for its position again and
//! again. This crate knows Zaber's replies, warning flags, checksum and moves. It moves nothing by itself.
//!
//! It opens no port and reads no clock.

#![forbid(unsafe_code)]

mod command;
mod family;
mod mover;
mod reply;
mod settings;
mod stage;
mod warning;

pub use family::FAMILY;
pub use settings::{Axis, Microstep, Settings};
pub use warning::{WARNINGS, Warning};

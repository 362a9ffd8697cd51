//! Simulated CiA 402 drive: a linear axis with a limit switch, on a CAN bus behind an slcan adapter.
//!
//! [`Drive`] has no clock and no port: frames in, frames out, time as an argument. It has the power states, profile position
//! and homing, moves in trapezoids, and can be made to fail. [`serve`] puts drives behind an adapter on TCP.
//!
//! This crate uses the wire format of `asphera-cia402` and never its state machine.

#![forbid(unsafe_code)]

mod dictionary;
mod drive;
mod power;
mod profile;
mod serve;

pub use drive::{Drive, DriveSettings, Fault};
pub use serve::{SharedDrives, serve};

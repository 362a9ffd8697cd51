//! A simulated Modbus device serving a register map.
//!
//! A [`Device`] holds the registers of an [`asphera_modbus::Map`], changes them with time and can be
//! told to misbehave ([`Fault`]). A [`Session`] is one connection to it without ports or clock; with
//! it a driver is tested in virtual time. [`serve`] runs a session on any stream, [`serve_tcp`] on
//! every connection of a listener, [`Pty`] gives a serial line.
//!
//! Frames are encoded and decoded here by hand, so that simulator and driver check each other.

#![forbid(unsafe_code)]

mod device;
mod fault;
mod frame;
mod image;
mod motion;
mod pdu;
mod serve;
mod session;

pub use device::Device;
pub use fault::Fault;
pub use image::{Image, SetError};
pub use motion::Sine;
pub use serve::{Pty, serve, serve_tcp};
pub use session::Session;

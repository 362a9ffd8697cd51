//! Coordinate measuring machines with I++ DME 1.4.3: a program of commands is run on order, its points are readings.
//!
//! asphera is the client, the machine's controller is the server. Nothing that moves is sent before someone armed the scan.
//! Points are those of the machine: centres of the probe's ball. This crate has no radius correction.
//!
//! It opens no port and reads no clock.

#![forbid(unsafe_code)]

mod device;
mod family;
mod settings;
pub mod wire;

pub use device::Ippdme;
pub use family::FAMILY;
pub use settings::Settings;

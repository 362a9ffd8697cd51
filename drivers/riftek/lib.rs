//! RIFTEK RF60x laser triangulation sensors, also sold as Acuity AR100 and AR500: the binary protocol of their
//! serial port.
//!
//! [`Riftek`] is an [`asphera_link::Driver`]. It asks the sensor who it is, then for each result or for a stream of
//! results. It changes no parameter.
//!
//! - [`wire`]: requests, and answers in halves of bytes with a counter.
//!
//! This crate opens no port and reads no clock.

#![forbid(unsafe_code)]

mod device;
mod family;
mod settings;
pub mod wire;

pub use device::{Riftek, Tally};
pub use family::FAMILY;
pub use settings::{Mode, Settings};

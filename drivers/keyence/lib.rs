//! Keyence LJ-X8000 and LJ-V7000 laser profilers: high-speed communication over two TCP connections.
//!
//! [`Profiler`] is an [`asphera_link::Driver`]. It asks on the command port and reads profiles from the stream. Each reading
//! has a profile, the trigger count and the count of the encoder.
//!
//! - [`wire`]: commands and answers, profiles of 20 bits a point, notices.
//!
//! This crate opens no port and reads no clock.

#![forbid(unsafe_code)]

mod device;
mod family;
mod settings;
pub mod wire;

pub use device::{Profiler, Tally};
pub use family::FAMILY;
pub use settings::Settings;

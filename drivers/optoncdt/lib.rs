//! Micro-Epsilon optoNCDT laser triangulation sensors: the binary stream of their serial port.
//!
//! [`Optoncdt`] is an [`asphera_link::Driver`]. It listens; what the sensor measures and sends is set up with the
//! maker's tool and saved there.
//!
//! - [`wire`]: words of 2 or 3 bytes, told apart by the highest bits of each byte;
//! - [`Series`]: what a word is worth, and which words are errors.
//!
//! This crate opens no port and reads no clock.

#![forbid(unsafe_code)]

mod device;
mod family;
mod series;
mod settings;
pub mod wire;

pub use device::{Optoncdt, Tally};
pub use family::FAMILY;
pub use series::{Distance, Series};
pub use settings::{Extra, Settings};

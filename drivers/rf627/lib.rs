//! RIFTEK RF627 laser line scanners: the profiles that they send as datagrams.
//!
//! [`Rf627`] is an [`asphera_link::Driver`]. It listens and sends nothing: the scanner is set up with the maker's
//! program. Each reading has a profile, and the count of the encoder or of the steps.
//!
//! - [`wire`]: datagrams of profiles, and the header of service messages.
//!
//! This crate opens no port and reads no clock.

#![forbid(unsafe_code)]

mod device;
mod family;
mod order;
mod settings;
pub mod wire;

pub use device::{Rf627, Tally};
pub use family::FAMILY;
pub use settings::Settings;

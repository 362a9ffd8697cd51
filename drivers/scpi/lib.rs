//! Instruments with SCPI: wavelength meters, thermometers, multimeters, counters.
//!
//! The state machine is that of [`asphera_described`]: `*IDN?` proves the instrument, a query gives each reading,
//! and `SYST:ERR?` says what went wrong. This crate knows SCPI: its questions, its numbers, its errors.
//!
//! It opens no port and reads no clock.

#![forbid(unsafe_code)]

mod answers;
mod family;
mod settings;

pub use family::FAMILY;
pub use settings::{Settings, Terminator, Value};

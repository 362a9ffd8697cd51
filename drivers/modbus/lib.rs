//! Modbus devices described by a register map.
//!
//! [`Modbus`] is an [`asphera_link::Driver`] that reads the fields of a [`Map`] at a fixed interval
//! over Modbus TCP or RTU and gives one reading per poll. Encoding and decoding are tokio-modbus's;
//! its client runs on a pipe in memory and is polled by hand, so this crate opens no port, needs no
//! runtime and reads no clock. Time-outs, late answers and the schedule are the driver's own.
//!
//! It never writes to a device.

#![forbid(unsafe_code)]

mod builtin;
mod call;
mod check;
mod device;
mod error;
mod family;
mod map;
mod pipe;
mod plan;
mod reading;
mod screen;
mod settings;
mod wire;

pub use builtin::BUILT_IN;
pub use device::{Modbus, Tally};
pub use error::{ValueError, WordError};
pub use family::FAMILY;
pub use map::{Block, Field, Function, Kind, Map, Role, WordOrder};
pub use settings::{MapSource, Settings, Transport};
pub use wire::{decode, decode_field, encode, encode_field};

//! Devices described in a configuration.
//!
//! Many gauges send a line of text or a record of bytes for each value, by themselves or when asked. [`Described`]
//! is an [`asphera_link::Driver`] for them; there is no code per device. [`Settings`] say how frames are told
//! apart, what guards them, where each number stands and what it is worth. [`CanGauge`] is the same for a device on a
//! CAN bus, whose numbers are bits of a frame.
//!
//! [`FAMILY`] also proposes such settings for bytes that were captured.
//!
//! This crate opens no port and reads no clock.

#![forbid(unsafe_code)]

mod assemble;
mod can;
mod check;
mod checksum;
mod device;
mod family;
mod field;
mod framing;
mod number;
mod pattern;
mod profile;
mod propose;
mod settings;

pub use can::{BitOrder, CanField, CanGauge, CanPoll, CanSettings, Signal, SignalForm};
pub use checksum::{Algorithm, Checksum, Digits};
pub use device::{Described, Tally};
pub use family::FAMILY;
pub use field::{Field, Flagged, Place, Role};
pub use framing::{End, Framing};
pub use number::{ByteOrder, Form};
pub use pattern::{Pattern, PatternError};
pub use profile::{Abscissae, ProfileRow};
pub use settings::{ErrorQueue, Hello, Layout, Poll, Refusal, Settings};

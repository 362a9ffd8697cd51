//! CANopen drives after CiA 402: a stage that homes and moves on order.
//!
//! The driver sets a drive up over SDO, reads its statusword and position by TPDO, and takes it through the power states, the
//! homing mode and the profile position mode. [`wire`] is what the profile adds to CANopen; the simulator uses it too.
//!
//! Sources are in the README. This crate deliberately opens no port, stores nothing in a drive (object 1010h is never
//! written), and moves nothing without an order.

#![forbid(unsafe_code)]

mod device;
mod family;
mod settings;
pub mod wire;

pub use device::Cia402;
pub use family::FAMILY;
pub use settings::{Homing, Reference, Settings, Step};

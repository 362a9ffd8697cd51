//! Precitec CHRocodile 2 and relatives as a driver.
//!
//! [`wire`] holds the protocols as bytes. [`Chrocodile`] is the device on the dollar protocol as a state machine,
//! [`PacketChrocodile`] that on the packet protocol. There is no port, no clock and no async code here.

#![forbid(unsafe_code)]

mod decode;
mod device;
mod error;
mod family;
mod framing;
mod packets;
mod settings;
pub mod wire;
mod words;

pub use device::Chrocodile;
pub use error::Error;
pub use family::FAMILY;
pub use packets::{PacketChrocodile, PacketSettings};
pub use settings::{Settings, Trigger};

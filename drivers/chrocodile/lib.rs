//! Precitec CHRocodile 2 and relatives, dollar protocol, as a driver.
//!
//! [`wire`] holds the protocol as bytes, [`Chrocodile`] the device as a state machine. There is no
//! port, no clock and no async code here; the packet protocol of TCP port 7891 is not supported.

#![forbid(unsafe_code)]

mod decode;
mod device;
mod error;
mod family;
mod framing;
mod settings;
pub mod wire;

pub use device::Chrocodile;
pub use error::Error;
pub use family::FAMILY;
pub use settings::{Settings, Trigger};

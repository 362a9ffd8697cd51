//! A simulated CHRocodile 2 on the dollar protocol, or on packets with one point or a line of them.
//!
//! [`Device`] and [`PacketDevice`] are the instrument as a state machine without ports; [`Simulator`] lets one run on any
//! byte stream, on a pseudo-terminal or on TCP, takes exposures from whoever moves the part, and
//! damages the link on command ([`Fault`]). It knows the protocol from
//! [`asphera_chrocodile::wire`] and nothing of the driver's state machine.

#![forbid(unsafe_code)]

mod device;
mod error;
mod instrument;
mod packets;
mod sample;
mod server;
mod transport;

pub use device::{Device, TriggerMode};
pub use error::Error;
pub use instrument::{Exposure, Instrument};
pub use packets::PacketDevice;
pub use sample::Sample;
pub use server::{Ended, Fault, Simulator};
pub use transport::{Pty, pty, tcp};

//! A simulated CHRocodile 2 on the dollar protocol.
//!
//! [`Device`] is the instrument as a state machine without ports; [`Simulator`] lets it run on any
//! byte stream, on a pseudo-terminal or on TCP, takes exposures from whoever moves the part, and
//! damages the link on command ([`Fault`]). It knows the protocol from
//! [`asphera_chrocodile::wire`] and nothing of the driver's state machine.

#![forbid(unsafe_code)]

mod device;
mod error;
mod sample;
mod server;
mod transport;

pub use device::{Device, TriggerMode};
pub use error::Error;
pub use sample::Sample;
pub use server::{Ended, Fault, Simulator};
pub use transport::{Pty, pty, tcp};

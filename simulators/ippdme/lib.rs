//! A simulated coordinate measuring machine that serves I++ DME.
//!
//! [`Machine`] is the server without a link: bytes in, bytes out, time as an argument. A [`Probe`] touches the part, whose surface is a
//! height over (x, y). [`SharedMachine`] is a machine that connections share, in real time. It uses the driver's `wire` alone.

#![forbid(unsafe_code)]

mod machine;
mod motion;
mod noise;
mod probe;
mod serve;

pub use machine::{Fault, Machine, MachineSettings};
pub use probe::{Probe, Surface};
pub use serve::{Received, SharedMachine};

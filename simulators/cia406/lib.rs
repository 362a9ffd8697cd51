//! Simulated CANopen CiA 406 encoders on one bus.
//!
//! [`Bus`] is the bus itself, without a clock or a port: nodes with an object dictionary, an SDO
//! server, network management, heartbeat, emergencies and a TPDO. [`Simulator`] puts it behind an
//! slcan adapter on any byte stream, a TCP listener or a pseudo terminal, with knobs for what goes
//! wrong in a workshop. [`Simulator::sync`] is the trigger of the bench: one SYNC with its counter,
//! and the position of each node after it.
//!
//! This crate uses the wire format of `asphera-cia406` and never its state machine.

#![forbid(unsafe_code)]

mod adapter;
mod bus;
mod dictionary;
mod node;
mod ports;
mod server;

pub use bus::{Bus, BusError};
pub use node::NodeConfig;
pub use ports::{Pty, serve_tcp};
pub use server::{Delivery, Participant, Simulator};

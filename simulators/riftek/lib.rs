//! A simulated RF60x laser sensor of RIFTEK: requests and distances in, answers and the stream out.
//!
//! It knows the protocol from [`asphera_riftek::wire`] and nothing of the driver's state machine.

#![forbid(unsafe_code)]

mod sensor;

pub use sensor::Sensor;

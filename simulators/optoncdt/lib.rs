//! A simulated optoNCDT laser sensor of Micro-Epsilon: distances in, blocks of its binary stream out.
//!
//! It knows the words and the formulas of [`asphera_optoncdt`] and nothing of the driver's state machine.

#![forbid(unsafe_code)]

mod sensor;

pub use sensor::{Measurement, Sensor};

//! The asphera daemon and its command line.
//!
//! The way of a datum, one direction, no way back:
//!
//! ```text
//! link bytes ─▶ driver ─▶ Reading ─▶ synchronizer ─▶ kinematics ─▶ Point ─▶ pipeline ─▶ Snapshot ─▶ publish
//!     └───────▶ session recorder
//! ```

pub mod calibration;
pub mod cli;
pub mod clock;
pub mod conclude;
pub mod config;
pub mod contour;
#[cfg(test)]
mod corpora;
pub mod lens;
pub mod live;
pub mod parts;
pub mod replay;
pub mod results;
pub mod session;
pub mod sessions;
mod shown;
mod snapshot;
pub mod station;
mod weighing;
mod whole_file;

// The laws of the fuzz targets name this crate from outside and are tested inside it.
#[cfg(test)]
extern crate self as asphera;

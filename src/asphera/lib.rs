//! The asphera daemon and its command line.

pub mod report;
pub mod snapshot;
pub mod station;

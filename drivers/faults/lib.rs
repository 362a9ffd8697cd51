//! The fault matrix of the drivers, for tests only.
//!
//! A [`Bench`] says how a driver is made and how its device talks. [`play()`] puts both on a line in virtual time, lets one
//! [`Fault`] happen and checks the laws that hold for all drivers. [`table()`] writes the outcome of all of them.
//!
//! The benches lie in `tests/matrix`, one file a driver. Nothing here opens a port or reads a clock.

#![forbid(unsafe_code)]

mod bench;
mod fault;
mod journal;
mod line;
mod noise;
mod play;
mod table;
mod verdict;

pub use bench::{Bench, Condition, Device, Expectation, Mark, Model, Sent};
pub use fault::Fault;
pub use play::play;
pub use table::{Row, replaced, table};
pub use verdict::Outcome;

//! The devices of a station, simulated from its own configuration.
//!
//! A [`Stand`] takes the devices as the configuration describes them, and what each is to show at every trigger. It opens a port of
//! 127.0.0.1 for each link and plays the devices there, so that a station can be tried before its instruments are there.
//!
//! Where the station moves its axes itself ([`Moving`]), stages and drives obey, and the other devices show where they stand.
//!
//! Frames of described devices, SCPI instruments and Zaber stages are made of the same settings that the station reads them by. A mistake
//! in these settings is therefore not found here. The other devices have simulators of their own.

#![forbid(unsafe_code)]

mod axes;
mod bus;
mod connection;
mod example;
mod frame;
mod gauges;
mod moving;
mod number;
mod opto;
mod played;
mod port;
mod probe;
mod profiler;
mod registers;
mod rf60x;
mod row;
mod scanner;
mod showing;
mod sight;
mod signals;
mod stand;
mod touch;
mod transducers;
mod voice;

pub use moving::Moving;
pub use played::{Instrument, Played, UnplayableError};
pub use port::{next_host, serve_hosts};
pub use sight::Sight;
pub use stand::{Listing, Stand, StandError};
pub use touch::Touch;

//! Clocks of devices against the host's, and readings of several devices joined by time.
//!
//! Three clocks are apart everywhere: that of a device ([`Reading::device_time_ns`](asphera_link::Reading), its zero is its own),
//! the host's monotonic clock ([`Nanos`](asphera_link::Nanos), from the start of the session), and the host's wall clock, which only
//! dates a session. This crate finds one from another; it reads none.
//!
//! All follows from readings and their times, so a recording gives the same again.

#![forbid(unsafe_code)]

mod clock;
mod envelope;
mod joiner;
mod keeper;
mod track;

pub use clock::{Clock, ClockState, Placed, SETTLED_PAIRS, SETTLED_SPAN, Stamp};
pub use joiner::{Coordinate, Fate, Joined, Spread, TimeJoiner, TimeSettings};
pub use keeper::{Keeper, Timekeeping};

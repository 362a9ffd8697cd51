//! Whole benches on real pseudo-terminals and sockets, measured by raw hosts written by hand: they
//! know the wire from the manuals and nothing of the drivers.

#![expect(clippy::unwrap_used, reason = "a failed test may panic, in its helpers too")]

mod faults;
mod host;
mod scans;
mod thermometer;

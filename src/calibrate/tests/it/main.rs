//! Calibrations of simulated machines whose errors are known.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod bad_input;
mod coverage;
mod laws;
mod reversal;
mod simulated;

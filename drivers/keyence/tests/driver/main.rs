//! The driver in virtual time: with a controller that answers or does not, and with any bytes.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod bench;
mod laws;
mod machine;

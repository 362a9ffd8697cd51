//! The packet protocol: literal bytes, the state machine, and laws for any bytes.

#![expect(clippy::unwrap_used, reason = "a panic here is a failed test")]

mod device;
mod golden;
mod laws;
mod machine;

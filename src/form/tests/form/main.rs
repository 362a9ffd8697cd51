//! Tests of the crate through its public interface, one binary.

mod common;
mod degenerate;
mod known;
mod laws;
mod live;
mod nominal;
mod real;
mod reference;

//! Tests of the crate as others see it.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod alike;
mod bodies;
mod degenerate;
mod genus;
mod geodesics;
mod library;
mod neighbours;
mod pieces;
mod resolutions;
mod running;
mod spectra;
mod tray;

//! Polynomial bases, series, expansions, grids and splines through the public interface, one binary.

#![expect(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]

mod degenerate;
mod differences;
mod expansion;
mod grid;
mod orthogonal;
mod tables;

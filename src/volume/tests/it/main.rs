//! Tests of the crate as others see it.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod areas;
mod bands;
mod betti;
mod bodies;
mod border;
mod critical;
mod gaps;
mod invariance;
mod knots;
mod measures;
mod meshes;
mod noise;
mod open_border;
mod regular;

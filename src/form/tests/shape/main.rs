//! Tests of the shapes through their public interface, one binary.

#![expect(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]

mod common;
mod compose;
mod degenerate;
mod derivatives;
mod limits;
mod mirror;
mod q;
mod sixty_digits;
mod values;

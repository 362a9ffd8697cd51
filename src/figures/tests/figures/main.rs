//! Figures of form and texture: analytic truths, laws, degenerate input, and figures by other software.

#![expect(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]
#![expect(
    clippy::print_stderr,
    reason = "a skipped test and the margin of a comparison must be seen"
)]

#[path = "../../../form/tests/form/common/places.rs"]
mod common;
mod form;
mod texture;

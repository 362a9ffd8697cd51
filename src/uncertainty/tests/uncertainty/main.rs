//! Uncertainties: known truths, laws of their meaning, extremes, limits, studies of coverage.

#![expect(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]
#![expect(
    clippy::print_stderr,
    reason = "a skipped test and the margin of a comparison must be seen"
)]

mod common;
mod extremes;
mod known;
mod limits;
mod meaning;
mod measured_mirror;
#[path = "../../../form/tests/form/mirror.rs"]
mod mirror;
mod robust;
mod shared;
#[path = "../../../form/tests/form/spoilt.rs"]
mod spoilt;
mod study;

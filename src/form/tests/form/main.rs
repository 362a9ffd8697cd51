//! Tests of the crate through its public interface, one binary.

#![expect(clippy::unwrap_used, reason = "a helper of a test may fail as the test itself")]
#![expect(
    clippy::print_stderr,
    reason = "a skipped test and the margin of a comparison must be seen"
)]

mod bad_input;
mod common;
mod contact;
mod curvature;
mod dabam;
mod degenerate;
mod freeform;
mod known;
mod laws;
mod live;
mod live_robust;
mod live_succession;
mod live_unknown;
mod live_weighted;
mod mirror;
mod nominal;
mod off_axis;
mod real;
mod reference;
mod reference_pairs;
mod robust;
mod search;
mod shapes;
mod spoilt;
mod unknown;
mod zone_degenerate;
mod zone_known;
mod zone_laws;
mod zone_reference;

//! The asphera daemon and its command line.
//!
//! The way of a datum, one direction, no way back:
//!
//! ```text
//! link bytes ─▶ driver ─▶ Reading ─▶ synchronizer ─▶ kinematics ─▶ Point ─▶ pipeline ─▶ Snapshot ─▶ publish
//!     └───────▶ session recorder
//! ```

pub mod cli;
pub mod clock;
pub mod conclude;
pub mod config;
pub mod live;
pub mod pipeline;
pub mod publish;
pub mod replay;
pub mod report;
pub mod results;
pub mod session;
pub mod snapshot;
pub mod station;

/// An error and its causes in one line, as it is printed at the edge.
pub fn error_chain(error: &dyn std::error::Error) -> String {
    let mut words = error.to_string();
    let mut source = error.source();
    while let Some(cause) = source {
        words.push_str(": ");
        words.push_str(&cause.to_string());
        source = cause.source();
    }
    words
}

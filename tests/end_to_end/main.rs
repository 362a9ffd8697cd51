//! The daemon end to end: one behaviour a file.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod api;
mod attacked;
mod browser;
mod defects;
mod demo;
mod errors;
mod faults;
mod file_kinds;
mod freeforms;
mod measure;
mod metamorphic;
mod peers;
mod profiles;
mod projection;
mod qif;
mod reduce;
mod report;
mod sampling;
mod service;
mod sessions;
mod shapes;
mod terminal;
mod unknown;

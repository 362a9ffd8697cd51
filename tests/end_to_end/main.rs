//! The daemon end to end: one behaviour a file.

mod api;
mod browser;
mod demo;
mod errors;
mod faults;
mod measure;
mod peers;

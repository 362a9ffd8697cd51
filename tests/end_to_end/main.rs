//! The daemon end to end: one behaviour a file.

#![expect(clippy::unwrap_used, reason = "a test ends where something is not as it must be")]

mod api;
mod attacked;
mod border;
mod browser;
mod by_time;
mod calibrated;
mod clocks;
mod closed_loop;
mod cmm;
mod contours;
mod defects;
mod demo;
mod described;
mod disks;
mod errors;
mod faults;
mod file_kinds;
mod freeforms;
mod kills;
mod line_scanner;
mod measure;
mod metamorphic;
mod outlines;
mod packets;
mod peers;
mod playback;
mod preloaded;
mod profiles;
mod projection;
mod qif;
mod random;
mod reduce;
mod report;
mod sampling;
mod service;
mod sessions;
mod shapes;
mod soak;
mod space;
mod stopping;
mod terminal;
mod tray;
mod twice;
mod unknown;

//! Local feature size against surfaces whose medial axis is known.

mod bodies;
mod field;
mod measured;
mod meshed;
mod nominal;

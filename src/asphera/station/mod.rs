//! One measuring station: links → drivers → synchronizer → kinematics → pipeline.

mod gate;
mod kinematics;
mod synchronizer;
mod unwrap;

pub use kinematics::{Axis, Kinematics, Point};
pub use synchronizer::{Record, StreamCounts, SyncSettings, Synchronizer};

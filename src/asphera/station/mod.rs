//! One measuring station: links → drivers → synchronizer → kinematics → pipeline.

mod adapter;
mod assemble;
mod bench;
mod bus;
mod framing;
mod gate;
mod heard;
mod hold_up;
mod joiner;
mod kinematics;
mod line;
mod places;
mod profiler;
mod rate;
mod scan;
mod synchronizer;
mod systematic;
mod thermal;
mod tilting;
mod unwrap;

pub use assemble::{AssembleError, assemble};
pub use bench::{Action, Bench, BenchSettings, EndSettings, Ended, Happening, ScanOrder};
pub use framing::Framing;
pub use joiner::JoinSettings;
pub use kinematics::{Axis, ErrorTable, Kinematics, Point, Source};
pub use line::Line;
pub use profiler::{Carriage, ProfileDirection, Profiler, Scaling};
pub(crate) use scan::plan_aperture;
pub use scan::{AdaptivePlan, ArmError, Order, ScanAxis, ScanDecision, ScanPlan, Scanner, Stroke};
pub use synchronizer::{Record, StreamCounts, SyncSettings, Synchronizer};
pub use thermal::{Expansion, Temperature, Thermal, ThermalSettings};
pub use tilting::Tilting;

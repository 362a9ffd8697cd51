//! A bench of simulators measuring a simulated part, started from one TOML file.
//!
//! A [`Scene`] says what is measured, how, and what goes wrong. [`Rig::start`] puts the bench up:
//! a chromatic probe and CANopen transducers on pseudo-terminals with stable names, and a
//! thermometer on Modbus TCP. The scan begins when the host has armed every triggered device.
//! [`Rig::truth`] is what a host that makes no mistake must find, under the names of the daemon's
//! report; [`Rig::station_toml`] is the configuration with which the daemon measures on this bench.
//!
//! Deliberately absent: any knowledge of the daemon or of the drivers' state machines.

#![forbid(unsafe_code)]

mod axes;
mod ball;
mod bench;
mod cmm;
mod ct;
mod drive;
mod error;
mod fault;
mod motion;
mod noise;
mod pace;
mod part;
mod plan;
mod port;
mod profiler;
mod rig;
mod scene;
mod section;
mod socket;
mod station;
mod thermal;
mod tray;
mod truth;

pub use asphera_sim_cia402::{Fault as DriveFault, SharedDrives};
pub use asphera_sim_ippdme::Fault as MachineFault;
pub use asphera_sim_keyence::Fault as ProfilerFault;
pub use asphera_sim_rf627::{Departure, send};
pub use asphera_sim_zaber::Fault as StageFault;
pub use cmm::{CmmRig, CmmScene};
pub use ct::{CtError, CtFace, CtScene, CtTruth, CtVolume};
pub use drive::{DriveRig, DriveScene};
pub use error::{FaultError, RigError, SceneError};
pub use fault::{Fault, Link};
pub use motion::Stop;
pub use pace::Speed;
pub use plan::{Plan, PlanError, Trigger};
pub use profiler::{ProfilerRig, ProfilerScene};
pub use rig::{Listing, Rig};
pub use scene::Scene;
pub use station::StationOptions;
pub use tray::{Tray, TrayKind, TrayPart, TrayPartTruth, TrayScan, TrayScene, TrayTruth};
pub use truth::{DeviationTruth, FitTruth, FormTruth, ParameterTruth, PartTruth, PoseTruth, Truth};

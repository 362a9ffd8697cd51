//! The contract between links, drivers and a station.
//!
//! A *link* carries bytes or CAN frames. A *driver* turns what one device says into [`Reading`]s and
//! what the station wants into bytes or frames to send. A driver is a state machine: it opens no
//! port, starts no task and reads no clock; time is an argument of type [`Nanos`]. The same driver
//! therefore runs on a real port, on a simulator and on a recording, and gives the same readings.
//!
//! A [`Family`] is what the configuration of a station knows of a driver: its name, its settings, and what they
//! ask of the link.
//!
//! Drivers share what all of them need: their [`Events`], and for devices that are asked [`Asking`] and [`Schedule`]. Links that stamp what
//! they carry share [`LeastDelay`].
//!
//! This crate deliberately holds no input or output and no async code.

#![forbid(unsafe_code)]

mod asking;
mod bytes;
mod can;
mod channel;
mod delay;
mod driver;
mod events;
mod family;
mod motion;
mod pair;
mod profile;
mod reading;
mod schedule;
mod setting;
mod time;

pub use asking::{Asking, AskingStep, Pace, Unanswered};
pub use bytes::{BytesError, bytes_of, shown, text_of};
pub use can::{CanFrame, CanId, FD_LENGTHS, FD_RECORD_LEN, FdFlags, FrameError, RECORD_LEN};
pub use channel::{Channel, Unit};
pub use delay::{LeastDelay, Stamped};
pub use driver::{Command, Driver, Event, Fault, FaultKind, Input, Output};
pub use events::Events;
pub use family::{BusNumber, Capture, Carries, DeviceClock, DeviceSettings, Family, Proposal};
pub use motion::{AxisMove, Motion, MotionEvent, MotionFailure, MotionTrouble};
pub use pair::Connection;
pub use profile::Profile;
pub use reading::{Count, Flags, MAX_CHANNELS, Reading, Values};
pub use schedule::Schedule;
pub use setting::{Problem, check_range};
pub use time::{Nanos, millis};

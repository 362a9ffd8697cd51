//! The protocols as bytes: signals, which both have; commands, answers and telegrams of the dollar protocol; [`packet`].
//!
//! Everything here is a pure function of its arguments and works in both directions, so that the
//! simulator speaks with the same tables as the driver.
//!
//! Sources, as cited below: **CR** is Precitec's "CHRocodile 2 Command Reference" of 2025-07-23,
//! **C** the "CHRocodile C Operation Manual" 1.0 of 2016-09-20, **CLS** the operation manual of the
//! CHRocodile CLS 0.2. C and CLS speak the same protocol and print literal dialogues.

mod command;
pub mod packet;
mod signal;
mod telegram;

pub use command::{Command, NOT_VALID, READY, Request, split_answer};
pub use signal::{Axis, Encoding, Mode, Part, Quantity, Signal, SignalError, ValueType};
pub use telegram::{Layout, MAX_SIGNALS, SYNC};

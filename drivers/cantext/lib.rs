//! CAN frames as text: logs of candump, and the protocol of socketcand.
//!
//! Both come from the Linux CAN project, and neither needs a CAN interface on this machine. A log has one frame a line;
//! a server of socketcand sends and takes elements in angle brackets over TCP.
//!
//! Sources: `lib.h`, `lib.c` and `candump.c` of linux-can/can-utils; `doc/protocol.md` and `state_raw.c` of
//! linux-can/socketcand. Classes of error frames: `<linux/can/error.h>`.
//!
//! This crate deliberately opens no file and no port, and has no clock. Its frames are classic and CAN FD. CAN XL frames are
//! counted with their line, never read as others; so are those of CAN FD where nobody wants them.

#![forbid(unsafe_code)]

mod bus_error;
pub mod candump;
mod error_frame;
mod hex;
pub mod socketcand;

pub use bus_error::{BusError, ERROR_FLAG};
pub use error_frame::{BusState, ErrorFrame};

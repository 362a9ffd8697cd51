//! A simulated Keyence LJ-X8000 or LJ-V7000 laser profiler over a moving part.
//!
//! [`Controller`] answers commands and makes the bytes of profiles. A [`Scan`] moves the part under it and has faults of the
//! controller and of the stream ([`Fault`]). [`accept`] and [`serve`] are one client on both ports, in real time. It knows the protocol from
//! [`asphera_keyence::wire`] and nothing of the driver's state machine.

#![forbid(unsafe_code)]

mod controller;
mod scan;
mod serve;
mod surface;

pub use controller::{Controller, Optics};
pub use scan::{Fault, Scan, ScanSettings};
pub use serve::{accept, serve};
pub use surface::Surface;

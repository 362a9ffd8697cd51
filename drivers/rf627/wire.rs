//! Datagrams of an RF627: profiles and service messages, as bytes and as types, without state.
//!
//! ```text
//! profile, little-endian
//!  0 type   1 flags   2 device 627 (u16)   4 serial (u32)   8 time ns (u64)
//! 16 version major, minor   18 offset of parameters   19 offset of points
//! 20 packet count (u32)   24 measure count (u32)
//! 28 z range mm   30 x range mm   32 steps of a range (u16 each)   44 licence hash (u32)
//! 48 exposure ns   52 laser   56 step count (u32 each)   60 direction   61 bytes of points (u16)   63 bytes a point
//! 64 points: x (i16), z (u16); then, where the flag says so, an intensity (u8) a point
//! ```
//!
//! Sources: README.md of this folder.

mod encode;
mod packet;
mod service;

pub use encode::{EncodeError, encode};
pub use packet::{Format, Header, Packet, PacketError, RawPoint};
pub use service::{ALL_DEVICES, Kind, SERVICE_LEN, ServiceHeader};

/// Number of the device type that stands in every profile.
pub const DEVICE: u16 = 627;

/// Bytes before the points as scanners send them today.
pub const HEADER_LEN: usize = 64;

/// Bytes of a point.
const POINT: usize = 4;

/// Flag of a profile with intensities.
const HAS_INTENSITY: u8 = 1;

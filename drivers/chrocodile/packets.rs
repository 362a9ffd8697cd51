//! The device on the packet protocol: settings, formats, and the state machine.

mod device;
mod formats;
mod framing;
mod order;
mod sample;
mod settings;

pub use device::PacketChrocodile;
pub use settings::PacketSettings;

//! The device on the packet protocol: settings, formats, and the state machine.

mod device;
mod formats;
mod framing;
mod order;
mod sample;
mod settings;
mod talk;

pub use device::PacketChrocodile;
pub use settings::PacketSettings;

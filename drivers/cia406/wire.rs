//! CANopen objects as bytes: those of [`asphera_canopen`], and what the profile adds.

pub mod object;
mod pdo;

pub use asphera_canopen::{
    AbortCode, Cob, Emergency, Expedited, MappedObject, NmtCommand, NmtRequest, NmtState, NodeId,
    SdoRequest, SdoResponse, heartbeat_frame, sync_frame,
};
pub use pdo::{AreaState, Position, TpdoLayout};

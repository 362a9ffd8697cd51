//! CANopen objects as bytes: identifiers, network management, SDO, PDO, emergencies, SYNC.

mod cob;
mod emcy;
mod nmt;
pub mod object;
mod pdo;
mod sdo;

pub use cob::{Cob, NodeId};
pub use emcy::Emergency;
pub use nmt::{NmtCommand, NmtRequest, NmtState, heartbeat_frame, sync_frame};
pub use pdo::{AreaState, MappedObject, Position, TpdoLayout};
pub use sdo::{AbortCode, Expedited, SdoRequest, SdoResponse};

use asphera_link::{CanFrame, CanId};

/// A frame of at most eight bytes, which all objects here are by construction.
fn frame(cob: Cob, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(cob.id()), data)
        .expect("identifiers of Cob have 11 bits and CANopen objects at most 8 bytes")
}

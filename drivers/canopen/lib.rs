//! CANopen (CiA 301) as bytes: identifiers, network management, SDO of up to four bytes, emergencies, SYNC.
//!
//! Drivers of device profiles stand on it: `asphera-cia402`, `asphera-cia406`. Sources: CiA 301 as the manuals of devices give it.
//! MTS: Temposonics E-Series CANopen, operation manual. TR: TR-Electronic LA-46/LMRI-46, TR-ELA-BA-DGB-0016. esd: CAN-CBX-REL4
//! manual C.3012.21.
//!
//! This crate deliberately has no state, opens no port and knows no device.

#![forbid(unsafe_code)]

mod cob;
mod emcy;
mod error;
mod nmt;
pub mod object;
mod sdo;

pub use cob::{Cob, NodeId};
pub use emcy::Emergency;
pub use error::WireError;
pub use nmt::{NmtCommand, NmtRequest, NmtState, heartbeat_frame, sync_frame};
pub use object::{Address, MappedObject};
pub use sdo::{AbortCode, Expedited, SdoRequest, SdoResponse};

use asphera_link::{CanFrame, CanId};

/// Frame of at most eight bytes, which all objects here are by construction.
pub fn frame(cob: Cob, data: &[u8]) -> CanFrame {
    CanFrame::data_frame(CanId::Standard(cob.id()), data)
        .expect("identifiers of Cob have 11 bits and CANopen objects at most 8 bytes")
}

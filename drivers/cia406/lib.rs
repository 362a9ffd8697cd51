//! CANopen encoders and linear transducers after CiA 406.
//!
//! [`Cia406`] is the driver of one node: it sets the node up over SDO, starts it, joins each
//! position to the SYNC that asked for it, and watches the node's heartbeat and emergencies. Several
//! of them share one bus, each shown every frame. [`wire`] is what stands on the bus; the simulator
//! uses it too.
//!
//! Sources: CiA 301 (application layer) and CiA 406 (encoder profile) as the manuals of devices give
//! them. MTS: Temposonics E-Series CANopen, operation manual, pages 27 to 36. TR: TR-Electronic
//! LA-46/LMRI-46, TR-ELA-BA-DGB-0016, pages 152 to 171. BEI: BEI Sensors CANopen manual serie M,
//! version 07/10. esd: CAN-CBX-REL4 manual C.3012.21.
//!
//! This crate deliberately opens no port, knows no adapter, produces no SYNC and stores nothing in a
//! device (object 1010h is never written).

#![forbid(unsafe_code)]

mod device;
mod family;
mod settings;
pub mod wire;

pub use asphera_canopen::WireError;
pub use device::Cia406;
pub use family::FAMILY;
pub use settings::{Kind, PositionObject, Settings, Transmission};

//! Communication object identifiers of the predefined connection set (CiA 301, section 7.3.5).

use std::fmt;

use asphera_link::{CanFrame, CanId};

use crate::WireError;

/// Number of a node, 1 to 127.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct NodeId(u8);

impl NodeId {
    /// The node of a number. Fails on 0 and above 127.
    pub const fn new(number: u8) -> Result<NodeId, WireError> {
        if number >= 1 && number <= 127 { Ok(NodeId(number)) } else { Err(WireError::Node(number)) }
    }

    /// The number, 1 to 127.
    pub const fn get(self) -> u8 {
        self.0
    }
}

impl fmt::Display for NodeId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0)
    }
}

/// A communication object this crate knows, by its default identifier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cob {
    /// 0x000: network management.
    Nmt,
    /// 0x080: SYNC.
    Sync,
    /// 0x080 + node: emergency.
    Emergency(NodeId),
    /// 0x180 + node: first transmit PDO.
    Tpdo1(NodeId),
    /// 0x580 + node: SDO, node to master.
    SdoResponse(NodeId),
    /// 0x600 + node: SDO, master to node.
    SdoRequest(NodeId),
    /// 0x700 + node: heartbeat and boot-up.
    Heartbeat(NodeId),
}

impl Cob {
    /// The identifier, 11 bits.
    pub const fn id(self) -> u16 {
        match self {
            Cob::Nmt => 0x000,
            Cob::Sync => 0x080,
            Cob::Emergency(node) => 0x080 + node.0 as u16,
            Cob::Tpdo1(node) => 0x180 + node.0 as u16,
            Cob::SdoResponse(node) => 0x580 + node.0 as u16,
            Cob::SdoRequest(node) => 0x600 + node.0 as u16,
            Cob::Heartbeat(node) => 0x700 + node.0 as u16,
        }
    }

    /// The object of a frame: none for remote and CAN FD frames, 29-bit identifiers and objects not used here.
    pub fn from_frame(frame: &CanFrame) -> Option<Cob> {
        let CanId::Standard(id) = frame.id() else { return None };
        if frame.is_remote() || frame.fd().is_some() {
            return None;
        }
        let Ok(node) = NodeId::new((id & 0x7F) as u8) else {
            return match id {
                0x000 => Some(Cob::Nmt),
                0x080 => Some(Cob::Sync),
                _ => None,
            };
        };
        Some(match id & 0x780 {
            0x080 => Cob::Emergency(node),
            0x180 => Cob::Tpdo1(node),
            0x580 => Cob::SdoResponse(node),
            0x600 => Cob::SdoRequest(node),
            0x700 => Cob::Heartbeat(node),
            _ => return None,
        })
    }
}

impl fmt::Display for Cob {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Cob::Nmt => f.write_str("NMT command"),
            Cob::Sync => f.write_str("SYNC"),
            Cob::Emergency(node) => write!(f, "emergency of node {node}"),
            Cob::Tpdo1(node) => write!(f, "TPDO1 of node {node}"),
            Cob::SdoResponse(node) => write!(f, "SDO response of node {node}"),
            Cob::SdoRequest(node) => write!(f, "SDO request to node {node}"),
            Cob::Heartbeat(node) => write!(f, "heartbeat of node {node}"),
        }
    }
}

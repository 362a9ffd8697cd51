//! Objects that every node has, and where objects are.

use std::fmt;

/// Index and sub-index of an object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Address {
    /// Index.
    pub index: u16,
    /// Sub-index; 0 for a plain variable, and for the count of an array.
    pub sub: u8,
}

impl Address {
    /// An object.
    pub const fn new(index: u16, sub: u8) -> Address {
        Address { index, sub }
    }
}

/// As manuals write it: `6005.01h`.
impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}.{:02X}h", self.index, self.sub)
    }
}

/// One object in a PDO.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MappedObject {
    /// The object.
    pub address: Address,
    /// Its length in bits.
    pub bits: u8,
}

impl MappedObject {
    /// The entry of the mapping: index, sub-index, bits; 0x60200120 is 32 bits of 6020.01h (MTS p.32).
    pub const fn entry(self) -> u32 {
        (self.address.index as u32) << 16 | (self.address.sub as u32) << 8 | self.bits as u32
    }

    /// The object of an entry.
    pub const fn from_entry(entry: u32) -> MappedObject {
        let address = Address::new((entry >> 16) as u16, (entry >> 8) as u8);
        MappedObject { address, bits: entry as u8 }
    }
}

impl fmt::Display for MappedObject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} bits)", self.address, self.bits)
    }
}

/// UNSIGNED32, ro: device profile in the low word, kind of encoder in the high one (TR p.152).
pub const DEVICE_TYPE: Address = Address::new(0x1000, 0);
/// UNSIGNED8, ro: error register, the byte emergencies carry too (TR p.152).
pub const ERROR_REGISTER: Address = Address::new(0x1001, 0);
/// UNSIGNED16, rw: time between heartbeats in ms; 0 for none (MTS p.27).
pub const HEARTBEAT_TIME: Address = Address::new(0x1017, 0);
/// UNSIGNED32, ro: vendor number given by CiA.
pub const VENDOR: Address = Address::new(0x1018, 1);
/// UNSIGNED32, rw: identifier of TPDO1; bit 31 set: switched off, bit 30: no remote request (MTS p.32).
pub const TPDO1_COB: Address = Address::new(0x1800, 1);
/// UNSIGNED8, rw: transmission type: 1 to 240 at every n-th SYNC, 254 and 255 by event (MTS p.36).
pub const TPDO1_TYPE: Address = Address::new(0x1800, 2);
/// UNSIGNED16, rw: event timer in ms (MTS p.36).
pub const TPDO1_EVENT_TIMER: Address = Address::new(0x1800, 5);
/// UNSIGNED8, rw: number of objects mapped into TPDO1; the objects follow at sub-index 1 (MTS p.32).
pub const TPDO1_MAPPING: Address = Address::new(0x1A00, 0);
/// Bit of [`TPDO1_COB`] that switches the PDO off.
pub const PDO_INVALID: u32 = 1 << 31;
/// Bit of [`TPDO1_COB`] that forbids remote requests.
pub const PDO_NO_REMOTE: u32 = 1 << 30;

//! Objects of the dictionary the driver touches.

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

/// UNSIGNED32, ro: device profile in the low word, kind of encoder in the high one (TR p.152).
pub const DEVICE_TYPE: Address = Address::new(0x1000, 0);
/// UNSIGNED8, ro: error register, the byte emergencies carry too (TR p.152).
pub const ERROR_REGISTER: Address = Address::new(0x1001, 0);
/// UNSIGNED16, rw: time between heartbeats in ms; 0 for none (MTS p.27).
pub const HEARTBEAT_TIME: Address = Address::new(0x1017, 0);
/// UNSIGNED32, ro: vendor number given by CiA.
pub const VENDOR: Address = Address::new(0x1018, 1);
/// UNSIGNED8, rw: SYNC counter overflow: 0 for no counter, else 2 to 240 (esd p.71).
pub const SYNC_OVERFLOW: Address = Address::new(0x1019, 0);
/// UNSIGNED32, rw: identifier of TPDO1; bit 31 set: switched off, bit 30: no remote request (MTS p.32).
pub const TPDO1_COB: Address = Address::new(0x1800, 1);
/// UNSIGNED8, rw: transmission type: 1 to 240 at every n-th SYNC, 254 and 255 by event (MTS p.36).
pub const TPDO1_TYPE: Address = Address::new(0x1800, 2);
/// UNSIGNED16, rw: event timer in ms (MTS p.36).
pub const TPDO1_EVENT_TIMER: Address = Address::new(0x1800, 5);
/// UNSIGNED8, rw: number of objects mapped into TPDO1; the objects follow at sub-index 1 (MTS p.32).
pub const TPDO1_MAPPING: Address = Address::new(0x1A00, 0);
/// INTEGER32 or UNSIGNED32, ro: position of a device with one sensor (TR p.165).
pub const POSITION: Address = Address::new(0x6004, 0);
/// UNSIGNED32: step of the position of a linear encoder in 0.001 µm, which is 1 nm (MTS p.33).
pub const POSITION_STEP: Address = Address::new(0x6005, 1);
/// UNSIGNED32: step of the velocity of a linear encoder in 0.01 mm/s (MTS p.33).
pub const VELOCITY_STEP: Address = Address::new(0x6005, 2);
/// INTEGER32, ro: position of the first sensor of a multi-sensor device (TR p.165).
pub const POSITION_1: Address = Address::new(0x6020, 1);
/// INTEGER16, ro: velocity of the first sensor (TR p.165).
pub const VELOCITY_1: Address = Address::new(0x6030, 1);
/// UNSIGNED8, ro: state of the work area of the first sensor (BEI p.51).
pub const AREA_STATE_1: Address = Address::new(0x6400, 1);
/// UNSIGNED32, ro: measuring step in 0.001 µm (MTS p.33).
pub const MEASURING_STEP: Address = Address::new(0x6501, 0);

/// Number of the encoder profile in the low word of [`DEVICE_TYPE`] (TR p.152: 196h).
pub const PROFILE_406: u16 = 406;
/// Bit of [`TPDO1_COB`] that switches the PDO off.
pub const PDO_INVALID: u32 = 1 << 31;
/// Bit of [`TPDO1_COB`] that forbids remote requests.
pub const PDO_NO_REMOTE: u32 = 1 << 30;

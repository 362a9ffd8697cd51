//! Objects of the dictionary the driver touches.

pub use asphera_canopen::Address;
pub use asphera_canopen::object::{
    DEVICE_TYPE, ERROR_REGISTER, HEARTBEAT_TIME, PDO_INVALID, PDO_NO_REMOTE, TPDO1_COB,
    TPDO1_EVENT_TIMER, TPDO1_MAPPING, TPDO1_TYPE, VENDOR,
};

/// UNSIGNED8, rw: SYNC counter overflow: 0 for no counter, else 2 to 240 (esd p.71).
pub const SYNC_OVERFLOW: Address = Address::new(0x1019, 0);
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

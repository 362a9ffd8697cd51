//! Objects of the profile, and the words of its state machine.

mod status;

pub use status::{PowerState, Statusword, control};

pub use asphera_canopen::{
    AbortCode, Address, Cob, Emergency, Expedited, MappedObject, NmtCommand, NmtRequest, NmtState,
    NodeId, SdoRequest, SdoResponse, WireError, frame, heartbeat_frame,
};

/// Objects of the dictionary.
pub mod object {
    use asphera_canopen::{Address, MappedObject};

    pub use asphera_canopen::object::{
        DEVICE_TYPE, ERROR_REGISTER, HEARTBEAT_TIME, PDO_INVALID, PDO_NO_REMOTE, TPDO1_COB,
        TPDO1_EVENT_TIMER, TPDO1_MAPPING, TPDO1_TYPE, VENDOR,
    };

    /// UNSIGNED16, ro: code of the last fault.
    pub const ERROR_CODE: Address = Address::new(0x603F, 0);
    /// UNSIGNED16, rw: controlword.
    pub const CONTROLWORD: Address = Address::new(0x6040, 0);
    /// UNSIGNED16, ro: statusword.
    pub const STATUSWORD: Address = Address::new(0x6041, 0);
    /// INTEGER16, rw: quick stop option code; 6: slow down on the quick stop ramp, and stay in quick stop.
    pub const QUICK_STOP_OPTION: Address = Address::new(0x605A, 0);
    /// INTEGER8, rw: mode of operation.
    pub const MODE: Address = Address::new(0x6060, 0);
    /// INTEGER8, ro: mode of operation that is in force.
    pub const MODE_DISPLAY: Address = Address::new(0x6061, 0);
    /// INTEGER32, ro: actual position.
    pub const POSITION: Address = Address::new(0x6064, 0);
    /// INTEGER32, rw: target position.
    pub const TARGET: Address = Address::new(0x607A, 0);
    /// INTEGER32, rw: home offset.
    pub const HOME_OFFSET: Address = Address::new(0x607C, 0);
    /// UNSIGNED32, rw: profile velocity.
    pub const PROFILE_VELOCITY: Address = Address::new(0x6081, 0);
    /// UNSIGNED32, rw: profile acceleration.
    pub const PROFILE_ACCELERATION: Address = Address::new(0x6083, 0);
    /// UNSIGNED32, rw: profile deceleration.
    pub const PROFILE_DECELERATION: Address = Address::new(0x6084, 0);
    /// INTEGER8, rw: homing method.
    pub const HOMING_METHOD: Address = Address::new(0x6098, 0);
    /// UNSIGNED32, rw: speed during the search for the switch.
    pub const HOMING_SPEED_SWITCH: Address = Address::new(0x6099, 1);
    /// UNSIGNED32, rw: speed during the search for zero.
    pub const HOMING_SPEED_ZERO: Address = Address::new(0x6099, 2);
    /// UNSIGNED32, rw: homing acceleration.
    pub const HOMING_ACCELERATION: Address = Address::new(0x609A, 0);
    /// UNSIGNED32, ro: modes that the drive has, bit by bit.
    pub const SUPPORTED_MODES: Address = Address::new(0x6502, 0);

    /// Number of the profile in the low word of [`DEVICE_TYPE`].
    pub const PROFILE_402: u16 = 402;
    /// Mode of operation: profile position.
    pub const PROFILE_POSITION: u8 = 1;
    /// Mode of operation: homing.
    pub const HOMING: u8 = 6;
    /// Bit of [`SUPPORTED_MODES`] for profile position.
    pub const HAS_PROFILE_POSITION: u32 = 1;
    /// Bit of [`SUPPORTED_MODES`] for homing.
    pub const HAS_HOMING: u32 = 1 << 5;

    /// Content of TPDO1: statusword and position, six bytes.
    pub const TPDO1: [MappedObject; 2] = [
        MappedObject { address: STATUSWORD, bits: 16 },
        MappedObject { address: POSITION, bits: 32 },
    ];
}

/// Statusword and position of a TPDO1, if it has six bytes.
pub fn decode_tpdo(data: &[u8]) -> Option<(Statusword, i32)> {
    let &[low, high, a, b, c, d] = data else { return None };
    Some((Statusword(u16::from_le_bytes([low, high])), i32::from_le_bytes([a, b, c, d])))
}

/// Data of a TPDO1.
pub fn encode_tpdo(status: Statusword, position: i32) -> [u8; 6] {
    let [low, high] = status.0.to_le_bytes();
    let [a, b, c, d] = position.to_le_bytes();
    [low, high, a, b, c, d]
}

//! Statusword and controlword (CiA 402, objects 6041h and 6040h).

use std::fmt;

/// Statusword of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Statusword(pub u16);

/// State of the power stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PowerState {
    /// The drive starts.
    NotReady,
    /// The power stage is off, and may not be switched on.
    SwitchOnDisabled,
    /// The power stage may be switched on.
    ReadyToSwitchOn,
    /// The power stage is on, without torque.
    SwitchedOn,
    /// The drive moves on order.
    OperationEnabled,
    /// The drive brakes, or stands after that.
    QuickStopActive,
    /// The drive reacts to a fault.
    FaultReactionActive,
    /// The drive has a fault.
    Fault,
}

/// Controlwords, each the command to the next state.
pub mod control {
    /// Power off.
    pub const DISABLE_VOLTAGE: u16 = 0x0000;
    /// Brake on the quick stop ramp.
    pub const QUICK_STOP: u16 = 0x0002;
    /// Switch on disabled to ready to switch on.
    pub const SHUTDOWN: u16 = 0x0006;
    /// Ready to switch on to switched on.
    pub const SWITCH_ON: u16 = 0x0007;
    /// Switched on to operation enabled.
    pub const ENABLE_OPERATION: u16 = 0x000F;
    /// Rising edge: new set-point of a move, or start of homing.
    pub const START: u16 = 0x0010;
    /// The new set-point counts at once.
    pub const AT_ONCE: u16 = 0x0020;
    /// Rising edge: fault reset.
    pub const FAULT_RESET: u16 = 0x0080;
}

impl Statusword {
    /// State of the power stage; `None` for bits that stand for none.
    pub const fn state(self) -> Option<PowerState> {
        match self.0 & 0x4F {
            0x00 => return Some(PowerState::NotReady),
            0x40 => return Some(PowerState::SwitchOnDisabled),
            0x08 => return Some(PowerState::Fault),
            0x0F => return Some(PowerState::FaultReactionActive),
            _ => {}
        }
        match self.0 & 0x6F {
            0x21 => Some(PowerState::ReadyToSwitchOn),
            0x23 => Some(PowerState::SwitchedOn),
            0x27 => Some(PowerState::OperationEnabled),
            0x07 => Some(PowerState::QuickStopActive),
            _ => None,
        }
    }

    /// Bit 10: the target is reached, or in quick stop the drive stands.
    pub const fn is_target_reached(self) -> bool {
        self.0 & 1 << 10 != 0
    }

    /// Bit 11: a limit of the drive holds it.
    pub const fn is_limited(self) -> bool {
        self.0 & 1 << 11 != 0
    }

    /// Bit 12: set-point acknowledged, or in homing mode home attained.
    pub const fn is_acknowledged(self) -> bool {
        self.0 & 1 << 12 != 0
    }

    /// Bit 13: following error, or in homing mode homing error.
    pub const fn has_mode_error(self) -> bool {
        self.0 & 1 << 13 != 0
    }
}

impl PowerState {
    /// Controlword on the way to operation enabled; `None` where the drive gets on by itself, or is there.
    pub const fn next_control(self) -> Option<u16> {
        match self {
            PowerState::SwitchOnDisabled => Some(control::SHUTDOWN),
            PowerState::ReadyToSwitchOn => Some(control::SWITCH_ON),
            PowerState::SwitchedOn => Some(control::ENABLE_OPERATION),
            PowerState::QuickStopActive => Some(control::DISABLE_VOLTAGE),
            PowerState::Fault => Some(control::FAULT_RESET),
            PowerState::NotReady
            | PowerState::FaultReactionActive
            | PowerState::OperationEnabled => None,
        }
    }
}

impl fmt::Display for Statusword {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = match self.state() {
            Some(PowerState::NotReady) => "not ready to switch on",
            Some(PowerState::SwitchOnDisabled) => "switch on disabled",
            Some(PowerState::ReadyToSwitchOn) => "ready to switch on",
            Some(PowerState::SwitchedOn) => "switched on",
            Some(PowerState::OperationEnabled) => "operation enabled",
            Some(PowerState::QuickStopActive) => "quick stop active",
            Some(PowerState::FaultReactionActive) => "fault reaction active",
            Some(PowerState::Fault) => "fault",
            None => "no state of CiA 402",
        };
        write!(f, "{state} (statusword {:04X}h)", self.0)
    }
}

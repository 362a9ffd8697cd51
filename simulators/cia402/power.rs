//! Power states of CiA 402, as a drive goes through them.

use asphera_cia402::wire::{PowerState, control};

/// State that a controlword leads to. Bits 0 to 3 are the command, bit 7 by its rising edge resets a fault.
pub(crate) fn next(state: PowerState, word: u16, last: u16) -> PowerState {
    let rises = |bit: u16| word & bit != 0 && last & bit == 0;
    let enables_voltage = word & 0b0010 != 0;
    let runs = word & 0b0100 != 0;
    match state {
        PowerState::Fault if rises(control::FAULT_RESET) => PowerState::SwitchOnDisabled,
        PowerState::Fault | PowerState::NotReady | PowerState::FaultReactionActive => state,
        _ if !enables_voltage => PowerState::SwitchOnDisabled,
        PowerState::OperationEnabled if !runs => PowerState::QuickStopActive,
        PowerState::QuickStopActive if word & 0b1111 == control::ENABLE_OPERATION => {
            PowerState::OperationEnabled
        }
        PowerState::QuickStopActive => state,
        _ if !runs => PowerState::SwitchOnDisabled,
        _ => match (state, word & 0b1111) {
            (_, 0b0110 | 0b1110) => PowerState::ReadyToSwitchOn,
            (PowerState::ReadyToSwitchOn | PowerState::OperationEnabled, 0b0111) => {
                PowerState::SwitchedOn
            }
            (PowerState::ReadyToSwitchOn | PowerState::SwitchedOn, 0b1111) => {
                PowerState::OperationEnabled
            }
            _ => state,
        },
    }
}

/// Bits of the statusword for a state; voltage and remote beside.
pub(crate) fn bits(state: PowerState) -> u16 {
    let state = match state {
        PowerState::NotReady => 0x00,
        PowerState::SwitchOnDisabled => 0x40,
        PowerState::ReadyToSwitchOn => 0x21,
        PowerState::SwitchedOn => 0x23,
        PowerState::OperationEnabled => 0x27,
        PowerState::QuickStopActive => 0x07,
        PowerState::FaultReactionActive => 0x0F,
        PowerState::Fault => 0x08,
    };
    state | 1 << 4 | 1 << 9
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The way of the manuals: 06, 07, 0F, and back.
    #[test]
    fn controlwords_lead_from_state_to_state() {
        let mut state = PowerState::SwitchOnDisabled;
        let mut last = 0;
        for (word, expected) in [
            (0x0F, PowerState::SwitchOnDisabled),
            (0x06, PowerState::ReadyToSwitchOn),
            (0x07, PowerState::SwitchedOn),
            (0x0F, PowerState::OperationEnabled),
            (0x3F, PowerState::OperationEnabled),
            (0x02, PowerState::QuickStopActive),
            (0x07, PowerState::QuickStopActive),
            (0x00, PowerState::SwitchOnDisabled),
            (0x06, PowerState::ReadyToSwitchOn),
            (0x0F, PowerState::OperationEnabled),
            (0x07, PowerState::SwitchedOn),
            (0x00, PowerState::SwitchOnDisabled),
        ] {
            state = next(state, word, last);
            assert_eq!(state, expected, "{word:02X}h");
            last = word;
        }
        assert_eq!(next(PowerState::Fault, 0x80, 0x80), PowerState::Fault, "no edge");
        assert_eq!(next(PowerState::Fault, 0x80, 0x00), PowerState::SwitchOnDisabled);
    }
}

//! Error frames with their data: which trouble, and the state of the controller.
//!
//! Source: `<linux/can/error.h>`.
//!
//! ```text
//!  data  0: bit in which arbitration was lost     4: transceiver
//!        1: controller                            6: transmit error counter
//!        2: kind of the protocol violation        7: receive error counter
//! ```

use std::fmt;

use crate::BusError;

/// One error frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ErrorFrame {
    /// Its classes.
    pub classes: BusError,
    /// Its data: zeros where the driver of the controller says nothing.
    pub data: [u8; 8],
}

/// State of a CAN controller (ISO 11898-1, fault confinement).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BusState {
    /// It takes part in the bus: fewer than 96 errors are counted.
    Active,
    /// It takes part, and counted more than 96 errors.
    Warning,
    /// It takes part, and no longer reports errors of others: more than 127 counted.
    Passive,
    /// It is off the bus after more than 255 errors in sending: nothing comes, nothing goes.
    Off,
}

/// Bits of the classes.
const CONTROLLER: u32 = 0x04;
const PROTOCOL: u32 = 0x08;
const BUS_OFF: u32 = 0x40;
const RESTARTED: u32 = 0x100;
const COUNTERS: u32 = 0x200;

/// Words of each bit of the controller, from bit 0 on.
const CONTROLLER_WORDS: [&str; 7] = [
    "receive buffer overflowed",
    "transmit buffer overflowed",
    "many errors in receiving",
    "many errors in sending",
    "error passive in receiving",
    "error passive in sending",
    "error active again",
];

/// Words of each bit of a protocol violation, from bit 0 on.
const PROTOCOL_WORDS: [&str; 8] = [
    "single bit",
    "frame format",
    "bit stuffing",
    "dominant bit failed",
    "recessive bit failed",
    "overload",
    "active error",
    "in sending",
];

impl ErrorFrame {
    /// The error frame of an identifier without its flag, and of its data.
    pub fn new(classes: u32, data: &[u8]) -> ErrorFrame {
        let mut bytes = [0; 8];
        let len = data.len().min(bytes.len());
        bytes[..len].copy_from_slice(&data[..len]);
        ErrorFrame { classes: BusError(classes), data: bytes }
    }

    /// The state of the controller from now on; `None` where the frame does not say it.
    pub fn state(&self) -> Option<BusState> {
        let BusError(classes) = self.classes;
        if classes & BUS_OFF != 0 {
            return Some(BusState::Off);
        }
        let bits = if classes & CONTROLLER != 0 { self.data[1] } else { 0 };
        match bits {
            _ if bits & 0x30 != 0 => Some(BusState::Passive),
            _ if bits & 0x0C != 0 => Some(BusState::Warning),
            _ if bits & 0x40 != 0 || classes & RESTARTED != 0 => Some(BusState::Active),
            _ => None,
        }
    }
}

/// Words for a person, and what to check where the controller is off the bus.
impl fmt::Display for ErrorFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let BusError(classes) = self.classes;
        // The counters stand at the end.
        let named = classes & !COUNTERS;
        write!(f, "{}", BusError(if named == 0 { classes } else { named }))?;
        if classes & CONTROLLER != 0 {
            write_bits(f, self.data[1], &CONTROLLER_WORDS)?;
        }
        if classes & PROTOCOL != 0 {
            write_bits(f, self.data[2], &PROTOCOL_WORDS)?;
        }
        if classes & COUNTERS != 0 {
            write!(f, "; error counters: sending {}, receiving {}", self.data[6], self.data[7])?;
        }
        match self.state() {
            Some(BusState::Off) => f.write_str(BUS_OFF_CURE),
            _ => Ok(()),
        }
    }
}

fn write_bits(f: &mut fmt::Formatter<'_>, bits: u8, words: &[&str]) -> fmt::Result {
    let mut separator = ": ";
    for (bit, words) in words.iter().enumerate() {
        if bits & 1 << bit != 0 {
            write!(f, "{separator}{words}")?;
            separator = ", ";
        }
    }
    Ok(())
}

const BUS_OFF_CURE: &str = ": check bit rate, wiring and termination; `ip link set NAME type can restart-ms 100` brings the interface back by itself";

#[cfg(test)]
mod tests {
    use super::*;

    /// Identifiers and data as drivers of Linux make them (`can_change_state` of drivers/net/can/dev): class CAN_ERR_CRTL with the
    /// state in data\[1\], CAN_ERR_CNT with the counters in data\[6\] and data\[7\].
    #[test]
    fn states_of_the_controller() {
        let frame = |classes, at: usize, byte| {
            let mut data = [0; 8];
            data[at] = byte;
            ErrorFrame::new(classes, &data)
        };
        for (found, state, words) in [
            (frame(0x40, 0, 0), Some(BusState::Off), "bus off: check bit rate"),
            (
                frame(0x204, 1, 0x20),
                Some(BusState::Passive),
                "controller: error passive in sending",
            ),
            (
                frame(0x04, 1, 0x10),
                Some(BusState::Passive),
                "controller: error passive in receiving",
            ),
            (frame(0x04, 1, 0x08), Some(BusState::Warning), "many errors in sending"),
            (frame(0x04, 1, 0x40), Some(BusState::Active), "error active again"),
            (frame(0x100, 0, 0), Some(BusState::Active), "restarted after bus off"),
            (frame(0x04, 1, 0x01), None, "receive buffer overflowed"),
            (frame(0x88, 2, 0x84), None, "bus error: bit stuffing, in sending"),
            (frame(0x20, 0, 0), None, "no acknowledgement"),
        ] {
            assert_eq!(found.state(), state, "{found}");
            assert!(found.to_string().contains(words), "{found}");
        }
        let counters = ErrorFrame::new(0x204, &[0, 0x30, 0, 0, 0, 0, 136, 128]);
        assert!(counters.to_string().ends_with("sending 136, receiving 128"), "{counters}");
    }
}

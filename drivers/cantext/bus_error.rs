//! Error frames: trouble on the bus, as its controller reports it.

use std::fmt;

/// Classes of trouble of one error frame, bit by bit (`<linux/can/error.h>`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BusError(pub u32);

/// Flag of an error frame in the identifier of Linux (`CAN_ERR_FLAG`).
pub const ERROR_FLAG: u32 = 0x2000_0000;

/// Words of each class, from bit 0 on.
const CLASSES: [&str; 10] = [
    "transmission timed out",
    "arbitration lost",
    "trouble of the controller",
    "protocol violated",
    "trouble of the transceiver",
    "no acknowledgement",
    "bus off",
    "bus error",
    "restarted after bus off",
    "counted errors",
];

impl fmt::Display for BusError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "";
        for (bit, words) in CLASSES.iter().enumerate() {
            if self.0 & 1 << bit != 0 {
                write!(f, "{separator}{words}")?;
                separator = ", ";
            }
        }
        if separator.is_empty() { write!(f, "error class {:X}h", self.0) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_have_words() {
        assert_eq!(BusError(0x40).to_string(), "bus off");
        assert_eq!(BusError(0x88).to_string(), "protocol violated, bus error");
        assert_eq!(BusError(0).to_string(), "error class 0h");
        assert_eq!(BusError(0x1000).to_string(), "error class 1000h");
    }
}

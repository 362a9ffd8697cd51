//! Emergencies (CiA 301, section 7.2.7).

use std::fmt;

use asphera_link::CanFrame;

use crate::{Cob, NodeId, WireError, frame};

/// What a node says when something goes wrong inside it, or is right again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Emergency {
    /// Error code.
    pub code: u16,
    /// Error register (object 1001h).
    pub register: u8,
    /// Bytes whose meaning the manufacturer knows.
    pub manufacturer: [u8; 5],
}

impl Emergency {
    /// The frame of `node`: code (low byte first), register, five bytes of the manufacturer.
    pub fn encode(self, node: NodeId) -> CanFrame {
        let [low, high] = self.code.to_le_bytes();
        let [a, b, c, d, e] = self.manufacturer;
        frame(Cob::Emergency(node), &[low, high, self.register, a, b, c, d, e])
    }

    /// Reads the data of an emergency of `node`.
    pub fn decode(node: NodeId, data: &[u8]) -> Result<Emergency, WireError> {
        let &[low, high, register, a, b, c, d, e] = data else {
            let cob = Cob::Emergency(node);
            return Err(WireError::Length { cob, expected: 8, found: data.len() });
        };
        let code = u16::from_le_bytes([low, high]);
        Ok(Emergency { code, register, manufacturer: [a, b, c, d, e] })
    }

    /// Whether an error has gone (code 00xxh), which is not yet to say that all have.
    pub const fn is_reset(self) -> bool {
        self.code >> 8 == 0
    }

    /// Whether no error is left: a reset with an empty error register.
    pub const fn is_all_clear(self) -> bool {
        self.is_reset() && self.register == 0
    }

    /// What the class of the code means (CiA 301, table of section 7.2.7.1).
    pub const fn meaning(self) -> &'static str {
        match self.code >> 8 {
            0x00 => "error reset",
            0x10 => "generic error",
            0x20..=0x23 => "current",
            0x30..=0x33 => "voltage",
            0x40..=0x42 => "temperature",
            0x50 => "device hardware",
            0x60..=0x63 => "device software",
            0x70 => "additional modules",
            0x81 => "communication",
            0x82 => "protocol error",
            0x80 => "monitoring",
            0x90 => "external error",
            0xF0 => "additional functions",
            0xFF => "device specific",
            _ => "a code CiA 301 does not define",
        }
    }
}

impl fmt::Display for Emergency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c, d, e] = self.manufacturer;
        write!(
            f,
            "emergency {:04X}h ({}), error register {:02X}h, {a:02X} {b:02X} {c:02X} {d:02X} {e:02X}",
            self.code,
            self.meaning(),
            self.register
        )
    }
}

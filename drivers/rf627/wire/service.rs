//! The header of a service message, port 50011. The driver sends none; it knows one that comes where profiles should.

/// Bytes of the header.
pub const SERVICE_LEN: usize = 14;

/// Serial number that every scanner answers to.
pub const ALL_DEVICES: u32 = u32::MAX;

/// Kinds of service messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A command to the scanner, 1.
    Command,
    /// A confirmation that a message came, 2.
    Confirmation,
    /// The scanner's answer, 3.
    Answer,
}

/// Fields before the content of a service message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ServiceHeader {
    /// Kind of the message.
    pub kind: Kind,
    /// Whether the receiver must confirm it.
    pub wants_confirmation: bool,
    /// Whether it is the last of its kind.
    pub is_last: bool,
    /// Bit 1: whether the content has a check value. The maker's code and comments disagree on which value says so.
    pub checksum_bit: bool,
    /// Check value of the content.
    pub checksum: u8,
    /// Serial number of the scanner, or [`ALL_DEVICES`].
    pub serial: u32,
    /// Number of the message, for its confirmation.
    pub message: u16,
    /// Command: module and number; big-endian, against all other fields.
    pub command: u16,
    /// Bytes of the content.
    pub size: u16,
}

impl ServiceHeader {
    /// The header as bytes.
    pub fn encode(&self) -> [u8; SERVICE_LEN] {
        let kind = match self.kind {
            Kind::Command => 1,
            Kind::Confirmation => 2,
            Kind::Answer => 3,
        };
        let bit = |is_set: bool, place: u8| u8::from(is_set) << place;
        let mut bytes = [0; SERVICE_LEN];
        bytes[0] = kind << 4
            | bit(self.wants_confirmation, 3)
            | bit(self.is_last, 2)
            | bit(self.checksum_bit, 1);
        bytes[2] = self.checksum;
        bytes[4..8].copy_from_slice(&self.serial.to_le_bytes());
        bytes[8..10].copy_from_slice(&self.message.to_le_bytes());
        bytes[10..12].copy_from_slice(&self.command.to_be_bytes());
        bytes[12..14].copy_from_slice(&self.size.to_le_bytes());
        bytes
    }

    /// Reads the header at the beginning of `bytes`; `None` where there is none.
    pub fn decode(bytes: &[u8]) -> Option<ServiceHeader> {
        let bytes = bytes.first_chunk::<SERVICE_LEN>()?;
        let kind = match bytes[0] >> 4 {
            1 => Kind::Command,
            2 => Kind::Confirmation,
            3 => Kind::Answer,
            _ => return None,
        };
        let is_set = |place: u8| bytes[0] >> place & 1 == 1;
        Some(ServiceHeader {
            kind,
            wants_confirmation: is_set(3),
            is_last: is_set(2),
            checksum_bit: is_set(1),
            checksum: bytes[2],
            serial: u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]),
            message: u16::from_le_bytes([bytes[8], bytes[9]]),
            command: u16::from_be_bytes([bytes[10], bytes[11]]),
            size: u16::from_le_bytes([bytes[12], bytes[13]]),
        })
    }

    /// Reads the header of a whole message, which has as many bytes as it says.
    pub(super) fn of_message(message: &[u8]) -> Option<ServiceHeader> {
        let header = ServiceHeader::decode(message)?;
        (message.len() == SERVICE_LEN + usize::from(header.size)).then_some(header)
    }
}

//! Expedited SDO: one object of up to four bytes, read or written (CiA 301, section 7.2.4.3).
//!
//! ```text
//! byte      0                      1..3          3        4..8
//! request   40 read                index (LE)    sub      zero
//!           2F 2B 27 23 write      index         sub      1 2 3 4 bytes, low first   (22: size not given)
//! answer    4F 4B 47 43 value      index         sub      1 2 3 4 bytes, low first   (42: size not given)
//!           60 written             index         sub      zero
//!           41 40 longer value     index         sub      length (segments follow)
//! both      80 abort               index         sub      abort code, low first
//! ```

use std::fmt;

use asphera_link::CanFrame;

use crate::{Address, Cob, NodeId, WireError, frame};

/// A value of one to four bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Expedited {
    bytes: [u8; 4],
    /// Bytes that count, or `None` if the sender did not say.
    len: Option<u8>,
}

/// What a master asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoRequest {
    /// Give the value of an object.
    Upload(Address),
    /// Take this value.
    Download(Address, Expedited),
    /// Forget the transfer.
    Abort(Address, AbortCode),
}

/// What a node answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SdoResponse {
    /// The value of an object.
    Uploaded(Address, Expedited),
    /// The value was taken.
    Downloaded(Address),
    /// The value is longer than four bytes; segments would follow.
    Segmented(Address),
    /// The request is refused.
    Aborted(Address, AbortCode),
}

/// Why a transfer was aborted.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct AbortCode(pub u32);

impl Expedited {
    /// An UNSIGNED8.
    pub const fn u8(value: u8) -> Expedited {
        Expedited { bytes: [value, 0, 0, 0], len: Some(1) }
    }

    /// An UNSIGNED16.
    pub const fn u16(value: u16) -> Expedited {
        let [low, high] = value.to_le_bytes();
        Expedited { bytes: [low, high, 0, 0], len: Some(2) }
    }

    /// An UNSIGNED32.
    pub const fn u32(value: u32) -> Expedited {
        Expedited { bytes: value.to_le_bytes(), len: Some(4) }
    }

    /// The value as a number; bytes not sent are zero.
    pub const fn number(self) -> u32 {
        u32::from_le_bytes(self.bytes)
    }

    /// How many bytes were sent, 1 to 4, if that was said.
    pub const fn byte_len(self) -> Option<u8> {
        self.len
    }

    /// Command specifier for `base` (0x20 download, 0x40 upload), with size and expedited bits.
    fn specifier(self, base: u8) -> u8 {
        match self.len {
            Some(len) => base | (4 - len) << 2 | 0b11,
            None => base | 0b10,
        }
    }

    fn decode(specifier: u8, bytes: [u8; 4]) -> Expedited {
        if specifier & 1 == 0 {
            return Expedited { bytes, len: None };
        }
        let len = 4 - (specifier >> 2 & 0b11);
        let mut kept = [0; 4];
        kept[..usize::from(len)].copy_from_slice(&bytes[..usize::from(len)]);
        Expedited { bytes: kept, len: Some(len) }
    }
}

impl SdoRequest {
    /// The object the request is about.
    pub const fn address(&self) -> Address {
        match *self {
            SdoRequest::Upload(address)
            | SdoRequest::Download(address, _)
            | SdoRequest::Abort(address, _) => address,
        }
    }

    /// The frame to `node`.
    pub fn encode(&self, node: NodeId) -> CanFrame {
        let cob = Cob::SdoRequest(node);
        match *self {
            SdoRequest::Upload(address) => message(cob, 0x40, address, [0; 4]),
            SdoRequest::Download(address, value) => {
                message(cob, value.specifier(0x20), address, value.bytes)
            }
            SdoRequest::Abort(address, code) => message(cob, 0x80, address, code.0.to_le_bytes()),
        }
    }

    /// Reads the data of a request to `node`. Segmented and block transfers are no value here.
    pub fn decode(node: NodeId, data: &[u8]) -> Result<SdoRequest, WireError> {
        let cob = Cob::SdoRequest(node);
        let (specifier, address, bytes) = fields(cob, data)?;
        match specifier {
            0x40 => Ok(SdoRequest::Upload(address)),
            0x22 | 0x23 | 0x27 | 0x2B | 0x2F => {
                Ok(SdoRequest::Download(address, Expedited::decode(specifier, bytes)))
            }
            0x80 => Ok(SdoRequest::Abort(address, AbortCode(u32::from_le_bytes(bytes)))),
            found => Err(WireError::Value { cob, found }),
        }
    }
}

impl SdoResponse {
    /// The object the answer is about.
    pub const fn address(&self) -> Address {
        match *self {
            SdoResponse::Uploaded(address, _)
            | SdoResponse::Downloaded(address)
            | SdoResponse::Segmented(address)
            | SdoResponse::Aborted(address, _) => address,
        }
    }

    /// The frame from `node`. A segmented answer is given the length 0, "not said".
    pub fn encode(&self, node: NodeId) -> CanFrame {
        let cob = Cob::SdoResponse(node);
        match *self {
            SdoResponse::Uploaded(address, value) => {
                message(cob, value.specifier(0x40), address, value.bytes)
            }
            SdoResponse::Downloaded(address) => message(cob, 0x60, address, [0; 4]),
            SdoResponse::Segmented(address) => message(cob, 0x40, address, [0; 4]),
            SdoResponse::Aborted(address, code) => {
                message(cob, 0x80, address, code.0.to_le_bytes())
            }
        }
    }

    /// Reads the data of an answer of `node`.
    pub fn decode(node: NodeId, data: &[u8]) -> Result<SdoResponse, WireError> {
        let cob = Cob::SdoResponse(node);
        let (specifier, address, bytes) = fields(cob, data)?;
        match specifier {
            0x42 | 0x43 | 0x47 | 0x4B | 0x4F => {
                Ok(SdoResponse::Uploaded(address, Expedited::decode(specifier, bytes)))
            }
            0x40 | 0x41 => Ok(SdoResponse::Segmented(address)),
            0x60 => Ok(SdoResponse::Downloaded(address)),
            0x80 => Ok(SdoResponse::Aborted(address, AbortCode(u32::from_le_bytes(bytes)))),
            found => Err(WireError::Value { cob, found }),
        }
    }
}

fn message(cob: Cob, specifier: u8, address: Address, bytes: [u8; 4]) -> CanFrame {
    let [low, high] = address.index.to_le_bytes();
    let [a, b, c, d] = bytes;
    frame(cob, &[specifier, low, high, address.sub, a, b, c, d])
}

fn fields(cob: Cob, data: &[u8]) -> Result<(u8, Address, [u8; 4]), WireError> {
    let &[specifier, low, high, sub, a, b, c, d] = data else {
        return Err(WireError::Length { cob, expected: 8, found: data.len() });
    };
    let address = Address { index: u16::from_le_bytes([low, high]), sub };
    Ok((specifier, address, [a, b, c, d]))
}

impl AbortCode {
    /// The SDO protocol timed out.
    pub const TIMED_OUT: AbortCode = AbortCode(0x0504_0000);
    /// Command specifier not valid or unknown.
    pub const UNKNOWN_COMMAND: AbortCode = AbortCode(0x0504_0001);
    /// The object cannot be accessed in this way.
    pub const UNSUPPORTED_ACCESS: AbortCode = AbortCode(0x0601_0000);
    /// The object cannot be written.
    pub const READ_ONLY: AbortCode = AbortCode(0x0601_0002);
    /// There is no such object.
    pub const NO_OBJECT: AbortCode = AbortCode(0x0602_0000);
    /// The object cannot be mapped to a PDO.
    pub const NOT_MAPPABLE: AbortCode = AbortCode(0x0604_0041);
    /// The mapped objects are longer than a PDO.
    pub const PDO_TOO_LONG: AbortCode = AbortCode(0x0604_0042);
    /// The length of the value does not fit the object.
    pub const WRONG_LENGTH: AbortCode = AbortCode(0x0607_0010);
    /// There is no such sub-index.
    pub const NO_SUB_INDEX: AbortCode = AbortCode(0x0609_0011);
    /// The value is out of the object's range.
    pub const OUT_OF_RANGE: AbortCode = AbortCode(0x0609_0030);

    /// Whether the node does not have the object asked for, rather than refusing it.
    pub const fn is_absent(self) -> bool {
        matches!(self, AbortCode::NO_OBJECT | AbortCode::NO_SUB_INDEX)
    }

    /// What the code means (CiA 301, table of section 7.2.4.3.17).
    pub const fn meaning(self) -> &'static str {
        match self.0 {
            0x0503_0000 => "toggle bit not alternated",
            0x0504_0000 => "SDO protocol timed out",
            0x0504_0001 => "unknown command specifier",
            0x0504_0002 => "invalid block size",
            0x0504_0003 => "invalid sequence number",
            0x0504_0004 => "CRC error",
            0x0504_0005 => "out of memory",
            0x0601_0000 => "unsupported access to the object",
            0x0601_0001 => "the object cannot be read",
            0x0601_0002 => "the object cannot be written",
            0x0602_0000 => "no such object",
            0x0604_0041 => "the object cannot be mapped to the PDO",
            0x0604_0042 => "the mapped objects exceed the PDO length",
            0x0604_0043 => "parameter incompatibility",
            0x0604_0047 => "incompatibility inside the device",
            0x0606_0000 => "hardware error",
            0x0607_0010 => "the length does not fit the object",
            0x0607_0012 => "the value is too long for the object",
            0x0607_0013 => "the value is too short for the object",
            0x0609_0011 => "no such sub-index",
            0x0609_0030 => "the value is out of range",
            0x0609_0031 => "the value is too high",
            0x0609_0032 => "the value is too low",
            0x0609_0036 => "maximum below minimum",
            0x060A_0023 => "resource not available",
            0x0800_0000 => "general error",
            0x0800_0020 => "the value cannot be transferred or stored",
            0x0800_0021 => "the value cannot be stored because of local control",
            0x0800_0022 => "the value cannot be stored in the present state of the device",
            0x0800_0023 => "no object dictionary",
            0x0800_0024 => "no data available",
            _ => "a code CiA 301 does not define",
        }
    }
}

impl fmt::Display for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (abort {:08X}h)", self.meaning(), self.0)
    }
}

impl fmt::Debug for AbortCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "AbortCode({:#010x})", self.0)
    }
}

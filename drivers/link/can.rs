//! Classic CAN frames.

use std::fmt;

use thiserror::Error;

/// Bytes of a frame in a recording: the layout of Linux's `struct can_frame`.
pub const RECORD_LEN: usize = 16;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;

/// Identifier of a CAN frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum CanId {
    /// 11 bits, 0 to 0x7FF.
    Standard(u16),
    /// 29 bits, 0 to 0x1FFF_FFFF.
    Extended(u32),
}

/// One classic CAN frame (CAN 2.0 A or B), 0 to 8 data bytes.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct CanFrame {
    id: CanId,
    remote: bool,
    len: u8,
    data: [u8; 8],
}

/// Why bytes are no CAN frame.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum FrameError {
    /// The identifier does not fit its kind.
    #[error("identifier {0:#x} is out of range")]
    Id(u32),
    /// More data than a classic frame holds.
    #[error("{0} data bytes, expected at most 8")]
    Length(usize),
    /// A recorded frame of the wrong size.
    #[error("recorded frame of {0} bytes, expected {RECORD_LEN}")]
    Record(usize),
}

impl CanFrame {
    /// A data frame. Fails when the identifier or the length is out of range.
    pub fn data_frame(id: CanId, data: &[u8]) -> Result<CanFrame, FrameError> {
        CanFrame::build(id, false, data.len(), data)
    }

    /// A remote frame asking for `len` bytes.
    pub fn remote_frame(id: CanId, len: usize) -> Result<CanFrame, FrameError> {
        CanFrame::build(id, true, len, &[])
    }

    fn build(id: CanId, remote: bool, len: usize, bytes: &[u8]) -> Result<CanFrame, FrameError> {
        match id {
            CanId::Standard(id) if id > 0x7FF => return Err(FrameError::Id(id.into())),
            CanId::Extended(id) if id > 0x1FFF_FFFF => return Err(FrameError::Id(id)),
            _ => {}
        }
        if len > 8 {
            return Err(FrameError::Length(len));
        }
        let mut data = [0; 8];
        data[..bytes.len()].copy_from_slice(bytes);
        Ok(CanFrame { id, remote, len: len as u8, data })
    }

    /// The identifier.
    pub fn id(&self) -> CanId {
        self.id
    }

    /// Whether this is a remote frame, which carries no data.
    pub fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data length code, 0 to 8. A remote frame has one too.
    pub fn dlc(&self) -> usize {
        self.len.into()
    }

    /// The data; empty for a remote frame.
    pub fn data(&self) -> &[u8] {
        if self.remote { &[] } else { &self.data[..usize::from(self.len)] }
    }

    /// The frame as a recording holds it: identifier with flags (little-endian), length, three zero
    /// bytes, eight data bytes.
    pub fn to_record(&self) -> [u8; RECORD_LEN] {
        let id = match self.id {
            CanId::Standard(id) => u32::from(id),
            CanId::Extended(id) => id | EXTENDED,
        } | if self.remote { REMOTE } else { 0 };
        let mut record = [0; RECORD_LEN];
        record[..4].copy_from_slice(&id.to_le_bytes());
        record[4] = self.len;
        record[8..].copy_from_slice(&self.data);
        record
    }

    /// Reads a frame back from a recording.
    pub fn from_record(record: &[u8]) -> Result<CanFrame, FrameError> {
        let record: &[u8; RECORD_LEN] =
            record.try_into().map_err(|_| FrameError::Record(record.len()))?;
        let word = u32::from_le_bytes([record[0], record[1], record[2], record[3]]);
        let remote = word & REMOTE != 0;
        let id = if word & EXTENDED != 0 {
            CanId::Extended(word & 0x1FFF_FFFF)
        } else {
            let id = word & 0x1FFF_FFFF;
            CanId::Standard(u16::try_from(id).map_err(|_| FrameError::Id(id))?)
        };
        let len = usize::from(record[4]);
        if len > 8 {
            return Err(FrameError::Length(len));
        }
        CanFrame::build(id, remote, len, if remote { &[] } else { &record[8..8 + len] })
    }
}

/// As `candump` writes it: `185#40E20100`, `1F334455#R`.
impl fmt::Debug for CanFrame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id {
            CanId::Standard(id) => write!(f, "{id:03X}#")?,
            CanId::Extended(id) => write!(f, "{id:08X}#")?,
        }
        if self.remote {
            return write!(f, "R{}", self.len);
        }
        self.data().iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recorded_frame_has_the_layout_of_struct_can_frame() {
        let frame = CanFrame::data_frame(CanId::Standard(0x185), &[0x40, 0xE2, 1, 0]).unwrap();
        let record = frame.to_record();
        assert_eq!(record, [0x85, 1, 0, 0, 4, 0, 0, 0, 0x40, 0xE2, 1, 0, 0, 0, 0, 0]);
        assert_eq!(CanFrame::from_record(&record), Ok(frame));
        assert_eq!(format!("{frame:?}"), "185#40E20100");
    }

    #[test]
    fn remote_and_extended_frames_survive_a_recording() {
        let frame = CanFrame::remote_frame(CanId::Extended(0x1FFF_FFFF), 7).unwrap();
        assert_eq!(CanFrame::from_record(&frame.to_record()), Ok(frame));
        assert_eq!((frame.dlc(), frame.data()), (7, &[][..]));
    }

    #[test]
    fn out_of_range_is_refused() {
        assert_eq!(CanFrame::data_frame(CanId::Standard(0x800), &[]), Err(FrameError::Id(0x800)));
        assert_eq!(CanFrame::data_frame(CanId::Standard(1), &[0; 9]), Err(FrameError::Length(9)));
        assert_eq!(CanFrame::from_record(&[0; 3]), Err(FrameError::Record(3)));
        let mut long = [0; RECORD_LEN];
        long[4] = 9;
        assert_eq!(CanFrame::from_record(&long), Err(FrameError::Length(9)));
    }
}

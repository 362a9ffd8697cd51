//! Frames as a recording holds them: the layouts of Linux's `struct can_frame` and `struct canfd_frame`.
//!
//! ```text
//!  byte 0     4    5      6  8
//!      ┌──────┬────┬──────┬──┬──────────────────┐
//!      │  id  │ len│ flags│ 0│ data, 8 or 64    │
//!      └──────┴────┴──────┴──┴──────────────────┘
//! ```
//!
//! The identifier is little-endian. Flags are 1 BRS, 2 ESI, 4 FDF; FDF stands in each CAN FD frame, and says how long the
//! record is. Recordings of older versions have classic frames alone, and are read as they are.

use super::{CanFrame, CanId, FdFlags, Format, FrameError};

/// Bytes of a classic frame in a recording: the layout of Linux's `struct can_frame`.
pub const RECORD_LEN: usize = 16;

/// Bytes of a CAN FD frame in a recording: the layout of Linux's `struct canfd_frame`.
pub const FD_RECORD_LEN: usize = 72;

const EXTENDED: u32 = 0x8000_0000;
const REMOTE: u32 = 0x4000_0000;

/// `CANFD_BRS`, `CANFD_ESI` and `CANFD_FDF` of `<linux/can.h>`.
const BRS: u8 = 1;
const ESI: u8 = 2;
const FDF: u8 = 4;

/// Place of the flags, and of the data.
const FLAGS_AT: usize = 5;
const DATA_AT: usize = 8;

impl CanFrame {
    /// The frame as a recording holds it: identifier with flags (little-endian), length, flags of CAN FD, two zero bytes,
    /// then the data in [`RECORD_LEN`] bytes altogether, or [`FD_RECORD_LEN`].
    pub fn to_record(&self) -> Vec<u8> {
        let id = match self.id {
            CanId::Standard(id) => u32::from(id),
            CanId::Extended(id) => id | EXTENDED,
        } | if self.is_remote() { REMOTE } else { 0 };
        let mut record = vec![0; if self.fd().is_some() { FD_RECORD_LEN } else { RECORD_LEN }];
        record[..4].copy_from_slice(&id.to_le_bytes());
        record[4] = self.len;
        if let Some(FdFlags { bit_rate_switch, error_passive }) = self.fd() {
            record[FLAGS_AT] =
                FDF | if bit_rate_switch { BRS } else { 0 } | if error_passive { ESI } else { 0 };
        }
        let room = record.len() - DATA_AT;
        record[DATA_AT..].copy_from_slice(&self.data[..room]);
        record
    }

    /// Takes the first record off `bytes`: the record, and what follows it. A piece that is too short is all there is.
    pub fn split_record(bytes: &[u8]) -> (&[u8], &[u8]) {
        let is_fd = bytes.get(FLAGS_AT).is_some_and(|flags| flags & FDF != 0);
        let len = if is_fd { FD_RECORD_LEN } else { RECORD_LEN };
        bytes.split_at(len.min(bytes.len()))
    }

    /// Reads a frame back from a recording.
    pub fn from_record(record: &[u8]) -> Result<CanFrame, FrameError> {
        let flags = *record.get(FLAGS_AT).ok_or(FrameError::Record(record.len()))?;
        let is_fd = flags & FDF != 0;
        if record.len() != if is_fd { FD_RECORD_LEN } else { RECORD_LEN } {
            return Err(FrameError::Record(record.len()));
        }
        let word = u32::from_le_bytes([record[0], record[1], record[2], record[3]]);
        let id = if word & EXTENDED != 0 {
            CanId::Extended(word & 0x1FFF_FFFF)
        } else {
            let id = word & 0x1FFF_FFFF;
            CanId::Standard(u16::try_from(id).map_err(|_| FrameError::Id(id))?)
        };
        let len = usize::from(record[4]);
        let data = || record.get(DATA_AT..DATA_AT + len);
        if is_fd {
            let flags =
                FdFlags { bit_rate_switch: flags & BRS != 0, error_passive: flags & ESI != 0 };
            return CanFrame::fd_frame(id, data().ok_or(FrameError::FdLength(len))?, flags);
        }
        match word & REMOTE != 0 {
            true => CanFrame::build(id, Format::Remote, len, &[]),
            false => CanFrame::data_frame(id, data().ok_or(FrameError::Length(len))?),
        }
    }
}
